"""Errors of the rigid answer for bodies that bend: `shockpc paper --beyond`."""
