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

__all__ = [
    "LINE", "colour_bar", "coordinates", "key", "legend", "line", "plane_names", "remarks", "round_step", "shock_bar", "table",
    "title",
]  # fmt: skip

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


def plane_names(profile: ShockProfile) -> Sequence[str]:
    """Names of the directions to the right and up."""
    plane, directions = profile.scene.plane, (profile.plane.e1, profile.plane.e2)
    return plane if isinstance(plane, str) else [f"along ({', '.join(f'{x + 0.0:.3g}' for x in e)})" for e in directions]


def coordinates(
    axes: Axes, window: Window, names: Sequence[str], left: bool = True, bottom: bool = True, apart: float = 0.5
) -> None:
    """Limit axes to a window and mark coordinates [m].

    Args:
        axes: in plane coordinates.
        window: what they show.
        names: of the directions to the right and up.
        left: whether the left edge has numbers.
        bottom: whether the lower edge has numbers.
        apart: least distance between these [inches].
    """
    axes.set(xlim=(window.low[0], window.high[0]), ylim=(window.low[1], window.high[1]), facecolor="none")
    for axis, name, shown in ((axes.xaxis, names[0], bottom), (axes.yaxis, names[1], left)):
        axis.set_major_locator(MultipleLocator(round_step(apart * window.inch)))
        axis.set_label_text(f"{name} [m]" if shown else "")
    axes.tick_params(color=INK, labelcolor=INK, labelleft=left, left=left, labelbottom=bottom)
    axes.spines["left"].set_visible(left)


def round_step(least: float) -> float:
    """The smallest of 1, 2, 5, 10, 20 and so on, and of 0.5, 0.2, 0.1 and so on, that is at least a number."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= least)


def shock_bar(figure: Figure, x: float, y: float, width: float) -> None:
    """The bands of shock with their limits, from (x, y) to the right and down [inches]."""
    labels = [*(f"{edge:g}" for edge in EDGES[:-1]), "∞"]
    text = "normalised shock |Δv| / v_in [-]; grey: 1.0 when rounded"
    colour_bar(figure, (x, y, width), [*EDGES[:-1], 2.5], BANDS, labels, text)


def colour_bar(
    figure: Figure,
    place: tuple[float, float, float],
    levels: Sequence[float],
    colours: Sequence[str],
    labels: Sequence[str],
    text: str,
) -> None:
    """Colours between levels.

    Args:
        figure: has the bar.
        place: left end, upper edge and width [inches].
        levels: one more than colours.
        colours: of the intervals.
        labels: of the levels.
        text: under the bar.
    """
    x, y, width = place
    mappable = ScalarMappable(BoundaryNorm(levels, len(colours)), ListedColormap(list(colours)))
    axes = add_axes(figure, x, y - 0.14, width, 0.14)
    bar = figure.colorbar(mappable, cax=axes, orientation="horizontal", spacing="uniform", drawedges=True)
    bar.set_ticks(list(levels), labels=list(labels))
    bar.ax.tick_params(length=0.0)
    bar.set_label(text)
    bar.dividers.set_linewidth(0.5)


def title(page: Axes, x: float, y: float, lines: tuple[str, str, str], width: float) -> None:
    """The title and two lines under it, down from (x, y) [inches]."""
    for text, drop, size, weight in zip(lines, (0.0, 0.25, 0.43), (11.0, 8.0, 8.0), ("bold", "normal", "normal"), strict=True):
        line(page, x, y - drop, text, size, width, weight)


def remarks(page: Axes, x: float, y: float, lines: Sequence[str]) -> float:
    """Lines in italics, down from (x, y); return where they end [inches]."""
    for text in lines:
        page.text(x, y, text, fontsize=7, fontstyle="italic", va="top")
        y -= 0.85 * LINE
    return y


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
    legend(page, handles, [words for sign, words in WORDS.items() if sign in signs], place)


def legend(page: Axes, handles: Sequence[Line2D | Patch], words: Sequence[str], place: tuple[float, float]) -> None:
    """Signs and what they mean, down from a place [inches]."""
    page.legend(
        handles, words, loc="upper left", bbox_to_anchor=place, bbox_transform=page.transData, borderpad=0.0, handlelength=1.9,
        handletextpad=0.6, labelspacing=0.45, borderaxespad=0.0,
    )  # fmt: skip
