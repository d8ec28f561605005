"""Quantities of parts and sensors, which need a pulse, a motion or a rating."""
