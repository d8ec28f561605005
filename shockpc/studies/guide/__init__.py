"""`shockpc guide`."""

HEADING, SUMMARY = "Begin", "Read how to use shockpc, by topic."
