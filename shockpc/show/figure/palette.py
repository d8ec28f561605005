"""The colours of normalised shock: five blues below the shock at the contact, a grey around it, four reds above.

Values that round to 1.0 are grey, so that a body which moves as the contact does is not marked as amplifying the shock. Lightness
falls from band to band, which keeps the order in grey printing, and blue and red differ with every common colour blindness. The
last band is open, so no value is clipped.
"""

import math

__all__ = ["BANDS", "CURVES", "EDGES", "INK", "PAPER", "band", "faded"]

EDGES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.95, 1.05, 1.25, 1.5, 2.0, math.inf)
"""Limits of the bands: shock |Δv| / v_in [1]."""

BANDS = ("#eff5fc", "#d3e6f9", "#b7d7f6", "#98c8f2", "#74b8ee", "#9e9e9e", "#c44c28", "#9a2c24", "#66161d", "#300810")
"""One colour for each band, lightest first."""

CURVES = ("#1f5f9f", "#c2512f", "#3f8f4f", "#7a4fa0", "#a08020", "#208f8f", "#a0406f", "#606060")
"""Of curves and marks that are told apart by their colours."""

INK = "#1a1a1a"
"""Lines and letters."""

PAPER = "#ffffff"
"""Background."""


def band(shock: float) -> int:
    """Index of the band of a shock |Δv| / v_in, not negative [1]; a value on a limit belongs to the band below it."""
    return next(i for i, upper in enumerate(EDGES[1:]) if shock <= upper)


def faded(colour: str, share: float) -> str:
    """A colour #rrggbb mixed with a share, 0 to 1, of the background."""
    channels = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(c + (255 - c) * share):02x}" for c in channels)
