"""The options that several commands share, declared once.

They are the fields of records, which a command takes by `command`.
"""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args, get_origin

from shockpc.cli.declared import Declared, Parser, argument, group, without_none
from shockpc.cli.parse import (
    Inertia,
    Motor,
    Setting,
    Vector,
    armature,
    definition,
    directions,
    drives,
    finite,
    folder,
    out_folder,
    path,
    plane,
    rotor,
    setting,
    stiffness,
    typed_robot,
    vector,
    whole_number,
)
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Posture, Scene
from shockpc.landing.scenes.scene_fields import Option, options_of
from shockpc.landing.scenes.strike import Strike

_in_files, _in_contact, _in_posture = group("Robot files"), group("Contact"), group("Posture")
_in_impact, _in_joints, _in_results = (
    group("Velocity before the impact"),
    group("Joint model"),
    group("What is computed"),
)
in_output, in_run = group("Output"), group("How it is computed, and where it is written")

ROBOT = argument(
    "A robot's name or file (URDF, xacro, MJCF, SDFormat), a scene (.toml) or BUDGETS.toml:CASE.",
    "ROBOT",
    typed_robot,
)
XACRO = _in_files("Argument of a xacro file.", "NAME:=VALUE", definition)
MESHES = _in_files("Folder in which missing meshes are searched by their file names.", "DIR", path)
PACKAGE = _in_files("Folder of a package, besides those in ROS_PACKAGE_PATH.", "NAME=DIR", folder)
FRAME = "FRAME[:X,Y,Z]"
EXPLAIN = in_output("Report on standard error the stages, their times, and what was not needed.")
JOBS = Option(
    "Number of processes, each of which takes some 100 MB.",
    "Run",
    "N",
    least=1,
    greatest=512,
    default="1",
)
STRICT = "Exit code 3 if any landing could not be computed, not only if none could."
AT = group("Question")(
    "The shock at this point (with friction, if given); offset in the frame [m].", FRAME
)
TARGET = group("Question")(
    "Another number: a quantity (shockpc quantities lists them) of a point, body, joint or "
    "contact.",
    "KEY@PLACE",
)


def packages_of(package: tuple[tuple[str, str], ...], meshes: str | None) -> dict[str, str]:
    """Folders by the names of packages, that of meshes for every other package."""
    return dict(package) | ({} if meshes is None else {"*": str(meshes)})


PARSERS: dict[Any, Parser] = {
    float: finite,
    Vector: vector,
    "plane": plane,
    "drives": drives,
    "contact_stiffness": stiffness,
    "flex": definition,
    "torque": setting,
}
"""Parsers of the text of an option: by its field, else by its type."""

RECORDS = {
    Contact: "contact.",
    Scene: "",
    Posture: "posture.",
    Strike: "strike.",
    Joints: "joints.",
}
"""The parts of a scene whose fields are options, and where their keys stand in its file."""

FORMER = {"--flat": "write --contact-kind flat", "--together": "write --contact A+B"}
"""Advice in place of options that are gone."""


def instead_of(option: str) -> str:
    """The advice in place of an option that no command has; empty for any other word.

    Args:
        option: as typed, such as "--srdf".
    """
    for record, table in RECORDS.items():
        for field, declared in options_of(record).items():
            if not declared.on_command_line and option == f"--{declared.name}":
                return f"{table}{field} is a key of a scene's file (shockpc schema describes it)"
    return FORMER.get(option, "")


def _declared(record: type) -> dict[str, tuple[Any, Any]]:
    """Type and declaration of the options of a record, by parameter of a command."""
    kinds: dict[str, Any] = {part.name: part.type for part in fields(record)}
    declared: dict[str, tuple[Any, Any]] = {}
    for field, described in options_of(record).items():
        if not described.on_command_line:
            continue
        kind = without_none(kinds[field])
        if get_origin(kind) is Mapping:
            kind = tuple[tuple[str, Any], ...]
        parser = PARSERS.get(field)
        if parser is None and get_origin(kind) is not Literal:
            parser = PARSERS.get(kind)
        repeated = get_args(kind)[1:] == (...,)
        option = group(described.heading)(described.text, described.form, parser)
        declared[described.name.replace("-", "_")] = (kind if repeated else kind | None, option)
    return declared


OF_RECORDS = Declared(pair for record in RECORDS for pair in _declared(record).items())


