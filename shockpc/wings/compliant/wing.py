"""The doors of this wing."""

from shockpc.text.wings import Wing

WING = Wing(beyond="beyond.report", report="report")
