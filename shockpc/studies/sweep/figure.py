"""Quantities over a sweep: curves over one variable, maps with iso-lines over two, distributions
and correlations otherwise.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_hex
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from shockpc.core.spatial import Array
from shockpc.evaluation.kinds.contacts import CONTACT
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.varied_landings import VariedLandings
from shockpc.show.figure.style import CURVES, INK, SHOCK, histogram, new_chart, shock_levels
from shockpc.show.wording import robot_name, varied_text
from shockpc.studies.sweep.summary import Extent, Summary
from shockpc.text.printed import printable

MOST_CURVES, MAPS = len(CURVES), 4
"""Curves or distributions, and maps, of one figure."""

BARS = 5
"""Varied quantities whose rank correlations are drawn beside a distribution."""

USUAL = 98.0
"""Share of a map's values that its colours tell apart, where others are far greater [%]."""

COLOUR_MAP = "YlGnBu"
"""Of what is no shock."""


class _Curve(NamedTuple):
    """Values that are drawn: their name, the label of their axis with the unit, and the values (n,)
    or, of a map, (slow, fast).
    """

    name: str
    label: str
    values: Array


def draw_sweep(summary: Summary[VariedLandings]) -> Figure:
    """Draw the figure of a sweep."""
    sweep, axes = summary.evaluation.landings, summary.evaluation.landings.axes
    contacts = " + ".join(contact.frame for contact in sweep.scene.contact)
    varied = any(variation.kind == CONTACT for variation in sweep.variations)
    title = robot_name(sweep.robot) + ("" if varied else printable(f", landing on {contacts}", 70))
    shown = [extent for extent in summary.extents if extent.counts.any()][:MOST_CURVES]
    if not shown:
        return new_chart(5.0, 1.0, f"{title}: no landing could be computed")
    values = [
        _Curve(
            printable(extent.column.title, 60),
            _label(extent),
            np.where(np.isfinite(extent.values), extent.values, np.nan),
        )
        for extent in shown
        if extent.values is not None
    ]
    if not values:
        return _distributions(f"{title}: {sweep.rows} landings", shown, summary)
    if len(axes) == 1:
        labels = dict.fromkeys(curve.label for curve in values)
        return _curves(
            title,
            axes[0],
            {label: [curve for curve in values if curve.label == label] for label in labels},
        )
    slow, fast = axes
    grids = [
        curve._replace(values=curve.values.reshape(len(slow.values), len(fast.values)))
        for curve in values[:MAPS]
    ]
    if fast.kind == CONTACT:
        slow, fast, grids = fast, slow, [grid._replace(values=grid.values.T) for grid in grids]
    if slow.kind != CONTACT:
        return _maps(title, slow, fast, grids)
    names = [printable(str(name), 60) for name in slow.values[:MOST_CURVES]]
    panels = {
        grid.name: [
            _Curve(*row) for row in zip(names, [grid.label] * len(names), grid.values, strict=False)
        ]
        for grid in grids
    }
    return _curves(title, fast, panels, slow.subject)


def _label(extent: Extent) -> str:
    column, entry = extent.column, extent.column.selection.quantity
    return (
        SHOCK if column.shock else printable(f"{entry.title} [{entry.unit.replace('1', '-')}]", 60)
    )


