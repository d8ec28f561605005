"""The tables of a batch: each robot in its worst landing, each landing, and the sensors of each."""

from pathlib import Path

from shockpc.quantities.selection import select
from shockpc.show.tables import Heading, Row, Sheet
from shockpc.show.wording import landing_name
from shockpc.studies.batch.rows import Batch, BatchRow
from shockpc.studies.batch.study import STANDARD
from shockpc.text.printed import count

SECOND = ("ropc", "friction_needed", "feasible", "error_bound")
"""Standard quantities that are not on a terminal, unless landings are ranked by one."""

LONG = (
    "robot",
    "trunk",
    "at",
    "posture",
    "drives",
    "drive_status",
    "marks",
    "warnings",
    "failure",
)
"""Columns of landings that are not on a terminal."""


def robots_sheet(batch: Batch) -> Sheet:
    """The worst landing of each robot, with the range over its drives.

    It is without a rank where nobody knows these.
    """
    shown = {*(text.removeprefix("robot.") for text in STANDARD), batch.rank}
    asked = [name for name in batch.columns if name not in shown]
    unit = _unit(batch.rank)
    header: list[str | Heading] = [
        "rank",
        "robot",
        "at",
        "kind of place",
        "landing",
        Heading(batch.rank, batch.rank, unit),
        Heading("smallest_found", "smallest", unit),
        Heading("largest", "largest", unit),
        Heading("effective_mass", "mass", "kg"),
        Heading("mitigation", "IMF", "-"),
        *(Heading(name, name, _unit(name)) for name in asked),
        "drives",
        "drives in short",
        "posture",
        "warnings",
    ]
    known = [row for row in batch.robots if row.drives_known]
    rows: list[Row] = []
    for row in batch.robots:
        rank = known.index(row) + 1 if row.drives_known else None
        rows.append((rank, *_robot_cells(batch, row, asked)))
    return Sheet(f"{count(len(rows), 'robot')}, each in its worst landing", header, rows)


def _robot_cells(batch: Batch, row: BatchRow, asked: list[str]) -> Row:
    """The cells of a robot but for its rank. Args: asked, further columns."""
    robot = batch.name_of(row)
    if row.of_scene:
        robot += f" ({Path(row.source).name})"
    at, kind = None, None
    if select(batch.rank.partition("@")[0]).quantity.of == "point":
        at, kind = row.at, "IMU" if row.at in row.sensors else "trunk"
    value = row.values[batch.rank]
    smallest, largest = value, value
    if row.range is not None:
        smallest, largest = row.range.smallest, row.range.largest
    several_unknown = not row.drives_known and "," in row.status
    status = "partly unknown" if several_unknown else row.status
    return (
        robot,
        at,
        kind,
        short_landing_name(row),
        value,
        smallest,
        largest,
        row.effective_mass,
        row.values["mitigation"],
        *(row.values[name] for name in asked),
        row.status,
        status,
        "; ".join(row.marks) or None,
        len(row.warnings),
    )


def short_robots_sheet(batch: Batch) -> Sheet:
    """The table of `robots_sheet` for people, in short words."""
    titles = {"rank": "#", "kind_of_place": "at", "drives_in_short": "drives"}
    sheet = robots_sheet(batch).without("at", "drives", "posture", "warnings")
    return sheet.headed(titles).known()


def landings_sheet(batch: Batch) -> Sheet:
    """One row for each landing, the worst first, then what failed."""
    unit = _unit(batch.rank)
    header: list[str | Heading] = [
        "scene",
        "robot",
        "name",
        "contact",
        "trunk",
        "at",
        "joints",
        "drives known",
        *(Heading(name, name, _unit(name)) for name in batch.columns),
        Heading("smallest_found", "smallest found", unit),
        Heading("largest", "largest", unit),
        "effective mass [kg]",
        "posture",
        "drives",
        "drive status",
        "marks",
        "warnings",
        "failure",
    ]
    rows = [_landing_cells(batch, row) for row in batch.rows]
    for failure in batch.failures:
        name = batch.name_of(failure)
        named = (None, failure.robot, name, failure.contact or None)
        rows.append((*named, *[None] * (len(header) - 5), failure.reason))
    return Sheet(f"{count(len(batch.rows), 'landing')}, ranked by {batch.rank}", header, rows)


def _landing_cells(batch: Batch, row: BatchRow) -> Row:
    """The cells of a landing."""
    smallest, largest = None, None
    if row.range is not None:
        smallest, largest = row.range.smallest, row.range.largest
    return (
        # A robot by its name or file needs no scene; a scene is known by its name.
        row.source if row.of_scene else None,
        row.robot,
        batch.name_of(row),
        row.contact,
        row.trunk,
        row.at,
        row.joint_model,
        row.drives_known,
        *(row.values[name] for name in batch.columns),
        smallest,
        largest,
        row.effective_mass,
        _posture(row),
        row.drives or None,
        row.status,
        "; ".join(row.marks) or None,
        "; ".join(map(str, row.warnings)) or None,
        None,
    )


def short_landings_sheet(batch: Batch) -> Sheet:
    """The landings without columns of second rank, and without those that are alike in all rows."""
    left_out = {*LONG, *(name for name in SECOND if name != batch.rank)}
    if {row.joint_model for row in batch.rows} == {"free"}:
        left_out.add("shock_com")
    if len({row.drives_known for row in batch.rows}) == 1:
        left_out.add("drives_known")
    if not any(row.of_scene for row in batch.rows):
        left_out.add("scene")
    sheet = landings_sheet(batch).where(lambda row: row["failure"] is None)
    return sheet.without(*left_out).headed({"name": "robot"})


def sensors_sheet(batch: Batch) -> Sheet:
    """The shock at each sensor and point of each landing."""
    rows: list[Row] = []
    for row in batch.rows:
        rows += [(row.robot, row.contact, name, shock) for name, shock in row.sensors.items()]
    return Sheet("shock at sensors and points", ("robot", "contact", "at", "shock [-]"), rows)


def short_landing_name(row: BatchRow) -> str:
    """The contacts that strike, in short words, such as "all four feet" or "FL + FR"."""
    return landing_name(row.contact.split("+"), row.feet)


def _unit(name: str) -> str:
    """The unit of a quantity, as people read it."""
    return select(name.partition("@")[0]).quantity.unit_text


def _posture(row: BatchRow) -> str:
    """The reference posture, and how many joints are set besides."""
    posture = row.scene.posture
    joints = {*posture.joints, *posture.joints_deg}
    if not joints:
        return str(posture.reference)
    return f"{posture.reference}, {count(len(joints), 'joint')} set"
