"""What all figures share: style, blank axes in inches, and how a figure becomes SVG and PNG."""

import io
import warnings
from collections.abc import Callable
from typing import Any

from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from shockpc.show.figure.palette import INK, PAPER

__all__ = ["STYLE", "add_axes", "new_chart", "new_page", "render"]

DPI = 160
"""Of the PNG."""

STYLE = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica"],
    "font.size": 7.5,
    "text.color": INK,
    "figure.facecolor": PAPER,
    "figure.titlesize": 10.0,
    "figure.titleweight": "bold",
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 8.0,
    "xtick.labelsize": 7.0,
    "xtick.major.size": 2.5,
    "xtick.major.width": 0.6,
    "ytick.labelsize": 7.0,
    "ytick.major.size": 2.5,
    "ytick.major.width": 0.6,
    "grid.linewidth": 0.4,
    "grid.color": "#d8d8d8",
    "legend.frameon": False,
    "path.simplify": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "shockpc",
}
"""Changes to matplotlib's default settings while a figure is drawn."""


def new_page(width: float, height: float) -> tuple[Figure, Axes]:
    """A figure and, over all of it, axes without decoration whose coordinates are inches from the lower left corner."""
    figure = Figure(figsize=(width, height))
    page = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, width), ylim=(0.0, height))
    page.set_axis_off()
    return figure, page


def new_chart(width: float, height: float, title: str) -> Figure:
    """A figure of that size [inches] with a title, whose axes find their places by themselves."""
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left")
    return figure


def add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place given in inches."""
    w, h = figure.get_size_inches()
    return figure.add_axes((left / w, bottom / h, width / w, height / h))


def render(name: str, draw: Callable[[], Figure], formulas: bool = False) -> dict[str, bytes]:
    """Draw a figure in matplotlib's default settings and return its files, <name>.svg and <name>.png: the same bytes every time.

    Args:
        name: of the files.
        draw: makes the figure.
        formulas: whether texts between dollar signs are formulas, as in the ticks of logarithmic axes.
    """
    svg, png = io.BytesIO(), io.BytesIO()
    with style.context({**STYLE, "text.parse_math": formulas}, after_reset=True), warnings.catch_warnings():
        # A letter that the font lacks is a box in the PNG; in the SVG the viewer's font has it.
        warnings.filterwarnings("ignore", message="Glyph ")
        figure = draw()
        vector: Any = FigureCanvasSVG(figure)
        vector.print_svg(svg, metadata={"Date": None, "Creator": "shockpc"})
        figure.set_dpi(DPI)
        pixels: Any = FigureCanvasAgg(figure)
        pixels.print_png(png, metadata={"Software": "shockpc"})
    return {f"{name}.svg": svg.getvalue(), f"{name}.png": png.getvalue()}
