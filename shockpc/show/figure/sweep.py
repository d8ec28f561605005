"""Shock over a sweep: a curve for one quantity, a map with iso-lines for two, distributions otherwise."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.printed import printable
from shockpc.show.figure.style import BANDS, CURVES, INK, PAPER, SHOCK, band, new_chart
from shockpc.studies.sweep.summary import Extent, SweepSummary
from shockpc.studies.sweep.variation import Variation

__all__ = ["draw_sweep"]

MOST, MAPS = len(CURVES), 4
"""Curves or distributions, and maps, of one figure."""

COLOUR_MAP = "YlGnBu"
"""Light to dark, as the bands of the other figures."""


def draw_sweep(summary: SweepSummary) -> Figure:
    """Draw the figure of a sweep."""
    sweep, axes = summary.sweep, summary.sweep.axes
    contacts = " + ".join(contact.frame for contact in sweep.scene.contact)
    varied = any(one.kind == "contact" for one in sweep.variations)
    title = printable(sweep.robot.name + ("" if varied else f", landing on {contacts}"), 90)
    extents = {printable(one.heading, 60): one for one in summary.extents if one.greatest_row >= 0}
    shown = dict(list(extents.items())[:MOST])
    values = {label: one.values for label, one in shown.items() if one.values is not None}
    if not shown:
        return new_chart(5.0, 1.0, f"{title}: no landing could be computed")
    if not values:
        return _distributions(f"{title}: {sweep.rows} landings", shown)
    if len(axes) == 1:
        return _curves(title, axes[0], {"": values})
    slow, fast = axes
    grids = {label: x.reshape(len(slow.values), len(fast.values)) for label, x in list(values.items())[:MAPS]}
    if fast.kind == "contact":
        slow, fast, grids = fast, slow, {label: x.T for label, x in grids.items()}
    if slow.kind != "contact":
        return _maps(title, slow, fast, grids)
    names = [printable(str(name), 60) for name in slow.values[:MOST]]
    return _curves(title, fast, {label: dict(zip(names, x, strict=False)) for label, x in grids.items()}, slow.subject)


def _curves(title: str, one: Variation, panels: Mapping[str, Mapping[str, Array]], varied: str = "") -> Figure:
    """Shock over one quantity: panels one above the other by their titles, each with curves by their names, the same in all.

    Args:
        title: of the figure.
        one: the quantity.
        panels: values by name of the curve by title of the panel.
        varied: what differs between the curves.
    """
    figure = new_chart(6.4, 1.6 + 2.0 * len(panels), title)
    x = [printable(str(name), 24) if one.kind == "contact" else name for name in one.values]
    style: dict[str, Any] = {"linestyle": "none"} if one.kind == "contact" else {"linewidth": 1.3}
    style |= {"marker": "o", "markersize": 3.0} if len(x) <= 32 else {}
    every = figure.subplots(len(panels), 1, sharex=True, squeeze=False).ravel()
    for axes, (label, curves) in zip(every, panels.items(), strict=True):
        lines = [axes.plot(x, y, color=colour, **style)[0] for colour, y in zip(CURVES, curves.values(), strict=False)]
        axes.set(ylim=(0.0, None), title=label)
        axes.grid(True)
    axes.set_xlabel(printable(one.column, 60))
    figure.supylabel(SHOCK)
    figure.legend(lines, list(curves), loc="outside right upper", title=varied or None)
    return figure


def _maps(title: str, slow: Variation, fast: Variation, grids: Mapping[str, Array]) -> Figure:
    """Shock over two quantities, a panel for each point."""
    across = min(len(grids), 2)
    down = math.ceil(len(grids) / across)
    figure = new_chart(3.6 * across + 1.0, 3.0 * down + 0.3, title)
    most = max(float(np.nanmax(values)) for values in grids.values()) or 1.0
    panels = figure.subplots(down, across, squeeze=False).ravel()[: len(grids)]
    for panel, (label, values) in zip(panels, grids.items(), strict=True):
        place = np.array(fast.values, dtype=float), np.array(slow.values, dtype=float), values
        mesh = panel.pcolormesh(*place, cmap=COLOUR_MAP, vmin=0.0, vmax=most, shading="nearest", rasterized=True)
        panel.set(title=label, xlabel=printable(fast.column, 60), ylabel=printable(slow.column, 60))
        if min(values.shape) > 2 and np.nanmax(values) > np.nanmin(values):
            contrast = {"cmap": ListedColormap([INK, PAPER]), "vmin": 0.0, "vmax": 1.1 * most}
            panel.clabel(panel.contour(*place, levels=6, linewidths=0.6, **contrast), fontsize=6.5, fmt="%g")
    for unused in figure.axes[len(grids) :]:
        unused.remove()
    figure.colorbar(mesh, ax=panels.tolist(), aspect=30, label=SHOCK)
    return figure


def _distributions(title: str, extents: Mapping[str, Extent]) -> Figure:
    """How often a shock occurs, a panel for each point, one above the other with a common scale."""
    figure = new_chart(6.4, 1.1 + 0.95 * len(extents), title)
    panels = figure.subplots(len(extents), 1, sharex=True, squeeze=False).ravel()
    for panel, (label, extent) in zip(panels, extents.items(), strict=True):
        margin = 0.0 if extent.greatest > extent.least else 0.005
        edges = np.linspace(extent.least - margin, extent.greatest + margin, len(extent.counts) + 1)
        colours = [BANDS[band(x)] for x in 0.5 * (edges[1:] + edges[:-1])]
        panel.bar(edges[:-1], extent.counts / extent.counts.sum(), np.diff(edges), align="edge", color=colours)
        panel.stairs(extent.counts / extent.counts.sum(), edges, color=INK, linewidth=0.6)
        panel.axvline(extent.median, color=INK, linewidth=0.8, linestyle="--")
        panel.set(title=f"{label}: median {extent.median:.3g}, greatest {extent.greatest:.3g}", yticks=[])
        panel.spines["left"].set_visible(False)
    figure.supylabel("share of landings")
    panels[-1].set(xlabel=f"{SHOCK}; dashed: median", xlim=(0.0, None))
    return figure
