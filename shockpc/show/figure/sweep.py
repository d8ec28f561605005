"""Shock over a sweep: a curve for one quantity, a map with iso-lines for two, distributions otherwise."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.printed import printable
from shockpc.show.figure.page import round_step
from shockpc.show.figure.style import BANDS, CURVES, INK, PAPER, band, new_chart
from shockpc.studies.sweep.summary import Extent, SweepSummary
from shockpc.studies.sweep.variation import Variation

__all__ = ["draw_sweep"]

MOST = len(CURVES)
"""Curves and distributions of one figure."""

MAPS = 4
"""Maps of one figure."""

COLOUR_MAP = "YlGnBu"
"""Light to dark, as the bands of the other figures."""

SHOCK = "normalised shock |Δv| / v_in [-]"


def draw_sweep(summary: SweepSummary) -> Figure:
    """Draw the figure of a sweep."""
    extents = {printable(one.heading.removesuffix(" [-]"), 60): one for one in summary.extents if one.greatest_row >= 0}
    contacts = " + ".join(contact.frame for contact in summary.sweep.scene.contact)
    varied = any(one.kind == "contact" for one in summary.sweep.variations)
    title = printable(summary.sweep.robot.name + ("" if varied else f", landing on {contacts}"), 90)
    if not extents:
        return new_chart(5.0, 1.0, f"{title}: no landing could be computed")
    shown = dict(list(extents.items())[:MOST])
    values = {label: one.values for label, one in shown.items() if one.values is not None}
    axes = summary.sweep.axes
    if not values:
        return _distributions(f"{title}: {summary.sweep.rows} landings", shown)
    if len(axes) == 1:
        return _curves(title, axes[0], {"": values})
    grids = {label: x.reshape(len(axes[0].values), len(axes[1].values)) for label, x in list(values.items())[:MAPS]}
    if axes[0].kind != "contact":
        return _maps(title, axes[0], axes[1], grids)
    names = [printable(str(name), 60) for name in axes[0].values]
    return _curves(
        title, axes[1], {label: dict(list(zip(names, rows, strict=True))[:MOST]) for label, rows in grids.items()}, axes[0].subject
    )


def _scale(axis: Any, one: Variation) -> Array:
    """Places of the values along an axis, which is labelled: numbers as they are, names at equal distances."""
    axis.set_label_text(printable(one.column, 60))
    if one.kind != "contact":
        return np.array(one.values, dtype=float)
    axis.set_ticks(range(len(one.values)), labels=[printable(str(name), 24) for name in one.values])
    return np.arange(len(one.values), dtype=float)


def _curves(title: str, one: Variation, panels: Mapping[str, Mapping[str, Array]], varied: str = "") -> Figure:
    """Shock over one quantity: panels one above the other by their titles, each with curves by their names, the same in all.

    Args:
        title: of the figure.
        one: the quantity.
        panels: values by name of the curve by title of the panel.
        varied: what differs between the curves.
    """
    figure = new_chart(6.4, 1.6 + 2.0 * len(panels), title)
    every = figure.subplots(len(panels), 1, sharex=True, squeeze=False).ravel()
    for axes, (label, curves) in zip(every, panels.items(), strict=True):
        x = _scale(every[-1].xaxis, one)
        style: dict[str, Any] = {"linestyle": "none"} if one.kind == "contact" else {"linewidth": 1.3}
        style |= {"marker": "o", "markersize": 3.0} if len(x) <= 32 else {}
        lines = [axes.plot(x, y, color=colour, **style)[0] for colour, y in zip(CURVES, curves.values(), strict=False)]
        axes.set(ylim=(0.0, None), title=label)
        axes.grid(True)
    figure.supylabel(SHOCK, fontsize=7.5)
    figure.legend(lines, list(curves), loc="outside right upper", title=varied or None)
    return figure


def _maps(title: str, slow: Variation, fast: Variation, grids: Mapping[str, Array]) -> Figure:
    """Shock over two quantities, a panel for each point."""
    width = min(len(grids), 2)
    height = math.ceil(len(grids) / width)
    figure = new_chart(3.6 * width + 1.0, 3.0 * height + 0.3, title)
    most = max(float(np.nanmax(values)) for values in grids.values()) or 1.0
    panels = figure.subplots(height, width, squeeze=False).ravel()
    for panel in panels[len(grids) :]:
        panel.set_axis_off()
    mesh: Any = None
    for panel, (label, values) in zip(panels, grids.items(), strict=False):
        x, y = _scale(panel.xaxis, fast), _scale(panel.yaxis, slow)
        mesh = panel.pcolormesh(x, y, values, norm=Normalize(0.0, most), cmap=COLOUR_MAP, shading="nearest", rasterized=True)
        least, span = float(np.nanmin(values)), float(np.nanmax(values) - np.nanmin(values))
        if min(len(x), len(y)) > 2 and fast.kind != "contact" and span > 0.0:
            step = round_step(span / 6.0)
            levels = np.arange(math.ceil(least / step) * step, least + span, step)
            dark = [PAPER if level > 0.55 * most else INK for level in levels]
            lines = panel.contour(x, y, values, levels=levels, colors=dark, linewidths=0.6)
            panel.clabel(lines, fontsize=6.5, fmt="%g")
        panel.set_title(label)
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
    figure.supylabel("share of landings", fontsize=7.5)
    panels[-1].set(xlabel=f"{SHOCK}; dashed: median", xlim=(0.0, None))
    return figure
