"""The options that several commands share, declared once: the fields of records, which a command takes by `command`."""

from pathlib import Path
from typing import Literal, NamedTuple

from shockpc.cli.declare import argument, group
from shockpc.cli.parse import (
    JointModelName,
    Motor,
    Setting,
    Vector,
    definition,
    drives,
    finite,
    folder,
    out_folder,
    path,
    plane,
    robot_name,
    rotor,
    setting,
    stiffness,
    vector,
)
from shockpc.text.errors import StudyError

_in_files, _in_contact, _in_posture = group("Robot files"), group("Contact"), group("Posture")
_in_impact, _in_joints, _in_results = group("Velocity before the impact"), group("Joint model"), group("What is computed")
in_output, in_run = group("Output"), group("How it is computed, and where it is written")

ROBOT = argument("A robot file (URDF, xacro, MJCF), a robot's name, a scene (.toml), or BUDGETS.toml:CASE.", "ROBOT", robot_name)
XACRO = _in_files("Argument of a xacro file.", "NAME:=VALUE", definition)
PACKAGE = _in_files("Folder of a package, besides those in ROS_PACKAGE_PATH.", "NAME=DIR", folder)
FRAME = "FRAME[:X,Y,Z]"
EXPLAIN = in_output("Report on standard error what ran, how long it took, and what was not needed.")
STRICT = in_output("End with exit code 3 if any landing could not be computed, and not only if none could.")
QUANTITY = group("What is computed")(
    "Another quantity, as shockpc quantities lists them; at all places of its kind, or at those of a name or glob.",
    "KEY[@PLACE]",
)

JOINT_MODELS = (
    "All joints turn freely (free) except where --armature, --rotor or --drives FILE gives them an inertia, resist by their "
    "reflected inertia (geared) or are locked; or they are as modelled, with springs that do not yield (rigid)."
)

TARGET = group("Question")(
    "Another number: a quantity (shockpc quantities lists them) of a point, body, joint or contact.", "QUANTITY@PLACE"
)


def target_of(at: str | None, quantity: str | None) -> str:
    """The number that a command is about: the shock at a point, or a quantity.

    Raises:
        StudyError: not one of the two is given.
    """
    if at is not None and quantity is None:
        return f"shock@{at}"
    if quantity is None or at is not None:
        raise StudyError("one number is needed: give a point with --at, or a quantity with --quantity, such as shock@imu_link")
    return quantity


