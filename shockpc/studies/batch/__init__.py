"""`shockpc batch`."""

HEADING, SUMMARY = "Many landings", "Compute landings of many robots, and rank them."
