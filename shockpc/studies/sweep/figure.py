"""Figures of quantities over a sweep.

They are curves over one variable, maps with iso-lines over two, and distributions and correlations
otherwise.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_hex
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.evaluation.variations.variation import Variation
from shockpc.show.figure.style import CURVES, INK, SHOCK, histogram, new_chart, shock_levels
from shockpc.show.wording import robot_name, varied_text
from shockpc.studies.sweep.summary import Extent, Summary
from shockpc.text.printed import printable

MOST_MARKERS = 32
"""Points of a curve that have markers, at most."""

MOST_CURVES, MAPS = len(CURVES), 4
"""Curves or distributions, and maps, of one figure."""

BARS = 5
"""Varied quantities whose rank correlations are drawn beside a distribution."""

USUAL = 98.0
"""Share of a map's values that its colours tell apart, where others are far greater [%]."""

COLOUR_MAP = "YlGnBu"
"""Colour map of quantities other than shocks."""


class _Curve(NamedTuple):
    """Values that are drawn: their name, the label of their axis with the unit, and the values.

    They are (n,) or, of a map, (slow, fast).
    """

    name: str
    label: str
    values: Array


def draw_sweep(summary: Summary[VariedLandings]) -> Figure:
    """Draw the figure of a sweep."""
    sweep = summary.evaluation.landings
    title = _title(sweep)
    shown = [extent for extent in summary.extents if extent.counts.any()][:MOST_CURVES]
    if not shown:
        return new_chart(5.0, 1.0, f"{title}: no landing could be computed")
    values = [_curve(extent) for extent in shown if extent.values is not None]
    if not values:
        return _distributions(f"{title}: {sweep.rows} landings", shown, summary)
    if len(sweep.axes) == 1:
        panels: dict[str, list[_Curve]] = {}
        for curve in values:
            panels.setdefault(curve.label, []).append(curve)
        return _curves(title, sweep.axes[0], panels)

    slow, fast = sweep.axes
    shape = len(slow.values), len(fast.values)
    grids = [curve._replace(values=curve.values.reshape(shape)) for curve in values[:MAPS]]
    if fast.kind.names_contacts:
        slow, fast = fast, slow
        grids = [grid._replace(values=grid.values.T) for grid in grids]
    if not slow.kind.names_contacts:
        return _maps(title, slow, fast, grids)
    panels = {grid.name: _by_contact(slow, grid) for grid in grids}
    return _curves(title, fast, panels, slow.subject)


def _title(sweep: VariedLandings) -> str:
    """The robot, and the contacts unless they vary."""
    robot = robot_name(sweep.robot)
    if any(variable.kind.names_contacts for variable in sweep.variations):
        return robot
    contacts = " + ".join(contact.frame for contact in sweep.scene.contact)
    return robot + printable(f", landing on {contacts}", 70)


def _curve(extent: Extent) -> _Curve:
    """The values of a column; NaN where they are infinite."""
    values = np.asarray(extent.values)
    finite = np.where(np.isfinite(values), values, np.nan)
    return _Curve(printable(extent.column.title, 60), _label(extent), finite)


def _by_contact(contacts: Variation, grid: _Curve) -> list[_Curve]:
    """The rows of a map over contacts and another variable, as a curve for each contact."""
    curves = []
    for name, values in zip(contacts.values[:MOST_CURVES], grid.values, strict=False):
        curves.append(_Curve(printable(str(name), 60), grid.label, values))
    return curves


def _label(extent: Extent) -> str:
    """The label of an axis: the quantity with its unit."""
    if extent.column.shock:
        return SHOCK
    quantity = extent.column.selection.quantity
    return printable(f"{quantity.title} [{quantity.unit.replace('1', '-')}]", 60)


def _axis(variable: Variation) -> str:
    """The name of a variable in words, with its unit."""
    words = varied_text(variable.subject, variable.unit)
    return f"{words} [{variable.unit}]" if variable.unit else words


