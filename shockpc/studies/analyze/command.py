"""`shockpc analyze`: from a robot file to a table and a figure."""

import sys
from contextlib import suppress
from pathlib import Path

from shockpc.cli.declared import command
from shockpc.cli.options import EXPLAIN, ROBOT, STRICT, OutputOptions, SceneOptions, in_output
from shockpc.cli.parse import scene_file


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
    with trace.stage("imports"):
        from shockpc.cli.output import emit, exit_code, scene_files
        from shockpc.cli.scenes import file_names, scenes_from
        from shockpc.landing.level_feet import together, whole_feet
        from shockpc.landing.scene_file import scene_text
        from shockpc.profile import shock_profile
        from shockpc.quantities.shock_profile import ShockProfile
        from shockpc.studies.analyze.closing import accuracy_line
        from shockpc.studies.analyze.report import analyze_report
        from shockpc.studies.analyze.several import level_text, whole_feet_text
        from shockpc.text.errors import ShockError, StudyError, traces
    loaded, scenes = scenes_from(robot, options, trace)
    if force and save_scene is None:
        raise StudyError(
            "--force lets --save-scene replace a file; give that too, or leave --force out"
        )
    if all_ and output.format != "table":
        raise StudyError(
            f"--all is for tables on a terminal, and changes nothing of --format {output.format}; "
            f"leave it out"
        )
    if body and output.format == "json" and output.out is None:
        raise StudyError(
            "--body chooses the bodies of tables and CSV files, and JSON has every body; leave it "
            "out"
        )
    shown = output.out is not None or output.format == "json"
    if spectrum and not (shown and all(scene.yields for scene in scenes)):
        missing = "--contact-stiffness" if shown else "--out, or --format json,"
        raise StudyError(
            f"--spectrum is in the files of a landing on contacts of finite stiffness; give "
            f"{missing} too"
        )
    for pattern in live:
        loaded.match_joints(pattern)
    if live and output.out is None:
        raise StudyError("--live is for report.html; give --out too")
    bodies = sorted({i for pattern in body for i in loaded.match_bodies(pattern)}) or None
    files = [] if save_scene is None else scene_files(scenes, save_scene, force)
    names = file_names(scenes)
    if len(scenes) == 1:  # which is not worth the import of what computes many
        results: dict[str, ShockProfile | ShockError] = {
            names[0]: shock_profile(scenes[0], loaded, trace)
        }
    else:
        from shockpc.evaluation.profiles import proven

        results = proven(
            {name: (scene, loaded) for name, scene in zip(names, scenes, strict=True)}, None, trace
        )
    profiles = {name: found for name, found in results.items() if isinstance(found, ShockProfile)}
    failures = {name: found for name, found in results.items() if isinstance(found, ShockError)}
    if not profiles:
        # the first, or an error in shockpc itself
        raise max(failures.values(), key=lambda failure: bool(traces([failure])))
    # no files without --save-scene
    file_of = dict(zip(names, files, strict=False))
    saved = {
        file: scene_text(profiles[name].scene, file.parent)
        for name, file in file_of.items()
        if name in profiles
    }
    remarks, first = list[tuple[str, str]](), next(iter(profiles.values()))
    # the only places of remarks
    prose = output.out is not None or output.format in ("table", "markdown")
    if (whole := whole_feet(first.landing) if prose else None) is not None:
        with trace.stage("landing on whole feet"), suppress(ShockError):
            remarks.append(("whole foot", whole_feet_text(first, shock_profile(whole, loaded))))
    if (joint := together(first.landing) if prose else None) and not any(
        {contact.frame for contact in scene.contact} == {contact.frame for contact in joint.contact}
        for scene in scenes
    ):
        with trace.stage("landing on all level feet"), suppress(ShockError):
            remarks.append(("level feet", level_text(first, shock_profile(joint, loaded))))
    with trace.stage("output"):
        if output.out is None:
            trace.skip("figure, and matplotlib with it", "no --out")
        emit(
            analyze_report(profiles, bodies, spectrum, all_, failures, remarks, live), output, saved
        )
    if explain:
        sys.stderr.write(
            trace.text() + "".join(f"{accuracy_line(profile)}\n" for profile in profiles.values())
        )
    return exit_code(len(failures), len(scenes), strict, traces(failures.values()))
