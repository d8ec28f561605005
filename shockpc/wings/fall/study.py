"""Falls of a robot: it tips over an edge of its support or is dropped, and each strike is a
separate landing.

Between strikes the robot is one rigid body, its joints held, in the plane of the fall. What then
strikes is solved as any other landing, with the joints with drives. Of the points that meet the
ground together those are in the landing that press.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal, NamedTuple

import numpy as np

from shockpc.evaluation.column import selected
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.named_scenes import common_robot, named_scenes
from shockpc.evaluation.profiles import proven
from shockpc.evaluation.scene_grid import scene_grid
from shockpc.evaluation.table import Table
from shockpc.evaluation.vary import Vary, pairs
from shockpc.landing.bandwidths import low_passes_of
from shockpc.landing.joint_options import Joints
from shockpc.landing.ratings import TorqueStrength, torque_limits
from shockpc.landing.record import CONTACT, STRIKE, Option
from shockpc.landing.scene import Contact, Scene
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import drawn_outline, outline
from shockpc.robot.tolerances import LIMIT_SLACK
from shockpc.text.diagnostic import warn
from shockpc.text.errors import DefectError, ShockError, StudyError, attempt, traces
from shockpc.text.printed import count, listed
from shockpc.text.shown import brief, shown_by
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

EFFORTS = "joint_torque_share"
"""Quantity of every strike by which joints are judged."""


class StrikeResult(NamedTuple):
    """What is known of a strike.

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
    """How far a part, or a joint, is from what it withstands in the strike that is the worst for
    it.

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
    if drop is None and attitudes is not None:
        raise StudyError("attitudes are those of a drop; give its height too, by drop")
    of_tipping = {"push": push, "headings": headings, "least": least}
    if drop is not None and (
        ignored := [name for name, value in of_tipping.items() if value is not None]
    ):
        raise StudyError(
            f"{listed(ignored)}: only for a robot that tips over, but a drop is given; leave one "
            "of the two out"
        )
    headings, least = (
        tuple(HEADINGS) if headings is None else headings,
        LEAST if least is None else least,
    )
    if not headings:
        raise StudyError("no heading is given; name one, such as front")
    scenes = {
        name: one
        for posture, scene in scenes.items()
        for name, one in scene_grid(posture, scene, robot, pairs(vary)).items()
    }
    judged = [_judged(scene, robot) for scene in scenes.values()]
    parts, efforts = (any(of) for of in zip(*judged, strict=True))
    slides = any(scene.friction is not None for scene in scenes.values())
    rank = rank or (
        "part_margin" if parts else "body.delta_v_friction" if slides else "delta_v_max"
    )
    standard = [*(WITH_FRICTION if slides else STANDARD), *[EFFORTS] * efforts]
    if any(low_passes_of(scene) for scene in scenes.values()):
        standard.append("filtered_peak_friction" if slides else "filtered_peak")
    texts = tuple(dict.fromkeys([rank, *standard, *quantities]))
    ranked, *others = [select(text.partition("@")[0]) for text in texts]
    tips, strikes, failures, notes = (
        list[Tip](),
        list[FallStrike](),
        dict[str, ShockError](),
        list[str](),
    )
    for posture, scene in scenes.items():
        _refuse_options(scene)
        with trace.stage("posture and geometry"):
            rigid = Rigid.of(scene, robot)
        notes += _notes(rigid)
        if drop is not None:
            strikes += drops(rigid, posture, drop, attitudes, within_height)
            continue
        for name, angle in map(_heading, headings):
            name = f"{posture} {name}".strip()
            try:
                with trace.stage("falls"):
                    tip = tip_over(rigid, name, angle, push, within_height, least)
                    strikes += strikes_of(rigid, tip, within_height, least)
                tips.append(tip)
            except StudyError as refusal:
                failures[name] = refusal
    if not strikes:
        raise StudyError(
            "; ".join(f"{name}: {text}" for name, text in failures.items())
            or (
                f"nothing strikes at {least:g} m/s or more: the robot rolls or comes to rest; a "
                "smaller --least lists slower strikes"
            )
        )
    found, refused = _results(strikes, robot, [ranked, *others], texts, trace)
    results = sorted(found.values(), key=lambda one: -float(ranked.worse(one.values[rank])))
    if not results:
        raise next(iter(refused.values()))
    failures |= refused
    warn(
        lambda: (
            one
            for result in results
            for one in result.profile.health.warnings
            if one.kind != "height"
        )
    )
    return Falls(
        robot=robot,
        rank=rank,
        quantities=texts,
        tips=tuple(tips),
        strikes=tuple(strikes),
        results=tuple(results),
        table=_table(strikes, found, refused, texts),
        failures=tuple(failures.items()),
        drop=drop,
        notes=tuple(dict.fromkeys(notes)),
        margins=_margins(results) if parts or efforts else (),
    )


def _judged(scene: Scene, robot: Robot) -> tuple[bool, bool]:
    """Whether parts can be judged, and joints by their torques, of which a pulse, a stiffness or a
    part says how long they last.
    """
    limits, durations = torque_limits(robot, scene.part)
    lasts = scene.pulse is not None or scene.yields
    efforts = bool(np.any(np.isfinite(limits) & (lasts | np.isfinite(durations))))
    return any(part.at or efforts for part in scene.part), efforts


def _margins(results: Sequence[StrikeResult]) -> tuple[Margin, ...]:
    """The smallest margin over the strikes of every part, and of every joint that no part rates."""
    found = list[Margin]()
    for strike, profile in ((result.strike.name, result.profile) for result in results):
        for one in profile.parts:
            if one.part_margin is not None:
                withstands = (
                    one.strength.momentary_torque
                    if isinstance(one.strength, TorqueStrength)
                    else None
                )
                found.append(
                    Margin(one.part, "part", one.part_margin, one.torque, withstands, strike)
                )
        rated = {place.joint for place in profile.landing.parts}
        joints = [place for place in profile.places("joint") if place.number not in rated]
        limits = torque_limits(profile.robot, profile.scene.part)[0]
        for place, share in zip(
            joints, profile.numbers(select(EFFORTS), joints).tolist() if joints else (), strict=True
        ):
            if not math.isnan(share):
                limit = float(limits[place.number])
                found.append(
                    Margin(
                        place.name,
                        "joint",
                        1.0 / share if share else math.inf,
                        share * limit,
                        limit,
                        strike,
                    )
                )
    worst = dict[tuple[str, str], Margin]()
    for margin in sorted(found, key=lambda one: one.margin):
        worst.setdefault((margin.kind, margin.name), margin)
    return tuple(worst.values())


def _refuse_options(scene: Scene) -> None:
    """Refuse what of a scene would have no effect: a motion before the impact, restitution, and how
    contacts are held.
    """
    given = [key for key, value in vars(scene.strike).items() if value not in (None, {})]
    like = Contact(frame="")
    for contact in scene.contact:
        given += [
            key
            for key in ("restitution", "directions", "normal")
            if getattr(contact, key) != getattr(like, key)
        ]
    if given:
        raise StudyError(
            f"the scene gives {listed(given)}: a fall computes how the robot strikes, and its "
            f"contacts are points on level ground "
            "without restitution; leave that out, or use shockpc analyze"
        )


def _notes(rigid: Rigid) -> Iterator[str]:
    """What geometry of a robot is used, and what has none."""
    robot, links = rigid.landing.robot, {shape.link for shape in rigid.shapes}
    if rigid.visual:
        which = (
            f"{listed(rigid.visual, 6)}; delta_v_max leaves it out"
            if len(rigid.visual) < len(links)
            else "all links"
        )
        yield f"visual geometry strikes where the file has no collision geometry: {which}"
    yield from outline(robot, "collision").warnings
    if rigid.visual:
        yield from drawn_outline(robot).warnings
    bodies = {robot.frames[link].body for link in links}
    if bare := [body for k, body in enumerate(robot.bodies) if k not in bodies]:
        share = 100.0 * sum(body.mass for body in bare) / robot.mass
        yield f"{len(bare)} of {len(robot.bodies)} bodies ({share:.3g} % of the mass) have no geometry, so they never strike"


def _heading(heading: str | float) -> tuple[str, float]:
    """Name of a heading and its angle [rad]."""
    try:
        angle = (
            HEADINGS[heading]
            if isinstance(heading, str) and heading in HEADINGS
            else float(heading)
        )
    except ValueError:
        angle = math.nan
    if not abs(angle) <= 360.0:
        valid = f"{', '.join(HEADINGS)}, and an angle from forward to the left within 360 deg"
        raise StudyError(f'"{heading}" is no heading; valid are {valid}')
    return str(heading) if heading in HEADINGS else f"{angle:g} deg", math.radians(angle)


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

    def with_joints(model: Literal["free", "locked"]) -> dict[str, tuple[Scene, Robot]]:
        return {
            name: (replace(scene, joints=Joints(model=model)), robot)
            for name, (scene, _) in cases.items()
        }

    landed = [
        proven(one, selections, trace)
        for one in (with_joints("free"), cases, with_joints("locked"))
    ]
    refused = {
        name: error
        for k, results in enumerate(landed)
        for name, error in results.items()
        if isinstance(error, ShockError) and (k == 1 or isinstance(error, DefectError))
    }
    made = {
        strike.name: attempt(
            _result, strike, profile, texts, [results[strike.name] for results in landed]
        )
        for strike in strikes
        if isinstance(profile := landed[1][strike.name], ShockProfile)
    }
    refused |= {name: error for name, error in made.items() if isinstance(error, ShockError)}
    found = {name: result for name, result in made.items() if isinstance(result, StrikeResult)}
    return found, refused


def _table(
    strikes: Sequence[FallStrike],
    found: Mapping[str, StrikeResult],
    refused: Mapping[str, ShockError],
    texts: Sequence[str],
) -> Table:
    """All strikes, with columns that tell them apart and the worst value of each quantity."""
    looks = {i: found[strike.name] for i, strike in enumerate(strikes) if strike.name in found}
    columns = {
        key: np.array([getattr(one, key) for one in strikes])
        for key in ("fall", "number", "motion", "rate", "speed", "energy")
    }
    columns |= {"struck": np.array(["+".join(one.struck) for one in strikes])}
    columns |= {"rotation": np.degrees([one.rotation for one in strikes]).round(9)}
    for text in texts:
        columns[text] = np.array(
            [looks[i].values[text] if i in looks else np.nan for i in range(len(strikes))]
        )
        columns[f"{text} at"] = np.array(
            [looks[i].places[text] if i in looks else "" for i in range(len(strikes))]
        )
    trunk = np.array([looks[i].trunk if i in looks else (np.nan,) * 3 for i in range(len(strikes))])
    columns |= {
        f"trunk {model}": trunk[:, k] for k, model in enumerate(("free", "with drives", "locked"))
    }
    units = {"rotation": "deg", "rate": "rad/s", "speed": "m/s", "energy": "J"} | {
        f"{text} at": "" for text in texts
    }
    units |= {name: "m/s" for name in columns if name.startswith("trunk ")}
    columns["proven"] = np.array([i in looks for i in range(len(strikes))])
    messages = {
        i: str(refused[strike.name])
        for i, strike in enumerate(strikes)
        if strike.name in refused and i not in looks
    }
    return Table((), columns, messages, defects=tuple(traces(refused.values())), label_units=units)


def _trunk(profile: ShockProfile | ShockError) -> float:
    """|Δv| of the heaviest body's centre of mass, with friction where it is given [m/s]; NaN
    without a verdict.
    """
    if isinstance(profile, ShockError):
        return math.nan
    key = "shock_com" if profile.scene.friction is None else "shock_com_friction"
    return float(profile.value(key, "body")[int(np.argmax(profile.robot.masses))]) * profile.v_in


def _result(
    strike: FallStrike,
    profile: ShockProfile,
    texts: Sequence[str],
    landed: Sequence[ShockProfile | ShockError],
) -> StrikeResult:
    """What is kept of a strike.

    Args: landed, the same landing with joints free, with drives and locked.
    """
    values, places = {}, {}
    for text in texts:
        values[text], places[text] = math.nan, ""
        key, at, place = text.partition("@")
        if profile.scene.friction is None:
            key = key.removesuffix("_friction")  # as its remark says
        if select(key).quantity.scope.lacks(profile.landing):
            continue
        selection, where = selected(profile.landing, key + at + place)
        numbers = profile.numbers(selection, where) if len(where) else np.zeros(0)
        if np.isfinite(numbers).any():
            k = int(np.argmax(selection.worse(numbers)))
            values[text], places[text] = float(numbers[k]), where[k].name
    return StrikeResult(
        strike, values, places, tuple(map(_trunk, landed)), _first_stop(profile), profile
    )


def _first_stop(profile: ShockProfile) -> tuple[str, float] | None:
    """The joint that reaches a limit first after a strike, and when [s]; of joints that are within
    their limits.
    """
    times, key = {}, "delta_qd" if profile.scene.friction is None else "delta_qd_friction"
    for place, rate in zip(
        profile.places("joint"), profile.value(key, "joint").tolist(), strict=True
    ):
        joint = profile.robot.joint(place.name)
        if joint.kind in ("revolute", "prismatic") and abs(rate) > 1e-9:
            left = joint.limits[rate > 0.0] - joint.value(profile.q)
            if math.isfinite(left) and left * rate > 0.0 and abs(left) > LIMIT_SLACK:
                times[joint.name] = left / rate
    return min(times.items(), key=lambda one: one[1]) if times else None
