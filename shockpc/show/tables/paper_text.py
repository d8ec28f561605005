"""The paper computed again, as text for a terminal and as a folder of files."""

from collections.abc import Sequence
from pathlib import Path

from shockpc.paper.results import FigureResult
from shockpc.paper.scenes import find_scene
from shockpc.scene_file import read_scene, scene_text
from shockpc.show.files import write_folder
from shockpc.show.tables.paper import paper_bodies_sheet, readings_sheet, statement_lines, statements_sheet
from shockpc.show.tables.text import as_csv, as_markdown, as_text

__all__ = ["paper_text", "write_paper"]


HOLDS, DEPENDS, FAILS = "hold under every reading of the text", "under some of them only", "under none"
"""What a verdict comes down to."""


def paper_text(results: Sequence[FigureResult]) -> str:
    """Bodies as a table, then every statement with its verdict."""
    statements = [statement for result in results for statement in result.statements]
    kinds = [_kind(s.verdict) for s in statements]
    told = ", ".join(f"{kinds.count(kind)} {kind}" for kind in (HOLDS, DEPENDS, FAILS) if kind in kinds)
    lines = "\n".join(statement_lines(statements))
    return f"{as_text(paper_bodies_sheet(results))}\nstatements of the paper: {told}\n{'─' * 8}\n{lines}\n"


def write_paper(results: Sequence[FigureResult], folder: Path) -> None:
    """Write figureN.svg and .png, bodies.csv, statements.csv, readings.csv, paper.md, and the scene of every panel.

    Raises:
        OutputError: the folder cannot be written.
    """
    from shockpc.show.figure.paper import paper_figure_files

    files: dict[str, str | bytes] = {}
    for result in results:
        files |= paper_figure_files(result.figure, result.profiles)
        files |= {f"{p.scene}.toml": scene_text(read_scene(find_scene(p.scene)), folder) for p in result.figure.panels}
    sheets = {"bodies": paper_bodies_sheet(results), "statements": statements_sheet(results), "readings": readings_sheet(results)}
    files |= {f"{name}.csv": as_csv(sheet) for name, sheet in sheets.items()}
    pictures = [
        f"![Figure {r.figure.number}: {r.figure.title}](figure{r.figure.number}.svg)\n\n*{r.figure.note}*\n" for r in results
    ]
    files["paper.md"] = "\n".join(["## The paper, computed again\n", *pictures, *map(as_markdown, sheets.values())])
    write_folder(folder, files)


def _kind(verdict: str) -> str:
    """Which of the three a verdict is."""
    if verdict == "holds":
        return HOLDS
    return DEPENDS if verdict.startswith("holds ") else FAILS
