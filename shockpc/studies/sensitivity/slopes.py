"""Derivatives of a number by whatever a sweep varies: differences of its rows beside a landing,
each with an error.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.evaluate import TRUSTED, Evaluation
from shockpc.evaluation.kinds.joints import ARMATURE
from shockpc.evaluation.kinds.links import (
    CENTRES,
    ENTRIES,
    INERTIA,
    LINK_PROPERTIES,
    POINT_MASS,
    LinkProperty,
)
from shockpc.evaluation.kinds.posture import JOINT_POSITION
from shockpc.evaluation.kinds.registry import KINDS
from shockpc.evaluation.kinds.strike import STRIKE_ANGLE
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.varied_landings import VariedLandings
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import COMPONENTS
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.changes import link_inertia, links_with_mass

STEP, FINER, ROUNDS = 2.0**-11, 16.0, 4
"""First step of a difference as a share of the parameter's size; where its two differences do not
agree, a step so much finer is
tried, so many times in all."""

AGREE = 1e-5
"""How far two differences are apart that agree, as a share of the derivative: what follows from
both is off by its square.
"""

SETTLED, SMALL = 1e-3, 1e-4
"""Largest error of a difference with which it is a derivative, as a share of it, or of the number
for a change by the size.
"""

ROUNDING = 4.0
"""Rounding of a derivative, at most, relative to the median of what rounding leaves of second
differences.
"""

ONE_SIDED = 22.0 / 3.0
"""How much more the rounding of its rows counts in a one-sided derivative: they enter by (1, −12,
32, −21) / 3, not by
(−1, 8, −8, 1) / 6, of which the sums are 22 and 3."""

CENTRAL, FORWARD = np.array([1.0, 0.5, -0.5, -1.0]), np.array([1.0, 0.5, 0.25, 0.0])
"""The rows of a parameter, as shares of the step; the second where less than none would be left on
the other side.
"""

EPSILON = float(np.finfo(float).eps)

RADIAN, MILLIMETRE = math.degrees(1.0), 1e-3

UNSETTLED = (
    "the difference does not settle: the number has a kink or a jump near this value, for example "
    "where a contact opens, its lowest point jumps, or contacts or loops are dependent"
)
NO_VALUE = (
    "the landing has no single value of it that could be changed (locked joints have none); give "
    "a value"
)


class Parameter(NamedTuple):
    """Something of a landing that can change.

    Attributes:
        varied: what a sweep varies.
        value: present value [its unit]; NaN if there is not one, or it cannot change.
        size: what the step of a difference is compared with [its unit].
        step: the step that is shown at 1 % [its unit]: one degree, one millimetre, or 1 % of what
            it is.
        relative: whether that is a share.
        away: the sign of the direction away from zero.
        lowest: below which there is no such value [its unit].
    """

    varied: Variation
    value: float
    size: float
    step: float
    relative: bool
    away: float
    lowest: float


def _parameter(landing: PosedLanding, varied: Variation) -> Parameter:
    """What a sweep varies as a parameter of a landing.

    Args: varied, of one link, one joint, or the landing.

    Raises:
        StudyError: the scene gives it in another way.
    """
    varied.kind.refuse_scene(landing.scene)
    robot = landing.robot
    kind = varied.kind
    value = away = varied.present(landing)
    lowest = 0.0 if kind.nonnegative or varied.factor else -math.inf
    relative = varied.unit not in ("deg", "m")
    size = step = (
        landing.length
        if varied.unit == "m"
        else RADIAN
        if varied.unit == "deg"
        else abs(value) or 1.0
    )
    if isinstance(kind, LinkProperty):
        whole, own = (
            robot.inertias[robot.frames[varied.target].body],
            link_inertia(robot, varied.target),
        )
        if kind in CENTRES:
            size, away = (
                float(robot.gyration[robot.frames[varied.target].body]) or size,
                float(own.lever["xyz".index(kind.word[-1])]),
            )
        elif kind in ENTRIES:
            size, step = float(np.trace(whole)) / 3.0, float(np.trace(own.inertia)) / 3.0
            away = float(own.inertia["xyz".index(kind.word[-2]), "xyz".index(kind.word[-1])])
        elif not varied.factor:
            size = step = own.mass
            if kind == POINT_MASS:
                lowest = -own.mass
    if kind == ARMATURE and not varied.factor:
        v, H = robot.joint(varied.target).v.start, landing.state.H[0]
        # the inertia that the joint moves; with all others free it resists by less
        step = value or float(H[v, v])
        size = 1.0 / float(np.linalg.inv(H)[v, v])
    if kind == STRIKE_ANGLE and landing.plane.level:
        value = math.nan
    step = {"deg": 1.0, "m": MILLIMETRE}.get(varied.unit, 0.01 * step)
    return Parameter(
        varied,
        value,
        size or 1.0,
        step,
        relative,
        math.copysign(1.0, away or 1.0),
        lowest,
    )


def _every(landing: PosedLanding) -> Iterator[Variation]:
    """What varies of a landing if nothing is named: of links, then of joints, then the strike."""
    robot, locked = landing.robot, landing.joint_model.locked
    with_rotor = {
        name for pattern in landing.scene.joints.rotor for name in robot.match_joints(pattern)
    }
    for link in links_with_mass(robot, "*"):
        yield from (
            Variation(f"{kind.word}:{link}", kind, link, kind.unit)
            for kind in LINK_PROPERTIES
            if kind != INERTIA
        )
    joints = [
        joint
        for name in robot.joint_names
        if name not in robot.followers
        for joint in [robot.joint(name)]
    ]
    for joint in joints:
        if not locked[joint.v].all():
            unit = ARMATURE.unit_of_prismatic
            if joint.unit == "rad":
                unit = ARMATURE.unit_of_revolute
            # A factor keeps the rotor, with its gear and its spring; another inertia would leave
            # them out.
            factor = joint.name in with_rotor or bool(landing.joint_model.per_turn[joint.v].any())
            yield Variation(
                f"armature:{joint.name}",
                ARMATURE,
                joint.name,
                "-" if factor else unit,
                factor=factor,
            )
    for joint in joints:
        if joint.axis is not None:
            yield Variation(
                joint.name, JOINT_POSITION, joint.name, joint.unit.replace("rad", "deg")
            )
        for word in COMPONENTS.get(joint.kind, ()):
            yield Variation(f"{word}:{joint.name}", KINDS[word], joint.name, KINDS[word].unit)
    if not landing.plane.level:
        yield Variation("strike-angle", STRIKE_ANGLE, "", "deg")


def parameters(landing: PosedLanding, chosen: Sequence[Variation] = ()) -> dict[str, Parameter]:
    """The parameters of a landing by name: those that are chosen, or all; an inertia that a link
    lacks does not change.
    """
    parameters = (_parameter(landing, varied) for varied in chosen or _every(landing))
    return {one.varied.subject: one for one in parameters if chosen or one.step > 0.0}


class Slope(NamedTuple):
    """A derivative of the number in a landing, its error, and why there is none."""

    value: float
    error: float = 0.0
    reason: str = ""


def slopes_beside(
    profile: ShockProfile, wanted: Mapping[str, Parameter], number: Column
) -> dict[str, Slope]:
    """The derivatives of the number by the parameters that are wanted: differences of the rows of a
    sweep beside the landing.

    Each has the step h of `STEP`, and finer ones as long as its two differences (`_differences`) do
    not agree and a finer step brings them closer. The error is stated as what these are apart, or
    as the part of the second differences that does not vanish with h, which is that of a kink or a
    jump, if that is larger. Of most parameters this part is rounding, which is added, and a smaller
    derivative is zero.

    Args:
        profile: the landing.
        wanted: the parameters by name.
        number: the number.
    """
    names = [name for name, parameter in wanted.items() if math.isfinite(parameter.value)]
    slopes = {name: Slope(np.nan, reason=NO_VALUE) for name in wanted if name not in names}
    if not names:
        return slopes
    present, size, lowest = np.array(
        [(p.value, p.size, p.lowest) for p in map(wanted.get, names) if p is not None]
    ).T
    here, n = number_of(profile, number), len(names)
    source = VariedLandings(
        profile.scene, profile.robot, tuple(wanted[name].varied for name in names), sample=1
    )
    evaluation = Evaluation(source, (number,), prove=0, trusted=TRUSTED)
    # so that a value and its step are added without rounding
    step = 2.0 ** np.round(np.log2(STEP * size))
    one_sided = present - step < lowest
    value, error, noise, todo, messages = (
        np.full(n, np.nan),
        np.full(n, np.inf),
        math.inf,
        np.arange(n),
        dict[int, str](),
    )
    for k in range(ROUNDS):
        h, sided, given = step[todo] / FINER**k, one_sided[todo], np.full((len(todo), 4, n), np.nan)
        shares = np.where(sided[:, None], FORWARD, CENTRAL)
        given[np.arange(len(todo)), :, todo] = present[todo, None] + h[:, None] * shares
        table = replace(
            evaluation, landings=source.at(given.reshape(-1, n))
        ).table.without_defects()
        f = table.values(number).reshape(-1, 4).T
        messages |= {int(todo[i // 4]): text for i, text in table.messages.items()}
        whole, half, left = _differences(f, here, h, sided)
        central = np.nan_to_num(left * h)[~sided]
        if not k or len(central):
            # Of one-sided differences alone it is seen where nothing changes: the row of the
            # landing, and its proven number.
            rounding = float(np.median(central)) if len(central) else np.abs(f[3] - here).max()
            # What is left with the steps of a few parameters may be more than rounding, and is less
            # with finer ones.
            noise = min(noise, ROUNDING * max(EPSILON * abs(here), rounding))
        rounded = noise / h * np.where(sided, ONE_SIDED, 1.0)
        apart = np.maximum(np.abs(whole - half), left) + rounded
        better = apart < error[todo]
        found = (4.0 * half - whole) / 3.0
        error[todo[better]], value[todo[better]] = (
            apart[better],
            np.where(np.abs(found) > rounded, found, 0.0)[better],
        )
        more = (apart > AGREE * np.abs(found) + 2.0 * rounded) | (
            apart > _settled(found, here, size[todo])
        )
        todo = todo[more & better]
        if not len(todo):
            break
    for i, name in enumerate(names):
        if i in messages:
            slopes[name] = Slope(
                np.nan, reason=f"beside this value there is no such number: {messages[i]}"
            )
        elif not error[i] <= _settled(value[i], here, size[i]):
            slopes[name] = Slope(np.nan, float(error[i]), UNSETTLED)
        else:
            slopes[name] = Slope(float(value[i]), float(error[i]))
    return slopes


def _differences(
    f: Array, here: float, h: Array, one_sided: np.ndarray
) -> tuple[Array, Array, Array]:
    """The differences D(h) and D(h/2) of m parameters, and the part of their second differences
    that does not vanish with h.

    Of central differences (4 D(h/2) − D(h)) / 3 is the derivative, off by h⁴ (Richardson).
    One-sided ones of second order, where less than none would be left of a mass, do the same, off
    by h³; of them there is no such part.

    Args:
        f: (4, m) the number in their rows, at the present value and the step times `CENTRAL` or
            `FORWARD`.
        here: the number in the landing.
        h: (m,) their steps.
        one_sided: (m,) which have rows on one side only.
    """
    central = (f[0] - f[3]) / (2.0 * h), (f[1] - f[2]) / h
    forward = (4.0 * f[1] - f[0] - 3.0 * f[3]) / h, 2.0 * (4.0 * f[2] - f[1] - 3.0 * f[3]) / h
    whole, half = (np.where(one_sided, *pair) for pair in zip(forward, central, strict=True))
    bend, kink = (f[0] - 2.0 * here + f[3]) / h, 2.0 * (f[1] - 2.0 * here + f[2]) / h
    return whole, half, np.where(one_sided, 0.0, np.abs(2.0 * kink - bend))


def _settled(slope: Array, number: float, size: Array) -> Array:
    """Largest error with which differences are derivatives.

    Args: slope, them; number, of the landing; size, of the parameters.
    """
    return np.maximum(SETTLED * np.abs(slope), SMALL * abs(number) / size)


def number_of(profile: ShockProfile, number: Column) -> float:
    """A number of a landing, as proven [its unit]."""
    return float(
        number.selection.scalar(profile.values(number.selection.quantity, [number.place]))[0]
    )
