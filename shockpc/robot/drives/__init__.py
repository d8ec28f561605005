"""Drives of robots: rotors, gears and motors."""