def _curves(
    title: str, variable: Variation, panels: Mapping[str, Sequence[_Curve]], varied: str = ""
) -> Figure:
    """Curves over one variable: panels one above the other, each with curves of one label.

    Args:
        title: of the figure.
        variable: over which they are drawn.
        panels: the curves of each; it is named where what varies besides differs between its
            curves.
        varied: what that is.
    """
    figure = new_chart(6.4, 1.6 + 2.0 * len(panels), title)
    x: Sequence[float | str] = variable.values
    style: dict[str, Any] = {"linewidth": 1.3}
    if variable.kind.names_contacts:
        x = [printable(str(name), 24) for name in variable.values]
        style = {"linestyle": "none"}
    if len(x) <= MOST_MARKERS:
        style |= {"marker": "o", "markersize": 3.0}
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False).ravel()
    for axes, (name, curves) in zip(rows, panels.items(), strict=True):
        for colour, curve in zip(CURVES, curves, strict=False):
            axes.plot(x, curve.values, color=colour, label=curve.name, **style)
        axes.set(ylabel=curves[0].label, title=name if varied else "")
        if not min(np.nanmin(curve.values) for curve in curves) < 0.0:
            axes.set_ylim(bottom=0.0)
        axes.grid(True)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), title=varied or None)
    axes.set_xlabel(_axis(variable))
    return figure


def _maps(title: str, slow: Variation, fast: Variation, grids: Sequence[_Curve]) -> Figure:
    """Maps over two variables, a panel each, those of one label with one scale of colours."""
    across = min(len(grids), 2)
    down = math.ceil(len(grids) / across)
    figure = new_chart(3.6 * across + 1.0, 3.0 * down + 0.3, title)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    by_label: dict[str, list[tuple[Axes, _Curve]]] = {}
    for panel, grid in zip(panels, grids, strict=False):
        by_label.setdefault(grid.label, []).append((panel, grid))
        panel.set(title=grid.name, xlabel=_axis(fast), ylabel=_axis(slow))
    x, y = (np.array(variable.values, dtype=float) for variable in (fast, slow))
    for label, maps in by_label.items():
        scale = _scale(label, np.concatenate([grid.values.ravel() for _, grid in maps]))
        for panel, grid in maps:
            mesh = _draw_map(panel, x, y, grid.values, scale)
        figure.colorbar(mesh, ax=[panel for panel, _ in maps], aspect=30, label=label)
    for unused in panels[len(grids) :]:
        unused.remove()
    return figure


class _Scale(NamedTuple):
    """The colours of maps: limits and colours of the bands, and whether the last band is open."""

    levels: list[float]
    colours: list[str]
    open_end: bool


def _scale(label: str, values: Array) -> _Scale:
    """The colours of all values (n,) with a label."""
    least = min(0.0, float(np.nanmin(values)))
    most, usual = float(np.nanmax(values)), float(np.nanpercentile(values, USUAL))
    # A few values that are far greater than all others would leave those in one colour.
    open_end = most > 2.0 * usual > 0.0
    most = usual if open_end else max(most, least + 1e-9)
    if label == SHOCK:
        levels, colours = shock_levels(least, most)
    else:
        levels = list(map(float, MaxNLocator(9).tick_values(least, most)))
        shares = np.linspace(0.0, 1.0, len(levels) - 1)
        colours = [to_hex(colour) for colour in colormaps[COLOUR_MAP](shares)]
    open_end = open_end or math.isinf(levels[-1])
    # An open band has no upper limit.
    most_levels = len(colours) if open_end else len(colours) + 1
    return _Scale(levels[:most_levels], list(colours), open_end)


