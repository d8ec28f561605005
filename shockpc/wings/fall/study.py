"""Falls of a robot: it tips over an edge of its support or is dropped.

Each strike is a separate landing.

Between strikes the robot is one rigid body, its joints held, in the plane of the fall. A strike is
solved as any other landing, with the drives of the joints. Of the points that meet the ground
together, the landing has those that press.
"""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal, NamedTuple

import numpy as np

from shockpc.evaluation.column import selected
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.named_scenes import common_robot, named_scenes
from shockpc.evaluation.profiles import proven
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.scene_grid import scene_grid
from shockpc.evaluation.variations.vary import Vary, pairs
from shockpc.landing.bandwidths import low_passes_of
from shockpc.landing.ratings import TorqueStrength, torque_limits
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.scene_fields import CONTACT, STRIKE, Option
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import drawn_outline, outline
from shockpc.robot.tolerances import LIMIT_SLACK
from shockpc.text.diagnostic import Diagnostic, warn
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import DefectError, ShockError, StudyError, attempt, traces
from shockpc.text.printed import count, listed
from shockpc.text.trace import Trace
from shockpc.wings.fall.body import Rigid
from shockpc.wings.fall.strikes import FallStrike, Tip, drops, strikes_of, tip_over

HEADINGS = {"front": 0.0, "left": 90.0, "back": 180.0, "right": -90.0}
"""Directions of a fall from forward to the left [deg]."""

LEAST = 0.1
"""Default of the smallest speed of strikes that are listed [m/s]."""

STANDARD = ("delta_v_max", "delta_v", "joint_impulse")
WITH_FRICTION = ("delta_v_friction", "joint_impulse_friction")
"""Quantities of every strike: of contacts that stick, or with friction."""

NO_TRUNK = (math.nan, math.nan, math.nan)
"""Motions of the heaviest body of a strike that could not be computed [m/s]."""

EFFORTS = "joint_torque_share"
"""Quantity of every strike by which joints are judged."""


class StrikeResult(NamedTuple):
    """A strike and its results.

    Attributes:
        strike: the strike.
        values: the worst value of each quantity, by its text; NaN where there is none.
        places: where it is the worst, by text.
        trunk: |Δv| of the heaviest body's centre of mass, with friction where it is given: free
            joints, with drives, locked; NaN without a verdict [m/s].
        stop: joint that reaches its limit first after the strike if its rate stays, and when [s];
            None if none moves towards it.
        profile: of the landing.
    """

    strike: FallStrike
    values: Mapping[str, float]
    places: Mapping[str, str]
    trunk: tuple[float, ...]
    stop: tuple[str, float] | None
    profile: ShockProfile


class Margin(NamedTuple):
    """Margin of a part, or a joint, to what it withstands in its worst strike.

    Attributes:
        name: of the part, or of the joint that no part rates.
        kind: "part" or "joint".
        margin: of a part as `part_margin`, of a joint its torque or effort limit over the torque
            [1].
        torque: along the joint's axis; None of a part at a point [N m, N].
        withstands: the torque given, or the effort limit of the robot's file; None of a part at a
            point [N m, N].
        strike: name of the strike.
    """

    name: str
    kind: Literal["part", "joint"]
    margin: float
    torque: float | None
    withstands: float | None
    strike: str


@dataclass(frozen=True, eq=False)
class Falls:
    """The falls of a robot.

    Attributes:
        robot: the robot.
        rank: quantity by which strikes are ranked.
        quantities: of every strike.
        tips: one for each posture and heading.
        strikes: all, in the order in which they happen.
        results: of those that could be computed, the worst first.
        table: all strikes in the order in which they happen, with their quantities and messages.
        failures: names of falls and strikes without a result, and why.
        drop: height of the drop [m]; None if it tips.
        notes: what geometry is used, and what is left out.
        margins: of all parts and joints that can be judged, the smallest first.
    """

    robot: Robot
    rank: str
    quantities: tuple[str, ...]
    tips: tuple[Tip, ...]
    strikes: tuple[FallStrike, ...]
    results: tuple[StrikeResult, ...]
    table: Table
    failures: tuple[tuple[str, ShockError], ...]
    drop: float | None
    notes: tuple[str, ...]
    margins: tuple[Margin, ...]

    _repr_html_ = shown_by("wings.fall.report:fall_report")

    def __repr__(self) -> str:
        return brief(self, self.robot.name, count(len(self.results), "strike"))

    @property
    def landings(self) -> tuple[StrikeResult, ...]:
        """The landings that could be computed."""
        return self.results


