"""What every study varies, as text and as records: posture, strike, contact, ground, inertia and
length of links, drives.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.number import number_from, numbers_from, whole_from
from shockpc.core.spatial import Array
from shockpc.landing.contact import landing_frames
from shockpc.landing.posture import COMPONENTS, component, refuse_beyond_turn, settable_joints
from shockpc.landing.record import options_of
from shockpc.landing.scene import Contact, Scene
from shockpc.landing.strike import Strike
from shockpc.robot.changes import ADDED, links_with_mass
from shockpc.robot.elements import Joint
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed

OF_THE_SCENE = {one.name: field for field, one in options_of(Scene).items() if one.varies}
"""Options of a scene that a sweep can vary, each with its field."""

OF_CONTACTS = {one.name: field for field, one in options_of(Contact).items() if one.varies}
"""Options of the contacts that a sweep can vary, each with its field."""

STRIKE = {one.name: one.unit for one in options_of(Strike).values() if one.varies}
ATTITUDE = {"base-roll": "deg", "base-pitch": "deg", "base-yaw": "deg"}
OFFSET = {"offset-x": "m", "offset-y": "m", "offset-z": "m"}
COMPONENT = {kind: "m" if kind.startswith("shift") else "deg" for kind in COMPONENTS["free"]}
OF_A_LINK = {
    "mass": "kg",
    "point-mass": "kg",
    "com-x": "m",
    "com-y": "m",
    "com-z": "m",
    "inertia": "-",
}
OF_A_LINK |= {f"inertia-{entry}": "kg m²" for entry in ("xx", "yy", "zz", "xy", "xz", "yz")}
OF_THE_GROUND = {
    one.name: one.unit.replace("1", "-")
    for record in (Scene, Contact)
    for one in options_of(record).values()
    if one.varies
}
INERTIAL = (*OF_A_LINK, "armature")
OF_A_JOINT = ("armature", "rotor", "joint-stiffness", "place")
OF_A_PART = (*OF_A_LINK, "flex", *OF_A_JOINT, *COMPONENT)
DRIVEN = {
    "armature": ("reflected inertia", "kg m²", "kg"),
    "rotor": ("rotor inertia", "kg m²", "kg m²"),
    "joint-stiffness": ("stiffness", "N m/rad", "N/m"),
}
"""What a drive has: its name, and its unit for revolute and for prismatic joints."""

WORDS = (
    *(*STRIKE, *ATTITUDE, *OFFSET, *OF_THE_GROUND, "contact"),
    *(f"{kind}:LINK" for kind in (*OF_A_LINK, "flex")),
    *(f"{kind}:JOINT" for kind in (*OF_A_JOINT, *COMPONENT)),
)
FORM = (
    "a:b:n (n values from a to b), a,b,c (these values) or, with --sample, a:b (any value "
    "between), a:b:log (log-uniform) or m±s "
    "(normal, cut off at 3 s; also typed m+-s)"
)

CUT = 3.0
"""Standard deviations from the mean at which a normal distribution is cut off."""

Law = Literal["uniform", "log-uniform", "normal"]

ROUNDED = 1e-2
"""By how much a value may miss limits, which files state in rounded decimals [deg, m]."""

MOST_VALUES = 1_000_000
"""Values of one quantity in a grid."""


@dataclass(frozen=True, eq=False)
class Variation:
    """One quantity that a sweep varies.

    Attributes:
        subject: as it is typed, such as "*_KFE", "strike-angle" or "mass:base_link".
        kind: "joint", "contact", or a word of the subject, such as "strike-angle", "mass" or
            "armature".
        target: what the kind applies to: a pattern of links or of joints; empty if it applies to
            the landing.
        unit: of the values.
        values: to be computed, or drawn from; numbers, or names of contacts.
        span: smallest and largest value between which numbers are drawn; None if values are given.
        law: distribution of these numbers; a normal one has its mean in the middle of the span,
            which is six standard deviations.
        factor: whether the values are factors of what the landing has.
    """

    subject: str
    kind: str
    target: str
    unit: str
    values: tuple[float | str, ...] = ()
    span: tuple[float, float] | None = None
    law: Law = "uniform"
    factor: bool = False

    @property
    def moves(self) -> bool:
        """Whether it changes the posture."""
        return self.kind == "joint" or self.kind in ATTITUDE or self.kind in COMPONENT

    def drawn(self, u: Array) -> np.ndarray:
        """Values (n,) of the distribution. Args: u (n,) uniform in [0, 1)."""
        if self.span is None:
            chosen: np.ndarray = np.asarray(self.values)[
                np.minimum((u * len(self.values)).astype(int), len(self.values) - 1)
            ]
            return chosen
        low, high = self.span
        if self.law == "log-uniform":
            return np.asarray(np.clip(low * np.exp(u * math.log(high / low)), low, high))
        if self.law == "normal":
            from scipy.special import ndtr, ndtri

            tail = ndtr(-CUT)
            return np.asarray(
                0.5 * (low + high)
                + (high - low) / (2.0 * CUT) * ndtri(tail + u * (1.0 - 2.0 * tail))
            )
        return np.asarray(low + (high - low) * u)

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value.

        Raises:
            StudyError: there is no range between them.
        """
        values = self.span or tuple(value for value in self.values if isinstance(value, float))
        if not values or not min(values) < max(values):
            raise StudyError(
                f"{self.subject} has no range; give one, such as {self.subject}=LOW:HIGH"
            )
        return min(values), max(values)

    @property
    def column(self) -> str:
        """Heading of its column in tables, with the unit."""
        return self.subject if self.kind == "contact" else f"{self.subject} [{self.unit}]"

    @property
    def stage(self) -> int:
        """What a change of it needs: 0 another landing, 1 another posture or inertia, 2 only
        another product with the maps.
        """
        # Springs matter only on contacts of finite stiffness, which are computed one by one; which
        # joints have one counts before.
        alike = self.kind in INERTIAL or (self.kind == "joint-stiffness" and self.factor)
        return 2 if self.kind in STRIKE else 1 if self.moves or alike else 0

    @property
    def uncertain(self) -> bool:
        """Whether it is of the robot or of the ground, rather than of how the robot lands."""
        return self.kind in (*OF_A_LINK, "flex", *OF_A_JOINT, *OF_THE_GROUND)

    def joints(self, robot: Robot) -> tuple[Joint, ...]:
        """The joints that a joint's variation sets: what follows another joint is not among them."""
        return _settable(robot, self.target)


