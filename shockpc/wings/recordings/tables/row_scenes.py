"""Scenes of the rows of a table: contacts, velocities of contacts, standing feet and friction."""

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.contact import contacts_like, landing_frames
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import with_definite_contacts
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError, StudyError
from shockpc.wings.recordings.tables.cells import RowMessages, empty_cells, numeric_column
from shockpc.wings.recordings.tables.column_meaning import FRICTION

ContactVelocities = Mapping[tuple[str, int], Array]
"""Velocities (n,) of contacts that a table gives, by frame and world axis [m/s].

They are NaN where a cell is empty.
"""


class RecordedScenes(NamedTuple):
    """The scenes of the rows of a table.

    Attributes:
        scenes: those that differ in their contacts, in which of them have a velocity, in the
            standing feet or in friction.
        scene: (n,) which of them each row is of.
        velocities: (n, c, 3) of contacts, world axes; NaN where it is that of the robot's motion
            [m/s].
    """

    scenes: tuple[Scene, ...]
    scene: np.ndarray
    velocities: Array


def recorded_scenes(
    landing: PosedLanding,
    columns: Mapping[str, np.ndarray],
    given: ContactVelocities,
    friction: Array,
    messages: RowMessages,
) -> RecordedScenes:
    """The scenes of the rows of a table.

    Args:
        landing: gives what the table does not.
        columns: of the table.
        given: velocities of contacts that it gives.
        friction: (n,) coefficients of friction, NaN where there are none.
        messages: get the rows whose contacts, velocities or standing feet cannot be understood.

    Raises:
        StudyError: the velocity of a contact is given in part, or for a frame that is no contact of
            any row.
    """
    scene = landing.scene
    contacts, index = _row_contacts(landing, columns, len(friction), messages)
    velocities = _velocities(contacts, index, given, messages)
    moving = np.asarray(np.isfinite(velocities).all(axis=2))
    stances, stance = _stances(landing, columns, len(friction), messages)
    # Rows of one code have one scene: the same contacts, stance, and contacts that move.
    code = index * len(stances) + stance
    for moves in moving.T[moving.any(axis=0)]:
        code = np.unique(2 * code + moves, return_inverse=True)[1]
    _, rows, group = np.unique(code, return_index=True, return_inverse=True)
    scenes = []
    for i in rows.tolist():
        of_row = []
        for c, contact in enumerate(contacts[index[i]]):
            velocity = tuple(velocities[i, c].tolist()) if moving[i, c] else None
            of_row.append(replace(contact, velocity=velocity))
        mu = None if np.isnan(friction[i]) else float(friction[i])
        scenes.append(replace(scene, contact=tuple(of_row), stance=stances[stance[i]], friction=mu))
    return RecordedScenes(tuple(scenes), group, velocities)


def row_friction(
    landing: PosedLanding, columns: Mapping[str, np.ndarray], n: int, messages: RowMessages
) -> Array:
    """Coefficients (n,) of friction of the rows of a table; NaN where there are none.

    The arguments are those of `recorded_scenes`.
    """
    name = next((name for name in FRICTION if name in columns), "")
    if not name:
        mu = landing.scene.friction
        return np.full(n, np.nan if mu is None else mu)
    friction = numeric_column(name, columns[name], messages)
    messages.refuse(
        friction < 0.0,
        lambda i: f"column {name}: {friction[i]:g} is not a valid friction; it must be ≥ 0",
    )
    return np.maximum(friction, 0.0)


def _row_contacts(
    landing: PosedLanding, columns: Mapping[str, np.ndarray], n: int, messages: RowMessages
) -> tuple[list[tuple[Contact, ...]], np.ndarray]:
    """The different landings, each with its contacts, and the number (n,) of that of each row."""
    if "contact" not in columns:
        return [landing.scene.contact], np.zeros(n, dtype=int)
    texts, index = np.unique(columns["contact"].astype(str), return_inverse=True)
    contacts: list[tuple[Contact, ...]] = []
    # The same contacts in another order are the same landing.
    first: dict[tuple[str, ...], int] = {}
    same = np.zeros(len(texts), dtype=int)
    for k, text in enumerate(texts.tolist()):
        of_text = landing.scene.contact
        if text:
            of_text = _contacts(landing, text, index == k, messages)
        contacts.append(of_text)
        same[k] = first.setdefault(tuple(sorted(map(repr, of_text))), k)
    return contacts, same[index]