class Tipping(NamedTuple):
    """Options of how robots tip over.

    Attributes:
        headings: names, or angles [deg].
        push: speed that a level push gives to the centre of mass [m/s]; None at rest.
        together: height within which parts strike together [m].
        least: smallest speed of strikes that are listed [m/s].
    """

    headings: tuple[str, ...]
    push: float | None
    together: float
    least: float


class FallMotion(NamedTuple):
    """The falls of all postures and their strikes.

    Attributes:
        tips: one for each posture and heading.
        strikes: all, in the order in which they happen.
        failures: why falls have no strikes, by name.
        notes: what geometry is used.
    """

    tips: list[Tip]
    strikes: list[FallStrike]
    failures: dict[str, ShockError]
    notes: list[str]


@study(
    "shockpc fall g1",
    "shockpc fall talos --heading front --friction 0.5 --out fall/",
    "shockpc fall go2 --drop 0.75 --part 'imu=half-sine 1500 g 0.5 ms'",
    more=(
        "The robot tips as one rigid body with held joints over an edge of its support, strike "
        "after strike, until it rests. The"
        " edge sticks, slides or leaves the ground. Each strike is a landing with the drives of "
        "the joints. With a pulse or"
        " a contact stiffness all joints are judged by their torque or effort limits; with a "
        "bandwidth every strike has the"
        " readings of its accelerometers."
    ),
    without=(CONTACT, STRIKE),  # which a fall computes
    uses=("part", "pulse", "imu-bandwidth", "range-g"),
    reads="postures",
    passed=("trace",),
    fails=True,
)
def fall(
    postures: Scene | str | Mapping[str, Scene | str],
    robot: Robot | None = None,
    *,
    headings: Annotated[
        Sequence[str] | None,
        Option(
            "Front, left, back, right, or an angle from forward to the left [deg].",
            "Fall",
            "HEADING",
            "heading",
            default="all four",
        ),
    ] = None,
    push: Annotated[
        float | None,
        Option(
            "Speed that a level push gives to the centre of mass.",
            "Fall",
            "V",
            unit="m/s",
            above=0.0,
            greatest=30.0,
            default="it falls from its balance at rest",
        ),
    ] = None,
    drop: Annotated[
        float | None,
        Option(
            "Drop it from this height instead, onto faces, edges and corners of the box around it, "
            "the centre of mass above them "
            "(26 drops, as in MIL-STD-810H, method 516.8, procedure IV).",
            "Fall",
            "H",
            unit="m",
            above=0.0,
        ),
    ] = None,
    attitudes: Annotated[
        int | None,
        Option(
            "Drop it in this number of attitudes, spread over all orientations.",
            "Fall",
            "N",
            least=1.0,
            greatest=1e4,
        ),
    ] = None,
    within_height: Annotated[
        float,
        Option("Height within which parts strike together.", "Fall", "H", unit="m", above=0.0),
    ] = 1e-3,
    least: Annotated[
        float | None,
        Option(
            "List strikes of at least this speed.",
            "Fall",
            "V",
            unit="m/s",
            above=0.0,
            default="0.1",
        ),
    ] = None,
    vary: Annotated[
        Vary,
        Option(
            "Postures: values a:b:n or a,b,c of a joint or a glob [deg; m if prismatic], or of "
            "another quantity of the landing.",
            "Fall",
            "NAME=VALUES",
            holds="varied",
        ),
    ] = (),
    quantities: QuantityOption = (),
    rank: Annotated[
        str | None,
        Option(
            "Quantity by which strikes are ranked, the worst first.",
            "What is computed",
            "KEY[@PLACE]",
            holds="quantity",
            default=(
                "delta_v_max; body.delta_v_friction with a friction, part_margin with a part that "
                "can be judged"
            ),
        ),
    ] = None,
    trace: Trace | None = None,
) -> Falls:
    """Let a robot tip over, or drop it, and compute each strike as a landing.

    Args:
        postures: a scene, or scenes of one robot by the names of their postures. What strikes in
            them is not used.
        robot: the scenes' robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        UnknownName: there is no such quantity, or nothing of what varies.
        StudyError: the robot cannot fall, or options contradict one another.
        ShockError: a posture is not possible, or no strike can be computed.
    """
    trace = trace or Trace()
    scenes = named_scenes(postures)
    robot = robot or common_robot(scenes)
    _refuse_contradictions(drop, attitudes, push, headings, least)
    headings = tuple(HEADINGS) if headings is None else tuple(headings)
    least = LEAST if least is None else least
    if not headings:
        raise StudyError("no heading is given; name one, such as front")
    # A posture becomes one scene for each point of the grid of what varies.
    postures_of_grid: dict[str, Scene] = {}
    for posture, scene in scenes.items():
        postures_of_grid |= scene_grid(posture, scene, robot, pairs(vary))
    scenes = postures_of_grid

    # Quantities are read before the robot falls, so that an unknown one is refused early.
    judged = _judged(scenes.values(), robot)
    texts, rank = _quantities(scenes.values(), judged, rank, quantities)
    selections = [select(text.partition("@")[0]) for text in texts]

    # Both ways give strikes, which are landings like any other from here on.
    if drop is None:
        tipping = Tipping(headings, push, within_height, least)
        motion = _tipped(scenes, robot, tipping, trace)
    else:
        motion = _dropped(scenes, robot, drop, attitudes, within_height, trace)
    if not motion.strikes:
        raise _no_strike(motion.failures, least)

    # A strike without a solution is a row with its reason; without any solution it is an error.
    results_by_name, refused = _results(motion.strikes, robot, selections, texts, trace)
    if not results_by_name:
        raise next(iter(refused.values()))
    worse = selections[0].worse
    results = sorted(
        results_by_name.values(), key=lambda result: -float(worse(result.values[rank]))
    )
    warn(lambda: _warnings(results))
    return Falls(
        robot=robot,
        rank=rank,
        quantities=texts,
        tips=tuple(motion.tips),
        strikes=tuple(motion.strikes),
        results=tuple(results),
        table=_table(motion.strikes, results_by_name, refused, texts),
        failures=tuple((motion.failures | refused).items()),
        drop=drop,
        notes=tuple(dict.fromkeys(motion.notes)),
        margins=_margins(results) if any(judged) else (),
    )


