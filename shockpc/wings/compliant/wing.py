"""The doors of this wing."""

from shockpc.text.wings import Wing

WING = Wing(
    landing="landing",
    quantities="quantities",
    checks="checks",
    report="show.report",
    variations="variations",
)
