"""The colours of normalised shock: five blues below the strike, four reds above it.

The change of hue at 1 shows at a glance what feels more than the strike itself. Lightness falls from band to band, most of
all at 1, so the order survives grey printing, and blue against red survives every common colour blindness. Nothing is clipped:
the last band is open.
"""

import math

__all__ = ["BANDS", "EDGES", "INK", "PAPER", "band", "faded"]

EDGES = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, math.inf)
"""Breaks between the bands: shock |Δv| / v_in [1]."""

BANDS = ("#e9f0f7", "#cbdef0", "#a8c9e6", "#82b2da", "#5b9aca", "#bb4524", "#932c22", "#66161e", "#300810")
"""One colour for each band, lightest first."""

INK = "#1a1a1a"
"""Lines and letters."""

PAPER = "#ffffff"
"""What the figure is printed on."""


def band(shock: float) -> int:
    """Index of the band that a shock falls into; a value on a break belongs to the band below it.

    Args:
        shock: |Δv| / v_in [1], not negative.
    """
    return next(i for i, upper in enumerate(EDGES[1:]) if shock <= upper)


def faded(colour: str, share: float) -> str:
    """A colour mixed with paper.

    Args:
        colour: as #rrggbb.
        share: of paper, 0 to 1.
    """
    channels = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(c + (255 - c) * share):02x}" for c in channels)
