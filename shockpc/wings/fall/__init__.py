"""`shockpc fall`."""

HEADING, SUMMARY = "Many landings", "Let a robot tip over, or drop it, and rank what strikes."
