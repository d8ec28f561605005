"""Sliders of a page for the posture of a landing."""

from typing import Any, NamedTuple


class PostureSliders(NamedTuple):
    """The sliders of one landing.

    Attributes:
        sliders: kind, name, unit, value, low and high of each; none where the posture cannot
            change.
        code: a function of JavaScript, or "null".
        note: what the sliders mean, or why there are none.
    """

    sliders: list[dict[str, Any]]
    code: str
    note: str
