"""`shockpc paper`: recompute the figures of the paper that the method is from."""

from shockpc.cli.declared import argument, command
from shockpc.cli.options import OutputOptions, in_output


@command(
    examples=("shockpc paper 1 --out paper/", "shockpc paper --beyond"),
    more="With --out, also the figures and the scenes of all panels.",
)
def paper(
    *,
    figures: tuple[str, ...] = argument(
        "Numbers of figures: 1, 2, 3, 5. [default: all]", "[FIGURE]..."
    ),
    beyond: bool = in_output(
        "The error of the paper's rigid answer for bodies that bend, in place of its figures and "
        "claims."
    ),
    verbose: bool = in_output(
        "Also show the interpretations that change an outcome, and the bodies of every figure."
    ),
    output: OutputOptions,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.cli.progress import shown_trace
    from shockpc.text.errors import SceneError
    from shockpc.text.wings import from_wings
    from shockpc.wings.paper.report import paper_report
    from shockpc.wings.paper.study import paper_figures

    if beyond:
        if figures:
            raise SceneError("--beyond is of no figure of the paper; leave one of them out")
        reports = from_wings("report", "beyond_report")
        if not reports:
            raise SceneError("--beyond needs the studies of bodies that bend, which are not here")
        for beyond_report in reports:
            emit(beyond_report(), output)
        return
    chosen = paper_figures(figures)
    with shown_trace().stage("claims of the paper"):
        for figure in chosen:
            for claim in figure.claims:
                _ = claim.alternatives  # computed once, and kept
    emit(paper_report(chosen, verbose), output)
