"""Which values of a joint, or of what else varies, keep a number below a bound: the shock at a
point, a torque, a friction.

It is a bound on the rows of a sweep over values and strike angles; the step in which a number
crosses it is halved on rows of its own.
"""

import functools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array, Plane
from shockpc.evaluation.column import Column, column, target_text
from shockpc.evaluation.column_values import columns
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import MOVED, End, at_drive_ends
from shockpc.evaluation.evaluate import profiles
from shockpc.evaluation.kinds.joints import OfDrive
from shockpc.evaluation.kinds.posture import JOINT_POSITION, motion_range
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.vary import kind_of, variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import set_many, settable_joints
from shockpc.landing.record import Option
from shockpc.landing.scene import Point, Scene
from shockpc.landing.scene_file import robot_of, scene_of
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.elements import Joint
from shockpc.robot.robot import Robot
from shockpc.studies.limits.scan import ANGLES, LEAST, Bound, Scan, Strikes, scanned, within
from shockpc.text.errors import ShockError, SolveError, StudyError
from shockpc.text.printed import UNITS, in_degrees
from shockpc.text.shown import brief, shown_by

STRIKES = (-30.0, 75.0)
"""Strike angles of landings that are looked at if none are given [deg]."""

STRIKE_ANGLE_STEP = 15.0
"""Between the strike angles for which limits are given one by one [deg]."""

STEEPEST = 89.0
"""Largest strike angle; at 90° the contact moves along the ground [deg]."""

VALUE = "deg; m if prismatic"
"""Unit of a joint's values as they are typed."""

STEP = {"rad": math.radians(0.1), "m": 1e-4}
"""Largest step of the scan of a joint if none is given: 0.1°, 0.1 mm.

Of other variations it is a 200th of the range.
"""

MOST_POSTURES = 200_000
"""Largest number of postures of a scan."""

PROBES = 64
"""Postures of the range of a joint by which the number of landings that need a proof is estimated.
"""

MOST_PROOFS = 2000
"""Number of proofs of a scan above which fewer postures and one strike are looked at; a proof takes
5 to 30 ms.
"""

UNCHANGED = 1e-9
"""Share of a number by which rounding may change it."""

NOT_LIMITED = {
    "strike-angle": "limits are found over strike angles; give their range with --strikes",
    "contact": (
        "contacts have names, which have no order; compute each landing, or compare them with "
        "shockpc sweep"
    ),
}
"""What a sweep varies without being limited, and why."""

Stop = Literal["bound", "range", "loop"]


class Interval(NamedTuple):
    """Values of the joint that keep the bound.

    Attributes:
        low: smallest value [rad, m].
        high: largest value [rad, m].
        low_end: what ends it there: the bound, the range of the study, or a loop that cannot be
            closed beyond.
        high_end: the same at the largest value.
    """

    low: float
    high: float
    low_end: Stop
    high_end: Stop


class StrikeLimits(NamedTuple):
    """What keeps the bound at one strike angle, or at all of a range.

    Attributes:
        strikes: smallest and largest strike angle, equal for a single one [rad].
        allowed: values of the joint for which the number keeps the bound for each of these strikes,
            ascending.
        feasible: values of the scan, from the first to the last of each run, for which flat ground
            allows all of these landings.
        best: best number over the feasible values of the scan, of the worst of these strikes [its
            unit]; NaN if there is none.
        best_at: where that is [rad, m].
    """

    strikes: tuple[float, float]
    allowed: tuple[Interval, ...]
    feasible: tuple[tuple[float, float], ...]
    best: float
    best_at: float

    @property
    def pieces(self) -> list[tuple[float, float, str, str, bool]]:
        """The allowed intervals, cut where flat ground begins or ceases to allow the landing,
        ascending [rad, m].

        Returns: minimum and maximum, what ends the piece there ("ground" within an interval),
        whether flat ground allows it.
        """
        pieces = list[tuple[float, float, str, str, bool]]()
        for low, high, low_end, high_end in self.allowed:
            runs = [(max(low, a), min(high, b)) for a, b in self.feasible if a <= high and b >= low]
            edges = [low, *(end for run in runs for end in run), high]
            gaps = [
                (a, b, False)
                for a, b in zip(edges[::2], edges[1::2], strict=True)
                if a < b or not runs
            ]
            ends = {low: low_end} | ({high: high_end} if high > low else {})
            for a, b, feasible in sorted([*gaps, *((a, b, True) for a, b in runs)]):
                pieces.append(
                    (a, b, ends.get(a, "ground"), high_end if b == high else "ground", feasible)
                )
        return pieces

    @property
    def usable(self) -> tuple[tuple[float, float], ...]:
        """Values of the joint that are both allowed and feasible, ascending [rad, m]."""
        return tuple((low, high) for low, high, _, _, feasible in self.pieces if feasible)


