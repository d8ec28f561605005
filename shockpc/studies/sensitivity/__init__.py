"""`shockpc sensitivity`."""

HEADING, SUMMARY = "Decide", "Rank masses, inertias and angles by their effect on a number."