def _refuse_contradictions(
    drop: float | None,
    attitudes: int | None,
    push: float | None,
    headings: Sequence[str] | None,
    least: float | None,
) -> None:
    """Refuse options of tipping for a drop, and attitudes without one."""
    if drop is None:
        if attitudes is not None:
            raise StudyError("attitudes are those of a drop; give its height too, by drop")
        return
    of_tipping = {"push": push, "headings": headings, "least": least}
    ignored = [name for name, value in of_tipping.items() if value is not None]
    if ignored:
        raise StudyError(
            f"{listed(ignored)}: only for a robot that tips over, but a drop is given; leave one "
            "of the two out"
        )


def _quantities(
    scenes: Collection[Scene], judged: tuple[bool, bool], rank: str | None, more: Sequence[str]
) -> tuple[tuple[str, ...], str]:
    """The quantities of every strike, first that by which strikes are ranked; and this one.

    Args:
        scenes: of all postures.
        judged: as `_judged` gives it.
        rank: quantity by which strikes are ranked; by default the margin of parts if they are
            judged, else the largest jump, with friction if a scene has it.
        more: further quantities.
    """
    parts, efforts = judged
    slides = any(scene.friction is not None for scene in scenes)
    if not rank:
        rank = "body.delta_v_friction" if slides else "delta_v_max"
        if parts:
            rank = "part_margin"
    texts = [rank, *(WITH_FRICTION if slides else STANDARD)]
    if efforts:
        texts.append(EFFORTS)
    if any(low_passes_of(scene) for scene in scenes):
        texts.append("filtered_peak_friction" if slides else "filtered_peak")
    return tuple(dict.fromkeys([*texts, *more])), rank


