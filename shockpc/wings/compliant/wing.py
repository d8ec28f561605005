"""The doors of this wing."""

from shockpc.text.wings import Wing

WING = Wing(
    quantities="quantities",
    checks="checks",
    report="report",
    beyond="beyond.report",
)
