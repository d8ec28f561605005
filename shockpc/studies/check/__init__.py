"""`shockpc check`."""

HEADING, SUMMARY = "Decide", "Compare landings with budgets, as a gate in CI."