def _tipped(
    scenes: Mapping[str, Scene], robot: Robot, tipping: Tipping, trace: Trace
) -> FallMotion:
    """The falls of all postures that tip over."""
    motion = FallMotion([], [], {}, [])
    for posture, scene in scenes.items():
        rigid = _rigid(scene, robot, motion, trace)
        for heading in tipping.headings:
            heading_name, angle = _heading(heading)
            name = f"{posture} {heading_name}".strip()
            try:
                with trace.stage("falls"):
                    tip = tip_over(
                        rigid, name, angle, tipping.push, tipping.together, tipping.least
                    )
                    motion.strikes.extend(strikes_of(rigid, tip, tipping.together, tipping.least))
                motion.tips.append(tip)
            except StudyError as refusal:
                motion.failures[name] = refusal
    return motion


def _dropped(
    scenes: Mapping[str, Scene],
    robot: Robot,
    height: float,
    attitudes: int | None,
    together: float,
    trace: Trace,
) -> FallMotion:
    """The drops of all postures. Args: together, height within which parts strike together [m]."""
    motion = FallMotion([], [], {}, [])
    for posture, scene in scenes.items():
        rigid = _rigid(scene, robot, motion, trace)
        motion.strikes.extend(drops(rigid, posture, height, attitudes, together))
    return motion


def _rigid(scene: Scene, robot: Robot, motion: FallMotion, trace: Trace) -> Rigid:
    """The robot in a posture with held joints; notes on it are added to those of a motion."""
    _refuse_options(scene)
    with trace.stage("posture and geometry"):
        rigid = Rigid.of(scene, robot)
    motion.notes.extend(_notes(rigid))
    return rigid


def _no_strike(failures: Mapping[str, ShockError], least: float) -> StudyError:
    """The error where nothing strikes."""
    if failures:
        return StudyError("; ".join(f"{name}: {text}" for name, text in failures.items()))
    return StudyError(
        f"nothing strikes at {least:g} m/s or more: the robot rolls or comes to rest; a "
        "smaller --least lists slower strikes"
    )


def _warnings(results: Iterable[StrikeResult]) -> Iterator[Diagnostic]:
    """The warnings of all landings; none of a height, which a fall computes."""
    for result in results:
        for warning in result.profile.health.warnings:
            if warning.kind != "height":
                yield warning


def _judged(scenes: Iterable[Scene], robot: Robot) -> tuple[bool, bool]:
    """Two flags: parts of a scene can be judged, and joints by their torques.

    Torques need a pulse, a stiffness or a part that says how long they last.
    """
    parts = efforts = False
    for scene in scenes:
        limits, durations = torque_limits(robot, scene.part)
        lasts = scene.pulse is not None or scene.yields
        of_joints = bool(np.any(np.isfinite(limits) & (lasts | np.isfinite(durations))))
        efforts |= of_joints
        parts |= any(part.at or of_joints for part in scene.part)
    return parts, efforts


def _margins(results: Sequence[StrikeResult]) -> tuple[Margin, ...]:
    """The smallest margin over the strikes of every part, and of every joint that no part rates."""
    margins: list[Margin] = []
    for result in results:
        margins += _part_margins(result)
        margins += _joint_margins(result)
    worst: dict[tuple[str, str], Margin] = {}
    for margin in sorted(margins, key=lambda margin: margin.margin):
        worst.setdefault((margin.kind, margin.name), margin)
    return tuple(worst.values())


def _part_margins(result: StrikeResult) -> Iterator[Margin]:
    """The margins of parts in a strike."""
    for part in result.profile.parts:
        if part.part_margin is None:
            continue
        withstands = None
        if isinstance(part.strength, TorqueStrength):
            withstands = part.strength.momentary_torque
        yield Margin(
            part.part, "part", part.part_margin, part.torque, withstands, result.strike.name
        )


def _joint_margins(result: StrikeResult) -> Iterator[Margin]:
    """The margins of joints that no part rates in a strike."""
    profile = result.profile
    rated = {part.joint for part in profile.landing.parts}
    joints = [place for place in profile.places("joint") if place.number not in rated]
    if not joints:
        return
    limits = torque_limits(profile.robot, profile.scene.part)[0]
    shares = profile.numbers(select(EFFORTS), joints).tolist()
    for joint, share in zip(joints, shares, strict=True):
        if math.isnan(share):
            continue
        limit = float(limits[joint.number])
        margin = 1.0 / share if share else math.inf
        yield Margin(joint.name, "joint", margin, share * limit, limit, result.strike.name)


