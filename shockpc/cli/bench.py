"""`shockpc bench`: error against run time of several methods."""

import gc
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

__all__ = ["bench"]

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def bench(
    robot: Annotated[
        str | None, typer.Argument(help="A robot file, a robot's name or a scene (TOML); without it the standing suite runs.")
    ] = None,
    contact: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="What strikes: a frame, a glob or part of a link's name.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the report. [suite: out/bench; one landing: not written]")
    ] = None,
) -> None:
    """Measure error against run time of several methods, on one landing or on the standing suite of hard cases."""
    # Set before numpy is loaded: the run times are those of one thread.
    for name in THREADS:
        os.environ[name] = "1"
    gc.enable()  # a long run makes garbage that a short command can ignore
    from shockpc.errors import SceneError
    from shockpc.show.files import check_folder

    if out is not None:
        check_folder(out, "--out")
    if robot is not None:
        _landing(robot, contact or [], out)
        return
    if contact:
        raise SceneError("--contact needs a robot: shockpc bench robot.urdf --contact foot")
    _suite(out or Path("out/bench"))


def _suite(out: Path) -> None:
    """The standing suite."""
    from shockpc.bench.report import costs_sheet, methods_sheet, throughput_sheet
    from shockpc.bench.run import run_suite
    from shockpc.show.tables.text import as_text

    found = run_suite(out)
    for sheet in (methods_sheet(found.cases), costs_sheet(found.costs), throughput_sheet(found.peers)):
        sys.stdout.write(as_text(sheet) + "\n")
    sys.stdout.write(f"the report: {out / 'report.md'}\n")


def _landing(robot: str, contacts: list[str], out: Path | None) -> None:
    """One landing of one's own."""
    from dataclasses import replace

    from shockpc.bench.run import bench_landing
    from shockpc.cli.build import is_scene_file
    from shockpc.model.contact import Contact, match_frames
    from shockpc.robot.robot import load_robot
    from shockpc.scene import Scene, read_scene
    from shockpc.show.tables.text import as_text

    scene = read_scene(Path(robot)) if is_scene_file(robot) else Scene(robot=robot)
    loaded = load_robot(scene.robot, xacro=scene.xacro, packages=scene.packages, srdf=scene.srdf)
    frames = [frame for text in contacts for frame in match_frames(loaded, text)]
    scene = replace(scene, contact=scene.contact + tuple(Contact(frame=frame) for frame in frames))
    sys.stdout.write(as_text(bench_landing(loaded, scene, out)))