def _draw_map(panel: Axes, x: Array, y: Array, values: Array, scale: _Scale) -> Any:
    """Draw values (slow, fast) in bands of colour; what a bar of colours is drawn for."""
    extend: Literal["max", "neither"] = "max" if scale.open_end else "neither"
    norm = BoundaryNorm(scale.levels, len(scale.colours), extend=extend)
    colours: dict[str, Any] = {"cmap": ListedColormap(scale.colours), "norm": norm}
    if min(values.shape) < 3:
        return panel.pcolormesh(x, y, values, shading="nearest", **colours)
    # Areas and lines are of one grid, so that each line is the edge of a colour.
    style: dict[str, Any] = {"extend": extend, "antialiased": False, **colours}
    mesh = panel.contourf(x, y, values, levels=scale.levels, **style)
    panel.contour(mesh, levels=scale.levels[1:], colors=INK, linewidths=0.5)
    return mesh


def _distributions(
    title: str, extents: Sequence[Extent], summary: Summary[VariedLandings]
) -> Figure:
    """The distributions of columns in panels, one above the other.

    Shocks have a common scale. Beside the distributions of a sample are the rank correlations with
    what was varied, the strongest first.
    """
    beside = bool(summary.varied)
    width, height = (9.6, 1.3) if beside else (6.4, 0.95)
    figure = new_chart(width, 1.1 + height * len(extents), title)
    common = len({_label(extent) for extent in extents}) == 1
    share: Any = "col" if common else False
    grid = figure.subplots(len(extents), 1 + beside, sharex=share, squeeze=False)
    if beside:
        for panel, extent in zip(grid[:, 1], extents, strict=True):
            _bars(panel, summary, summary.extents.index(extent))
        grid[-1, 1].set_xlabel("rank correlation with what was varied; grey: within chance")
    for panel, extent in zip(grid[:, 0], extents, strict=True):
        _histogram(panel, extent, common)
    figure.supylabel("share of landings")
    below = "dashed: median"
    if common:
        below = f"{_label(extents[0])}; {below}"
    grid[-1, 0].set_xlabel(below)
    return figure


def _histogram(panel: Axes, extent: Extent, common: bool) -> None:
    """Draw how often the values of a column occur. Args: common, whether panels have one unit."""
    low, high = extent.span
    margin = 0.0
    if low == high:
        margin = 0.005 * (abs(high) or 1.0)
    joined = _joined_bins(len(extent.counts), int(extent.counts.sum()))
    shares = extent.counts.reshape(-1, joined).sum(axis=1) / extent.counts.sum()
    edges = np.linspace(low - margin, high + margin, len(shares) + 1)
    histogram(panel, shares, edges, extent.median)
    unit = "" if common else f" [{extent.column.unit}]"
    name = printable(f"{extent.column.title}{unit}", 80)
    median, greatest = f"median {extent.median:.4g}", f"maximum {extent.greatest:.4g}"
    panel.set(title=f"{name}: {median}, {greatest}", yticks=[])
    panel.spines["left"].set_visible(False)
    if 0.0 <= extent.least < 0.5 * extent.greatest:
        panel.set_xlim(left=0.0)


def _joined_bins(bins: int, values: int) -> int:
    """The number of intervals of a histogram that are joined.

    Few landings have few intervals, so that the shape is not that of chance.
    """
    for joined in (1, 2, 4, 5, 8, 10):
        if bins % joined == 0 and bins / joined <= 2.0 * values**0.5:
            return joined
    return 1


def _bars(panel: Axes, summary: Summary[VariedLandings], k: int) -> None:
    """The strongest rank correlations of one column with what was varied."""
    correlations = np.nan_to_num(summary.correlations[:, k])
    strongest = np.argsort(-np.abs(correlations), kind="stable")[:BARS]
    names = [varied_text(summary.varied[i].subject, summary.varied[i].unit) for i in strongest]
    panel.axvspan(-summary.chance, summary.chance, color="#e6e6e6", zorder=0)
    panel.barh(range(len(names)), correlations[strongest], color=CURVES[0], height=0.7)
    panel.set(yticks=range(len(names)), yticklabels=names, xlim=(-1.0, 1.0))
    panel.invert_yaxis()
    panel.axvline(0.0, color=INK, linewidth=0.6)
