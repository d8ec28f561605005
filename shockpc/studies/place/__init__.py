"""`shockpc place`."""

HEADING, SUMMARY = "Decide", "Find where on a body a sensor sees least shock."