@dataclass(frozen=True, eq=False)
class JointLimits:
    """The limits of a joint, or of what else varies, that a bound on a number sets.

    Attributes:
        profile: the landing in the scene's posture.
        target: the number.
        joints: the joints that are moved, all to the same value; or the subject of another
            variation.
        of_joints: whether joints vary, and nothing else.
        unit: of that value, "rad" or "m", or that of the variation.
        bound: of the number, in its unit.
        range: smallest and largest value looked at [rad, m].
        file_limits: those of the robot's file; infinite where it gives none [rad, m].
        present: the value, NaN where there is none, and the strike angle of the scene [rad, m;
            rad].
        strikes: smallest and largest strike angle looked at [rad].
        step: largest distance between the values of the scan [rad, m].
        scan: the postures and their numbers.
        limits: at the scene's strike angle, at others one by one, and last at all strike angles of
            the range.
        ends: the limits with all drives at the smallest inertias that what is known allows, and at
            the largest, or why there are none; empty where all are known exactly, or vary.
    """

    profile: ShockProfile = field(repr=False)
    target: Column
    joints: tuple[str, ...]
    of_joints: bool
    unit: str
    bound: Bound
    range: tuple[float, float]
    file_limits: tuple[float, float]
    present: tuple[float, float]
    strikes: tuple[float, float]
    step: float
    scan: Scan = field(repr=False)
    limits: tuple[StrikeLimits, ...]
    ends: Mapping[End, "JointLimits | ShockError"] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.limits.report:limits_report")

    def __repr__(self) -> str:
        bound = f"{self.target.name} {'≥' if self.bound.below else '≤'} {self.bound.value:g}"
        return brief(self, bound, f"varied: {', '.join(self.joints)}")

    @property
    def worst(self) -> tuple[Array, Array]:
        """The worst number (n,) of every posture over the range of strike angles, and the strike
        angle (n,) of it [rad].
        """
        return self.scan.worst(self.strikes)

    def moves(self, other: "JointLimits") -> bool:
        """Whether other limits differ by more than 1 degree, 1 cm, or 1 % of the range."""
        most = {"rad": math.radians(1.0), "m": 0.01}.get(
            self.unit, MOVED * (self.range[1] - self.range[0])
        )
        for one, another in zip(self.limits, other.limits, strict=True):
            here, there = np.array(one.usable).ravel(), np.array(another.usable).ravel()
            if len(here) != len(there) or np.any(np.abs(here - there) > most):
                return True
        return False

    @property
    def subject(self) -> str:
        """The joints, or what else varies."""
        return "+".join(self.joints)

    @property
    def shown_unit(self) -> str:
        """Unit of values in tables."""
        return UNITS.get(self.unit, (1.0, self.unit))[1]

    def shown(self, value: float) -> float:
        """A value in the unit of tables."""
        return round(UNITS.get(self.unit, (1.0, self.unit))[0] * value, 9) + 0.0

    @property
    def table(self) -> Table:
        """At each strike angle, and over the range, a row for each interval of values that keep the
        bound, without ends if none do.

        An end is that of the bound, of the range, of a loop, or of what the ground allows.
        """
        unit = self.shown_unit
        ends = f"low [{unit}]", f"high [{unit}]", "low end", "high end", "feasible"
        rows = (self._row(one, piece) for one in self.limits for piece in one.pieces or (None,))
        return Table.of_rows(("strike from [deg]", "strike to [deg]", *ends), rows)

    def _row(
        self, one: StrikeLimits, piece: tuple[float, float, str, str, bool] | None
    ) -> tuple[float | str | None, ...]:
        strikes = map(in_degrees, one.strikes)
        if piece is None:
            return (*strikes, *(None,) * 5)
        low, high, low_end, high_end, feasible = piece
        return (
            *strikes,
            self.shown(low),
            self.shown(high),
            low_end,
            high_end,
            "yes" if feasible else "no",
        )

    @functools.cached_property
    def unchanged(self) -> bool:
        """Whether the number does not depend on the value at any of the strike angles, but for
        rounding.
        """
        numbers = self.scan.numbers[~np.isnan(self.scan.numbers).any(axis=1)]
        if len(numbers) < 2 or np.isinf(numbers).any():
            return False
        return bool((np.ptp(numbers, axis=0) <= UNCHANGED * np.abs(numbers).max(axis=0)).all())


