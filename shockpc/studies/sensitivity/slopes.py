"""Derivatives of a number by whatever a sweep varies, each with an error.

They are differences of the rows of a sweep beside a landing.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.evaluate import MAX_CONDITION, Evaluation
from shockpc.evaluation.variations.kinds.posture import JOINT_POSITION
from shockpc.evaluation.variations.kinds.registry import KINDS
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.evaluation.variations.variation import Variation
from shockpc.landing.landing import PosedLanding
from shockpc.quantities.shock_profile import ShockProfile

STEP, FINER, ROUNDS = 2.0**-11, 16.0, 4
"""First step of a difference as a share of the parameter's size, its refinement, and their number.

Where its two differences do not agree, a step so much finer is tried, so many times in all.
"""

AGREE = 1e-5
"""Share of the derivative within which two differences agree.

What follows from both is off by its square.
"""

SETTLED, SMALL = 1e-3, 1e-4
"""Largest error of a difference with which it is a derivative, as a share.

The first is a share of it, the second of the number for a change by the size.
"""

ROUNDING = 4.0
"""Largest rounding of a derivative.

It is relative to the median of what rounding leaves of second differences.
"""

ONE_SIDED = 22.0 / 3.0
"""Factor by which the rounding of its rows counts more in a one-sided derivative.

They enter by (1, −12, 32, −21) / 3, not by (−1, 8, −8, 1) / 6; the sums are 22/3 and 3.
"""

CENTRAL, FORWARD = np.array([1.0, 0.5, -0.5, -1.0]), np.array([1.0, 0.5, 0.25, 0.0])
"""The rows of a parameter, as shares of the step, for central and for one-sided differences.