class SceneOptions(NamedTuple):
    """All that a scene consists of; None, False or empty where nothing was typed."""

    xacro: tuple[tuple[str, str], ...] = XACRO
    package: tuple[tuple[str, str], ...] = PACKAGE
    contact: tuple[str, ...] = _in_contact(
        "What strikes the ground: a link, site or geom, by name or by a glob, such as '*_foot', which all names here may be. "
        "Several matches are one landing each; A+B is one landing on both.",
        "NAME",
    )
    together: bool = _in_contact("One landing on all matching contacts at once.")
    offset: Vector | None = _in_contact("Contact point from the frame's origin, in its axes [m].", "X,Y,Z", vector)
    contact_point: Literal["frame", "lowest"] | None = _in_contact(
        "Contact point at the frame's origin, or at the lowest point of the link's collision geometry."
    )
    slide: bool = _in_contact("No friction: the contact stops the normal direction only.")
    flat: bool = _in_contact("A sole: the contact also stops the link from tilting, and from twisting unless it slides.")
    normal: Vector | None = _in_contact(
        "Normal of the ground at the contact: a slope, or a wall; vertical by default.", "X,Y,Z", vector
    )
    restitution: float | None = _in_contact("Coefficient of restitution, 0 (default) to 1.", "E", finite)
    restitution_along: Literal["normal", "directions"] | None = _in_contact(
        "What restitution reverses: the velocity along the normal alone (default; Newton's law), or along every direction in which "
        "the contact stops (Eq. 4 of the paper), so that a sticking contact rebounds along the ground too."
    )
    stance: tuple[str, ...] = _in_contact("A foot that is on the ground already and stays where it is.", "NAME")
    posture: str | None = _in_posture("A reference posture of the robot, or neutral; by default the standing one.", "NAME")
    srdf: Path | None = _in_posture("File of reference postures.", "FILE", path)
    set: tuple[Setting, ...] = _in_posture("Position of joints [deg; m if prismatic].", "JOINT=VALUE", setting)
    base_rpy: Vector | None = _in_posture("Roll, pitch and yaw of the base [deg]; a positive pitch is nose down.", "R,P,Y", vector)
    base: Literal["free", "planar", "fixed"] | None = _in_posture(
        "How the base may move; by default free, or fixed where the file fixes it or its root link is called world. free and "
        "planar also free the base of an MJCF file."
    )
    assemble: tuple[str, ...] = _in_posture("The only joints that may move to close loops.", "JOINT")
    strike_angle: float | None = _in_impact(
        "Angle of the velocity from the vertical in the plane, positive moving forward [deg].", "DEG", finite
    )
    speed: float | None = _in_impact("Speed along the strike angle [m/s]; 1 by default.", "V", finite)
    velocity: Vector | None = _in_impact("Velocity of the robot, world axes [m/s].", "VX,VY,VZ", vector)
    drop_height: float | None = _in_impact(
        "Height of a free fall that ends in the impact, with a --strike-angle or a --forward-speed while moving forward [m].",
        "H",
        finite,
    )
    forward_speed: float | None = _in_impact("Horizontal speed in the plane after the fall from --drop-height [m/s].", "V", finite)
    angular_velocity: Vector | None = _in_impact("Angular velocity of the base, world axes [rad/s].", "WX,WY,WZ", vector)
    joint_velocity: tuple[Setting, ...] = _in_impact("Velocity of joints [rad/s; m/s if prismatic].", "JOINT=RATE", setting)
    joints: JointModelName | None = _in_joints(JOINT_MODELS)
    drives: str | None = _in_joints(
        "Drives in the form of robots/drives.toml, or none, which leaves what the robot's own file gives; by default those known "
        "of a robot of the catalogue.",
        "FILE|none",
        drives,
    )
    rotor: tuple[Motor, ...] = _in_joints(
        "Inertia of a rotor [kg m²], gear ratio (by default the file's), stiffness of a spring between gear and joint [N m/rad].",
        "JOINT=INERTIA[:RATIO[:STIFFNESS]]",
        rotor,
    )
    joint_stiffness: tuple[Setting, ...] = _in_joints(
        "Stiffness of a spring of the joint itself, such as in a compliant leg, instead of the stiffness in an MJCF; its load at "
        "touchdown (springref) is stated and left out, as gravity and the motors that balance it are [N m/rad; N/m if prismatic].",
        "JOINT=STIFFNESS",
        setting,
    )
    armature: tuple[Setting, ...] = _in_joints("Reflected inertia of joints [kg m²; kg if prismatic].", "JOINT=INERTIA", setting)
    lock: tuple[str, ...] = _in_joints("Locked joints, which keep the rate that they have.", "JOINT")
    plane: str | Vector | None = _in_results(
        "Plane of CoPc, RoPc and figures: xz (sagittal), yz (frontal), xy, or a normal NX,NY,NZ; by default auto: xz, or yz where "
        "more than half of the motion before the impact is sideways (velocity along y, rotation about x).",
        "PLANE",
        plane,
    )
    v_in: Literal["contact", "com"] | None = _in_results(
        "The speed that shock is relative to: of the contact (default) or of the centre of mass."
    )
    at: tuple[str, ...] = _in_results("Points whose shock is computed besides the sensors', offset in the frame [m].", FRAME)
    part: tuple[tuple[str, str], ...] = _in_results(
        "A part at a point and a pulse that it survives, such as imu_link='half-sine 1500 g 0.5 ms'; a scene takes more.",
        f"{FRAME}=RATING",
        definition,
    )
    pulse: str | None = _in_results(
        "Also give peak accelerations, for example half-sine:5ms; shapes are half-sine, saw-tooth, haversine and rectangle.",
        "SHAPE:LENGTH",
    )
    range_g: float | None = _in_results("Measuring range of the sensors, compared with the peaks [g].", "G", finite)
    friction: float | None = _in_results(
        "Also solve with this coefficient of friction (quantities *_friction); all others are those of contacts that stick.",
        "MU",
        finite,
    )
    contact_stiffness: tuple[float, float | None] | None = _in_results(
        "Also give forces, accelerations and their times on contacts of this stiffness, in every direction or along the normal and "
        "along the ground [N/m].",
        "K or KN:KT",
        stiffness,
    )
    contact_damping: float | None = _in_results(
        "Damping of these contacts along the normal [N s/m], in place of --restitution: taken as the restitution of the mode that "
        "carries the contact's force.",
        "C",
        finite,
    )
    ground_tolerance: float | None = _in_results(
        "By how much the lowest points of contacts and other links may differ in height that flat ground is taken to touch "
        "together, in warnings and in what is feasible [m]; 0.005 by default.",
        "H",
        finite,
    )


class RunOptions(NamedTuple):
    """Where the parts of a study are computed."""

    jobs: int = in_run("Number of processes; 1 by default.", "N", least=1, default=1)
    cluster: str | None = in_run("Compute on a running Dask cluster; the folder has to be shared with its workers.", "ADDRESS")
    wait: bool = in_run("Wait for workers while the cluster has none.")
    resume: bool = in_run("Continue what was interrupted; parts that are damaged are computed again.")


class OutputOptions(NamedTuple):
    """How the results of a study are given."""

    format: Literal["table", "json", "csv", "markdown"] = in_output("What is printed; table by default.", default="table")
    out: Path | None = in_output("Write JSON, CSV, a report and figures into this folder.", "DIR", out_folder)