def _typed(robot: Robot, given: dict[str, Any]) -> dict[str, Any]:
    """The values of a joint that turns in radians, which are typed in degrees."""
    kind, pattern = kind_of(robot, given["joint"])
    turns = kind.unit == "deg"
    if kind == JOINT_POSITION:
        turns = robot.joint(robot.match_joints(pattern)[0]).kind != "prismatic"
    return given | {
        name: np.radians(given[name]).tolist()
        for name in ("joint_range", "step")
        if turns and name in given
    }


@study(
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --at trunk_imu --max 0.1",
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --quantity friction_needed@lf_foot "
    "--max 0.6",
    typed=_typed,
    reads="scene",
    passed=("target",),
)
def limits(
    scene: Scene | str,
    joint: Annotated[
        str,
        Option(
            "The joint; all joints that match a glob have the same value. With --range also "
            "another name that sweep varies.",
            "Question",
            "JOINT",
        ),
    ],
    target: str | Point,
    max: Annotated[
        float | None,
        Option(
            "The largest value allowed, of the number or of its magnitude, in its unit.",
            "Question",
            "VALUE",
            above=0.0,
        ),
    ] = None,
    *,
    min: Annotated[
        float | None,
        Option(
            "The smallest value allowed, of a number that is worse when smaller: a margin.",
            "Question",
            "VALUE",
            above=0.0,
        ),
    ] = None,
    joint_range: Annotated[
        tuple[float, float] | None,
        Option(
            "Values to look at.",
            "Question",
            "LOW:HIGH",
            "range",
            VALUE,
            default="the joint's limits, at most a turn",
        ),
    ] = None,
    strikes: Annotated[
        tuple[float, float] | None,
        Option(
            "Range of strike angles.",
            "Question",
            "LOW:HIGH",
            unit="deg",
            default="-30:75; the scene's for quantities that are always exact",
        ),
    ] = None,
    step: Annotated[
        float | None,
        Option(
            "Largest step of the scan.",
            "Question",
            "STEP",
            unit=VALUE,
            default=(
                "0.1 deg or 0.0001 m, 20 times that for quantities that are always exact; a 200th "
                "of the range for other subjects"
            ),
        ),
    ] = None,
    robot: Robot | None = None,
) -> JointLimits:
    """Find the values of a joint that keep a number at or below a bound, or at or above one.

    The strike angle turns the part of the velocity that is in the plane; after a fall from a drop
    height its vertical component stays. The part out of the plane, and what else moves before the
    impact, stays as it is.

    Args:
        scene: the landing; the joint's value is not used, except that loops are followed from it.
        target: KEY@PLACE, or KEY of the robot as a whole; a point means the shock there, with
            friction if the scene has it.
        robot: the scene's robot, if it is loaded already.

    Raises:
        UnknownName: there is no such joint, quantity or place.
        StudyError: the question makes no sense.
        SolveError: no posture of the range has a result.
        ShockError: the landing cannot be computed.
    """
    bound = _bound(max, min)
    scene = scene_of(scene)
    robot = robot or robot_of(scene)
    varied, joints, (low, high) = _varied(robot, joint, joint_range)
    scene = varied.kind.prepared(scene)
    (profile,) = profiles({"": (scene, robot)}).values()
    landing, angle = profile.landing, profile.landing.strike_angle
    number = column(profile, target_text(target, [scene]))
    _refuse_senseless(landing, number, bound, joints)
    unit = joints[0].unit if joints else varied.unit.replace("deg", "rad")
    finest = STEP[unit] if joints else (high - low) / 200.0
    coarse = _is_dear(landing, number, joints, (low, high, finest), strikes)
    angles = _strike_range(landing.plane, (angle, angle) if coarse and strikes is None else strikes)
    step = finest * (20 if coarse and joints else 1) if step is None else step
    values = _values(low, high, step, unit)
    scale = math.degrees(1.0) if unit == "rad" else 1.0
    targets = _targets(angle, *angles)
    scan = scanned(landing, joint, number, bound, values, scale, targets)
    if scan.unreachable and np.isnan(scan.at_scene_strike).all():
        raise SolveError(
            f"no posture from {_value(low, unit)} to {_value(high, unit)} has a result: "
            f"{scan.unreachable[0][2]}"
        )
    ends: tuple[Stop, Stop] = (
        "range" if scan.values[0] <= low else "loop",
        "range" if scan.values[-1] >= high else "loop",
    )
    modelled = JointLimits(
        profile=profile,
        target=number,
        joints=tuple(each.name for each in joints) or (joint,),
        of_joints=bool(joints),
        unit=unit,
        bound=bound,
        range=(low, high),
        file_limits=_file_limits(joints),
        present=(varied.present(landing) / scale, angle),
        strikes=angles,
        step=step,
        scan=scan,
        limits=tuple(_limits(scan, ends, targets)),
    )

    def at_end(scenes: dict[str, Scene]) -> JointLimits:
        return limits(
            scenes[""],
            joint,
            target,
            max,
            min=min,
            joint_range=(low, high),
            strikes=angles,
            step=step,
            robot=robot,
        )

    if isinstance(varied.kind, OfDrive):
        return modelled
    return replace(modelled, ends=at_drive_ends(modelled, {"": (scene, robot)}, at_end))