def _refuse_options(scene: Scene) -> None:
    """Refuse settings of a scene that would have no effect.

    These are a motion before the impact, restitution, and how contacts are held.
    """
    ignored = [key for key, value in vars(scene.strike).items() if value not in (None, {})]
    default = Contact(frame="")
    for contact in scene.contact:
        for key in ("restitution", "directions", "normal"):
            if getattr(contact, key) != getattr(default, key):
                ignored.append(key)
    if ignored:
        raise StudyError(
            f"the scene gives {listed(ignored)}: a fall computes how the robot strikes, and its "
            f"contacts are points on level ground "
            "without restitution; leave that out, or use shockpc analyze"
        )


def _notes(rigid: Rigid) -> Iterator[str]:
    """Notes on what geometry of a robot is used, and what has none."""
    robot = rigid.landing.robot
    links = {shape.link for shape in rigid.shapes}
    if rigid.visual:
        which = "all links"
        if len(rigid.visual) < len(links):
            which = f"{listed(rigid.visual, 6)}; delta_v_max leaves it out"
        yield f"visual geometry strikes where the file has no collision geometry: {which}"
    yield from outline(robot, "collision").warnings
    if rigid.visual:
        yield from drawn_outline(robot).warnings
    with_geometry = {robot.frames[link].body for link in links}
    bare = [body for k, body in enumerate(robot.bodies) if k not in with_geometry]
    if bare:
        share = 100.0 * sum(body.mass for body in bare) / robot.mass
        yield (
            f"{len(bare)} of {len(robot.bodies)} bodies ({share:.3g} % of the mass) have no "
            "geometry, so they never strike"
        )


def _heading(heading: str | float) -> tuple[str, float]:
    """Name of a heading and its angle [rad]."""
    if isinstance(heading, str) and heading in HEADINGS:
        return heading, math.radians(HEADINGS[heading])
    try:
        angle = float(heading)
    except ValueError:
        angle = math.nan
    if not abs(angle) <= 360.0:
        valid = f"{', '.join(HEADINGS)}, and an angle from forward to the left within 360 deg"
        raise StudyError(f'"{heading}" is no heading; valid are {valid}')
    return f"{angle:g} deg", math.radians(angle)


def _results(
    strikes: Sequence[FallStrike],
    robot: Robot,
    selections: Sequence[Selection],
    texts: Sequence[str],
    trace: Trace,
) -> tuple[dict[str, StrikeResult], dict[str, ShockError]]:
    """The landings of strikes by their names, and why others have none."""
    cases = {strike.name: (strike.scene, robot) for strike in strikes}
    if len(cases) < len(strikes):
        raise StudyError("two falls have one name; give each posture and heading once")
    free = proven(_with_joints(cases, "free"), selections, trace)
    driven = proven(cases, selections, trace)
    locked = proven(_with_joints(cases, "locked"), selections, trace)

    # The landing itself is the one with drives; of the others only defects are told.
    refused: dict[str, ShockError] = {}
    for name, error in free.items():
        if isinstance(error, DefectError):
            refused[name] = error
    for name, error in driven.items():
        if isinstance(error, ShockError):
            refused[name] = error
    for name, error in locked.items():
        if isinstance(error, DefectError):
            refused[name] = error
    results: dict[str, StrikeResult] = {}
    for strike in strikes:
        name = strike.name
        profile = driven[name]
        if isinstance(profile, ShockError):
            continue
        landings = [free[name], profile, locked[name]]
        result = attempt(_result, strike, profile, texts, landings)
        if isinstance(result, ShockError):
            refused[name] = result
        else:
            results[name] = result
    return results, refused


def _with_joints(
    cases: Mapping[str, tuple[Scene, Robot]], model: Literal["free", "locked"]
) -> dict[str, tuple[Scene, Robot]]:
    """Landings with another joint model."""
    joints = Joints(model=model)
    return {name: (replace(scene, joints=joints), robot) for name, (scene, robot) in cases.items()}


