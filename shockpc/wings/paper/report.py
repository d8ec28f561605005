"""The paper's claims and their outcomes, failed ones first, and the landings of its figures."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from shockpc import Point, ShockProfile
from shockpc.landing.scenes.scene_file import scene_text
from shockpc.show.document import record
from shockpc.show.html import plotly
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines, Row, Sheet
from shockpc.wings.paper.claim import Claim, PaperFigure
from shockpc.wings.paper.panel_landings import land, scene

OUTCOMES = {
    "does not hold": "do not hold",
    "as interpreted": "hold as interpreted, but not under an alternative",
    "holds": "hold",
}
"""Outcomes of a claim, and the words for several; "as interpreted" if an alternative changes it."""

LIVE = {
    1: (
        ("the beam, struck anywhere", "fig1_d", "pivot"),
        ("a bat and its sweet spot", "bat", "hands"),
    ),
    2: (("the leg of two links", "fig2_a", "upper_leg"),),
}
"""The moving part of report.html by figure: name, scene, and frame of the point of the shock."""


def paper_report(figures: Sequence[PaperFigure], verbose: bool = False) -> Report:
    """The claims and figures of the paper.

    Args:
        figures: those that are shown, with their claims.
        verbose: whether a terminal also shows the alternatives that change an outcome, and the
            bodies.
    """
    claims = [claim for figure in figures for claim in figure.claims]

    def body(full: bool) -> Iterator[Section]:
        yield _outcomes_sheet(claims)
        if full:
            yield from map(paper_picture, figures)
            yield Lines([f"Figure {figure.number}: {figure.note}" for figure in figures])
            yield _claims_sheet(claims)
        elif verbose:
            yield Lines(_details(claims), "details")
        if full or verbose:
            yield _bodies_sheet(figures)

    return Report(
        name="paper",
        title="Figures and claims of the paper",
        page="paper",
        body=body,
        lead=len(figures) + 4,
        landings=_live_landings(figures) if plotly() else {},
        live=(),
        sheets={"claims": lambda: _claims_sheet(claims), "bodies": lambda: _bodies_sheet(figures)},
        document=lambda: {"figures": list(map(_figure_document, figures))},
        tables=True,
        more=lambda folder: _scenes(figures, folder),
    )


def _figure_document(figure: PaperFigure) -> dict[str, Any]:
    """A figure in the document."""
    return {**record(figure, "number", "title", "note"), "panels": figure.panels}


def _scenes(figures: Sequence[PaperFigure], folder: Path) -> dict[str, str]:
    """The scenes of all panels as files by name."""
    files: dict[str, str] = {}
    for figure in figures:
        for panel in figure.panels:
            files[f"{panel.scene}.toml"] = scene_text(scene(panel.scene), folder)
    return files


def _live_landings(figures: Sequence[PaperFigure]) -> dict[str, ShockProfile]:
    """The landings of the moving part of report.html by name."""
    landings: dict[str, ShockProfile] = {}
    for figure in figures:
        for name, stem, frame in LIVE.get(figure.number, ()):
            landings[name] = land(stem, point=(Point(frame=frame),))
    return landings


def paper_picture(figure: PaperFigure) -> Picture:
    """The panels of a figure of the paper side by side."""
    labels = [panel.label for panel in figure.panels]
    captions = [[panel.words] for panel in figure.panels]
    title = f"Figure {figure.number}: {figure.title}"
    drawn = (figure.profiles, title, labels, captions, figure.note)
    return Picture(f"figure{figure.number}", title, "wings.paper.figure:draw_panels", drawn)


def _outcomes_sheet(claims: Sequence[Claim]) -> Sheet:
    """The claims with their outcomes, those that do not hold first."""
    own = _claims_sheet(claims).where(lambda row: not row["alternative"])
    sheet = own.only("outcome", "section", "claim", "value", "holds_if")
    order = list(OUTCOMES)
    rows = sorted(sheet.rows, key=lambda row: order.index(str(row[0])))
    outcomes = [row[0] for row in rows]
    counts = []
    for outcome, words in reversed(OUTCOMES.items()):
        if outcome in outcomes:
            counts.append(f"{outcomes.count(outcome)} {words}")
    title = f"claims of the paper: {', '.join(counts)}"
    notes = ("the quantities, and the alternatives that change an outcome: --verbose, or --out",)
    return sheet._replace(title=title, rows=rows, notes=notes)


def _details(claims: Sequence[Claim]) -> list[str]:
    """Every claim with its quantity and its outcomes; several lines each."""
    lines = []
    for claim in claims:
        lines += [claim.statement, f"    {claim.quantity}, {claim.criterion}"]
        for interpretation, value, outcome in _outcomes(claim):
            lines.append(f"    {outcome:<14} {value:>9.4g}  {interpretation}")
    return lines


def _bodies_sheet(figures: Sequence[PaperFigure]) -> Sheet:
    rows: list[Row] = []
    for figure in figures:
        for panel, profile in zip(figure.panels, figure.profiles, strict=True):
            for i, body in enumerate(profile.bodies):
                copc = (profile.copc[i, 0], profile.copc[i, 2])
                shock = (profile.shock_com[i], profile.shock_min[i], profile.shock_max[i])
                motion = "translates" if profile.translates[i] else None
                rows.append(
                    (f"{figure.number} {panel.label}", body, *copc, profile.ropc[i], *shock, motion)
                )
    header = (
        "figure",
        "body",
        "CoPc x [m]",
        "CoPc z [m]",
        "RoPc [m]",
        "shock at CoM [-]",
        "minimum [-]",
        "maximum [-]",
        "motion",
    )
    notes = (
        ("Figure 3: all masses and most lengths are assumed",)
        if any(figure.number == 3 for figure in figures)
        else ()
    )
    return Sheet(
        "bodies (CoPc in body coordinates, joints free; shock: |Δv| / v_in)",
        header,
        rows,
        notes,
    )


def _claims_sheet(claims: Sequence[Claim]) -> Sheet:
    """A row for each claim, and for each alternative interpretation with a different outcome."""
    rows: list[Row] = []
    for claim in claims:
        section, _, text = claim.statement.partition(": ")
        for k, (interpretation, value, outcome) in enumerate(_outcomes(claim)):
            rows.append(
                (
                    outcome,
                    section,
                    text,
                    value,
                    claim.criterion,
                    interpretation,
                    k > 0,
                    claim.quantity,
                )
            )
    header = (
        "outcome",
        "section",
        "claim",
        "value",
        "holds if",
        "interpretation",
        "alternative",
        "quantity",
    )
    return Sheet("claims of the paper, with the alternatives that change the outcome", header, rows)


def _outcomes(claim: Claim) -> Iterator[tuple[str, float, str]]:
    """Interpretation, value and outcome of a claim and of its alternatives.

    Of the alternatives only those with the opposite outcome are listed.
    """
    fails, as_interpreted, holds = OUTCOMES
    outcome, opposite = fails, holds
    if claim.holds:
        outcome = as_interpreted if claim.alternatives else holds
        opposite = fails
    yield claim.interpretation, _without_rounding(claim.value), outcome
    for name, value in claim.alternatives.items():
        yield name, _without_rounding(value), opposite


def _without_rounding(value: float) -> float:
    """A value, or zero for one that is zero but for rounding."""
    return 0.0 if abs(value) < 1e-15 else value
