"""`shockpc analyze`."""

HEADING, SUMMARY = "One landing", "Compute the shock of a landing on every body of a robot."
