"""`shockpc analyze`: from a robot file to a table and a figure."""

import sys
from pathlib import Path
from typing import Annotated, Literal

from shockpc.cli.declare import option, takes_options
from shockpc.cli.options import RobotName, SceneOptions
from shockpc.cli.parse import path

__all__ = ["analyze"]

OUTPUT = "Output"


@takes_options
def analyze(
    robot: RobotName,
    options: SceneOptions,
    format_: Annotated[
        Literal["table", "json", "csv", "markdown"],
        option("What is printed; table by default.", "--format", group=OUTPUT),
    ] = "table",
    bodies: Annotated[
        str | None,
        option("Show only bodies that match this glob or part of a name (tables and CSV).", group=OUTPUT, metavar="PATTERN"),
    ] = None,
    out: Annotated[
        Path | None, option("Write JSON, CSV, a report and the figure into this folder.", group=OUTPUT, metavar="DIR", parser=path)
    ] = None,
    save_scene: Annotated[
        Path | None,
        option(
            "Write the scene that this command line describes, a file for each landing.", group=OUTPUT, metavar="FILE", parser=path
        ),
    ] = None,
    force: Annotated[bool, option("Let --save-scene replace a file.", "--force", group=OUTPUT)] = False,
    explain: Annotated[
        bool,
        option("Report on standard error what ran, how long it took, and what was not needed.", "--explain", group=OUTPUT),
    ] = False,
) -> None:
    """Compute the shock of a landing on every body of a robot."""
    from shockpc.cli.progress import ShownTrace

    trace = ShownTrace()
    with trace.stage("imports"):
        from shockpc.cli.output import body_pattern, check_places, file_names, scene_files, shown
        from shockpc.cli.scenes import scenes_from
        from shockpc.profile import shock_profile
        from shockpc.scene import scene_text
        from shockpc.show.files import write_text
    check_places(out, save_scene)
    loaded, scenes = scenes_from(robot, options, trace)
    pattern = None if bodies is None else body_pattern(loaded, bodies)
    files = [] if save_scene is None else scene_files(scenes, save_scene, force)
    profiles = [shock_profile(scene, loaded, trace) for scene in scenes]
    with trace.stage("output"):
        text = shown(profiles, format_, pattern)
        for profile, file in zip(profiles, files, strict=False):  # no files without --save-scene
            write_text(file, scene_text(profile.scene, file.parent))
        if out is not None:
            from shockpc.show.folder import write_landings

            write_landings(profiles, file_names(scenes), out, pattern)
        else:
            trace.skip("figure, and matplotlib with it", "no --out")
        sys.stdout.write(text)
    if explain:
        sys.stderr.write(trace.text())
