"""The ways in which the base of a robot may move."""

from typing import Literal

Base = Literal["free", "planar", "fixed"]
"""Free, in the plane of the study only, or fixed."""
