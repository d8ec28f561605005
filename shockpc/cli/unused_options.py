"""Refusals of options of a landing that have no effect on what a study computes."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from shockpc.cli.options import SceneOptions
from shockpc.evaluation.declare import declaration
from shockpc.evaluation.variations.variation import Variation
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


class NeededBy(NamedTuple):
    """An option on which some quantities depend, and no others.

    Attributes:
        option: its name.
        example: key of a quantity that depends on it.
        depends: True for a quantity that does.
    """

    option: str
    example: str
    depends: Callable[[Quantity], bool]


NEEDED_BY = (
    NeededBy(
        "pulse",
        "peak_g",
        lambda entry: entry.computation.exact == "rigid" or entry.key.startswith("peak_g"),
    ),
    NeededBy(
        "imu-bandwidth",
        "filtered_peak",
        lambda entry: entry.key.startswith(("filtered_peak", "range_share")),
    ),
    NeededBy("range-g", "range_share", lambda entry: entry.key == "range_share"),
    NeededBy(
        "part",
        "part_margin",
        lambda entry: entry.of == "part" or entry.key == "joint_torque_share",
    ),
)


def refuse_unasked(
    study: Callable[..., Any],
    options: SceneOptions,
    typed: Mapping[str, Any],
    quantities: Iterable[str] = (),
) -> None:
    """Refuse a pulse, a bandwidth, a range and parts on which no number of a study depends.

    In a scene's file they may stand: they are of the robot.

    Args:
        study: the study.
        options: of the command.
        typed: the arguments of the study, by parameter.
        quantities: further ones that are computed, KEY[@PLACE].

    Raises:
        UnknownName: there is no such quantity.
        StudyError: an option has no effect.
    """
    declared = declaration(study)
    texts = list(quantities)
    for name, parameter in declared.parameters.items():
        if parameter.option.holds == "quantity" and (value := typed.get(name)):
            texts += [value] if isinstance(value, str) else value
    entries = [select(re.split("@|<=|>=", text)[0].strip()).quantity for text in texts]
    for option, example, depends in NEEDED_BY:
        if options.value(option) and option not in declared.uses and not any(map(depends, entries)):
            raise StudyError(
                f"no number here depends on --{option}; leave it out, or add a quantity such as "
                f"{example}"
            )


def refuse_varied(options: SceneOptions, robot: Robot, varied: Iterable[Variation]) -> None:
    """Refuse options whose value varies from landing to landing of a study.

    Of a glob of joints one that does not vary is enough to have an effect, and components of zero
    say nothing.

    Args:
        options: of the command.
        robot: the robot.
        varied: what has these values; factors are of what the options give.

    Raises:
        StudyError: an option has no effect.
    """
    ignored: list[str] = []
    varied_joints: dict[str, set[str]] = {}
    for varying in varied:
        option, axis = varying.kind.option, varying.kind.axis
        if varying.factor or not option:
            continue
        value = options.value(option)
        if varying.kind.of == "JOINT":
            joints = varied_joints.setdefault(option, set())
            joints.update(robot.match_joints(varying.target))
        elif axis >= 0:
            # Of three numbers, one that varies.
            if value and value[axis]:
                ignored.append(f"--{option}")
        elif value not in (None, ()):
            ignored.append(f"--{option}")
    for option, joints in varied_joints.items():
        for pattern, *_ in options.value(option):
            if joints.issuperset(robot.match_joints(pattern)):
                ignored.append(f"--{option} {pattern}")
    if ignored:
        options_text = ", ".join(dict.fromkeys(ignored))
        raise StudyError(
            f"{options_text} has no effect, because the value varies from landing to landing; "
            "leave it out, or, of an option with three numbers, set the varied one to zero"
        )
