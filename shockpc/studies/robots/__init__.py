"""`shockpc robots`."""

HEADING, SUMMARY = "Look at a robot", "List the robots known by name, or check and show one."
