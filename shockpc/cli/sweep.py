"""`shockpc sweep`: many landings that differ in posture, strike, contact, inertia or joint model."""

import dataclasses
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from shockpc.cli.declare import group, takes_options
from shockpc.cli.options import RobotName, SceneOptions
from shockpc.cli.parse import Variable, path, variable
from shockpc.cli.streams import complain

if TYPE_CHECKING:
    from shockpc.show.parts import Parts
    from shockpc.studies.sweep.study import Sweep

__all__ = ["SweepOptions", "sweep"]

_in_varied, _in_computed = group("What varies"), group("What is computed")
_in_run = group("How it is computed, and where it is written")


@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """What a sweep is."""

    vary: Annotated[
        tuple[Variable, ...],
        _in_varied(
            "Quantity and values: a:b:n, a list a,b,c or, with --sample, a range a:b. Quantities are a joint or a glob [deg; m if "
            "prismatic], base-roll, base-pitch, base-yaw and strike-angle [deg], speed [m/s], contact (names), offset-x, -y, -z "
            "[m], mass:LINK [kg; or factors, 0.8x:1.2x:9], com-x:LINK, -y, -z (a shift) [m], inertia:LINK (factors), "
            "armature:JOINTS [kg m²].",
            "NAME=VALUES",
            variable,
        ),
    ] = ()
    vary_each: Annotated[
        tuple[Variable, ...],
        _in_varied("The same for a glob of joints, each of which varies by itself.", "GLOB=VALUES", variable),
    ] = ()
    sample: Annotated[
        int | None,
        _in_varied("Random landings instead of the full grid. If no joint is varied, all are, within their limits.", "N"),
    ] = None
    lhs: Annotated[bool, _in_varied("Draw the sample as a Latin hypercube.")] = False
    seed: Annotated[int, _in_varied("Seed of the random numbers; 0 by default.", "N")] = 0
    at: Annotated[
        tuple[str, ...], _in_computed("Point at which the shock is computed, offset in the frame [m].", "FRAME[:X,Y,Z]")
    ] = ()
    body: Annotated[
        tuple[str, ...],
        _in_computed(
            "Body of which CoPc, RoPc and the shock at the CoM are computed; the base, if there is no --at either.", "NAME"
        ),
    ] = ()
    greatest: Annotated[bool, _in_computed("Also the greatest shock over the geometry of each --body.")] = False
    prove: Annotated[int, _in_computed("Random landings that are compared with a proof; 100 by default.", "N")] = 100


@takes_options
def sweep(
    robot: RobotName,
    options: SceneOptions,
    varied: SweepOptions,
    out: Annotated[Path, _in_run("Folder of the rows, the summary and the figure.", "DIR", path)],
    format_: Annotated[Literal["parquet", "csv"], _in_run("Format of the rows; parquet by default.")] = "parquet",
    jobs: Annotated[int, _in_run("Number of processes; 1 by default.", "N", least=1)] = 1,
    cluster: Annotated[
        str | None, _in_run("Compute on a running Dask cluster; DIR has to be shared with its workers.", "ADDRESS")
    ] = None,
    resume: Annotated[bool, _in_run("Continue a sweep that was interrupted.")] = False,
) -> None:
    """Compute landings over many postures, strikes and models."""
    from shockpc.cli.progress import progress
    from shockpc.errors import SolveError
    from shockpc.executor import executor
    from shockpc.show.files import check_folder
    from shockpc.show.parts import Parts

    check_folder(out, "--out")
    made = _sweep(robot, options, varied)
    parts = Parts(made, out, format_)
    ahead = 64 if cluster is not None else 4 * jobs if jobs > 1 else 0
    done, finished = 0, False
    try:
        with executor(jobs, cluster) as workers:
            parts.prepare(resume)
            written = parts.write(workers, ahead)
            done = next(written)
            advance = progress("rows computed", made.rows, done)
            for rows in written:
                done += rows
                advance(parts=rows)
        failed = _summarise(parts)
        finished = True
    finally:
        if done and not finished:
            complain(f"{done} of {made.rows} rows are complete in {out}; the same command with --resume continues")
    if failed:
        raise typer.Exit(SolveError.exit_code)


def _sweep(robot: str, options: SceneOptions, varied: SweepOptions) -> "Sweep":
    """The sweep that the options describe."""
    from shockpc.cli.scenes import point_from, scenes_from
    from shockpc.errors import StudyError
    from shockpc.studies.sweep.study import sweep_of

    contacts = [values for name, values in varied.vary if name == "contact" and values is not None]
    if contacts and not options.contact:
        # The rows have contacts of their own; the scene needs one until they are set.
        options = dataclasses.replace(options, contact=(contacts[0].split(",")[0],))
    loaded, scenes = scenes_from(robot, options)
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


def _summarise(parts: "Parts") -> int:
    """Print the summary, and write it with the figure; the number of rows that could not be computed."""
    from shockpc.show.files import write_folder
    from shockpc.show.reports.sweep import sweep_files, sweep_text
    from shockpc.studies.sweep.summary import summarise

    summary = summarise(parts.sweep, parts.column)
    write_folder(parts.folder, sweep_files(summary))
    sys.stdout.write(sweep_text(summary))
    return summary.failed
