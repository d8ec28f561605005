"""Shock over a sweep: a curve for one quantity, a map with iso-lines for two, distributions otherwise."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.printed import printable
from shockpc.show.figure.palette import BANDS, INK, PAPER, band
from shockpc.studies.sweep.summary import Extent, SweepSummary
from shockpc.studies.sweep.variation import Variation

__all__ = ["draw_sweep"]

COLOURS = ("#1f5f9f", "#c2512f", "#3f8f4f", "#7a4fa0", "#a08020", "#208f8f", "#a0406f", "#606060")
MOST = 8
"""Curves and distributions of one figure."""

MAPS = 4
"""Maps of one figure."""

COLOUR_MAP = "YlGnBu"
"""Light to dark, as the bands of the other figures."""


def draw_sweep(summary: SweepSummary) -> Figure:
    """Draw the figure of a sweep."""
    extents = [one for one in summary.extents if one.greatest_row >= 0]
    axes = list(summary.sweep.axes)
    if not extents:
        figure = Figure(figsize=(5.0, 1.0), facecolor=PAPER)
        figure.text(0.5, 0.5, "no landing could be computed", ha="center", va="center")
        return figure
    if extents[0].values is None:
        return _distributions(summary, extents[:MOST])
    if len(axes) == 1:
        return _curves(summary, axes[0], extents[:MOST])
    return (_families if axes[0].kind == "contact" else _maps)(summary, axes, extents[:MAPS])


def _label(one: Extent) -> str:
    return printable(one.heading.removesuffix(" [-]"), 60)


def _values(one: Extent) -> Array:
    return np.zeros(0) if one.values is None else one.values


def _title(summary: SweepSummary) -> str:
    contacts = " + ".join(contact.frame for contact in summary.sweep.scene.contact)
    varied = any(one.kind == "contact" for one in summary.sweep.variations)
    return printable(f"{summary.sweep.robot.name}" + ("" if varied else f", landing on {contacts}"), 90)


def _scale(axis: Any, one: Variation) -> Array:
    """Places of the values along an axis, which is labelled: numbers as they are, names at equal distances."""
    axis.set_label_text(printable(one.column, 60))
    if one.kind != "contact":
        return np.array(one.values, dtype=float)
    axis.set_ticks(range(len(one.values)), labels=[printable(str(name), 24) for name in one.values])
    return np.arange(len(one.values), dtype=float)


def _plain(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=7.0, length=2.5, width=0.6)


def _curves(summary: SweepSummary, one: Variation, extents: list[Extent]) -> Figure:
    """Shock over one quantity."""
    figure = Figure(figsize=(6.4, 3.6), facecolor=PAPER, layout="constrained")
    axes = figure.add_subplot(ylabel="normalised shock |Δv| / v_in [-]", title="")
    x = _scale(axes.xaxis, one)
    for k, extent in enumerate(extents):
        style: dict[str, Any] = {"linestyle": "none"} if one.kind == "contact" else {"linewidth": 1.3}
        style |= {"marker": "o", "markersize": 3.0} if len(x) <= 32 else {}
        axes.plot(x, _values(extent), color=COLOURS[k], label=_label(extent), **style)
    axes.set_ylim(bottom=0.0)
    axes.set_title(_title(summary), fontsize=9.0, loc="left")
    axes.grid(True, linewidth=0.4, color="#dddddd")
    _plain(axes)
    figure.legend(loc="outside right upper", fontsize=7.5)
    return figure


def _families(summary: SweepSummary, axes: list[Variation], extents: list[Extent]) -> Figure:
    """Shock over one quantity, a panel for each point and a curve for each contact."""
    contacts, one = axes
    figure = Figure(figsize=(6.4, 0.8 + 2.0 * len(extents)), facecolor=PAPER, layout="constrained")
    panels = figure.subplots(len(extents), 1, sharex=True, squeeze=False).ravel()
    for panel, extent in zip(panels, extents, strict=True):
        x = np.array(one.values, dtype=float)
        for k, y in enumerate(_values(extent).reshape(len(contacts.values), len(x))[: len(COLOURS)]):
            style: dict[str, Any] = {"marker": "o", "markersize": 3.0} if len(x) <= 32 else {}
            label = printable(str(contacts.values[k]), 60) if panel is panels[0] else None
            panel.plot(x, y, color=COLOURS[k], linewidth=1.3, label=label, **style)
        panel.set_ylim(bottom=0.0)
        panel.set_title(_label(extent), fontsize=8.0, loc="left")
        panel.grid(True, linewidth=0.4, color="#dddddd")
        _plain(panel)
    panels[-1].set_xlabel(printable(one.column, 60))
    figure.supylabel("normalised shock |Δv| / v_in [-]", fontsize=7.5)
    figure.suptitle(_title(summary), fontsize=9.0, x=0.01, ha="left")
    figure.legend(loc="outside right upper", fontsize=7.5, title="contact", title_fontsize=7.5)
    return figure


def _maps(summary: SweepSummary, axes: list[Variation], extents: list[Extent]) -> Figure:
    """Shock over two quantities, a panel for each point."""
    slow, fast = axes
    count = len(extents)
    width = min(count, 2)
    height = math.ceil(count / width)
    figure = Figure(figsize=(3.6 * width + 1.0, 3.0 * height + 0.3), facecolor=PAPER, layout="constrained")
    most = max(one.greatest for one in extents) or 1.0
    norm = Normalize(0.0, most)
    panels = figure.subplots(height, width, squeeze=False).ravel()
    for panel in panels[count:]:
        panel.set_axis_off()
    mesh: Any = None
    for panel, extent in zip(panels, extents, strict=False):
        x, y = _scale(panel.xaxis, fast), _scale(panel.yaxis, slow)
        values = _values(extent).reshape(len(y), len(x))
        mesh = panel.pcolormesh(x, y, values, norm=norm, cmap=COLOUR_MAP, shading="nearest", rasterized=True)
        smooth = min(len(x), len(y)) > 2 and "contact" not in (slow.kind, fast.kind)
        if smooth and np.isfinite(values).any() and extent.greatest > extent.least:
            span = extent.greatest - extent.least
            levels = _round_levels(extent.least, span)
            dark = [PAPER if level > 0.55 * most else INK for level in levels]
            lines = panel.contour(x, y, values, levels=levels, colors=dark, linewidths=0.6)
            panel.clabel(lines, fontsize=6.5, fmt="%g")
        panel.set_title(_label(extent), fontsize=8.0, loc="left")
        panel.tick_params(labelsize=7.0, length=2.5, width=0.6)
    figure.suptitle(_title(summary), fontsize=9.0, x=0.01, ha="left")
    bar = figure.colorbar(mesh, ax=panels.tolist(), aspect=30)
    bar.set_label("normalised shock |Δv| / v_in [-]")
    bar.ax.tick_params(labelsize=7.0, length=2.5, width=0.6)
    bar.outline.set_linewidth(0.6)
    return figure


def _round_levels(least: float, span: float) -> Array:
    """About six round numbers within a range."""
    power = 10.0 ** math.floor(math.log10(span / 6.0))
    step = next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= span / 6.0)
    return np.arange(math.ceil(least / step) * step, least + span, step)


def _distributions(summary: SweepSummary, extents: list[Extent]) -> Figure:
    """How often a shock occurs, a panel for each point, one above the other with a common scale."""
    figure = Figure(figsize=(6.4, 1.1 + 0.95 * len(extents)), facecolor=PAPER, layout="constrained")
    panels = figure.subplots(len(extents), 1, sharex=True, squeeze=False).ravel()
    for panel, extent in zip(panels, extents, strict=True):
        edges = np.linspace(extent.least, extent.greatest, len(extent.counts) + 1)
        if not extent.greatest > extent.least:
            edges = np.linspace(extent.least - 0.005, extent.least + 0.005, len(extent.counts) + 1)
        middles = 0.5 * (edges[1:] + edges[:-1])
        colours = [BANDS[band(x)] for x in middles]
        panel.bar(edges[:-1], extent.counts / extent.counts.sum(), np.diff(edges), align="edge", color=colours)
        panel.stairs(extent.counts / extent.counts.sum(), edges, color=INK, linewidth=0.6)
        panel.axvline(extent.median, color=INK, linewidth=0.8, linestyle="--")
        panel.set_title(f"{_label(extent)}: median {extent.median:.3g}, greatest {extent.greatest:.3g}", fontsize=8.0, loc="left")
        panel.set_yticks([])
        panel.spines["left"].set_visible(False)
        _plain(panel)
    figure.supylabel("share of landings", fontsize=7.5)
    panels[-1].set_xlabel("normalised shock |Δv| / v_in [-]; dashed: median")
    panels[-1].set_xlim(left=0.0)
    figure.suptitle(f"{_title(summary)}: {summary.sweep.rows} landings", fontsize=9.0, x=0.01, ha="left")
    return figure
