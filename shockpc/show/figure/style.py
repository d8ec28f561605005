"""Style of all figures: colours, settings of matplotlib, and how a figure becomes SVG and PNG.

Normalised shock has five blues below the shock at the contact, a grey around it, and four reds
above. Values that round to 1.0 are grey, so that a body which moves as the contact does is not
marked as amplifying the shock. Lightness falls from band to band, which keeps the order in grey
printing, and blue and red differ with every common colour blindness. The last band is open, so no
value is clipped.
"""

import io
import math
import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from matplotlib import rc_context, rcParamsDefault
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LinearSegmentedColormap, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

EDGES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.95, 1.05, 1.25, 1.5, 2.0, math.inf)
"""Limits of the bands: shock |Δv| / v_in [1]."""

BANDS = (
    "#eff5fc",
    "#d3e6f9",
    "#b7d7f6",
    "#98c8f2",
    "#74b8ee",
    "#9e9e9e",
    "#c44c28",
    "#9a2c24",
    "#66161d",
    "#300810",
)
"""One colour for each band, lightest first."""

CURVES = ("#1f5f9f", "#c2512f", "#3f8f4f", "#7a4fa0", "#a08020", "#208f8f", "#a0406f", "#606060")
"""Colours of curves and marks."""

MARKERS = ("o", "^", "s", "D")
"""Markers of quantities whose colours are the same."""

COUNTS = "#b9a77c"
"""Colour of how often a value occurs; it does not mean the size of the value."""

INK, PAPER = "#1a1a1a", "#ffffff"
"""Lines and letters; background."""

SHOCK = "normalised shock |Δv| / v_in [-]"
"""Label of bars and axes."""

DECADE, DECADES = 15.0, 1e3
"""Ratios of the limits of a logarithmic axis up to which numbers between powers of ten are written.

Up to the first all of them are, up to the second twos and fives.
"""

DPI = 120
"""Resolution of the PNG [dots per inch]."""

STYLE = {
    "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica"],
    "font.size": 7.5,
    "text.color": INK,
    "text.parse_math": False,
    "text.hinting": "none",  # so that letters are as wide in the PNG as where the layout is found
    "figure.facecolor": PAPER,
    "figure.titlesize": 10.0,
    "figure.titleweight": "bold",
    "figure.labelsize": 7.5,
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
    "legend.handlelength": 1.9,
    "legend.handletextpad": 0.6,
    "legend.labelspacing": 0.45,
    "svg.fonttype": "none",
    "svg.hashsalt": "shockpc",
}
"""Changes to matplotlib's default settings while a figure is drawn."""


def band(shock: float) -> int:
    """Index of the band of a shock |Δv| / v_in, not negative [1].

    A value on a limit belongs to the band below it.
    """
    return next(i for i, upper in enumerate(EDGES[1:]) if shock <= upper)


def shock_levels(least: float, greatest: float) -> tuple[list[float], list[str]]:
    """Levels of a map of shocks [1] and the colours between them.

    They are the bands, or blues where all shocks are below that of the contact.
    """
    if greatest > EDGES[5]:
        return list(EDGES), list(BANDS)
    ticks = MaxNLocator(nbins=9, steps=[1, 2, 2.5, 5, 10]).tick_values(
        least, max(greatest, least + 1e-9)
    )
    levels = [float(x) for x in ticks]
    blues = LinearSegmentedColormap.from_list(
        "shock", [*BANDS[:5], "#3a6ea8", "#23406e"], N=len(levels) - 1
    )
    return levels, [to_hex(blues(k)) for k in range(len(levels) - 1)]


def faded(colour: str, share: float) -> tuple[float, float, float]:
    """A colour mixed with a share, 0 to 1, of the background."""
    r, g, b = [part + (1.0 - part) * share for part in to_rgb(colour)]
    return r, g, b


def new_chart(width: float, height: float, title: str) -> Figure:
    """A figure of that size [inches] with a title, whose axes find their places by themselves."""
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left")
    return figure


def plain_numbers(axis: Axis) -> None:
    """Write the numbers of a logarithmic axis without powers.

    Where the axis is short, also those between powers of ten.
    """
    low, high = axis.get_view_interval()
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter("{x:g}" if high < DECADE * low else NullFormatter())
    if DECADE * low <= high < DECADES * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))


def histogram(axes: Axes, heights: np.ndarray, edges: np.ndarray, median: float) -> None:
    """Draw how often values occur, heights (n,) between edges (n + 1,); dashed: median."""
    axes.stairs(heights, edges, fill=True, facecolor=COUNTS, edgecolor=INK, linewidth=0.6)
    axes.axvline(median, color=INK, linewidth=0.8, linestyle="--")
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))


def settings() -> AbstractContextManager[None]:
    """A context with matplotlib's default settings and the changes in `STYLE`."""
    defaults: dict[Any, Any] = {
        key: value for key, value in rcParamsDefault.items() if "backend" not in key
    }
    return rc_context(defaults | STYLE)


def render(name: str, draw: Callable[[], Figure], pdf: bool = False) -> dict[str, bytes]:
    """The files of a figure in matplotlib's default settings, <name>.svg and <name>.png.

    They are the same bytes every time.

    Args:
        name: of the files.
        draw: makes the figure.
        pdf: whether <name>.pdf is made too.
    """
    svg, png, paper = io.BytesIO(), io.BytesIO(), io.BytesIO()
    with settings(), warnings.catch_warnings():
        # A letter that the font lacks is a box in the PNG; in the SVG the viewer's font has it.
        warnings.filterwarnings("ignore", message="Glyph ")
        figure = draw()
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": "shockpc"})
        figure.set_layout_engine("none")  # the places of the axes are found once
        # At this level zlib takes half the time, and the files are no larger.
        figure.savefig(
            png,
            format="png",
            dpi=DPI,
            metadata={"Software": "shockpc"},
            pil_kwargs={"compress_level": 3},
        )
        if pdf:
            figure.savefig(
                paper, format="pdf", metadata={"CreationDate": None, "Creator": "shockpc"}
            )
    files = {f"{name}.svg": svg.getvalue(), f"{name}.png": png.getvalue()}
    if pdf:
        files[f"{name}.pdf"] = paper.getvalue()
    return files
