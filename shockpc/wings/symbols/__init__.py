"""Landings in symbols: gradients, code in C and JavaScript, and sliders for the posture."""
