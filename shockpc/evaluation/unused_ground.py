"""The refusal of a friction or a contact stiffness on which no number of a study depends."""

from collections.abc import Iterable

from shockpc.landing.scenes.scene import Scene
from shockpc.quantities.selection import Selection
from shockpc.text.errors import StudyError

NAME_ONE = "name a quantity that depends on it, such as shock_friction or peak_force"
"""Remedy, for messages, where none of the numbers of a study depends on the ground."""


def refuse_ground(scene: Scene, *, friction: bool = True, remedy: str = NAME_ONE) -> None:
    """Refuse what a study of contacts that stick and are rigid would ignore.

    Args:
        scene: a landing of the study.
        friction: whether a coefficient of friction has no effect either.
        remedy: what else can be done.

    Raises:
        StudyError: the scene gives a contact stiffness, or a friction.
    """
    ignored = ["contact stiffness"] if scene.yields else []
    if friction and scene.friction is not None:
        ignored.append("friction")
    if ignored:
        raise StudyError(
            f"the scene gives a {' and a '.join(ignored)}, which would change nothing here: all "
            f"numbers are of the impulse of "
            f"contacts that stick; leave it out, or {remedy}"
        )


def refuse_unused_ground(scene: Scene, selections: Iterable[Selection]) -> None:
    """Refuse a friction or a contact stiffness on which nothing depends that a study computes.

    Args:
        scene: a landing of the study.
        selections: what is computed; whether flat ground allows the landing depends on the
            friction.

    Raises:
        StudyError: the scene gives one.
    """
    entries = tuple(selection.quantity for selection in selections)
    if not any(entry.of_ground(scene) for entry in entries):
        refuse_ground(scene, friction=not any(entry.decided_by_ground for entry in entries))
