"""`shockpc sweep`."""

HEADING, SUMMARY = "Many landings", "Compute landings over many postures, strikes and models."