class SceneOptions(NamedTuple):
    """All that a scene consists of; None, False or empty where nothing was typed.

    Attributes:
        given: the options that are fields of the parts of a scene, by their names with underscores;
            the others follow.
    """

    xacro: tuple[tuple[str, str], ...] = XACRO
    package: tuple[tuple[str, str], ...] = PACKAGE
    meshes: str | None = MESHES
    contact: tuple[str, ...] = _in_contact(
        "The contact: a link, site or geom, by name or glob such as '*_foot'. Several matches are "
        "one landing each; A+B is one landing on both; stop:JOINT is a joint that runs into its "
        "end stop.",
        "NAME",
    )
    slide: bool = _in_contact("No friction: the contact stops the normal direction only.")
    directions: tuple[str | Vector, ...] | None = _in_contact(
        "Directions in which the contact stops the point: axes, or vectors with semicolons "
        "between them. It slides freely along the others; xz is for a leg on a boom along y. By "
        "default xyz.",
        "AXES|X,Y,Z;…",
        directions,
    )
    stance: tuple[str, ...] = _in_contact(
        "A foot that is on the ground already and stays where it is.", "NAME"
    )
    set: tuple[Setting, ...] = _in_posture(
        "Position of joints [deg; m if prismatic].", "JOINT=VALUE", setting
    )
    joint_velocity: tuple[Setting, ...] = _in_impact(
        "Velocity of joints [rad/s; m/s if prismatic].", "JOINT=RATE", setting
    )
    rotor: tuple[Motor, ...] = _in_joints(
        "Inertia of a rotor [kg m²], gear ratio, and stiffness of a spring between gear and joint "
        "[N m/rad]. The ratio is "
        "the file's by default. The gear (planetary, belt, harmonic or spur) gives the sense in "
        "which the rotor turns. "
        "[LOW,HIGH] is an interval of the inertia or the ratio.",
        "JOINT=INERTIA[:RATIO[:STIFFNESS]][:GEAR]",
        rotor,
    )
    joint_stiffness: tuple[Setting, ...] = _in_joints(
        "Stiffness of a spring of the joint itself, such as in a leg with springs, instead of the "
        "stiffness in an MJCF; its load at "
        "touchdown (springref) is included with a contact stiffness [N m/rad; N/m if prismatic].",
        "JOINT=STIFFNESS",
        setting,
    )
    armature: tuple[Inertia, ...] = _in_joints(
        "Reflected inertia [kg m²; kg if prismatic]. LOW:HIGH is an interval, whose arithmetic "
        "mean is used.",
        "JOINT=INERTIA",
        armature,
    )
    lock: tuple[str, ...] = _in_joints(
        "Locked joints, which keep the rate that they have.", "JOINT"
    )
    at: tuple[str, ...] = _in_results(
        "Points whose shock is computed, besides the sensors; offset in the frame [m].", FRAME
    )
    part: tuple[tuple[str, str], ...] = _in_results(
        "A part and the pulse that it survives, such as imu_link='half-sine 1500 g 0.5 ms'; the "
        "bandwidth of an "
        "accelerometer may follow, as 200Hz. For joints, the torque that their gears withstand, "
        "such as "
        "FL_calf_joint='50 N m', or with its duration '50 N m 20 ms'. A scene takes more keys.",
        f"{FRAME}=RATING|JOINT=TORQUE",
        definition,
    )
    given: Mapping[str, Any] = OF_RECORDS

    @property
    def packages(self) -> dict[str, str]:
        """The folders that were typed, by the names of packages."""
        return packages_of(self.package, self.meshes)

    @property
    def typed(self) -> bool:
        """True if any option was typed."""
        others = any(self._replace(given={}))
        return others or any(value not in (None, ()) for value in self.given.values())

    def value(self, option: str) -> Any:
        """What was typed for an option by its name, such as "base-rpy"; None or empty without."""
        field = option.replace("-", "_")
        return self.given[field] if field in self.given else getattr(self, field, None)

    def fields(self, record: type) -> dict[str, Any]:
        """The fields of a part of a scene that were typed."""
        typed: dict[str, Any] = {}
        for field, option in options_of(record).items():
            value = self.given.get(option.name.replace("-", "_"))
            if value not in (None, ()):
                typed[field] = not value if option.name.startswith("no-") else value
        return typed


EVERYBODY = (
    "contact",
    "set",
    "drop_height",
    "speed",
    "strike_angle",
    "drives",
    "armature",
    "rotor",
    "joints",
    "at",
    "pulse",
    "contact_stiffness",
    "friction",
    "imu_bandwidth",
    "part",
)
"""The options of a landing that --help lists, in its order."""

RARE = frozenset({*SceneOptions._fields, *OF_RECORDS} - {"given", *EVERYBODY})
"""Those that --help-all adds."""

RARE_OF_RUN = ("cluster", "wait", "strict", "explain", "spectrum", "save_scene", "force", "live")
"""Options of a run that --help-all adds."""

PANELS = frozenset(
    info.rich_help_panel
    for info in (*SceneOptions._field_defaults.values(), *(info for _, info in OF_RECORDS.values()))
    if not isinstance(info, Declared)
)
"""The headings under which the options of a landing stand; a command's option in the place of one
has another.
"""


class RunOptions(NamedTuple):
    """Where the parts of a study are computed."""

    jobs: int = in_run(JOBS.text, JOBS.form, whole_number(JOBS), default=1)
    cluster: str | None = in_run(
        "Compute on a running Dask cluster; the folder has to be shared with its workers.",
        "ADDRESS",
    )
    wait: bool = in_run("Wait for workers while the cluster has none.")
    strict: bool = in_run(STRICT)
    resume: bool = in_run("Continue an interrupted run: existing parts of Parquet files are kept.")


class OutputOptions(NamedTuple):
    """The options for the results of a study: their format and their folder."""

    format: Literal["table", "json", "csv", "markdown", "pdf"] = in_output(
        "What is printed; pdf: figures of --out. [default: table]", default="table"
    )
    out: Path | None = in_output("Folder for JSON, CSV, a report and figures.", "DIR", out_folder)
