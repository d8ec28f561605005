"""`shockpc compare`."""

HEADING, SUMMARY = "Decide", "Compare the shock of designs, or of a design's changes."
