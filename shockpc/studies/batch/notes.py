"""Notes that explain the tables of a batch, and what distinguishes some robots and landings."""

import itertools
from collections.abc import Iterator

from shockpc.quantities.selection import select
from shockpc.robot.feet_and_sensors import BENT
from shockpc.show.wording import STICKING, proof_text, without_value
from shockpc.studies.batch.rows import Batch, BatchRow
from shockpc.text.diagnostic import Diagnostic, alike
from shockpc.text.printed import count, few
from shockpc.text.wings import from_wings

NO_DRIVES = {
    "free": "nothing gives a reflected inertia; stiff gearboxes change the results considerably"
}
"""The meaning of a joint model without drives of the catalogue, in words."""


def robot_notes(batch: Batch) -> Iterator[str]:
    """Notes that explain the columns of robots, and what distinguishes some robots."""
    title = "|Δv| / v_in"
    if batch.rank != "shock":
        title = select(batch.rank.partition("@")[0]).quantity.title
    landings = count(len(batch.rows), "landing")
    yield f"{batch.rank}: {title}, the worst of {landings}; --landings prints all of them"
    yield "smallest (as found) and largest: over the possible drives"
    yield (
        "mass: effective mass of all contacts; IMF: smallest impact mitigation factor of the "
        "contacts"
    )
    if not all(row.drives_known for row in batch.robots):
        yield (
            "–: unknown drives, so the number may lie anywhere in the range; give --drives or "
            "--armature"
        )
    marked = []
    for row in batch.robots:
        if row.marks:
            marked.append(f"{batch.name_of(row)} ({', '.join(row.marks)})")
    if marked:
        yield f"not on bent legs, so not comparable with the others: {', '.join(marked)}"
    yield from _notes(batch)


def landing_notes(batch: Batch) -> Iterator[str]:
    """Notes that explain the columns of landings, and what distinguishes some of them.

    They also name the joint models with which landings are computed.
    """
    rows = batch.rows
    yield (
        "shock: at the IMU, else at the CoM of the trunk (the heaviest body); shock_max: maximum "
        "over the trunk"
    )
    if rows:
        bound = max(row.values["error_bound"] or 0.0 for row in rows)
        yield (
            f"{proof_text(bound)}; shockpc quantities lists what the columns mean; --out writes "
            f"more of them"
        )
    yield _joint_note(batch)
    if len({row.drives_known for row in rows}) == 2:
        yield (
            "drives known: origin of the drives of the joints; compare only landings with known "
            "drives"
        )
    if any(_drives_of_catalogue(row) for row in rows):
        yield "with free joints: --joints free"
    if any(row.values["shock_max"] is None for row in rows):
        note = "–: the trunk has no geometry"
        if batch.rank == "shock_max":
            note += "; such rows come last, ranked by the shock at its centre of mass"
        yield note
    yield from _notes(batch)


def warning_lines(batch: Batch) -> list[str]:
    """A line for each cause of warnings of a robot, with the worst of it."""
    of_robots: dict[str, list[tuple[Diagnostic, str]]] = {}
    for row in batch.rows:
        warnings = of_robots.setdefault(row.robot, [])
        warnings += [(warning, row.contact) for warning in row.warnings]
    lines = []
    for robot, warnings in of_robots.items():
        for group in alike(warnings):
            worst, contact = group[0]
            line = f"warning: {robot}: {worst}"
            if len(group) > 1:
                line += f" (in {contact}, less in {len(group) - 1} more)"
            lines.append(line)
    return lines


def _drives_of_catalogue(row: BatchRow) -> bool:
    return bool(row.drives) and row.joint_model != "free" and row.scene.joints.drives is None


def _joint_note(batch: Batch) -> str:
    """The joint models, each with its drives and the robots that have it."""
    models: dict[tuple[str, str], dict[str, None]] = {}
    for row in batch.rows:
        drives = row.drives.replace(f"drives of {row.robot}, ", "drives ")
        if drives and row.joint_model == "free":
            drives = f"{drives}, through springs"
        drives = drives or NO_DRIVES.get(row.joint_model, "")
        models.setdefault((row.joint_model, drives), {})[batch.name_of(row)] = None
    texts = []
    for (model, drives), robots in models.items():
        described = f"{model}, {drives}" if drives else model
        texts.append(f"{described}: {', '.join(robots)}")
    return f"joints: {'; '.join(texts)}"


def _notes(batch: Batch) -> Iterator[str]:
    """Notes on what distinguishes some robots and landings."""
    rows = batch.rows
    for label, name in batch.short_names.items():
        yield f"{name}: {label}"
    yield from _empty_notes(batch)
    neutral = [row for row in rows if row.scene.posture.reference in ("neutral", BENT)]
    if neutral:
        yield (
            "in the neutral posture, with straight legs bent where they can be, the default of "
            f"robots without a standing posture: {_robots_of(batch, neutral)}"
        )
    refused = [row for row in rows if row.values["feasible"] == 0.0 and not row.feasible_if_tilted]
    if refused:
        names = ", ".join(f"{batch.name_of(row)} {row.contact}" for row in refused)
        landings = count(len(refused), "landing")
        yield f"flat ground does not allow {landings}, as the warnings say: {names}"
    yield from _friction_notes(batch)
    yield from _shared_warning(batch)
    warned = [row for row in rows if row.warnings]
    if warned:
        yield (
            f"{count(len(warned), 'landing')} with warnings (in JSON, CSV and the report): "
            f"{_robots_of(batch, warned)}"
        )


def _robots_of(batch: Batch, rows: list[BatchRow]) -> str:
    """The robots of some rows, each once."""
    return ", ".join(dict.fromkeys(batch.name_of(row) for row in rows))


def _empty_notes(batch: Batch) -> Iterator[str]:
    """The reasons why columns have no value in any landing."""
    empty = []
    for name in batch.columns:
        if batch.rows and all(row.values[name] is None for row in batch.rows):
            empty.append((name, select(name.partition("@")[0]).quantity))
    return without_value(empty)


def _friction_notes(batch: Batch) -> Iterator[str]:
    """A note on the columns that depend on friction, where scenes give one."""
    scenes = [row.scene for row in batch.rows if row.scene.friction is not None]
    if not scenes:
        return
    names = []
    for name in batch.columns:
        if select(name.partition("@")[0]).quantity.of_ground(scenes[0]):
            names.append(name)
    if names:
        yield f"in double precision: {few(names, 4)}; the others are for contacts that stick"
    else:
        yield f"warning: {STICKING}"


def _shared_warning(batch: Batch) -> Iterator[str]:
    """The warning of the shared checks of wings, with the robots that have it.

    Its words are those of the landing in which it is worst.
    """
    shared = set(itertools.chain.from_iterable(from_wings("checks", "SHARED")))
    warnings: list[tuple[Diagnostic, BatchRow]] = []
    for row in batch.rows:
        for warning in row.warnings:
            if (warning.kind, warning.subject) in shared:
                warnings.append((warning, row))
    if not warnings:
        return
    worst, row = max(warnings, key=lambda pair: pair[0].size)
    robots = list(dict.fromkeys(batch.name_of(row) for _, row in warnings))
    note = f"warning: {few(robots, 6, noun=' robots')}: {worst}"
    if len(warnings) > 1:
        note += f" (numbers of {batch.name_of(row)} {row.contact})"
    yield note
