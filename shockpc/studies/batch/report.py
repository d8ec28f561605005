"""A batch: one row for each landing, ranked by a quantity, and a sheet of pictures where the batch
has them.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from shockpc.quantities.selection import select
from shockpc.robot.feet_and_sensors import BENT
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Column, Lines, Row, Sheet
from shockpc.show.wording import STICKING, count, landing_names, proof_text, without_value
from shockpc.studies.batch.study import STANDARD, Batch, BatchRow
from shockpc.text.diagnostic import alike
from shockpc.text.printed import Cause, cause_lines, causes, few
from shockpc.text.wings import doors

CAUSES = 20
"""Different causes of landings that could not be computed that are shown."""

NO_DRIVES = {
    "free": "nothing gives a reflected inertia; stiff gearboxes change the results considerably"
}
"""What a joint model without drives of the catalogue means."""


SECOND = ("ropc", "friction_needed", "feasible", "error_bound")
"""Standard quantities that are not on a terminal, unless landings are ranked by one."""


def batch_report(batch: Batch, every: bool = False) -> Report:
    """The worst landing of each robot, or every landing; the Markdown document also has their
    warnings.
    """
    caption = f"the worst landing of each robot, ranked by {batch.rank}"
    table = _for_people if every else _of_robots
    drawn = any(row.picture is not None for row in batch.rows)
    picture = (
        [Picture("sheet", caption, "studies.batch.figure:draw_contact_sheet", (batch,))]
        if drawn
        else []
    )
    warnings = _warnings(batch)
    return Report(
        name="batch",
        title="Landings of robots",
        body=lambda full: [
            *picture,
            *([table(batch)] if batch.rows else []),
            *([Lines(warnings)] if full else []),
        ],
        closing=[
            f"not computed: {line}" for line in cause_lines(_causes(batch), "landings", CAUSES)
        ],
        sheets={
            "batch": lambda: _sheet(batch),
            "robots": lambda: _robots(batch),
            "sensors": lambda: _sensors(batch),
        },
        document=lambda: {
            "rank": batch.rank,
            "landings": [
                {
                    key: getattr(row, key)
                    for key in ("source", "robot", "contact", "scene", "warnings")
                }
                for row in batch.rows
            ],
        },
        tables=True,
    )


def _robots(batch: Batch) -> Sheet:
    """The worst landing of each robot, with the range over its drives; without a rank where nobody
    knows them.
    """
    short, known = batch.short_names, [row for row in batch.robots if row.drives_known]
    quantity, unit = select(batch.rank.partition("@")[0]).quantity, _unit(batch.rank)
    shown = (*(text.removeprefix("robot.") for text in STANDARD), batch.rank)
    asked = [name for name in batch.columns if name not in shown]
    rows: list[Row] = []
    for row in batch.robots:
        value, found = row.values[batch.rank], row.range
        ends = (value, value) if found is None else (found.smallest, found.largest)
        rank = known.index(row) + 1 if row.drives_known else None
        robot = short.get(row.robot, row.robot)
        robot += f" ({Path(row.source).name})" * row.source.endswith(".toml")
        where: Row = (robot, None, None)
        if quantity.of == "point":
            where = (robot, row.at, "IMU" if row.at in row.sensors else "trunk")
        in_short = row.status if row.drives_known or "," not in row.status else "partly unknown"
        (landing,) = landing_names([row.contact.split("+")], row.feet)
        rest = (row.effective_mass, row.values["mitigation"], *(row.values[name] for name in asked))
        marks = "; ".join(row.marks) or None
        rows.append(
            (
                rank,
                *where,
                landing,
                value,
                *ends,
                *rest,
                row.status,
                in_short,
                marks,
                len(row.warnings),
            )
        )
    header: tuple[str | Column, ...] = (
        "rank",
        "robot",
        "at",
        "kind of place",
        "landing",
        Column(batch.rank, batch.rank, unit),
        Column("smallest_found", "smallest", unit),
        Column("largest", "largest", unit),
        Column("effective_mass", "mass", "kg"),
        Column("mitigation", "IMF", "-"),
        *(Column(name, name, _unit(name)) for name in asked),
        "drives",
        "drives in short",
        "posture",
        "warnings",
    )
    return Sheet(f"{count(len(rows), 'robot')}, each in its worst landing", header, rows)


def _of_robots(batch: Batch) -> Sheet:
    """The same for people, in short words, with what the columns mean."""
    rows, sheet = batch.robots, _robots(batch).without("at", "drives", "posture", "warnings")
    titles = {"rank": "#", "kind_of_place": "at", "drives_in_short": "drives"}
    sheet = sheet._replace(
        header=[one._replace(title=titles.get(one.key, one.title)) for one in sheet.columns]
    ).known()
    what = (
        "|Δv| / v_in"
        if batch.rank == "shock"
        else select(batch.rank.partition("@")[0]).quantity.title
    )
    notes = [
        f"{batch.rank}: {what}, the worst of {count(len(batch.rows), 'landing')}; --landings "
        f"prints all of them",
        "smallest (as found) and largest: over the possible drives",
        "mass: effective mass of all contacts; IMF: impact mitigation factor of the contact where "
        "it is least",
    ]
    if any(not row.drives_known for row in rows):
        notes.append(
            "–: nobody knows the drives, so the number may lie anywhere in the range; give "
            "--drives or --armature"
        )
    marked = [
        f"{batch.short_names.get(row.robot, row.robot)} ({', '.join(row.marks)})"
        for row in rows
        if row.marks
    ]
    if marked:
        notes.append(f"not on bent legs, so not comparable with the others: {', '.join(marked)}")
    notes += _notes(batch)
    return sheet._replace(notes=notes)


def _bending(rows: Iterable[BatchRow], short: Mapping[str, str]) -> Iterator[str]:
    """The warning of the shared checks of wings, with the robots, and the words of the landing of
    which it is worst.
    """
    shared = {key for door in doors("checks") for key in door.SHARED}
    found = []
    for row in rows:
        for warning in row.warnings:
            if (warning.kind, warning.subject) in shared:
                found.append((warning, row))
    if found:
        worst, row = max(found, key=lambda one: one[0].size)
        robots = few(
            list(dict.fromkeys(short.get(row.robot, row.robot) for _, row in found)),
            6,
            what=" robots",
        )
        yield (
            f"warning: {robots}: {worst}"
            + f" (numbers of {short.get(row.robot, row.robot)} {row.contact})" * (len(found) > 1)
        )


def _unit(name: str) -> str:
    """The unit of a quantity, as people read it."""
    return select(name.partition("@")[0]).quantity.unit.replace("1", "-")


def _posture(row: BatchRow) -> str:
    """The reference posture, and how many joints are set besides."""
    posture = row.scene.posture
    given = len({*posture.joints, *posture.joints_deg})
    return f"{posture.reference}, {count(given, 'joint')} set" if given else str(posture.reference)


def _warnings(batch: Batch) -> list[str]:
    """A line for each cause of warnings of a robot, with the worst of it."""
    lines = []
    for robot in dict.fromkeys(row.robot for row in batch.rows):
        for every in alike(
            (warning, row.contact)
            for row in batch.rows
            if row.robot == robot
            for warning in row.warnings
        ):
            others = f" (in {every[0][1]}, less in {len(every) - 1} more)" if len(every) > 1 else ""
            lines.append(f"warning: {robot}: {every[0][0]}{others}")
    return lines


def _causes(batch: Batch) -> list[Cause]:
    """Why landings were not computed."""
    short = batch.short_names
    names = (
        " ".join(filter(None, (short.get(one.robot, one.robot), one.contact)))
        for one in batch.failures
    )
    return causes(zip(names, (one.reason for one in batch.failures), strict=True))


def _sheet(batch: Batch) -> Sheet:
    """One row for each landing, the worst first, then what failed."""
    header: list[str | Column] = [
        "scene",
        "robot",
        "name",
        "contact",
        "trunk",
        "at",
        "joints",
        "drives known",
    ]
    header += [Column(name, name, _unit(name)) for name in batch.columns]
    unit = _unit(batch.rank)
    header += [
        Column("smallest_found", "smallest found", unit),
        Column("largest", "largest", unit),
        "effective mass [kg]",
    ]
    header += ["posture", "drives", "drive status", "marks", "warnings", "failure"]
    rows: list[Row] = []
    short = batch.short_names
    for row in batch.rows:
        # A robot by its name or file needs no scene; a scene is known by its name.
        scene = row.source if row.source.endswith(".toml") else None
        cells: Row = (
            scene,
            row.robot,
            short.get(row.robot, row.robot),
            row.contact,
            row.trunk,
            row.at,
            row.joint_model,
        )
        cells += (row.drives_known, *(row.values[name] for name in batch.columns))
        cells += (None, None) if row.range is None else (row.range.smallest, row.range.largest)
        cells += (
            row.effective_mass,
            _posture(row),
            row.drives or None,
            row.status,
            "; ".join(row.marks) or None,
        )
        rows.append((*cells, "; ".join(map(str, row.warnings)) or None, None))
    for one in batch.failures:
        named = (None, one.robot, short.get(one.robot, one.robot), one.contact or None)
        rows.append((*named, *[None] * (len(header) - 5), one.reason))
    return Sheet(f"{count(len(batch.rows), 'landing')}, ranked by {batch.rank}", header, rows)


def _sensors(batch: Batch) -> Sheet:
    """The shock at each sensor and point of each landing."""
    rows = [
        (row.robot, row.contact, name, shock)
        for row in batch.rows
        for name, shock in row.sensors.items()
    ]
    return Sheet("shock at sensors and points", ("robot", "contact", "at", "shock [-]"), rows)


def _for_people(batch: Batch) -> Sheet:
    """The landings without columns of second rank, and without those that say the same of every
    row.
    """
    models, known = (
        {row.joint_model for row in batch.rows},
        {row.drives_known for row in batch.rows},
    )
    left_out = [name for name in SECOND if name != batch.rank] + ["shock_com"] * (
        models == {"free"}
    )
    left_out += ["drives_known"] * (len(known) == 1)
    left_out += [
        "robot",
        "trunk",
        "at",
        "posture",
        "drives",
        "drive_status",
        "marks",
        "warnings",
        "failure",
    ]
    sheet = _sheet(batch).where(lambda row: row["failure"] is None).without(*left_out)
    left_out = ["scene"] * all(row[0] is None for row in sheet.rows)
    sheet = sheet.without(*left_out)
    header = [
        column._replace(title="robot") if column.key == "name" else column
        for column in sheet.columns
    ]
    return sheet._replace(header=header, notes=[*_landing_notes(batch), *_notes(batch)])


def _landing_notes(batch: Batch) -> Iterable[str]:
    """What the columns of landings mean, and with which joint models they are computed."""
    rows, short = batch.rows, batch.short_names
    yield "shock: at the IMU, else at the CoM of the trunk, the heaviest body; shock_max: the largest of the trunk"
    if rows:
        bound = max(row.values["error_bound"] or 0.0 for row in rows)
        yield f"{proof_text(bound)}; shockpc quantities lists what the columns mean; --out writes more of them"
    models: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        drives = row.drives.replace(f"drives of {row.robot}, ", "drives ")
        drives = f"{drives}, through springs" if drives and row.joint_model == "free" else drives
        drives = drives or NO_DRIVES.get(row.joint_model, "")
        named = models.setdefault((row.joint_model, drives), [])
        name = short.get(row.robot, row.robot)
        named += [name] * (name not in named)
    yield "joints: " + "; ".join(
        f"{model}{f', {drives}' if drives else ''}: {', '.join(of)}"
        for (model, drives), of in models.items()
    )
    if any(row.drives_known for row in rows) and not all(row.drives_known for row in rows):
        yield "drives known: what drives the joints; compare landings whose drives are known"
    if any(
        row.drives and row.joint_model != "free" and row.scene.joints.drives is None for row in rows
    ):
        yield "with free joints: --joints free"
    if any(row.values["shock_max"] is None for row in rows):
        last = (
            "; such rows come last, ranked by the shock at its centre of mass"
            if batch.rank == "shock_max"
            else ""
        )
        yield f"–: the trunk has no geometry{last}"


def _notes(batch: Batch) -> Iterable[str]:
    """What distinguishes some robots and landings."""
    rows, short = batch.rows, batch.short_names
    yield from (f"{name}: {label}" for label, name in short.items())
    empty = [
        name for name in batch.columns if rows and all(row.values[name] is None for row in rows)
    ]
    yield from without_value((name, select(name.partition("@")[0]).quantity) for name in empty)
    neutral = list(
        dict.fromkeys(
            short.get(row.robot, row.robot)
            for row in rows
            if row.scene.posture.reference in ("neutral", BENT)
        )
    )
    if neutral:
        bent = "with straight legs bent where they can be"
        yield f"in the neutral posture, {bent}, which is taken where no standing one is known: {', '.join(neutral)}"
    refused = [
        f"{short.get(row.robot, row.robot)} {row.contact}"
        for row in rows
        if row.values["feasible"] == 0.0 and not row.feasible_if_tilted
    ]
    if refused:
        yield f"flat ground does not allow {count(len(refused), 'landing')}, as the warnings say: {', '.join(refused)}"
    if slides := [row.scene for row in rows if row.scene.friction is not None]:
        names = [
            name
            for name in batch.columns
            if select(name.partition("@")[0]).quantity.of_ground(slides[0])
        ]
        others = "the others are of contacts that stick"
        yield (
            f"in double precision: {few(names, 4)}; {others}" if names else f"warning: {STICKING}"
        )
    yield from _bending(rows, short)
    warned = [row for row in rows if row.warnings]
    if warned:
        robots = ", ".join(dict.fromkeys(short.get(row.robot, row.robot) for row in warned))
        yield f"{count(len(warned), 'landing')} with warnings, which JSON, CSV and the report hold: {robots}"
