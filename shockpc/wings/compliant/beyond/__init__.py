"""What the rigid answer is off by for bodies that bend: `shockpc paper --beyond`."""
