"""What varies, and changes of a design, read from subjects with values: SUBJECT=VALUES."""

from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

from shockpc.core.number import factor_texts, number_from
from shockpc.evaluation.variations.kinds.registry import KINDS, WORDS, kind_and_target
from shockpc.evaluation.variations.variation import Kind, Variation
from shockpc.robot.changes import Change
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

Vary: TypeAlias = Mapping[str, Any] | Iterable[tuple[str, Any]]
"""Values that vary, by subject as `variation` takes them, or pairs of both."""

EXAMPLE = "mass:*_shank=0.9x; com-z:trunk=-0.02; armature:*=0.01; place:*_knee=0,0,-0.3"
"""Changes of a design, for messages."""


def pairs(vary: Vary) -> list[tuple[str, Any]]:
    """Subjects with their values, given as a mapping or as pairs."""
    return list(vary.items() if isinstance(vary, Mapping) else vary)


def variation(
    robot: Robot, subject: str, values: "str | float | Iterable[float | str] | None" = None
) -> Variation:
    """One quantity to vary.

    Args:
        robot: the robot.
        subject: "*_KFE", "joint:speed", "strike-angle", "speed", "base-pitch", "contact",
            "offset-x", "friction", "mass:LINK", "point-mass:LINK", "com-z:LINK", "inertia:LINK",
            "inertia-xx:LINK", "armature:JOINTS", "rotor:JOINTS",
            "joint-stiffness:JOINTS", "place:JOINTS", "turn-x:JOINTS" of ball joints, and so on; a
            name that is none of these words is a joint, or a pattern of joints.
        values: numbers or names; or a text: "a:b:n" for n values from a to b, "a,b,c" for these,
            "a:b" for a range to draw from, uniformly or, of factors of armature and stiffness and
            with ":log" after it, uniformly in the logarithm; "m±s" to draw from a normal
            distribution of mean m and standard deviation s, of a centre of mass also "±s"; an x
            after each number, or "±5%", makes it a factor of what the landing has. None for the
            limits of a joint.

    Raises:
        UnknownName: the robot has no such joint or link.
        StudyError: the values do not fit the subject, there are none, or they are beyond the limits
            of a joint and a whole turn.
    """
    kind, target = kind_of(robot, subject)
    return kind.read(robot, subject, target, values)


def kind_of(robot: Robot, subject: str) -> tuple[Kind, str]:
    """Kind and target of a `Variation`, from its subject.

    Raises:
        UnknownName: the robot has no such joint.
        StudyError: the subject names nothing, or the base of the robot is fixed.
    """
    kind, target = kind_and_target(subject)
    if target == subject:
        robot.match("joint or quantity", subject, robot.joint_names, WORDS)
    elif kind.of and not target:
        raise StudyError(f"{subject} names no {kind.of.lower()}; write {kind.form}=VALUES")
    kind.check_robot(robot, subject)
    return kind, target


def each_of(robot: Robot, varied: Variation) -> tuple[Variation, ...]:
    """A quantity for each joint or link that matches; one of the whole landing as it is."""
    return varied.kind.each(robot, varied)


def refuse_repeated(robot: Robot, variations: Iterable[Variation]) -> None:
    """Refuse quantities that are varied twice, joints also by patterns that both match them.

    Raises:
        StudyError: one is.
    """
    seen: dict[str, str] = {}
    for varied in variations:
        for name in varied.kind.sets(robot, varied):
            if name in seen:
                raise StudyError(
                    f'"{name}" is varied twice, by "{seen[name]}" and by "{varied.subject}"; keep '
                    f"one of them"
                )
            seen[name] = varied.subject


def read_changes(text: str) -> tuple[Change, ...]:
    """Changes as they are typed, such as "mass:thigh=0.9x; armature:*=0.01".

    An x after a number makes it a factor.

    Raises:
        StudyError: it is not of that form.
    """
    changes = tuple(_read_change(part) for part in map(str.strip, text.split(";")) if part)
    if not changes:
        raise StudyError(f'"{text}" holds no change; give for example {EXAMPLE}')
    return changes


def _read_change(text: str) -> Change:
    """One change, PROPERTY:NAME=VALUE or PROPERTY:NAME=FACTORx."""
    subject, _, number = text.rpartition("=")
    kind, target = kind_and_target(":".join(map(str.strip, subject.split(":", 1))))
    texts, factor = factor_texts(number.split(","))
    try:
        values = tuple(map(number_from, texts))
    except ValueError:
        values = ()
    if not (kind.changes_designs and target and values):
        properties = ", ".join(kind.word for kind in KINDS.values() if kind.changes_designs)
        raise StudyError(
            f'"{text}" is not a change PROPERTY:NAME=VALUE or PROPERTY:NAME=FACTORx, such as '
            f"{EXAMPLE}; properties are {properties}"
        )
    return Change(kind.word, target, values if len(values) > 1 else values[0], factor)
