"""`shockpc place`."""

HEADING, SUMMARY = "Decide", "Find where on a body a sensor has the smallest shock."
