"""The paper's claims and their outcomes, failed ones first, and the landings of its figures."""

from collections.abc import Sequence

from shockpc import Point
from shockpc.landing.scenes.scene_file import scene_text
from shockpc.show.document import record
from shockpc.show.html import plotly
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines, Row, Sheet
from shockpc.wings.paper.claim import Claim, PaperFigure
from shockpc.wings.paper.panel_landings import land, scene

OUTCOMES = ("does not hold", "as interpreted", "holds")
"""Outcomes of a claim; "as interpreted" if an alternative interpretation changes it."""

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

    def body(full: bool) -> list[Section]:
        if full:
            notes = [Lines([f"Figure {figure.number}: {figure.note}" for figure in figures])]
            return [
                _outcomes_sheet(claims),
                *map(paper_picture, figures),
                *notes,
                _claims_sheet(claims),
                _bodies_sheet(figures),
            ]
        details: list[Section] = [Lines(_details(claims), "details"), _bodies_sheet(figures)]
        return [_outcomes_sheet(claims), *(details if verbose else [])]

    landings = (
        {name: land(stem, point=(Point(frame=frame),)) for name, stem, frame in _live(figures)}
        if plotly()
        else {}
    )
    return Report(
        name="paper",
        title="Figures and claims of the paper",
        page="paper",
        body=body,
        lead=len(figures) + 4,
        landings=landings,
        live=(),
        sheets={"claims": lambda: _claims_sheet(claims), "bodies": lambda: _bodies_sheet(figures)},
        document=lambda: {
            "figures": [
                {**record(figure, "number", "title", "note"), "panels": figure.panels}
                for figure in figures
            ],
        },
        tables=True,
        more=lambda folder: {
            f"{panel.scene}.toml": scene_text(scene(panel.scene), folder)
            for figure in figures
            for panel in figure.panels
        },
    )


def _live(figures: Sequence[PaperFigure]) -> list[tuple[str, str, str]]:
    return [shown for figure in figures for shown in LIVE.get(figure.number, ())]


def paper_picture(figure: PaperFigure) -> Picture:
    """The panels of a figure of the paper side by side."""
    labels, captions = (
        [panel.label for panel in figure.panels],
        [[panel.words] for panel in figure.panels],
    )
    title = f"Figure {figure.number}: {figure.title}"
    drawn = (figure.profiles, title, labels, captions, figure.note)
    return Picture(f"figure{figure.number}", title, "wings.paper.figure:draw_panels", drawn)


def _outcomes_sheet(claims: Sequence[Claim]) -> Sheet:
    """The claims with their outcomes, those that do not hold first."""
    whole = _claims_sheet(claims).where(lambda row: not row["alternative"])
    sheet = whole.only("outcome", "section", "claim", "value", "holds_if")
    rows = sorted(sheet.rows, key=lambda row: OUTCOMES.index(str(row[0])))
    counts = [sum(row[0] == name for row in rows) for name in reversed(OUTCOMES)]
    words = ("hold", "hold as interpreted, but not under an alternative", "do not hold")
    title = ", ".join(
        f"{number} {text}" for number, text in zip(counts, words, strict=True) if number
    )
    notes = ("the quantities, and the alternatives that change an outcome: --verbose, or --out",)
    return sheet._replace(title=f"claims of the paper: {title}", rows=rows, notes=notes)


def _details(claims: Sequence[Claim]) -> list[str]:
    """Every claim with its quantity and its outcomes; several lines each."""
    lines = []
    for claim in claims:
        lines += [claim.statement, f"    {claim.quantity}, {claim.criterion}"]
        lines += [
            f"    {outcome:<14} {value:>9.4g}  {interpretation}"
            for interpretation, value, outcome in _outcomes(claim)
        ]
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
    rows = [
        (
            outcome,
            *claim.statement.partition(": ")[::2],
            value,
            claim.criterion,
            interpretation,
            k > 0,
            claim.quantity,
        )
        for claim in claims
        for k, (interpretation, value, outcome) in enumerate(_outcomes(claim))
    ]
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


def _outcomes(claim: Claim) -> list[tuple[str, float, str]]:
    """Interpretation, value and outcome of a claim and of its alternatives.

    Of the alternatives only those with the opposite outcome are listed.
    """
    fails, as_interpreted, holds = OUTCOMES
    own, other = (
        ((as_interpreted if claim.alternatives else holds), fails)
        if claim.holds
        else (fails, holds)
    )
    outcomes = [
        (claim.interpretation, claim.value, own),
        *((name, value, other) for name, value in claim.alternatives.items()),
    ]
    return [
        (name, 0.0 if abs(value) < 1e-15 else value, outcome) for name, value, outcome in outcomes
    ]
