"""`shockpc sweep`: many landings that differ in posture, strike, contact, inertia or joint model."""

import sys
from pathlib import Path
from typing import Literal

from shockpc.cli.declare import command, group
from shockpc.cli.options import QUANTITY, ROBOT, RunOptions, SceneOptions, in_run
from shockpc.cli.parse import Variable, out_folder, variable
from shockpc.cli.process import print_error

_in_varied, _in_computed = group("What varies"), group("What is computed")


@command(
    'shockpc sweep anymal_b --contact LF_FOOT --vary "*_KFE=-120:-10:50" --at imu_link --out sweep/',
    'shockpc sweep anymal_b --contact LF_FOOT --sample 100 --quantity "joint_impulse@*_KFE" --out random/',
    'shockpc sweep go2 --contact FL_foot --sample 10000 --vary-each "mass:*_calf=±5%" --out masses/',
)
def sweep(
    *,
    robot: str = ROBOT,
    options: SceneOptions,
    vary: tuple[Variable, ...] = _in_varied(
        "Quantity and values: a:b:n, a list a,b,c or, with --sample, a range a:b, a:b:log (log-uniform) or m±s (normal; also "
        "m+-s). Quantities are a joint or a glob [deg; m if prismatic], base-roll, base-pitch, base-yaw and strike-angle [deg], "
        "speed [m/s], contact (names), offset-x, -y, -z [m], friction, contact-stiffness [N/m], mass:LINKS [kg], com-x:LINKS, "
        "-y, -z (a shift) [m], inertia:LINKS, armature:JOINTS [kg m²], joint-stiffness:JOINTS (of springs; counts with a contact "
        "stiffness) [N m/rad], place:JOINTS (lengths, of a robot for each row); of masses, inertias, armature, springs and places "
        "factors, 0.8x:1.2x:9 or ±5% (a standard deviation).",
        "NAME=VALUES",
        variable,
    ),
    vary_each: tuple[Variable, ...] = _in_varied(
        "The same for a glob of joints or links, each of which varies by itself.", "GLOB=VALUES", variable
    ),
    sample: int | None = _in_varied(
        "Random landings instead of the full grid. If neither a joint nor what the robot and the ground are is varied, all "
        "joints are, within their limits.",
        "N",
    ),
    lhs: bool = _in_varied("Draw the sample as a Latin hypercube."),
    seed: int = _in_varied("Seed of the random numbers; 0 by default.", "N", default=0),
    body: tuple[str, ...] = _in_computed(
        "Bodies of which CoPc, RoPc and the shock at the CoM are computed; the base, if there is no --at either.", "BODY"
    ),
    greatest: bool = _in_computed("Also the greatest shock over the geometry of each --body."),
    quantity: tuple[str, ...] = QUANTITY,
    feasible: bool = _in_computed(
        "Keep only the landings that flat ground allows, which pulls no contact and meets no other link first; with --friction "
        "contacts slide and open instead. The summary counts the others; what could not be computed stays, with its message."
    ),
    prove: int = _in_computed("Random landings that are compared with a proof; 100 by default.", "N", default=100),
    out: Path = in_run("Folder of the rows, the summary and the figure.", "DIR", out_folder),
    format_: Literal["parquet", "csv"] = in_run("Format of the rows; parquet by default.", default="parquet"),
    run: RunOptions,
) -> int:
    from shockpc.cli.output import exit_code, write_report
    from shockpc.cli.scenes import scenes_from
    from shockpc.cli.write_parts import written_parts
    from shockpc.evaluation.executor import executor
    from shockpc.evaluation.summary import summarise
    from shockpc.show.parts import Parts
    from shockpc.show.reports.sweep import sweep_report
    from shockpc.studies.sweep import sweep as study
    from shockpc.text.errors import StudyError

    contacts = [values for name, values in vary if name == "contact" and values is not None]
    if contacts and not options.contact:
        # The rows have contacts of their own, as --contact names them; the scene needs one until they are set.
        options = options._replace(contact=(contacts[0].split(",")[0],))
    loaded, scenes = scenes_from(robot, options)
    if len(scenes) > 1 and not contacts:
        names = ",".join(contact.frame for scene in scenes for contact in scene.contact)
        raise StudyError(f"a sweep varies one landing, but there are {len(scenes)}; compare contacts with --vary contact={names}")
    made = study(
        scenes[0],
        vary,
        robot=loaded,
        vary_each=vary_each,
        at=scenes[0].point,
        bodies=body,
        greatest=greatest,
        quantities=quantity,
        feasible=feasible,
        sample=sample,
        lhs=lhs,
        seed=seed,
        prove=prove,
    )
    parts = Parts(made, out, format_)
    with written_parts(parts, executor(run.jobs, run.cluster, print_error if run.wait else None), run.resume, "rows"):
        landings, table = made.landings, parts.table()
        varied = [one for one in landings.variations if landings.sample is not None and one.kind != "contact"]
        summary = summarise(made, table, varied, keep=landings.sample is None and len(landings.variations) <= 2)
        report = sweep_report(summary)
        write_report(report, out)
        sys.stdout.write(report.text("table"))
    return exit_code(summary.failed, summary.rows, run.strict, table.defects)
