"""The paper's figures and claims as tables, as text for a terminal, and as a folder of files."""

from collections.abc import Sequence
from pathlib import Path

from shockpc.paper.claim import Claim, PaperFigure
from shockpc.paper.landings import scene
from shockpc.scene import scene_text
from shockpc.show.files import write_folder
from shockpc.show.reports.report import Picture
from shockpc.show.tables import Row, Sheet, as_csv, as_markdown, as_text

__all__ = ["paper_picture", "paper_text", "write_paper"]


def paper_text(figures: Sequence[PaperFigure]) -> str:
    """The bodies as a table, then every claim with its outcomes, a short line each."""
    claims = [claim for figure in figures for claim in figure.claims]
    kinds = {
        "hold": sum(claim.holds and not claim.alternatives for claim in claims),
        "hold as interpreted, but not under an alternative": sum(claim.holds and bool(claim.alternatives) for claim in claims),
        "do not hold": sum(not claim.holds for claim in claims),
    }
    lines = ["claims of the paper: " + ", ".join(f"{count} {kind}" for kind, count in kinds.items() if count), "─" * 8]
    for claim in claims:
        lines += [claim.statement, f"    {claim.quantity}, {claim.criterion}"]
        lines += [f"    {outcome:<13} {value:>9.4g}  {interpretation}" for interpretation, value, outcome in _outcomes(claim)]
    return f"{as_text(_bodies_sheet(figures))}\n" + "\n".join(lines) + "\n"


def write_paper(figures: Sequence[PaperFigure], folder: Path) -> None:
    """Write figureN.svg and .png, bodies.csv, claims.csv, paper.md, and the scene of every panel.

    Raises:
        OutputError: the folder cannot be written.
    """
    files: dict[str, str | bytes] = {}
    parts = ["## Figures and claims of the paper\n"]
    for figure in figures:
        files |= paper_picture(figure).files()
        files |= {f"{panel.scene}.toml": scene_text(scene(panel.scene), folder) for panel in figure.panels}
        parts.append(f"![Figure {figure.number}: {figure.title}](figure{figure.number}.svg)\n\n*{figure.note}*\n")
    for name, sheet in (("bodies", _bodies_sheet(figures)), ("claims", _claims_sheet(figures))):
        files[f"{name}.csv"] = as_csv(sheet)
        parts.append(as_markdown(sheet))
    write_folder(folder, files | {"paper.md": "\n".join(parts)})


def paper_picture(figure: PaperFigure) -> Picture:
    """The panels of a figure of the paper side by side."""
    labels, captions = [panel.label for panel in figure.panels], [[panel.words] for panel in figure.panels]
    drawn = (figure.profiles, f"Figure {figure.number}: {figure.title}", labels, captions, figure.note)
    return Picture(f"figure{figure.number}", figure.title, "landing:draw_panels", drawn)


def _bodies_sheet(figures: Sequence[PaperFigure]) -> Sheet:
    """One row for every body of every panel."""
    rows: list[Row] = []
    for figure in figures:
        for panel, found in zip(figure.panels, figure.profiles, strict=True):
            for i, body in enumerate(found.bodies):
                copc = ("translates", None) if found.translates[i] else (found.copc[i, 0], found.copc[i, 2])
                shock = (found.shock_com[i], found.shock_min[i], found.shock_max[i])
                rows.append((f"{figure.number} {panel.label}", body, *copc, found.ropc[i], *shock))
    header = ("figure", "body", "CoPc x [m]", "CoPc z [m]", "RoPc [m]", "shock at CoM [-]", "least [-]", "greatest [-]")
    notes = ("Figure 3: all masses and most lengths are assumed",) if any(figure.number == 3 for figure in figures) else ()
    return Sheet("bodies (CoPc in body coordinates, joints free; shock relative to the strike)", header, rows, notes)


def _claims_sheet(figures: Sequence[PaperFigure]) -> Sheet:
    """One row for every claim, and one for each alternative interpretation that changes the outcome."""
    rows = [
        (*claim.statement.partition(": ")[::2], interpretation, claim.quantity, claim.criterion, value, outcome)
        for figure in figures
        for claim in figure.claims
        for interpretation, value, outcome in _outcomes(claim)
    ]
    header = ("section", "claim", "interpretation", "quantity", "holds if", "value", "outcome")
    return Sheet("claims of the paper, with the alternatives that change the outcome", header, rows)


def _outcomes(claim: Claim) -> list[tuple[str, float, str]]:
    """Interpretation, value and outcome of a claim, then of its alternatives, which have the other outcome."""
    outcome, other = ("holds", "does not hold") if claim.holds else ("does not hold", "holds")
    found = [(claim.interpretation, claim.value, outcome), *((name, value, other) for name, value in claim.alternatives.items())]
    return [(name, 0.0 if abs(value) < 1e-15 else value, result) for name, value, result in found]
