"""The robot and the rows of a table, with a scene that gives what the table does not."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from shockpc.landing.contact import first_contact, landing_frames
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.robot.robot import Robot
from shockpc.wings.recordings.logs.cells import empty_cells
from shockpc.wings.recordings.logs.column_meaning import named_columns
from shockpc.wings.recordings.logs.reader import rows_of
from shockpc.wings.recordings.logs.rows import RecordedRows


def robot_of_table(columns: Mapping[str, np.ndarray], scene: Scene) -> Robot:
    """The robot of a scene, with the geoms that strike in rows of a table.

    These count where the scene has no contact.

    Raises:
        ShockError: as for `robot_of`.
    """
    if scene.contact:
        return robot_of(scene, [])
    cells = dict.fromkeys(map(str, np.ravel(columns.get("contact", ())).tolist()))
    names: list[str] = []
    for text in cells:
        for name in (text, *text.split("+")):
            if name.strip():
                names.append(name.strip())
    return robot_of(scene, names)


def rows_of_table(
    columns: Mapping[str, np.ndarray],
    scene: Scene,
    robot: Robot,
    rename: Mapping[str, str] | None = None,
) -> RecordedRows:
    """The rows of a table, as `rows_of` gives them.

    The scene gives what the table does not.

    Where the scene has no contact, every row has to have its own: one without any is refused, and
    has not those of another.
    """
    columns = named_columns(columns, rename or {})
    if not scene.contact and "contact" in columns:
        texts = np.where(empty_cells(columns["contact"]), " ", columns["contact"].astype(str))
        text, columns = first_contact(robot, texts.ravel().tolist()), {**columns, "contact": texts}
        frames = landing_frames(robot, text)[0] if text else ()
        scene = replace(scene, contact=tuple(Contact(frame=frame) for frame in frames))
    return rows_of(columns, landing_of(scene, robot))
