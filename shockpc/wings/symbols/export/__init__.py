"""`shockpc export`."""

HEADING, SUMMARY = "For developers", "Write a landing's numbers as code that needs no library."
