"""`shockpc recorded`."""

HEADING, SUMMARY = "Data", "Compute recorded landings, and compare what was measured."