@memoized()
def _settable(robot: Robot, pattern: str) -> tuple[Joint, ...]:
    return settable_joints(robot, pattern, StudyError)


Vary: TypeAlias = Mapping[str, Any] | Iterable[tuple[str, Any]]
"""What varies: values by subject as `variation` takes them, or pairs of both."""


def pairs(vary: Vary) -> list[tuple[str, Any]]:
    """Subjects with their values, given as a mapping or as pairs.

    Raises:
        StudyError: they are given in another way.
    """
    given: Any = vary.items() if isinstance(vary, Mapping) else vary
    ones = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else [given]
    for one in ones:
        if not (isinstance(one, tuple | list) and len(one) == 2 and isinstance(one[0], str)):
            raise StudyError(
                f'what varies is {one!r}; give values by subject, such as {{"strike-angle": '
                f'"0:30"}}, or pairs of both'
            )
    return [(subject, values) for subject, values in ones]


def variation(
    robot: Robot, subject: str, values: "str | float | Iterable[float | str] | None" = None
) -> Variation:
    """One quantity to vary.

    Args:
        robot: the robot.
        subject: "*_KFE", "joint:speed", "strike-angle", "speed", "base-pitch", "contact",
            "offset-x", "friction", "mass:LINK", "point-mass:LINK", "com-z:LINK", "inertia:LINK",
            "inertia-xx:LINK", "flex:LINK", "armature:JOINTS", "rotor:JOINTS",
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
    if kind == "contact":
        return _contacts(robot, subject, values)
    numbers, span, law, factor = _numbers(subject, values)
    if values is None and kind != "joint":
        raise StudyError(f"{subject}: no values are given; valid are {FORM}")
    unit = {
        **STRIKE,
        **ATTITUDE,
        **OFFSET,
        **OF_THE_GROUND,
        **OF_A_LINK,
        **COMPONENT,
        "flex": "N m²",
    }.get(kind, "")
    least = min(numbers + (span or ()), default=0.0)
    if factor and (kind == "rotor" or kind not in ("mass", "inertia", "flex", *OF_A_JOINT)):
        raise StudyError(
            f"{subject}: a factor such as 0.8x or ±5% applies to mass:LINK, inertia:LINK, "
            f"flex:LINK, armature:JOINT, "
            f"joint-stiffness:JOINT and place:JOINT only; give values in {unit or 'SI units'}"
        )
    if (
        law == "normal"
        and isinstance(values, str)
        and values.startswith(("±", "+-"))
        and not (factor or kind in ADDED or kind in COMPONENT)
    ):
        raise StudyError(f"{subject}: {values} has no mean; give it too, such as 1{values}")
    if kind == "inertia" and not factor:
        raise StudyError(
            f"{subject}: the moments of inertia are varied by factors; give them with an x, such "
            f"as 0.5x:2x:4"
        )
    if kind == "place":
        robot.match_joints(target)
        if not factor:
            raise StudyError(
                f"{subject}: places, and so lengths, are varied by factors; give them with an x, "
                f"such as 0.8x:1.2x:5"
            )
    if kind in COMPONENT:
        several_joints(robot, subject, kind, target)
    if kind in OF_A_LINK:
        masses = links_with_mass(robot, target)
        if kind == "point-mass" and least <= -min(masses.values()):
            raise StudyError(
                f"{subject}: {least:g} kg would leave no mass of a link of "
                f"{min(masses.values()):g} kg"
            )
        if kind in ("mass", "inertia") and not least > 0.0:
            raise StudyError(
                f"{subject}: {least:g} is not above zero, but a link has to keep some {kind}"
            )
    if kind == "flex":
        robot.match_bodies(target)
        if not least > 0.0:
            raise StudyError(f"{subject}: a bending stiffness of {least:g} is not above zero")
    if kind in DRIVEN:
        what, *units = DRIVEN[kind]
        unit = _unit(robot, subject, target, dict(zip(("rad", "m"), units, strict=True)))
        if least < 0.0 or (least == 0.0 and kind != "armature"):
            raise StudyError(
                f"{subject}: a {what} of {least:g} is {'below' if least < 0.0 else 'not above'} "
                f"zero"
            )
    if factor and law == "uniform" and span is not None and kind in (*DRIVEN, "flex"):
        law = "log-uniform"
    if law == "log-uniform" and not least > 0.0:
        raise StudyError(
            f"{subject}: {least:g} has no logarithm; give a range above zero, or leave :log out"
        )
    if kind == "joint":
        varied = Variation(
            subject,
            kind,
            target,
            _unit(robot, subject, target, {"rad": "deg", "m": "m"}),
            numbers,
            span,
            law,
        )
        return _within_limits(robot, varied)
    return Variation(subject, kind, target, "-" if factor else unit, numbers, span, law, factor)


def motion_range(joints: Iterable[Joint]) -> tuple[float, float]:
    """The values that are looked at of joints that all have the same value, where none are given
    [rad, m].

    They are the limits in the robot's file. Of joints that turn by a whole turn or more it is one
    turn about zero, −180° to 180°, which holds every posture of theirs: files write "no limit" in
    many ways. Infinite where joints slide without limits; empty where the joints have no value in
    common.
    """
    limits = [
        (-math.inf, math.inf) if joint.kind == "continuous" else joint.limits for joint in joints
    ]
    low, high = max(least for least, _ in limits), min(greatest for _, greatest in limits)
    turns = any(joint.unit == "rad" for joint in joints)
    return (-math.pi, math.pi) if turns and high - low >= 2.0 * math.pi else (low, high)


def each_of(robot: Robot, varied: Variation) -> tuple[Variation, ...]:
    """A variation with a separate quantity for each joint or link that matches; one of the whole
    landing as it is.
    """
    if varied.kind == "joint":
        single = (
            replace(varied, subject=joint.name, target=joint.name) for joint in varied.joints(robot)
        )
        return tuple(_within_limits(robot, each) for each in single)
    if varied.kind in OF_A_PART:
        names: Iterable[str] = ()
        if varied.kind in OF_A_LINK:
            names = links_with_mass(robot, varied.target)
        elif varied.kind == "flex":
            names = [robot.bodies[k].name for k in robot.match_bodies(varied.target)]
        elif varied.kind in OF_A_JOINT:
            names = robot.match_joints(varied.target)
        else:
            names = [
                joint.name
                for joint, _ in several_joints(robot, varied.subject, varied.kind, varied.target)
            ]
        return tuple(
            replace(varied, subject=f"{varied.kind}:{name}", target=name) for name in names
        )
    return (varied,)


def several_joints(robot: Robot, subject: str, kind: str, pattern: str) -> list[tuple[Joint, int]]:
    """The joints of several degrees of freedom that can move in one way, each with the velocity of
    it.

    Raises:
        UnknownName: no joint fits.
        StudyError: none of them can move so.
    """
    joints = [robot.joint(name) for name in robot.match_joints(pattern)]
    found = [(joint, v) for joint in joints if (v := component(joint, kind)) >= 0]
    if not found:
        known = [
            f"{word}:{joint.name}" for joint in joints for word in COMPONENTS.get(joint.kind, ())
        ]
        raise StudyError(
            f"{subject}: no joint moves so; "
            f"{f'valid are {listed(known, 6)}' if known else 'name a joint by itself'}"
        )
    return found


def refuse_repeated(robot: Robot, variations: Iterable[Variation]) -> None:
    """Refuse quantities that are varied twice, joints also by patterns that both match them.

    Raises:
        StudyError: one is.
    """
    seen: dict[str, str] = {}
    for varied in variations:
        names = (
            [joint.name for joint in varied.joints(robot)]
            if varied.kind == "joint"
            else [varied.subject]
        )
        for name in names:
            if name in seen:
                raise StudyError(
                    f'"{name}" is varied twice, by "{seen[name]}" and by "{varied.subject}"; keep '
                    f"one of them"
                )
            seen[name] = varied.subject


def kind_of(robot: Robot, subject: str) -> tuple[str, str]:
    """Kind and target of a `Variation`, from its subject.

    Raises:
        UnknownName: the robot has no such joint.
        StudyError: the subject names nothing, or the base of the robot is fixed.
    """
    word, colon, target = subject.partition(":")
    if word == "joint" and colon:
        return "joint", target
    if colon and word in OF_A_PART:
        if not target:
            raise StudyError(f"{subject} names nothing; write {word}:{_target(word)}")
        return word, target
    if (
        subject in STRIKE
        or subject in ATTITUDE
        or subject in OFFSET
        or subject in OF_THE_GROUND
        or subject == "contact"
    ):
        if subject in ATTITUDE and not robot.free_base:
            raise StudyError(
                f'{subject}: the base of robot "{robot.name}" is fixed in its file, so it cannot '
                f"be turned"
            )
        return subject, ""
    if subject in OF_A_PART:
        raise StudyError(
            f"{subject} names no {_target(subject).lower()}; write "
            f"{subject}:{_target(subject)}=VALUES"
        )
    robot.match("joint or quantity", subject, robot.joint_names, WORDS)
    return "joint", subject


def _target(kind: str) -> str:
    """What a kind applies to, as it is typed."""
    return "JOINT" if kind in (*OF_A_JOINT, *COMPONENT) else "LINK"


def _contacts(robot: Robot, subject: str, values: object) -> Variation:
    texts = (
        values.split(",")
        if isinstance(values, str)
        else list(values)
        if isinstance(values, Iterable)
        else []
    )
    if not texts:
        raise StudyError(
            "contact: no contact is named; write contact=NAME,NAME or a glob, such as "
            "contact=*_foot"
        )
    names = ["+".join(landing) for text in texts for landing in landing_frames(robot, str(text))]
    return Variation(subject, "contact", "", "", tuple(dict.fromkeys(names)))


def _numbers(
    subject: str, values: object
) -> tuple[tuple[float, ...], tuple[float, float] | None, Law, bool]:
    """Values, or the range to draw from and its distribution, and whether they are factors."""
    if values is None:
        return (), None, "uniform", False
    if not isinstance(values, str):
        values = values.tolist() if isinstance(values, np.ndarray) else values
        given = (
            list(values)
            if isinstance(values, Iterable) and not isinstance(values, bytes)
            else [values]
        )
        numbers = tuple(_number(subject, value) for value in given)
        if not numbers:
            raise StudyError(f"{subject}: the list of values is empty; give at least one")
        return numbers, None, "uniform", False
    mean, sign, deviation = values.replace("+-", "±").partition("±")
    if sign:
        share = deviation.strip().endswith("%") and not mean.strip()
        size = _number(
            subject, deviation.strip().removesuffix("%") if share else deviation.strip()
        ) / (100.0 if share else 1.0)
        middle = _number(subject, mean.strip()) if mean.strip() else float(share)
        if not size > 0.0:
            raise StudyError(
                f'{subject}: "{values}" has no standard deviation above zero; valid are {FORM}'
            )
        return (), (middle - CUT * size, middle + CUT * size), "normal", share
    parts = values.split(":") if ":" in values else values.split(",")
    count = parts.pop() if ":" in values and len(parts) == 3 else None
    factor = bool(parts[0]) and all(part.strip().endswith("x") for part in parts)
    bounds = tuple(
        _number(subject, part.strip().removesuffix("x") if factor else part.strip())
        for part in parts
    )
    if ":" not in values:
        return bounds, None, "uniform", factor
    if len(bounds) != 2:
        raise StudyError(f'{subject}: "{values}" is not understood; valid are {FORM}')
    low, high = bounds
    if count is None or count.strip() == "log":
        if not low < high:
            raise StudyError(
                f"{subject}: the range {low:g}:{high:g} is empty; give the lesser value first"
            )
        return (), (low, high), "log-uniform" if count else "uniform", factor
    try:
        n = whole_from(count)
    except ValueError:
        n = 0
    if not 1 <= n <= MOST_VALUES:
        raise StudyError(
            f'{subject}: "{count}" is not a number of values from 1 to {MOST_VALUES}; valid are '
            f"{FORM}"
        )
    # The ends are as typed, and what lies between does not depend on the number of values.
    steps = (
        (low,) if n == 1 else (*(low + (high - low) * (k / (n - 1)) for k in range(n - 1)), high)
    )
    return steps, None, "uniform", factor


def _number(subject: str, given: Any) -> float:
    value = math.nan
    try:
        if isinstance(given, str):
            value = number_from(given)
        elif not isinstance(given, bool | bytes) and not np.ndim(given):
            value = float(numbers_from(given))
    except (ValueError, TypeError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise StudyError(f'{subject}: "{given}" is not a finite number; valid are {FORM}')
    return value


def _unit(robot: Robot, subject: str, pattern: str, units: dict[str, str]) -> str:
    """The common unit of the joints that a pattern means."""
    common = {units[robot.joint(name).unit] for name in robot.match_joints(pattern)}
    if len(common) > 1:
        raise StudyError(
            f"{subject} means revolute and prismatic joints, which have different units; vary them "
            f"separately"
        )
    return common.pop()


def beyond_limits(robot: Robot, varied: Variation) -> str:
    """That values of a joint are outside the limits of the robot's file, and by which; empty where
    none is.
    """
    if varied.kind != "joint":
        return ""
    size, joints = math.degrees(1.0) if varied.unit == "deg" else 1.0, varied.joints(robot)
    low, high = (
        size * max(joint.limits[0] for joint in joints),
        size * min(joint.limits[1] for joint in joints),
    )
    values = [value for value in varied.span or varied.values if isinstance(value, float)]
    if not values or (min(values) >= low - ROUNDED and max(values) <= high + ROUNDED):
        return ""
    return (
        f"{varied.subject} from {min(values):g} to {max(values):g} {varied.unit} leaves the limits "
        f"of the robot file, {low:.6g} to "
        f"{high:.6g} {varied.unit}; these landings are computed all the same"
    )


def _within_limits(robot: Robot, varied: Variation) -> Variation:
    """Refuse joints that one number cannot set, and angles beyond a whole turn and the limits of
    the file.
    """
    for joint in varied.joints(robot):
        for value in varied.span or varied.values if varied.unit == "deg" else ():
            if isinstance(value, float):
                refuse_beyond_turn(joint, math.radians(value), varied.subject, StudyError)
    return varied
