"""`shockpc paper`: recompute the figures of the paper that the method is from."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from shockpc.cli.declare import option
from shockpc.cli.parse import path

__all__ = ["paper"]


def paper(
    figures: Annotated[
        list[str] | None,
        typer.Argument(metavar="[FIGURE]...", help="Numbers of figures: 1, 2, 3, 5; all by default.", show_default=False),
    ] = None,
    out: Annotated[
        Path | None,
        option("Write figures, tables and the scenes of all panels into this folder.", group="Output", metavar="DIR", parser=path),
    ] = None,
) -> None:
    """Recompute the figures of the paper and check its claims."""
    from shockpc.paper.figures import paper_figures
    from shockpc.show.files import check_folder
    from shockpc.show.reports.paper import paper_text, write_paper

    chosen = paper_figures(figures or ())
    if out is not None:
        check_folder(out, "--out")
        write_paper(chosen, out)
    sys.stdout.write(paper_text(chosen))
