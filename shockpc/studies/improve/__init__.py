"""`shockpc improve`."""

HEADING, SUMMARY = "Decide", "Find the posture, strike or design with the smallest shock."
