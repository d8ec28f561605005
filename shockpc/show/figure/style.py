"""What all drawings share: letters and line ends, an empty sheet, and how a drawing becomes two files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.show.figure.palette import INK
from shockpc.show.files import write_whole

__all__ = ["STYLE", "blank", "save_drawing"]

DPI = 160
"""Of the PNG."""

STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica"],
    "svg.fonttype": "none",
    "svg.hashsalt": "shockpc",
    "path.simplify": False,
    "text.color": INK,
}
"""Settings of matplotlib, for the time of a drawing."""


def blank(axes: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Make axes a plain sheet with these coordinates."""
    axes.set_axis_off()
    axes.set_xlim(*x)
    axes.set_ylim(*y)


def save_drawing(make: Callable[[], Figure], folder: Path, stem: str) -> tuple[Path, Path]:
    """Write a drawing as SVG and PNG, the same bytes every time; a file is there whole or not at all.

    Args:
        make: draws it.
        folder: exists already.
        stem: of both files' names.

    Returns: the paths of both.

    Raises:
        OutputError: the folder cannot be written.
    """
    svg, png = folder / f"{stem}.svg", folder / f"{stem}.png"
    with matplotlib.rc_context(STYLE):
        figure = make()
        write_whole(svg, lambda part: figure.savefig(part, format="svg", metadata={"Date": None, "Creator": "shockpc"}))
        write_whole(png, lambda part: figure.savefig(part, format="png", dpi=DPI, metadata={"Software": "shockpc"}))
    return svg, png