def _axis(variable: Variation) -> str:
    """What is varied, in words, with its unit."""
    words = varied_text(variable.subject, variable.unit)
    return words if variable.kind == CONTACT else f"{words} [{variable.unit}]"


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
    x = [printable(str(name), 24) if variable.kind == CONTACT else name for name in variable.values]
    style: dict[str, Any] = (
        {"linestyle": "none"} if variable.kind == CONTACT else {"linewidth": 1.3}
    )
    style |= {"marker": "o", "markersize": 3.0} if len(x) <= 32 else {}
    every = figure.subplots(len(panels), 1, sharex=True, squeeze=False).ravel()
    for axes, (name, curves) in zip(every, panels.items(), strict=True):
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
    for label in dict.fromkeys(grid.label for grid in grids):
        maps = [
            (panel, grid) for panel, grid in zip(panels, grids, strict=False) if grid.label == label
        ]
        least = min(0.0, *(float(np.nanmin(grid.values)) for _, grid in maps))
        every = np.concatenate([grid.values.ravel() for _, grid in maps])
        most, usual = float(np.nanmax(every)), float(np.nanpercentile(every, USUAL))
        # A few values that are far greater than all others would leave those in one colour.
        open_end = most > 2.0 * usual > 0.0
        most = usual if open_end else max(most, least + 1e-9)
        if label == SHOCK:
            levels, colours = shock_levels(least, most)
        else:
            levels = [float(x) for x in MaxNLocator(9).tick_values(least, most)]
            colours = [
                to_hex(colour)
                for colour in colormaps[COLOUR_MAP](np.linspace(0.0, 1.0, len(levels) - 1))
            ]
        extend: Any = "max" if open_end or math.isinf(levels[-1]) else "neither"
        levels = levels[: len(colours) + (extend == "neither")]
        scale: dict[str, Any] = {
            "cmap": ListedColormap(colours),
            "norm": BoundaryNorm(levels, len(colours), extend=extend),
        }
        for panel, grid in maps:
            place = (
                np.array(fast.values, dtype=float),
                np.array(slow.values, dtype=float),
                grid.values,
            )
            panel.set(title=grid.name, xlabel=_axis(fast), ylabel=_axis(slow))
            if min(grid.values.shape) < 3:
                mesh: Any = panel.pcolormesh(*place, shading="nearest", **scale)
                continue
            # Areas and lines are of one grid, so that each line is the edge of a colour.
            mesh = panel.contourf(*place, levels=levels, extend=extend, antialiased=False, **scale)
            panel.contour(mesh, levels=levels[1:], colors=INK, linewidths=0.5)
        figure.colorbar(mesh, ax=[panel for panel, _ in maps], aspect=30, label=label)
    for unused in panels[len(grids) :]:
        unused.remove()
    return figure


def _distributions(
    title: str, extents: Sequence[Extent], summary: Summary[VariedLandings]
) -> Figure:
    """How often a value occurs, a panel for each column, one above the other; shocks have a common
    scale.

    Beside those of a sample are the rank correlations with what was varied, the strongest first.
    """
    beside = bool(summary.varied)
    figure = new_chart(
        9.6 if beside else 6.4, 1.1 + (1.3 if beside else 0.95) * len(extents), title
    )
    common = len({_label(extent) for extent in extents}) == 1
    grid = figure.subplots(
        len(extents), 1 + beside, sharex="col" if common else False, squeeze=False
    )
    panels = grid[:, 0]
    if beside:
        for panel, extent in zip(grid[:, 1], extents, strict=True):
            _bars(panel, summary, summary.extents.index(extent))
        grid[-1, 1].set_xlabel("rank correlation with what was varied; grey: within chance")
    for panel, extent in zip(panels, extents, strict=True):
        low, high = extent.span
        margin = 0.0 if high > low else 0.005 * (abs(high) or 1.0)
        total = extent.counts.sum()
        # Few landings have few intervals, so that the shape is not that of chance.
        joined = next(
            (
                n
                for n in (1, 2, 4, 5, 8, 10)
                if len(extent.counts) % n == 0 and len(extent.counts) / n <= 2.0 * total**0.5
            ),
            1,
        )
        shares = extent.counts.reshape(-1, joined).sum(axis=1) / total
        edges = np.linspace(low - margin, high + margin, len(shares) + 1)
        histogram(panel, shares, edges, extent.median)
        unit = "" if common else f" [{extent.column.unit}]"
        name = printable(f"{extent.column.title}{unit}", 80)
        panel.set(
            title=f"{name}: median {extent.median:.4g}, maximum {extent.greatest:.4g}", yticks=[]
        )
        panel.spines["left"].set_visible(False)
        if 0.0 <= extent.least < 0.5 * extent.greatest:
            panel.set_xlim(left=0.0)
    figure.supylabel("share of landings")
    panels[-1].set_xlabel(f"{_label(extents[0])}; dashed: median" if common else "dashed: median")
    return figure


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
