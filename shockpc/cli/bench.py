"""`shockpc bench`: error against run time of several methods."""

import os
import sys
from pathlib import Path

from shockpc.cli.declare import argument, command
from shockpc.cli.options import SceneOptions, in_output
from shockpc.cli.parse import out_folder, robot_name

__all__ = ["bench"]

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@command(
    "Measure the error and the run time of several methods.",
    "shockpc bench anymal_b --contact LF_FOOT",
)
def bench(
    *,
    options: SceneOptions,
    robot: str | None = argument(
        "A robot file, a robot's name or a scene (TOML); without it the standing suite runs.", "ROBOT", robot_name
    ),
    out: Path | None = in_output(
        "Folder of the report; by default out/bench for the suite, and none for a landing.", "DIR", out_folder
    ),
) -> None:
    # Set before numpy is loaded: the run times are those of one thread.
    for name in THREADS:
        os.environ[name] = "1"
    from shockpc.errors import SceneError

    if robot is not None:
        _landings(robot, options, out)
    elif not any(options):
        _suite(out or Path("out/bench"))
    else:
        raise SceneError("the options of a landing need a robot: shockpc bench robot.urdf --contact foot")


def _suite(out: Path) -> None:
    """The standing suite."""
    from shockpc.bench.report import PARTS, run_suite
    from shockpc.cli.progress import progress
    from shockpc.show.tables import as_text

    for sheet in run_suite(out, progress=progress("parts measured", len(PARTS))):
        sys.stdout.write(as_text(sheet) + "\n")
    sys.stdout.write(f"the report: {out / 'report.md'}\n")


def _landings(robot: str, options: SceneOptions, out: Path | None) -> None:
    """The landings that the options describe, each with a table; several have a folder each in `out`."""
    from shockpc.bench.report import bench_landing
    from shockpc.cli.output import file_names
    from shockpc.cli.scenes import scenes_from
    from shockpc.show.tables import as_text

    loaded, scenes = scenes_from(robot, options)
    for scene, name in zip(scenes, file_names(scenes), strict=True):
        folder = out if out is None or len(scenes) == 1 else out / name
        if len(scenes) > 1:
            sys.stdout.write(f"{name}\n")
        sys.stdout.write(as_text(bench_landing(loaded, scene, folder)))