def _table(
    strikes: Sequence[FallStrike],
    results: Mapping[str, StrikeResult],
    refused: Mapping[str, ShockError],
    texts: Sequence[str],
) -> Table:
    """All strikes, with columns that tell them apart and the worst value of each quantity."""
    columns: dict[str, np.ndarray] = {}
    for key in ("fall", "number", "motion", "rate", "speed", "energy"):
        columns[key] = np.array([getattr(strike, key) for strike in strikes])
    columns["struck"] = np.array(["+".join(strike.struck) for strike in strikes])
    columns["rotation"] = np.degrees([strike.rotation for strike in strikes]).round(9)
    units = {"rotation": "deg", "rate": "rad/s", "speed": "m/s", "energy": "J"}

    # A strike that was refused keeps its row, so that the table has all strikes in their order.
    of_strikes = [results.get(strike.name) for strike in strikes]
    for text in texts:
        values = [math.nan if result is None else result.values[text] for result in of_strikes]
        places = ["" if result is None else result.places[text] for result in of_strikes]
        columns[text] = np.array(values)
        columns[f"{text} at"] = np.array(places)
        units[f"{text} at"] = ""
    # What the joints do changes the trunk's motion most, so that each joint model has a column.
    trunk = np.array([NO_TRUNK if result is None else result.trunk for result in of_strikes])
    for k, model in enumerate(("free", "with drives", "locked")):
        columns[f"trunk {model}"] = trunk[:, k]
        units[f"trunk {model}"] = "m/s"
    columns["proven"] = np.array([result is not None for result in of_strikes])
    messages: dict[int, str] = {}
    for i, strike in enumerate(strikes):
        if strike.name in refused and strike.name not in results:
            messages[i] = str(refused[strike.name])
    return Table((), columns, messages, defects=tuple(traces(refused.values())), label_units=units)


def _trunk(profile: ShockProfile | ShockError) -> float:
    """|Δv| of the heaviest body's centre of mass [m/s]; NaN without a verdict.

    It is with friction where this is given.
    """
    if isinstance(profile, ShockError):
        return math.nan
    key = "shock_com" if profile.scene.friction is None else "shock_com_friction"
    heaviest = int(np.argmax(profile.robot.masses))
    return float(profile.value(key, "body")[heaviest]) * profile.v_in


def _result(
    strike: FallStrike,
    profile: ShockProfile,
    texts: Sequence[str],
    landings: Sequence[ShockProfile | ShockError],
) -> StrikeResult:
    """The result of a strike.

    Args: landings, the same with joints free, with drives and locked.
    """
    values: dict[str, float] = {}
    places: dict[str, str] = {}
    for text in texts:
        values[text], places[text] = _worst(profile, text)
    return StrikeResult(
        strike=strike,
        values=values,
        places=places,
        trunk=tuple(map(_trunk, landings)),
        stop=_first_stop(profile),
        profile=profile,
    )


def _worst(profile: ShockProfile, text: str) -> tuple[float, str]:
    """The worst value of a quantity, and where; NaN and no place where it has no value."""
    key, at, place = text.partition("@")
    if profile.scene.friction is None:
        key = key.removesuffix("_friction")  # as its remark says
    if select(key).quantity.scope.lacks(profile.landing):
        return math.nan, ""
    selection, where = selected(profile.landing, key + at + place)
    if not len(where):
        return math.nan, ""
    numbers = profile.numbers(selection, where)
    if not np.isfinite(numbers).any():
        return math.nan, ""
    k = int(np.argmax(selection.worse(numbers)))
    return float(numbers[k]), where[k].name


def _first_stop(profile: ShockProfile) -> tuple[str, float] | None:
    """The joint that first reaches a limit after a strike, and when [s].

    Only joints within their limits count.
    """
    key = "delta_qd" if profile.scene.friction is None else "delta_qd_friction"
    rates = profile.value(key, "joint").tolist()
    first: tuple[str, float] | None = None
    for place, rate in zip(profile.places("joint"), rates, strict=True):
        joint = profile.robot.joint(place.name)
        if joint.kind not in ("revolute", "prismatic") or abs(rate) <= 1e-9:
            continue
        left = joint.limits[rate > 0.0] - joint.value(profile.q)
        if not (math.isfinite(left) and left * rate > 0.0 and abs(left) > LIMIT_SLACK):
            continue
        if first is None or left / rate < first[1]:
            first = joint.name, left / rate
    return first
