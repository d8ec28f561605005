"""`shockpc analyze`: from a robot file to a table and a figure."""

import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from shockpc.cli.declared import command
from shockpc.cli.options import EXPLAIN, ROBOT, STRICT, OutputOptions, SceneOptions, in_output
from shockpc.cli.parse import scene_file

if TYPE_CHECKING:
    from shockpc.landing.scenes.scene import Scene
    from shockpc.quantities.shock_profile import ShockProfile
    from shockpc.robot.robot import Robot
    from shockpc.text.errors import ShockError
    from shockpc.text.trace import Trace


@command(
    examples=(
        "shockpc analyze anymal_b --contact LF_FOOT --out out/",
        'shockpc analyze robot.urdf --contact "*_foot" --set "*_knee=-60"',
        "shockpc analyze go2 --contact FL_foot --drop-height 0.3 --pulse half-sine:5ms",
    ),
)
def analyze(
    *,
    robot: str = ROBOT,
    options: SceneOptions,
    output: OutputOptions,
    body: tuple[str, ...] = in_output("Show only these bodies.", "BODY"),
    save_scene: Path | None = in_output(
        "Write the scene that this command line describes, a file for each landing.",
        "FILE",
        scene_file,
    ),
    force: bool = in_output("Let --save-scene replace a file."),
    spectrum: bool = in_output(
        "With a contact stiffness and --out, draw the shock response spectrum of sensors and "
        "points too; in JSON, give it."
    ),
    live: tuple[str, ...] = in_output(
        "With --out, give these joints sliders in report.html; the joints of a single landing's "
        "contact always have them.",
        "JOINT",
    ),
    all_: bool = in_output("Print all tables."),
    strict: bool = in_output(STRICT),
    explain: bool = EXPLAIN,
) -> int:
    from shockpc.cli.progress import shown_trace

    trace = shown_trace()
    # Imported here, so that the help of the command does not wait for it.
    with trace.stage("imports"):
        from shockpc.cli.output import emit, exit_code, scene_files
        from shockpc.cli.scenes import file_names, scenes_from
        from shockpc.studies.analyze.closing import accuracy_line
        from shockpc.studies.analyze.report import analyze_report
        from shockpc.text.errors import traces
    loaded, scenes = scenes_from(robot, options, trace)
    # Names are checked before the landings are computed, which takes longer.
    for pattern in live:
        loaded.match_joints(pattern)
    _refuse_without_effect(output, scenes, body, live, save_scene, force, spectrum, all_)
    bodies: set[int] = set()
    for pattern in body:
        bodies.update(loaded.match_bodies(pattern))
    names = file_names(scenes)
    files = {}
    if save_scene is not None:
        files = dict(zip(names, scene_files(scenes, save_scene, force), strict=True))
    profiles, failures = _results(names, scenes, loaded, trace)
    remarks = []
    if output.out is not None or output.format in ("table", "markdown"):
        remarks = _remarks(next(iter(profiles.values())), scenes, trace)
    with trace.stage("output"):
        if output.out is None:
            trace.skip("figure, and matplotlib with it", "no --out")
        report = analyze_report(
            profiles, sorted(bodies) or None, spectrum, all_, failures, remarks, live
        )
        emit(report, output, _scene_texts(profiles, files))
    if explain:
        lines = [f"{accuracy_line(profile)}\n" for profile in profiles.values()]
        sys.stderr.write(trace.text() + "".join(lines))
    return exit_code(len(failures), len(scenes), strict, traces(failures.values()))


def _refuse_without_effect(
    output: OutputOptions,
    scenes: "Sequence[Scene]",
    body: Sequence[str],
    live: Sequence[str],
    save_scene: Path | None,
    force: bool,
    spectrum: bool,
    all_: bool,
) -> None:
    """Refuse options that change nothing of what is asked for.

    Raises:
        StudyError: there is one.
    """
    from shockpc.text.errors import StudyError

    if force and save_scene is None:
        raise StudyError(
            "--force lets --save-scene replace a file; give --save-scene too, or leave --force out"
        )
    if all_ and output.format != "table":
        raise StudyError(
            f"--all is for tables on a terminal and has no effect on --format {output.format}; "
            "leave it out"
        )
    if body and output.format == "json" and output.out is None:
        raise StudyError(
            "--body selects the bodies of tables and CSV files, but JSON has every body; leave it "
            "out"
        )
    in_files = output.out is not None or output.format == "json"
    if spectrum and not (in_files and all(scene.yields for scene in scenes)):
        missing = "--contact-stiffness" if in_files else "--out, or --format json,"
        raise StudyError(
            f"--spectrum is in the files of a landing on contacts of finite stiffness; give "
            f"{missing} too"
        )
    if live and output.out is None:
        raise StudyError("--live is for report.html; give --out too")


def _results(
    names: Sequence[str], scenes: "Sequence[Scene]", robot: "Robot", trace: "Trace"
) -> "tuple[dict[str, ShockProfile], dict[str, ShockError]]":
    """The landings by name, and why others could not be computed."""
    if len(scenes) == 1:  # which is not worth the import of what computes many
        from shockpc.profile import shock_profile

        return {names[0]: shock_profile(scenes[0], robot, trace)}, {}
    from shockpc.evaluation.profiles import profiles_and_failures

    cases = {name: (scene, robot) for name, scene in zip(names, scenes, strict=True)}
    return profiles_and_failures(cases, trace)


def _scene_texts(
    profiles: "Mapping[str, ShockProfile]", files: Mapping[str, Path]
) -> dict[Path, str]:
    """The texts of the scenes of landings by the files to which they are saved."""
    from shockpc.landing.scenes.scene_file import scene_text

    texts = {}
    for name, file in files.items():
        if name in profiles:
            texts[file] = scene_text(profiles[name].scene, file.parent)
    return texts


def _remarks(
    profile: "ShockProfile", scenes: "Sequence[Scene]", trace: "Trace"
) -> list[tuple[str, str]]:
    """Remarks on landings on whole feet and on all level feet, each with its heading.

    They are of landings that differ from that of a profile and from all scenes.
    """
    from shockpc.landing.feet.level_feet import together, whole_feet
    from shockpc.profile import shock_profile
    from shockpc.studies.analyze.several import level_text, whole_feet_text
    from shockpc.text.errors import ShockError

    remarks: list[tuple[str, str]] = []
    on_feet = whole_feet(profile.landing)
    if on_feet is not None:
        with trace.stage("landing on whole feet"), suppress(ShockError):
            text = whole_feet_text(profile, shock_profile(on_feet, profile.robot))
            remarks.append(("whole foot", text))
    level = together(profile.landing)
    if level is not None and _frames(level) not in map(_frames, scenes):
        with trace.stage("landing on all level feet"), suppress(ShockError):
            text = level_text(profile, shock_profile(level, profile.robot))
            remarks.append(("level feet", text))
    return remarks


def _frames(scene: "Scene") -> set[str]:
    return {contact.frame for contact in scene.contact}
