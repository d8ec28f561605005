"""Table of landings from a log: when feet touch down, and the motion before and after.

A foot lands where its contacts say so, a column of flags or forces, or else where its height over
time has a kink. Velocities are slopes of straight lines through positions: before, in a window that
ends with the last sample before the first foot touches; after, in one around each time that is
asked for, counted from the touchdown of the last foot of the landing.
"""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from shockpc.evaluation.declare import study
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import JOINT_MODEL, RESULTS, STRIKE, Option
from shockpc.landing.scenes.scene_file import robot_of, scene_of
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.logs.logged_motion import watched_motion
from shockpc.wings.recordings.logs.logs import read_log
from shockpc.wings.recordings.tables.column_meaning import RenameOption
from shockpc.wings.recordings.touchdowns.finder import TouchdownFinder
from shockpc.wings.recordings.touchdowns.touchdowns import Touchdowns


@study(
    "shockpc touchdowns walk.csv anymal_b --contact LF_FOOT --out touchdowns/",
    "shockpc touchdowns walk.csv anymal_b --contact LF_FOOT --flag LF_FOOT=force --after 6,12",
    more=(
        "A log is a time series: CSV, Parquet or NPZ with a column time [s] (or time_ms, time_us, "
        "time_ns) and columns of joints "
        "and base as in shockpc recorded; or a bag of ROS 1, ROS 2 or MCAP (pip install rosbags) "
        "with JointState, and Odometry, "
        "PoseStamped, TwistStamped or Imu. All feet are looked at, or those of --contact. A "
        "touchdown is where a "
        "falling foot stops, or where its column of flags or forces begins. Velocities are slopes "
        "of straight lines through "
        "positions. If the log lacks the velocity of the base, it follows from the standing feet "
        "and a gyro (wx_body wy_body "
        "wz_body, or wx@FRAME …). Jumps follow from accelerometers, ax@FRAME ay@FRAME az@FRAME, "
        "and gyros. shockpc recorded "
        "takes the table touchdowns.csv."
    ),
    # Of the robot, where it touches and what the log lacks of its posture is all that is used of a
    # landing.
    without=(
        STRIKE,
        RESULTS,
        JOINT_MODEL,
        "together",
        "slide",
        "directions",
        "flat",
        "contact_kind",
        "stance",
        "restitution",
        "restitution_along",
    ),
    reads="log",
)
def touchdowns(
    log: str | os.PathLike[str] | Mapping[str, Any],
    scene: Scene | str,
    *,
    robot: Robot | None = None,
    contacts: Sequence[str] | None = None,
    rename: RenameOption = None,
    topics: Annotated[
        Sequence[str],
        Option(
            "Read only these topics of a bag.", "Log", "TOPIC", "topic", default="the usual ones"
        ),
    ] = (),
    flags: Annotated[
        Mapping[str, str] | None,
        Option(
            "The column with the flags or the forces of a contact.",
            "Touchdowns",
            "FRAME=COLUMN",
            "flag",
            default="one named like it, such as FRAME_contact",
        ),
    ] = None,
    contact_force: Annotated[
        float | None,
        Option(
            "Force above which a contact touches.",
            "Touchdowns",
            "F",
            unit="N",
            default="5 % of the robot's weight, at least 1 N",
        ),
    ] = None,
    within_time: Annotated[
        float,
        Option(
            "Feet that touch within this time are one landing.",
            "Touchdowns",
            "T",
            unit="ms",
            least=0.0,
            greatest=1e4,
        ),
    ] = 5.0,
    after: Annotated[
        tuple[float, ...],
        Option(
            "Times after the touchdown at which velocities are measured.",
            "Touchdowns",
            "T[,T]",
            unit="ms",
            least=1e-3,
            greatest=1e4,
            most=100,
            default="6,12,30",
        ),
    ] = (6.0, 12.0, 30.0),
    window: Annotated[
        float | None,
        Option(
            "Length of the windows for velocities.",
            "Touchdowns",
            "T",
            unit="ms",
            above=0.0,
            greatest=1e4,
            default="3, and at least the 3 nearest samples",
        ),
    ] = None,
) -> Touchdowns:
    """Find the touchdowns of a log, and the motion before and after them.

    Args:
        log: a table with a column of times, a bag, or the columns of such a table by name.
        scene: the robot; gives the joints that the log does not, and contacts that are looked at
            besides the feet. Its strike, joint model, friction and so on are not used: they are
            what `landings` takes of the same scene.
        robot: the scene's robot, if it is loaded already.
        contacts: frames that are looked at; by default all feet, and the contacts of the scene.

    Raises:
        ShockError: the log cannot be read, or lacks what touchdowns follow from.
    """
    if len(set(after)) < len(after):
        raise StudyError("a time after touchdowns is given twice; give each once")
    scene = scene_of(scene)
    robot = robot or robot_of(scene)
    source = Path(log) if isinstance(log, str | os.PathLike) else log
    series = read_log(source, robot, rename or {}, topics)
    motion = watched_motion(series, scene, robot, contacts)
    finder = TouchdownFinder(motion, series, flags or {}, contact_force)
    length = None if window is None else window / 1e3
    return finder.touchdowns(within_time / 1e3, tuple(time / 1e3 for time in after), length)
