"""`shockpc limits`."""

HEADING, SUMMARY = "Decide", "Find joint angles that keep a number below or above a bound."
