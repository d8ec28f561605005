"""`shockpc identify`."""

HEADING, SUMMARY = "Data", "Find drives, friction and masses from measured landings."
