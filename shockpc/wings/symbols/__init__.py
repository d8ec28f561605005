"""Landings in symbols: gradients, code in C and JavaScript, and sliders of a page for the posture."""
