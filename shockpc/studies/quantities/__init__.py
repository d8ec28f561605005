"""`shockpc quantities`."""

HEADING, SUMMARY = "For developers", "List the numbers that a landing has."