One-sided ones are taken where less than none would be left on the other side.
"""

EPSILON = float(np.finfo(float).eps)

ABSOLUTE_STEPS = {"deg": 1.0, "m": 1e-3}
"""The steps that are shown of angles and lengths [deg, m]; others are 1 % of what they are of."""

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
    """The parameter of a landing that a sweep varies.

    Args:
        landing: the landing.
        varied: of one link, one joint, or the landing.

    Raises:
        StudyError: the scene gives it in another way.
    """
    kind = varied.kind
    kind.refuse_scene(landing.scene)
    value = varied.present(landing)
    scale = kind.scale(varied, landing, value)
    return Parameter(
        varied=varied,
        value=value,
        size=scale.size or 1.0,
        step=ABSOLUTE_STEPS.get(varied.unit, 0.01 * scale.amount),
        relative=varied.unit not in ABSOLUTE_STEPS,
        away=math.copysign(1.0, scale.away or 1.0),
        lowest=kind.lowest(varied, landing.robot),
    )


def _usual(landing: PosedLanding) -> list[Variation]:
    """The quantities that vary if none is named: link by link, then of joints, then the strike."""
    usual: list[Variation] = []
    for kind in (*KINDS.values(), JOINT_POSITION):
        usual += kind.usual(landing)
    robot = landing.robot
    links = {link: k for k, link in enumerate(robot.links)}
    joints = {joint: k for k, joint in enumerate(robot.joint_names)}

    def order(varied: Variation) -> tuple[int, int]:
        if varied.kind.of == "LINK":
            return 0, links[varied.target]
        # Motions follow the robot's joints, whatever their kinds.
        if varied.kind.of == "JOINT" and varied.kind.moves:
            return 2, joints[varied.target]
        return (1, 0) if varied.kind.of == "JOINT" else (3, 0)

    return sorted(usual, key=order)


def parameters(landing: PosedLanding, chosen: Sequence[Variation] = ()) -> dict[str, Parameter]:
    """The parameters of a landing by name: those that are chosen, or all.

    An inertia that a link lacks does not change.
    """
    parameters = {}
    for varied in chosen or _usual(landing):
        parameter = _parameter(landing, varied)
        if chosen or parameter.step > 0.0:
            parameters[varied.subject] = parameter
    return parameters


class Slope(NamedTuple):
    """A derivative of the number in a landing, its error, and why there is none."""

    value: float
    error: float = 0.0
    reason: str = ""


def slopes_beside(
    profile: ShockProfile, wanted: Mapping[str, Parameter], number: Column
) -> dict[str, Slope]:
    """The derivatives of the number by the parameters that are wanted.

    They are differences of the rows of a sweep beside the landing. Each has the step h of `STEP`,
    and finer ones as long as its two differences (`_differences`) do not agree and a finer step
    brings them closer. The error is stated as what these are apart, or as the part of the second
    differences that does not vanish with h, which is that of a kink or a jump, if that is larger.
    Of most parameters this part is rounding, which is added, and a smaller derivative is zero.

    Args:
        profile: the landing.
        wanted: the parameters by name.
        number: the number.
    """
    slopes: dict[str, Slope] = {}
    known: dict[str, Parameter] = {}
    for name, parameter in wanted.items():
        if math.isfinite(parameter.value):
            known[name] = parameter
        else:
            slopes[name] = Slope(np.nan, reason=NO_VALUE)
    if known:
        beside = _Beside(profile, list(known.values()), number)
        beside.refine()
        for i, name in enumerate(known):
            slopes[name] = beside.slope(i)
    return slopes


class _Beside:
    """Differences of a number beside a landing, by n parameters, each refined until it settles.

    Args:
        profile: the landing.
        parameters: with present values.
        number: the number.
    """

    def __init__(self, profile: ShockProfile, parameters: Sequence[Parameter], number: Column):
        self._number = number
        self._here = number_of(profile, number)
        self._present = np.array([parameter.value for parameter in parameters])
        self._size = np.array([parameter.size for parameter in parameters])
        varied = tuple(parameter.varied for parameter in parameters)
        self._landings = VariedLandings(profile.scene, profile.robot, varied, sample=1)
        self._evaluation = Evaluation(
            self._landings, (number,), prove=0, max_condition=MAX_CONDITION
        )
        # A power of two, so that a value and its step are added without rounding.
        self._step: Array = np.exp2(np.round(np.log2(STEP * self._size)))
        lowest = np.array([parameter.lowest for parameter in parameters])
        self._one_sided = self._present - self._step < lowest
        # What rounding leaves of second differences of rows.
        self._noise = math.inf
        self._value = np.full(len(parameters), np.nan)
        self._error = np.full(len(parameters), np.inf)
        self._messages: dict[int, str] = {}

    def slope(self, i: int) -> Slope:
        """The derivative by a parameter."""
        value, error = float(self._value[i]), float(self._error[i])
        if i in self._messages:
            reason = f"beside this value there is no such number: {self._messages[i]}"
            return Slope(np.nan, reason=reason)
        if not error <= _settled(self._value[i], self._here, self._size[i]):
            return Slope(np.nan, error, UNSETTLED)
        return Slope(value, error)

    def refine(self) -> None:
        """Compute the differences with steps that become finer."""
        todo = np.arange(len(self._present))
        for k in range(ROUNDS):
            todo = self._refined(todo, self._step[todo] / FINER**k, first=k == 0)
            if not len(todo):
                return

    def _refined(self, todo: NDArray[np.intp], h: Array, *, first: bool) -> NDArray[np.intp]:
        """Compute the differences of some parameters (m,) with their steps (m,).

        Returns: those that take a finer step.
        """
        sided = self._one_sided[todo]
        f = self._rows(todo, h)
        of_step, of_half, left = _differences(f, self._here, h, sided)
        central = np.nan_to_num(left * h)[~sided]
        if first or len(central):
            self._note_rounding(central, f)
        rounded = self._noise / h * np.where(sided, ONE_SIDED, 1.0)
        # (4 D(h/2) − D(h)) / 3, and how far both are apart.
        slope = (4.0 * of_half - of_step) / 3.0
        apart = np.maximum(np.abs(of_step - of_half), left) + rounded
        better = apart < self._error[todo]
        self._error[todo[better]] = apart[better]
        self._value[todo[better]] = np.where(np.abs(slope) > rounded, slope, 0.0)[better]
        disagree = apart > AGREE * np.abs(slope) + 2.0 * rounded
        unsettled = apart > _settled(slope, self._here, self._size[todo])
        return todo[(disagree | unsettled) & better]

    def _rows(self, todo: NDArray[np.intp], h: Array) -> Array:
        """The number (4, m) in four rows beside the landing, for each parameter."""
        m, n = len(todo), len(self._present)
        shares = np.where(self._one_sided[todo, None], FORWARD, CENTRAL)
        # NaN leaves a parameter as it is.
        values = np.full((m, 4, n), np.nan)
        values[np.arange(m), :, todo] = self._present[todo, None] + h[:, None] * shares
        landings = self._landings.at(values.reshape(-1, n))
        table = replace(self._evaluation, landings=landings).table.without_defects()
        for row, text in table.messages.items():
            self._messages[int(todo[row // 4])] = text
        return table.values(self._number).reshape(-1, 4).T

    def _note_rounding(self, central: Array, f: Array) -> None:
        """Note what rounding leaves: the median of what is left of central second differences.

        Of one-sided differences alone it is seen where nothing changes: the row of the landing, and
        its proven number. What is left with the steps of a few parameters may be more than
        rounding, and is less with finer ones.

        Args:
            central: (c,) what is left.
            f: (4, m) rows, of which the last has no change if there are no central differences.
        """
        if len(central):
            rounding = float(np.median(central))
        else:
            rounding = np.abs(f[3] - self._here).max()
        self._noise = min(self._noise, ROUNDING * max(EPSILON * abs(self._here), rounding))


def _differences(
    f: Array, here: float, h: Array, one_sided: np.ndarray
) -> tuple[Array, Array, Array]:
    """The differences D(h) and D(h/2) of m parameters, and a part of their second differences.

    It is the part that does not vanish with h. Of central differences (4 D(h/2) − D(h)) / 3 is the
    derivative, off by h⁴ (Richardson). One-sided ones of second order, where less than none would
    be left of a mass, do the same, off by h³; of them there is no such part.

    Args:
        f: (4, m) the number in their rows, at the present value and the step times `CENTRAL` or
            `FORWARD`.
        here: the number in the landing.
        h: (m,) their steps.
        one_sided: (m,) which have rows on one side only.
    """
    f_0, f_1, f_2, f_3 = f
    # D(h) = (f(h) − f(−h)) / 2h,  D(h/2) = (f(h/2) − f(−h/2)) / h
    central = (f_0 - f_3) / (2.0 * h)
    central_half = (f_1 - f_2) / h
    # D(h) = (4 f(h/2) − f(h) − 3 f(0)) / h,  D(h/2) = 2 (4 f(h/4) − f(h/2) − 3 f(0)) / h
    forward = (4.0 * f_1 - f_0 - 3.0 * f_3) / h
    forward_half = 2.0 * (4.0 * f_2 - f_1 - 3.0 * f_3) / h
    # h f'' with both steps: halved for a smooth function, equal at a kink.
    bend = (f_0 - 2.0 * here + f_3) / h
    kink = 2.0 * (f_1 - 2.0 * here + f_2) / h
    left = np.where(one_sided, 0.0, np.abs(2.0 * kink - bend))
    of_step = np.where(one_sided, forward, central)
    of_half = np.where(one_sided, forward_half, central_half)
    return of_step, of_half, left


def _settled(slope: Array, number: float, size: Array) -> Array:
    """Largest error with which differences are derivatives.

    Args:
        slope: the differences.
        number: of the landing.
        size: of the parameters.
    """
    return np.maximum(SETTLED * np.abs(slope), SMALL * abs(number) / size)


def number_of(profile: ShockProfile, number: Column) -> float:
    """A number of a landing, as proven [its unit]."""
    wanted = number.selection.quantity
    values = profile.value(wanted.key, wanted.of, [number.place])
    return float(number.selection.scalar(values)[0])
