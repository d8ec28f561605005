"""`shockpc sweep`: many landings that differ in posture, strike, contact, inertia or joint model."""

import dataclasses
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from shockpc.cli.declare import option, takes_options
from shockpc.cli.options import RobotName, SceneOptions
from shockpc.cli.parse import Variable, path, variable
from shockpc.cli.streams import complain

if TYPE_CHECKING:
    from shockpc.studies.sweep.study import Sweep

__all__ = ["SweepOptions", "sweep"]

VARIED, COMPUTED, RUN = "What varies", "What is computed", "How it is computed, and where it is written"


@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """What a sweep is."""

    vary: Annotated[
        list[Variable],
        option(
            "Quantity and values: a:b:n, a list a,b,c or, with --sample, a range a:b. Quantities are a joint or a glob [deg; m if "
            "prismatic], base-roll, base-pitch, base-yaw and strike-angle [deg], speed [m/s], contact (names), offset-x, -y, -z "
            "[m], mass:LINK [kg; or factors, 0.8x:1.2x:9], com-x:LINK, -y, -z (a shift) [m], inertia:LINK (factors), "
            "armature:JOINTS [kg m²].",
            group=VARIED,
            metavar="NAME=VALUES",
            parser=variable,
        ),
    ] = field(default_factory=list)
    vary_each: Annotated[
        list[Variable],
        option(
            "The same for a glob of joints, each of which varies by itself.", group=VARIED, metavar="GLOB=VALUES", parser=variable
        ),
    ] = field(default_factory=list)
    sample: Annotated[
        int | None,
        option(
            "Random landings instead of the full grid. If no joint is varied, all are, within their limits.",
            group=VARIED,
            metavar="N",
        ),
    ] = None
    lhs: Annotated[bool, option("Draw the sample as a Latin hypercube.", "--lhs", group=VARIED)] = False
    seed: Annotated[int, option("Seed of the random numbers; 0 by default.", group=VARIED, metavar="N")] = 0
    at: Annotated[
        list[str],
        option("Point at which the shock is computed, offset in the frame [m].", group=COMPUTED, metavar="FRAME[:X,Y,Z]"),
    ] = field(default_factory=list)
    body: Annotated[
        list[str],
        option(
            "Body of which CoPc, RoPc and the shock at the CoM are computed; the base, if there is no --at either.",
            group=COMPUTED,
            metavar="NAME",
        ),
    ] = field(default_factory=list)
    greatest: Annotated[bool, option("Also the greatest shock over the geometry of each --body.", "--greatest", group=COMPUTED)] = (
        False
    )
    prove: Annotated[
        int,
        option("Random landings that are compared with a proof; 100 by default.", group=COMPUTED, metavar="N"),
    ] = 100


@takes_options
def sweep(
    robot: RobotName,
    options: SceneOptions,
    varied: SweepOptions,
    out: Annotated[Path, option("Folder of the rows, the summary and the figure.", group=RUN, metavar="DIR", parser=path)],
    format_: Annotated[
        Literal["parquet", "csv"], option("Format of the rows; parquet by default.", "--format", group=RUN)
    ] = "parquet",
    jobs: Annotated[int, option("Number of processes; 1 by default.", group=RUN, metavar="N")] = 1,
    cluster: Annotated[
        str | None,
        option("Compute on a running Dask cluster; DIR has to be shared with its workers.", group=RUN, metavar="ADDRESS"),
    ] = None,
    resume: Annotated[bool, option("Continue a sweep that was interrupted.", "--resume", group=RUN)] = False,
) -> None:
    """Compute many landings that differ in posture, strike or model."""
    from shockpc.errors import SolveError, StudyError
    from shockpc.executor import executor
    from shockpc.show.files import check_folder
    from shockpc.show.parts import open_sweep, write_parts

    check_folder(out, "--out")
    if jobs < 1:
        raise StudyError(f"{jobs} processes compute nothing; give --jobs a number above zero")
    made = _sweep(robot, options, varied)
    done = 0
    try:
        with executor(jobs, cluster) as workers, _progress(made.rows) as advance:
            open_sweep(made, out, format_, resume)
            for rows in write_parts(made, out, format_, workers, 64 if cluster is not None else 4 * jobs if jobs > 1 else 0):
                done += rows
                advance(rows)
    except BaseException:
        if done:
            complain(f"{done} of {made.rows} rows are complete in {out}; the same command with --resume continues")
        raise
    if _summarise(made, out, format_):
        raise typer.Exit(SolveError.exit_code)


def _sweep(robot: str, options: SceneOptions, varied: SweepOptions) -> "Sweep":
    """The sweep that the options describe."""
    from shockpc.cli.scenes import point_from, scenes_from
    from shockpc.errors import StudyError
    from shockpc.studies.sweep.study import sweep_of
    from shockpc.trace import Trace

    contacts = [one.values for one in varied.vary if one.name == "contact" and one.values is not None]
    if contacts and not options.contact:
        # The rows have contacts of their own; the scene needs one until they are set.
        options = dataclasses.replace(options, contact=[contacts[0].split(",")[0]])
    loaded, scenes = scenes_from(robot, options, Trace())
    if len(scenes) > 1 and not contacts:
        names = ",".join(contact.frame for scene in scenes for contact in scene.contact)
        raise StudyError(f"a sweep varies one landing, but there are {len(scenes)}; compare contacts with --vary contact={names}")
    return sweep_of(
        scenes[0],
        loaded,
        varied.vary,
        vary_each=varied.vary_each,
        at=[point_from(loaded, text, "--at") for text in varied.at] or scenes[0].point,
        bodies=varied.body,
        greatest=varied.greatest,
        sample=varied.sample,
        lhs=varied.lhs,
        seed=varied.seed,
        prove=varied.prove,
    )


def _summarise(made: "Sweep", out: Path, format_: Literal["parquet", "csv"]) -> int:
    """Print the summary, and write it with the figure; the number of rows that could not be computed."""
    import functools

    from shockpc.show.figure.sweep import sweep_figure
    from shockpc.show.files import write_folder
    from shockpc.show.parts import read_column
    from shockpc.show.tables.sweep import extents_sheet, sweep_markdown, sweep_text
    from shockpc.show.tables.text import as_csv
    from shockpc.studies.sweep.summary import summarise

    summary = summarise(made, functools.partial(read_column, made, out, format_))
    files: dict[str, str | bytes] = {
        **sweep_figure(summary),
        "summary.md": sweep_markdown(summary, "sweep.svg"),
        "summary.csv": as_csv(extents_sheet(summary)),
    }
    write_folder(out, files)
    sys.stdout.write(sweep_text(summary))
    return summary.failed


@contextmanager
def _progress(rows: int) -> Iterator[Callable[[int], None]]:
    """Show rows done, rate and time left while a sweep runs, on a terminal only; the function takes rows that are done."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    rate = TextColumn("rows, {task.fields[rate]}")
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        rate,
        TimeElapsedColumn(),
        TextColumn("elapsed,"),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    # Without a thread of its own, which would be copied into worker processes half way through.
    with Progress(*columns, console=Console(file=sys.stderr), transient=True, auto_refresh=False) as progress:
        task = progress.add_task("", total=rows, rate="")

        def advance(count: int) -> None:
            speed = progress.tasks[0].speed
            progress.update(task, advance=count, rate="" if speed is None else f"{speed:.0f} a second", refresh=True)

        yield advance
