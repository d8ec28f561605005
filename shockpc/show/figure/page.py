"""What surrounds a picture: coordinates along its edges, the colour bar, tables and the key to the signs."""

import math
import re
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator

from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import BOXED
from shockpc.show.figure.canvas import add_axes
from shockpc.show.figure.marks import SIGNS
from shockpc.show.figure.palette import BANDS, EDGES, INK, faded
from shockpc.show.figure.window import Window

__all__ = ["LINE", "colour_bar", "coordinates", "key", "line", "table"]

LINE = 0.165
"""Height of a line of text [inches]."""

WORDS = {
    "arrow": "velocity of the contact before the impact",
    "ring": "contact that moves perpendicular to the plane",
    "centre": "CoPc of the body with this number",
    "circle": "RoPc: shock is 1 on this circle",
    "joint": "joint",
    "sensor": "sensor or point",
    "outlined": "body in front of the struck limb",
    "box": "box of the inertia: there is no shape to draw",
}
"""What the signs mean."""


def coordinates(axes: Axes, window: Window, profile: ShockProfile, first: bool = True) -> None:
    """Limit axes to a window and mark world coordinates along the lower and, of the first picture, the left edge [m]."""
    axes.set(xlim=(window.low[0], window.high[0]), ylim=(window.low[1], window.high[1]))
    power = 10.0 ** math.floor(math.log10(0.5 * window.inch))
    step = next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= 0.5 * window.inch)
    plane = profile.scene.plane
    directions = (profile.plane.e1, profile.plane.e2)
    names = plane if isinstance(plane, str) else [f"along ({', '.join(f'{x + 0.0:.3g}' for x in e)})" for e in directions]
    for axis, name in zip((axes.xaxis, axes.yaxis), names, strict=True):
        axis.set_major_locator(MultipleLocator(step))
        axis.set_label_text(f"{name} [m]", fontsize=7.5)
    axes.tick_params(labelsize=7.0, length=2.5, width=0.6, color=INK, labelcolor=INK, labelleft=first, left=first)
    axes.spines[["top", "right"] if first else ["top", "right", "left"]].set_visible(False)
    axes.set_facecolor("none")
    if not first:
        axes.set_ylabel("")


def colour_bar(figure: Figure, x: float, y: float, width: float) -> None:
    """The bands of shock with their limits, from (x, y) to the right and down [inches]."""
    limits = [*EDGES[:-1], 2.5]
    mappable = ScalarMappable(BoundaryNorm(limits, len(BANDS)), ListedColormap(BANDS))
    axes = add_axes(figure, x, y - 0.14, width, 0.14)
    bar = figure.colorbar(mappable, cax=axes, orientation="horizontal", spacing="uniform", drawedges=True)
    bar.set_ticks(limits, labels=[*(f"{edge:g}" for edge in EDGES[:-1]), "∞"])
    bar.ax.tick_params(labelsize=7.0, length=0.0)
    bar.set_label("normalised shock |Δv| / v_in [-]; grey: 1.0 when rounded", fontsize=7.5)
    bar.outline.set_linewidth(0.6)
    bar.dividers.set_linewidth(0.5)


def line(page: Axes, x: float, y: float, text: str, size: float, width: float, weight: str = "normal") -> None:
    """One line of text down from (x, y), in smaller letters if the width [inches] requires it."""
    text = re.sub(r"(?<!\w)-(?=\d)", "−", text)
    needed = (0.62 if weight == "normal" else 0.72) * len(text) / 72.0
    page.text(x, y, text, fontsize=min(size, width / needed), fontweight=weight, va="top")


def table(page: Axes, x: float, y: float, stops: Sequence[float], rows: Sequence[Sequence[str]]) -> float:
    """Write rows down from (x, y), the first one as header; return where they end [inches].

    The stops are the left edges of the first two columns and the right edges of the others, from x.
    """
    for k, row in enumerate(rows):
        for column, (stop, cell) in enumerate(zip(stops, row, strict=True)):
            weight = "bold" if k == 0 or column == 0 else "normal"
            page.text(x + stop, y, cell, fontweight=weight, ha="left" if column < 2 else "right", va="top")
        y -= LINE
        if k == 0:
            page.plot([x, x + stops[-1]], [y + 0.01] * 2, color=INK, linewidth=0.6)
            y -= 0.03
    return y


def key(page: Axes, signs: set[str], place: tuple[float, float]) -> None:
    """What the signs mean that occur, down from a place [inches]."""
    handles: list[Line2D | Patch] = [Line2D([], [], **SIGNS[sign]) for sign in WORDS if sign in signs & SIGNS.keys()]
    if "outlined" in signs:
        handles.append(Patch(fill=False, edgecolor=faded(INK, 0.35), linewidth=0.5))
    if "box" in signs:
        handles.append(Patch(fill=False, edgecolor=INK, linewidth=0.7, linestyle=BOXED))
    page.legend(
        handles, [words for sign, words in WORDS.items() if sign in signs], loc="upper left", bbox_to_anchor=place,
        bbox_transform=page.transData, borderpad=0.0, handlelength=1.9, handletextpad=0.6, labelspacing=0.45, borderaxespad=0.0,
    )  # fmt: skip