def _bound(most: float | None, least: float | None) -> Bound:
    """The one bound that is given."""
    if most is not None and least is None:
        return Bound(most, below=False)
    if least is not None and most is None:
        return Bound(least, below=True)
    raise StudyError(
        "one bound is needed: max for the largest value that is allowed, or min for the smallest"
    )


def _refuse_senseless(
    landing: PosedLanding, number: Column, bound: Bound, joints: tuple[Joint, ...]
) -> None:
    """Refuse a bound on the better side, a loop whose joints move, and a velocity that no strike
    angle turns.
    """
    worse = number.selection.quantity.worse
    if worse == ("greater" if bound.below else "less"):
        raise StudyError(
            f"the {worse} value of {number.name} is the worse one; bound it by "
            f"{'max' if bound.below else 'min'}"
        )
    if joints and landing.loops and landing.before.joint_rates.any():
        raise StudyError(
            "how fast joints of a loop move depends on the posture; leave the joint velocities out"
        )
    in_plane = landing.before.velocity @ np.stack([landing.plane.forward, [0.0, 0.0, 1.0]], axis=1)
    if not landing.plane.level and not np.linalg.norm(in_plane) > 0.0:
        raise StudyError(
            "the robot's velocity lies across the plane, so a strike angle does not change it; "
            "give another plane or velocity"
        )


def _is_dear(
    landing: PosedLanding,
    number: Column,
    joints: tuple[Joint, ...],
    values: tuple[float, float, float],
    strikes: tuple[float, float] | None,
) -> bool:
    """Whether a scan at the smallest step would need too many proofs, or landings of their own.

    Args:
        landing: that varies.
        number: the number.
        joints: those that vary.
        values: the smallest, the largest, and the smallest step.
        strikes: the range of strike angles, if it is given.
    """
    if number.selection.quantity.per_landing(landing.scene):
        return True
    low, high, finest = values
    angles = 1 if strikes is not None and strikes[0] == strikes[1] else ANGLES
    rows = (high - low) / finest * angles
    return (
        rows * _share_to_prove(landing, number, joints, np.linspace(low, high, PROBES))
        > MOST_PROOFS
    )


def _values(low: float, high: float, step: float, unit: str) -> Array:
    """The values (n,) of a scan, ascending, at most a step apart."""
    if not step > 0.0 or (high - low) / step > MOST_POSTURES:
        raise StudyError(
            f"a step of {_value(step, unit)} from {_value(low, unit)} to {_value(high, unit)} is "
            f"not possible; "
            f"give one above zero that makes at most {MOST_POSTURES} postures"
        )
    steps = math.ceil((high - low) / step - 1e-9)
    return np.linspace(low, high, int(np.maximum(LEAST, steps + 1)))


def _share_to_prove(
    landing: PosedLanding, target: Column, joints: tuple[Joint, ...], values: Array
) -> float:
    """The share of postures that need a proof, which takes a thousand times as long as double
    precision.

    Args:
        landing: the scene's; the only posture that is looked at if it has loops, or no joint
            varies.
        target: the number.
        joints: those that vary.
        values: (m,) of each of them.
    """
    Q = landing.q[None]
    if joints and not landing.loops:
        Q = np.repeat(Q, len(values), axis=0)
        set_many(landing.robot, [(joint, values) for joint in joints], Q)
    needed = columns(
        landing,
        Q,
        np.tile(landing.before.velocity, (len(Q), 1, 1)),
        (target,),
        trusted=ILL_CONDITIONED,
    )[2]
    return float(needed.mean())


