"""`shockpc touchdowns`."""

HEADING, SUMMARY = "Data", "Find the touchdowns of a log: the table of its landings."
