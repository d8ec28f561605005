"""`--vary SUBJECT=VALUES`: the same landing with several strike angles, speeds or joint positions."""

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import typer

from shockpc.cli.parse import definition, finite
from shockpc.errors import StudyError

if TYPE_CHECKING:
    from shockpc.scene import Scene

__all__ = ["Varied", "varied", "varied_scenes"]

FORM = "SUBJECT=FIRST:LAST:NUMBER or SUBJECT=VALUE,VALUE"
EXAMPLE = "strike-angle=-30:75:8"


class Varied(NamedTuple):
    """A quantity and its values: "strike-angle" [deg], "speed" [m/s], or joints by name or glob [deg; m]."""

    subject: str
    values: tuple[float, ...]


def varied(text: str) -> Varied:
    """A quantity and its values from their text.

    Raises:
        typer.BadParameter: it is not of the form.
    """
    subject, values = definition(FORM, EXAMPLE)(text)
    parts = values.split(":")
    if len(parts) == 1:
        return Varied(subject, tuple(map(finite, values.split(","))))
    if len(parts) != 3 or not (parts[2].isascii() and parts[2].isdigit() and 0 < int(parts[2]) <= 10_000):
        raise typer.BadParameter(f'"{text}" is not {FORM}, such as {EXAMPLE}')
    first, last, number = finite(parts[0]), finite(parts[1]), int(parts[2])
    steps = (first + (last - first) * k / (number - 1) for k in range(number - 1))
    return Varied(subject, (first,) if number == 1 else (*steps, last))


def varied_scenes(name: str, scene: "Scene", all_: Iterable[Varied]) -> "dict[str, Scene]":
    """All combinations of values, by a name that says them.

    Raises:
        StudyError: a strike angle or a speed varies, but the scene gives its velocity in another way.
    """
    scenes = {name: scene}
    for one in all_:
        scenes = {
            f"{label} {one.subject}={value:g}": _with(known, one.subject, value)
            for label, known in scenes.items()
            for value in one.values
        }
    return scenes


def _with(scene: "Scene", subject: str, value: float) -> "Scene":
    """The scene with one value set."""
    if subject in ("strike-angle", "speed"):
        if scene.strike.velocity is not None or scene.strike.drop_height is not None:
            raise StudyError(f"--vary {subject}: the velocity is given as a vector or a drop height; leave that out")
        strike = scene.strike
        angle, speed = (value, strike.speed) if subject == "strike-angle" else (strike.strike_angle_deg, value)
        return dataclasses.replace(scene, strike=dataclasses.replace(strike, strike_angle_deg=angle, speed=speed))
    joints = {name: known for name, known in scene.posture.joints_deg.items() if name != subject} | {subject: value}
    return dataclasses.replace(scene, posture=dataclasses.replace(scene.posture, joints_deg=joints))