def _varied(
    robot: Robot, subject: str, given: tuple[float, float] | None
) -> tuple[Variation, tuple[Joint, ...], tuple[float, float]]:
    """What varies, its joints, and the range that is looked at [rad, m; the unit of another
    variation].
    """
    kind, pattern = kind_of(robot, subject)
    if kind.word in NOT_LIMITED:
        raise StudyError(f"{subject} has no limits here: {NOT_LIMITED[kind.word]}")
    joints = settable_joints(robot, pattern, StudyError) if kind == JOINT_POSITION else ()
    low, high = (
        given if given is not None else motion_range(joints) if joints else (math.nan, math.nan)
    )
    unit = joints[0].unit if joints else ""
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        what = "without limits in the file" if joints else "not given"
        if given is not None or math.isfinite(low + high):
            what = f"from {_value(low, unit)} to {_value(high, unit)}"
        subject_text = f'joint "{subject}"' if joints else subject
        raise StudyError(
            f"the range of {subject_text} is {what}; give its minimum and maximum with --range "
            f"LOW:HIGH"
        )
    scale = math.degrees(1.0) if unit == "rad" or kind.unit == "deg" else 1.0
    return variation(robot, subject, (scale * low, scale * high)), joints, (low, high)


def _file_limits(joints: Sequence[Joint]) -> tuple[float, float]:
    return max((one.limits[0] for one in joints), default=-math.inf), min(
        (one.limits[1] for one in joints), default=math.inf
    )


def _targets(angle: float, low: float, high: float) -> tuple[tuple[float, float], ...]:
    """The strikes for which limits are found: the scene's, others one by one, and last all of the
    range [rad].
    """
    step = math.radians(STRIKE_ANGLE_STEP)
    inside = [step * k for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
    # Angles that differ by the rounding of degrees are one.
    single = {round(each, 9): each for each in (*inside, low, high, angle)}
    others = sorted(each for each in single.values() if each != angle)
    return tuple(dict.fromkeys([(angle, angle), *((each, each) for each in others), (low, high)]))


def _limits(
    scan: Scan, ends: tuple[Stop, Stop], targets: Sequence[Strikes]
) -> Iterator[StrikeLimits]:
    """The intervals that keep the bound, for each of some ranges of strikes.

    Args: ends, what ends the scan.
    """
    x = scan.values
    for strikes, roots in zip(targets, scan.crossings(targets), strict=True):
        number, _ = scan.worst(strikes)
        beyond = scan.bound.violation(number)
        edges: list[tuple[float, Stop]] = [(float(root), "bound") for root in roots]
        if beyond[0] <= 0.0:
            edges.insert(0, (float(x[0]), ends[0]))
        if beyond[-1] <= 0.0:
            edges.append((float(x[-1]), ends[1]))
        pairs = zip(edges[::2], edges[1::2], strict=True)
        allowed = tuple(
            Interval(low, high, low_end, high_end) for (low, low_end), (high, high_end) in pairs
        )
        feasible = scan.feasible_runs(strikes)
        k = int(np.argmin(np.where(within(x, feasible), beyond, np.inf)))
        best, best_at = (
            (float(number[k]), float(x[k]))
            if feasible and np.isfinite(number[k])
            else (math.nan, math.nan)
        )
        yield StrikeLimits(strikes, allowed, feasible, best, best_at)


def _strike_range(plane: Plane, given: tuple[float, float] | None) -> tuple[float, float]:
    """The range of strike angles [rad], all of which approach the ground."""
    if plane.level:
        raise StudyError("no strike angle is defined in a horizontal plane; choose another plane")
    low, high = (math.radians(STRIKES[0]), math.radians(STRIKES[1])) if given is None else given
    most = math.radians(STEEPEST) * (1.0 + 1e-12)
    if not -most <= low <= high <= most:
        raise StudyError(
            f"strike angles from {_value(low, 'rad')} to {_value(high, 'rad')} are not a range of "
            f"landings; "
            f"give the lesser one first, both between -{STEEPEST:g} and {STEEPEST:g} deg"
        )
    return low, high


def _value(value: float, unit: str) -> str:
    degrees = round(math.degrees(value), 12) + 0.0
    text = {"rad": f"{round(degrees, 2) or degrees:g}°", "m": f"{1e3 * value:.4g} mm"}.get(
        unit, f"{value:g} {unit}".rstrip(" -")
    )
    return text.replace("-", "−")
