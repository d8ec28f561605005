"""`shockpc paper`: recompute the figures of the paper that the method is from."""

import sys
from pathlib import Path

from shockpc.cli.declare import argument, command
from shockpc.cli.options import in_output
from shockpc.cli.parse import out_folder

__all__ = ["paper"]


@command(
    "Recompute the figures of the paper and check its claims.",
    "shockpc paper 1 --out paper/",
)
def paper(
    *,
    figures: tuple[str, ...] = argument("Numbers of figures: 1, 2, 3, 5; all by default.", "[FIGURE]..."),
    out: Path | None = in_output("Write figures, tables and the scenes of all panels into this folder.", "DIR", out_folder),
) -> None:
    from shockpc.cli.progress import ShownTrace
    from shockpc.paper.figures import paper_figures
    from shockpc.show.reports.paper import paper_text, write_paper

    chosen = paper_figures(figures)
    with ShownTrace().stage("figures and claims of the paper"):
        if out is not None:
            write_paper(chosen, out)
        text = paper_text(chosen)
    sys.stdout.write(text)