def _velocities(
    contacts: Sequence[tuple[Contact, ...]],
    index: np.ndarray,
    in_table: ContactVelocities,
    messages: RowMessages,
) -> Array:
    """Velocities (n, c, 3) of contacts, those of the table before those of the scene.

    Args: contacts and index as `_row_contacts` gives them.
    """
    numbers = np.unique(index).tolist()
    used = {contact.frame for k in numbers for contact in contacts[k]}
    unused = {frame for frame, _ in in_table} - used
    if unused:
        raise StudyError(
            f'the table gives the velocity of "{min(unused)}", which is no contact of any row; '
            f"leave it out (--map)"
        )
    velocities = np.full((len(index), max(map(len, contacts)), 3), np.nan)
    for k in numbers:
        rows = np.flatnonzero(index == k)
        for c, contact in enumerate(contacts[k]):
            if contact.velocity is not None:
                velocities[rows, c] = contact.velocity
            of_rows = _velocities_in_table(contact.frame, rows, in_table, messages)
            if of_rows is not None:
                velocities[rows, c] = np.where(np.isnan(of_rows), velocities[rows, c], of_rows)
    return velocities


def _velocities_in_table(
    frame: str, rows: np.ndarray, in_table: ContactVelocities, messages: RowMessages
) -> Array | None:
    """Velocities (m, 3) of a contact in rows (m,) of a table; None if it has no such columns.

    Rows that give some components only are refused.
    """
    axes = [in_table[frame, axis] for axis in range(3) if (frame, axis) in in_table]
    if not axes:
        return None
    if len(axes) < 3:
        raise StudyError(f'the velocity of contact "{frame}" needs all of vx@, vy@ and vz@{frame}')
    velocities: Array = np.stack(axes, axis=1)[rows]
    known = ~np.isnan(velocities)
    text = (
        f'the velocity of contact "{frame}" is not given in full: vx@, vy@ and vz@ are needed, '
        f"or none"
    )
    for i in rows[known.any(axis=1) & ~known.all(axis=1)].tolist():
        messages.setdefault(i, text)
    return velocities


def _stances(
    landing: PosedLanding, columns: Mapping[str, np.ndarray], n: int, messages: RowMessages
) -> tuple[list[tuple[str, ...]], np.ndarray]:
    """The different sets of standing feet, and the number (n,) of that of each row.

    Where a cell is empty, it is the scene's.
    """
    if "stance" not in columns:
        return [landing.scene.stance], np.zeros(n, dtype=int)
    cells = columns["stance"]
    texts = np.where(empty_cells(cells), "", cells.astype(str))
    different, index = np.unique(texts, return_inverse=True)
    stances = []
    for k, text in enumerate(different.tolist()):
        stance = landing.scene.stance
        if text:
            stance = _frames(landing.robot, text, index == k, messages)
        stances.append(stance)
    return stances, index


def _contacts(
    landing: PosedLanding, text: str, rows: np.ndarray, messages: RowMessages
) -> tuple[Contact, ...]:
    """The contacts A+B of rows (n,), each as the scene has it.

    One that the scene has not has all that the first of the scene is given.

    They are resolved in the posture of the scene. Rows whose text means no contacts are refused,
    and have those of the scene.
    """
    if not (frames := _frames(landing.robot, text, rows, messages)):
        return landing.scene.contact
    contacts = contacts_like(landing.asked, frames)
    with contextlib.suppress(ShockError):  # which is the message of the rows
        contacts = with_definite_contacts(
            replace(landing.scene, contact=contacts), landing.robot
        ).contact
    return contacts


def _frames(robot: Robot, text: str, rows: np.ndarray, messages: RowMessages) -> tuple[str, ...]:
    """The frames A+B of rows (n,); none where the text means none.

    The rows are refused then.
    """
    try:
        landings = landing_frames(robot, text)
        if len(landings) > 1:
            raise StudyError(
                f'contact "{text}" of a row means {len(landings)} landings; name the frames, with '
                f"+ between them"
            )
    except ShockError as error:
        reason = str(error)
        messages.refuse(rows, lambda _: reason)
        return ()
    return landings[0]
