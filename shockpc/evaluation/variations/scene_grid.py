"""All combinations of the values of several quantities, as scenes by name."""

from collections.abc import Iterable
from typing import Any

from shockpc.evaluation.variations.vary import refuse_repeated, variation
from shockpc.landing.contact import contact_name
from shockpc.landing.scenes.scene import Scene
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


def scene_grid(
    name: str, scene: Scene, robot: Robot, vary: Iterable[tuple[str, Any]]
) -> dict[str, Scene]:
    """All combinations of the values of several quantities, by a name that states them.

    Args:
        name: of the landing that is varied, with which the names begin, unless it is the contact
            and another one replaces that.
        scene: that landing.
        robot: its robot.
        vary: subjects with their values, as in `variation`.

    Raises:
        ShockError: a value is not possible, a quantity is one of the robot, not of the landing, or
            varied twice, or a range has no number of values.
    """
    variations = [variation(robot, subject, values) for subject, values in vary]
    refuse_repeated(robot, variations)
    names_contact = name == contact_name(scene)
    replaced = names_contact and any(varied.kind.names_contacts for varied in variations)
    scenes = {"" if replaced else name: scene}
    for varied in variations:
        subject = varied.subject
        if varied.kind.of_robot:
            raise StudyError(
                f"{subject}: the robot is the same in all of these landings; compare robots with "
                f"shockpc compare"
            )
        if not varied.values:
            raise StudyError(f"{subject} needs values: a:b:n (n values from a to b) or a,b,c")
        combined: dict[str, Scene] = {}
        for label, without_value in scenes.items():
            for value in varied.values:
                text = value if isinstance(value, str) else f"{value:g}"
                with_value, _ = varied.applied(without_value, robot, value)
                combined[f"{label} {subject}={text}".strip()] = with_value
        scenes = combined
    return scenes
