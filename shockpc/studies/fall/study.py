"""Falls of a robot: it tips over an edge of its support or is dropped, and each strike is a landing of its own.

Between strikes the robot is one rigid body, its joints held, in the plane of the fall. What then strikes is solved as any other
landing, with the joints as modelled. Of the points that meet the ground together those are in the landing that press.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from shockpc.core.friction import solve_friction
from shockpc.core.spatial import Array
from shockpc.evaluation.columns import selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.landings import common_robot, landings_by_name
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import Vary, pairs
from shockpc.evaluation.varied_scene import scene_grid
from shockpc.impact.friction import contact_rows, friction_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.record import Option
from shockpc.landing.resolve import landing_of
from shockpc.landing.scene import GRAVITY, Contact, Joints, Scene
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.table import select
from shockpc.robot.geometry import drawn_outline, outline
from shockpc.robot.robot import Robot
from shockpc.robot.slack import LIMIT_SLACK
from shockpc.studies.declare import QuantityOption, study
from shockpc.studies.fall.body import UP, Rigid, Spot
from shockpc.studies.fall.motion import STICKS, CrossSection, Fall, Kind, Touch, follow_fall
from shockpc.text.errors import SceneError, ShockError, SolveError, StudyError
from shockpc.text.printed import listed
from shockpc.text.trace import Trace

HEADINGS = {"front": 0.0, "left": 90.0, "back": 180.0, "right": -90.0}
"""Directions of a fall from forward to the left [deg]."""

SIDES = (("back", "", "front"), ("right", "", "left"), ("bottom", "", "top"))
"""Names of the sides of the box around the robot, along x, y and z."""

STANDARD = ("delta_v_max", "delta_v", "joint_impulse")
WITH_FRICTION = ("delta_v_friction", "joint_impulse_friction")
"""Quantities of every strike: of contacts that stick, or with friction."""

NUDGE = 1e-6
"""Rotation beyond the balance at which a robot begins to fall [rad]."""

LEVEL = math.radians(1.0)
"""Rotation within which points within `together` of the ground meet it as the robot is pushed [rad]."""

SINKS = 1e-6
"""Speed into the ground, of that of the strike, with which a point that stands takes part [1]."""

NEAR_GROUND = 5e-3
"""Height up to which a part nearly strikes together with others [m]."""

ASIDE = 0.3
"""Share of the change of rotation at the first strike that is out of the plane of the fall, above which there is a warning [1]."""

EARLY = math.radians(3.0)
"""How long before the edge would be pulled or slips the centre of pressure may leave it without a warning [rad]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FallStrike:
    """A strike, and its landing.

    Attributes:
        fall: name of the fall: posture, then heading or attitude.
        number: of the strike in its fall, from 1.
        struck: links that meet the ground together, the fastest first, with the speed of each towards the ground [m/s].
        near: links less than `NEAR_GROUND` above the ground then.
        pressing: those of the struck links that press on it; the others separate.
        stands: links that are on the ground already, on the edge about which the robot turns, and press on it.
        motion: how the robot moved before.
        rotation: since the posture in which the fall began [rad].
        rate: angular velocity before [rad/s].
        energy: kinetic energy before [J].
        scene: of the landing.
        forward: (3,) level unit vector in which the robot tips; None of a drop.
        remark: what meets the ground and is not part of the landing as it should be, and why.
    """

    fall: str
    number: int
    struck: Mapping[str, float]
    near: tuple[str, ...]
    pressing: tuple[str, ...]
    stands: tuple[str, ...]
    motion: Kind
    rotation: float
    rate: float
    energy: float
    scene: Scene = field(repr=False)
    forward: Array | None = None
    remark: str = ""

    @property
    def name(self) -> str:
        """Of the landing."""
        return f"{self.fall} {self.number}" if self.forward is not None else self.fall

    @property
    def speed(self) -> float:
        """Of the fastest of them towards the ground [m/s]."""
        return max(self.struck.values())


@dataclass(frozen=True, eq=False, kw_only=True)
class Tip:
    """A robot that tips over.

    Attributes:
        name: posture, then heading.
        forward: (3,) level unit vector across the edge over which it tips.
        balance: rotation at which it balances on the edge [rad]; zero or less if it does not stand on its own.
        least_push: least speed of the centre of mass that a level push has to give for the robot to tip [m/s].
        hinged: rate at the first strike of `least` or more, if the edge were a hinge [rad/s].
        fall: what it does until it rests.
        section: the robot in the plane of the fall.
        warnings: what limits the result.
    """

    name: str
    forward: Array
    balance: float
    least_push: float
    hinged: float
    fall: Fall
    section: CrossSection = field(repr=False)
    warnings: tuple[str, ...]


class StrikeResult(NamedTuple):
    """What is known of a strike.

    Attributes:
        strike: the strike.
        values: the worst value of each quantity, by its text; NaN where there is none.
        places: where it is the worst, by text.
        trunk: |Δv| of the heaviest body's centre of mass, with friction where it is given: free joints, as modelled, locked; NaN
            without a verdict [m/s].
        stop: joint that reaches its limit first after the strike if its rate stays, and when [s]; None if none moves towards it.
        profile: of the landing.
    """

    strike: FallStrike
    values: Mapping[str, float]
    places: Mapping[str, str]
    trunk: tuple[float, ...]
    stop: tuple[str, float] | None
    profile: ShockProfile


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

    @property
    def landings(self) -> tuple[StrikeResult, ...]:
        """The landings that could be computed."""
        return self.results


@study(
    "shockpc fall g1",
    "shockpc fall talos --heading front --friction 0.5 --out fall/",
    "shockpc fall go2 --drop 0.75 --part 'imu=half-sine 1500 g 0.5 ms'",
    more=(
        "The robot tips as one rigid body, its joints held, over an edge of its support until it rests: on an edge that sticks,"
        " slides or leaves the ground, strike after strike. Each strike is a landing with the joints as modelled."
    ),
)
def fall(
    postures: Scene | Mapping[str, Scene],
    robot: Robot | None = None,
    *,
    headings: Annotated[
        Sequence[str],
        Option(
            "Front, left, back, right, or an angle from forward to the left [deg]; by default all four.",
            "Fall",
            "HEADING",
            "heading",
        ),
    ] = tuple(HEADINGS),
    push: Annotated[
        float | None,
        Option(
            "Speed that a level push gives to the centre of mass; by default it falls from its balance at rest.",
            "Fall",
            "V",
            unit="m/s",
            above=0.0,
        ),
    ] = None,
    drop: Annotated[
        float | None,
        Option(
            "Drop it from this height instead, onto faces, edges and corners of the box around it, the centre of mass above them "
            "(26 drops, as in MIL-STD-810H, method 516.8, procedure IV).",
            "Fall",
            "H",
            unit="m",
            above=0.0,
        ),
    ] = None,
    attitudes: Annotated[
        int | None, Option("Drop it in so many attitudes that are spread over all instead.", "Fall", "N", least=1.0)
    ] = None,
    together: Annotated[float, Option("Height within which parts strike together.", "Fall", "H", unit="m", above=0.0)] = 1e-3,
    least: Annotated[float, Option("List strikes of at least this speed.", "Fall", "V", unit="m/s", above=0.0)] = 0.1,
    vary: Annotated[
        Vary,
        Option(
            "Postures: values a:b:n or a,b,c of a joint or a glob [deg; m if prismatic], or of another quantity of the landing.",
            "Fall",
            "NAME=VALUES",
        ),
    ] = (),
    quantities: QuantityOption = (),
    rank: Annotated[
        str | None,
        Option(
            "Quantity by which strikes are ranked, the worst first: delta_v_max by default, body.delta_v_friction with a friction, "
            "part_margin with a part at a frame.",
            "What is computed",
            "KEY[@PLACE]",
        ),
    ] = None,
    trace: Trace | None = None,
) -> Falls:
    """Let a robot tip over, or drop it, and compute each strike as a landing.

    Args:
        postures: a scene, or scenes of one robot by the names of their postures. What strikes in them is not used.
        robot: the scenes' robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        UnknownName: there is no such quantity, or nothing of what varies.
        StudyError: the robot cannot fall, or options contradict one another.
        ShockError: a posture is not possible, or no strike can be computed.
    """
    trace = trace or Trace()
    scenes = {"": postures} if isinstance(postures, Scene) else dict(postures)
    robot = robot if robot is not None and scenes else common_robot(scenes)
    if drop is None and attitudes is not None:
        raise StudyError("attitudes are those of a drop; give its height too, by drop")
    if drop is not None and push is not None:
        raise StudyError("a push tips the robot, and a drop has none; leave one of them out")
    scenes = {
        name: one for posture, scene in scenes.items() for name, one in scene_grid(posture, scene, robot, pairs(vary)).items()
    }
    parts = any(part.at for scene in scenes.values() for part in scene.part)
    slides = any(scene.friction is not None for scene in scenes.values())
    rank = rank or ("part_margin" if parts else "body.delta_v_friction" if slides else "delta_v_max")
    texts = tuple(dict.fromkeys([rank, *(WITH_FRICTION if slides else STANDARD), *quantities]))
    worse, *_ = (select(text.partition("@")[0]).quantity.worse for text in texts)
    tips, strikes, failures, notes = list[Tip](), list[FallStrike](), dict[str, ShockError](), list[str]()
    for posture, scene in scenes.items():
        _refuse_options(scene)
        with trace.stage("posture and geometry"):
            rigid = Rigid.of(scene, robot)
        notes += _notes(rigid)
        if drop is not None:
            strikes += _drops(rigid, posture, drop, attitudes, together)
            continue
        for name, angle in map(_heading, headings):
            name = f"{posture} {name}".strip()
            try:
                with trace.stage("falls"):
                    tip = _tip(rigid, name, angle, push, together, least)
                    strikes += _strikes(rigid, tip, together, least)
                tips.append(tip)
            except StudyError as refusal:
                failures[name] = refusal
    if not strikes:
        raise StudyError(
            "; ".join(f"{name}: {text}" for name, text in failures.items())
            or f"nothing strikes at {least:g} m/s or more: the robot rolls or comes to rest; a smaller --least lists slower ones"
        )
    table = _evaluated(strikes, robot, texts, trace)
    results = sorted(
        table.looks.values(),
        key=lambda one: np.nan_to_num(one.values[rank] if worse == "less" else -abs(one.values[rank]), nan=math.inf),
    )
    if not results:
        raise next(iter(table.refusals.values()))
    failures |= {strikes[i].name: refusal for i, refusal in table.refusals.items()}
    return Falls(
        robot=robot, rank=rank, quantities=texts, tips=tuple(tips), strikes=tuple(strikes), results=tuple(results),
        table=replace(table, looks={}), failures=tuple(failures.items()), drop=drop, notes=tuple(dict.fromkeys(notes)),
    )  # fmt: skip


def _refuse_options(scene: Scene) -> None:
    """Refuse what of a scene would have no effect: a motion before the impact, restitution, and how contacts are held."""
    given = [key for key, value in vars(scene.strike).items() if value not in (None, {})]
    like = Contact(frame="")
    for contact in scene.contact:
        given += [key for key in ("restitution", "directions", "kind", "normal") if getattr(contact, key) != getattr(like, key)]
    if given:
        raise StudyError(
            f"the scene gives {listed(given)}: a fall computes how the robot strikes, and its contacts are points on level ground "
            "without restitution; leave that out, or use shockpc analyze"
        )


def _notes(rigid: Rigid) -> Iterator[str]:
    """What geometry of a robot is used, and what has none."""
    robot, links = rigid.landing.robot, {shape.link for shape in rigid.shapes}
    if rigid.visual:
        which = f"{listed(rigid.visual, 6)}; delta_v_max leaves it out" if len(rigid.visual) < len(links) else "all links"
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
        angle = HEADINGS[heading] if isinstance(heading, str) and heading in HEADINGS else float(heading)
    except ValueError:
        angle = math.nan
    if not abs(angle) <= 360.0:
        valid = f"{', '.join(HEADINGS)}, and an angle from forward to the left within 360 deg"
        raise StudyError(f'"{heading}" is no heading; valid are {valid}')
    return str(heading) if heading in HEADINGS else f"{angle:g} deg", math.radians(angle)


def _tip(rigid: Rigid, name: str, heading: float, push: float | None, together: float, least: float) -> Tip:
    """How a robot tips over along a heading.

    Raises:
        StudyError: it does not tip, or nothing of it strikes.
    """
    forward, ends = rigid.edge(heading, together)
    section, friction = rigid.section(forward), rigid.landing.scene.friction
    first, theta = _support(section, together)
    corner, balanced = section.balance(first)
    rate = section.least_rate(first, theta) if balanced > theta else 0.0
    height = -section.at(first, theta)[1]
    if balanced <= theta:
        start, corner = section.pivoting(first, theta, 0.0 if push is None else push / height), first
    elif push is None:
        length, _, kappa = section.arm(corner)
        start = section.pivoting(corner, balanced + NUDGE, math.sqrt(kappa * GRAVITY / length) * NUDGE)
    elif push <= rate * height:
        raise StudyError(
            f"a push to {push:g} m/s does not tip the robot: it balances at {math.degrees(balanced):.3g} deg, which takes at least "
            f"{rate * height:.3g} m/s"
        )
    else:
        start, corner = section.pivoting(first, theta, push / height), first
    found, hinge = follow_fall(section, corner, start, friction), follow_fall(section, corner, start, hinged=least)
    turned = math.degrees(math.acos(min(1.0, float(forward @ [math.cos(heading), math.sin(heading), 0.0]))))
    warnings = [f"the edge is turned by {turned:.2g} deg from the heading; the robot tips across the edge"] * (turned > 3.0)
    strike = next((touch for touch in found.touches if touch.speed >= least), found.touches[0])
    warnings += _below(rigid, forward, section, strike)
    warnings += _pressure(rigid, forward, ends, section, found, least)
    warnings += ["it is still rocking when it is no longer followed"] * (not found.rests)
    return Tip(
        name=name, forward=forward, balance=balanced, least_push=rate * height, hinged=hinge.touches[-1].before.omega,
        fall=found, section=section, warnings=tuple(warnings),
    )  # fmt: skip


def _tilt(forward: Array, angle: float) -> Array:
    """The rotation (3, 3) of a robot that tips by an angle [rad] along a level unit vector."""
    return np.asarray(Rotation.from_rotvec(angle * np.cross(UP, forward)).as_matrix())


def _below(rigid: Rigid, forward: Array, section: CrossSection, touch: Touch) -> Iterator[str]:
    """A warning of bodies without geometry whose centres of mass are below the ground at a strike.

    Raises:
        StudyError: they are most of the mass.
    """
    robot, theta = rigid.landing.robot, touch.before.theta
    under = np.flatnonzero((rigid.coms - rigid.com) @ _tilt(forward, theta)[2] < section.at(touch.corner, theta)[1])
    share, names = float(robot.masses[under].sum()) / rigid.mass, listed((robot.bodies[i].name for i in under), 4)
    text = f"{names} ({100.0 * share:.3g} % of the mass) would be below the ground at the strike at {math.degrees(theta):.3g} deg, "
    text += "because they have no geometry there"
    if share > 0.5:
        raise StudyError(f"{text}; give the robot's file collision or visual geometry")
    yield from [text] * bool(names)


def _support(section: CrossSection, together: float) -> tuple[int, float]:
    """The forward corner of a robot's support, and the rotation at which it is on the ground [rad]."""
    low = best = section.lowest(0.0)
    while section.side(best) <= LEVEL and section.at(best + 1, 0.0)[1] - section.at(low, 0.0)[1] <= together:
        best += 1
    return best, max(section.side(best - 1), 0.0)


def _pressure(rigid: Rigid, forward: Array, ends: Array, section: CrossSection, found: Fall, least: float) -> Iterator[str]:
    """A warning where the centre of pressure leaves the edge: at (I_xy ω' + I_zy ω²) / N along it, from the centre of mass."""
    if np.ptp(ends) == 0.0:
        yield "the support is a corner in this direction, not an edge: the robot may turn about it, and another part may strike"
        return
    last = next((touch for touch in found.touches if touch.speed >= least), found.touches[-1]).before.theta
    held = list(itertools.takewhile(lambda phase: phase.kind == "pivots" and phase.start.theta < last, found.phases))
    for phase in held:
        length, angle, kappa = section.arm(phase.corner)
        steps = 2 + int((phase.end.theta - phase.start.theta) / EARLY)
        for theta in np.linspace(phase.start.theta, phase.end.theta, steps).tolist():
            turn = _tilt(forward, theta)
            moments, squared = (
                turn @ rigid.inertia @ turn.T @ np.cross(UP, forward),
                section.squared_rate(phase.corner, theta, phase.start),
            )
            rate = forward @ moments * kappa * GRAVITY / length * math.sin(theta + angle) + UP @ moments * squared
            place = float(rate) / (rigid.mass * max(float(section.forces(phase.corner, theta, squared)[1]), 1e-9))
            if not ends[0] <= place <= ends[1]:
                if held[-1].end.theta - theta > EARLY:
                    yield (
                        f"the centre of pressure leaves the edge at {math.degrees(theta):.3g} deg, before the strike at "
                        f"{math.degrees(last):.3g} deg: the robot then turns about a corner, and another part may strike"
                    )
                return


def _strikes(rigid: Rigid, tip: Tip, together: float, least: float) -> Iterator[FallStrike]:
    """The strikes of a fall that are fast enough, each with its landing."""
    left, number, last, section = np.cross(UP, tip.forward), 0, tip.fall.touches[0], tip.section
    kinds = {phase.end: phase.kind for phase in tip.fall.phases}
    for touch in tip.fall.touches:
        theta, omega = touch.before.theta, touch.before.omega
        ahead, height = section.at(touch.corner, last.before.theta)
        # What was within `together` of the ground at the last strike has been part of it, unless it stood there.
        known = height - section.at(last.corner, last.before.theta)[1] <= together and not _stood(section, last, ahead)
        if touch.speed < least or (number and known):
            continue
        number, last, turn = number + 1, touch, _tilt(tip.forward, theta)
        points, links = rigid.struck(turn, together)
        old = np.array([_stood(section, touch, place) for place in (points @ tip.forward).tolist()])
        old[:] &= not old.all()  # a disc that lands flat is one point, as far from the edge on which it stood as from the other
        struck, stands = (rigid.spots(turn, points[own], links[own]) for own in (~old, old))
        velocity = touch.before.vx * tip.forward + touch.before.vz * UP
        down = {spot.link: omega * float(tip.forward @ turn @ (spot.point - rigid.com)) - touch.before.vz for spot in struck}
        fastest = sorted(struck, key=lambda spot: -down[spot.link])
        struck = tuple(spot for spot in fastest if down[spot.link] > SINKS * touch.speed) or tuple(fastest[:1])
        near = set(rigid.struck(turn, max(NEAR_GROUND, together))[1].tolist()) - set(links.tolist())
        scene = rigid.scene(turn, velocity, omega * left, struck, stands, kinds[touch.before] == "slides")
        if scene.plane == "auto":
            scene = replace(scene, plane=tuple(np.cross(tip.forward, UP).tolist()))
        if scene.contact_stiffness is not None:
            scene = replace(scene, contact=scene.contact[: len(struck)], stance=())
        strike = _landing(
            rigid, scene, turn, fall=tip.name, number=number, struck={spot.link: down[spot.link] for spot in struck},
            near=tuple(sorted(near)), motion=kinds[touch.before], rotation=theta, rate=omega, forward=tip.forward,
            energy=section.energy(touch.before) - rigid.mass * GRAVITY * touch.before.z,
        )  # fmt: skip
        aside = _turns_aside(rigid, turn, (*struck, *stands), velocity, omega, tip.forward) if number == 1 else 0.0
        if aside > ASIDE:
            text = f"{100.0 * aside:.0f} % of its change of rotation is out of the plane in which later strikes are followed"
            strike = replace(strike, remark="; ".join(filter(None, [strike.remark, text])))
        yield strike


def _turns_aside(rigid: Rigid, turn: Array, spots: Sequence[Spot], velocity: Array, omega: float, forward: Array) -> float:
    """Share of the change of rotation at a strike of the rigid robot that is not about the edge [1]."""
    axes, mu = np.array([forward, np.cross(UP, forward), UP]), rigid.landing.scene.friction
    arms = (np.array([spot.point for spot in spots]) - rigid.com) @ turn.T
    rows = np.concatenate([np.hstack([axes, np.cross(arm, axes)]) for arm in arms])
    response = np.vstack([rows[:, :3].T / rigid.mass, np.linalg.solve(turn @ rigid.inertia @ turn.T, rows[:, 3:].T)])
    speeds = (rows @ np.concatenate([velocity, omega * axes[1]])).reshape(-1, 3)
    change = response[3:] @ _impulses(rows @ response, speeds, mu)[0].ravel()
    return float(np.linalg.norm(change - (change @ axes[1]) * axes[1]) / (np.linalg.norm(change) or 1.0))


def _stood(section: CrossSection, touch: Touch, place: float) -> bool:
    """Whether what is on the ground at a place [m] is nearer to the corner that was there before a touch than to the new one."""
    new, old = (section.at(corner, touch.before.theta)[0] for corner in (touch.corner, touch.on))
    return touch.on >= 0 and abs(place - old) < abs(place - new)


def _landing(rigid: Rigid, scene: Scene, turn: Array, **strike: Any) -> FallStrike:
    """A strike with those contacts that press.

    Friction is left out where it has no solution. Args: turn, (3, 3) from the posture to the attitude.
    """
    landing, n, m = landing_of(scene, rigid.landing.robot), len(scene.contact), len(strike["struck"])
    kept, remark = _pressing(landing, m) if n + len(scene.stance) > 1 else ([0], "")
    pressing = [k for k in kept if k < m] or [0]
    scene = replace(
        scene,
        contact=tuple(scene.contact[k] for k in [*pressing, *(k for k in kept if m <= k < n)]),
        stance=tuple(scene.stance[k - n] for k in kept if k >= n),
    )
    try:
        friction_of(landing_of(scene, rigid.landing.robot)) if scene.friction is not None else None
    except (SceneError, SolveError) as refusal:
        remark, scene = f"{refusal}; the numbers are those of contacts that stick", replace(scene, friction=None)
    frames = [*(one.frame for one in scene.contact), *(foot.rpartition(":")[0] for foot in scene.stance)]
    m = len(pressing)
    return FallStrike(scene=scene, pressing=tuple(frames[:m]), stands=tuple(frames[m:]), remark=remark, **strike)


def _pressing(landing: PosedLanding, n: int) -> tuple[list[int], str]:
    """Which of the contacts and standing points of a landing press, and what is wrong with that.

    The first n contacts strike. What stands or slides takes part if it would sink otherwise. Where contacts stick, those that
    would be pulled are taken out.
    """
    friction, kept, frames = landing.scene.friction, list(range(n)), [place.name for place in landing.contact_places]
    try:
        rows = contact_rows(landing)
        A, v = rows.J @ np.linalg.solve(rows.M, rows.J.T), rows.speeds.reshape(-1, 3)
    except (np.linalg.LinAlgError, SceneError, SolveError):
        return kept, ""  # the landing says why
    for count in dict.fromkeys((n, len(frames))):
        impulse, kept = _impulses(A[: 3 * count, : 3 * count], v[:count], friction)
        sinking = -(v[:, 2] + (A[:, : 3 * count] @ impulse.ravel())[2::3]) / np.abs(v).max()
        if sinking.max() <= SINKS:
            break
    worst, laws = int(np.argmax(sinking)), "no impulse was found that obeys the laws of friction"
    if friction is None:
        laws = "no set of contacts that stick or open obeys the laws of contact; with --friction they may slide"
    text = f"{frames[worst]} would go on into the ground at {100.0 * sinking[worst]:.0f} % of the strike's speed: {laws}"
    return kept, text if sinking[worst] > 0.01 else ""


def _impulses(A: Array, velocity: Array, friction: float | None) -> tuple[Array, list[int]]:
    """The impulses (m, 3) of contacts that may open, and which of them press.

    Without a friction, or if none was found with it, contacts stick; those that would be pulled are taken out one by one.

    Args:
        A: (3m, 3m) Delassus matrix of rows along two tangents and the normal of each [1/kg].
        velocity: (m, 3) before the impact [m/s].
        friction: µ.
    """
    m = len(velocity)
    found = solve_friction(A, velocity, np.full(m, STICKS if friction is None else friction), np.zeros(m))
    kept = [k for k in range(m) if not found or found[0].state[k] != "separates"]
    if found and friction is not None:
        return found[0].impulse, kept
    while True:
        rows, impulse = (3 * np.array(kept)[:, None] + np.arange(3)).ravel(), np.zeros((m, 3))
        impulse[kept] = np.linalg.lstsq(A[np.ix_(rows, rows)], -velocity.ravel()[rows], rcond=1e-12)[0].reshape(-1, 3)
        pulled = min(kept, key=lambda k: float(impulse[k, 2]))
        if impulse[pulled, 2] >= -SINKS * np.abs(impulse).max() or len(kept) == 1:
            return impulse, kept
        kept.remove(pulled)


def _drops(rigid: Rigid, posture: str, height: float, count: int | None, together: float) -> Iterator[FallStrike]:
    """The strikes of drops in all attitudes."""
    speed = math.sqrt(2.0 * GRAVITY * height)
    for name, down in (_box_attitudes(rigid) if count is None else _spread(count)).items():
        level = np.linalg.norm(down[:2])
        turn = _tilt(np.append(down[:2], 0.0) / level if level > 1e-12 else np.array([0.0, -1.0, 0.0]), math.atan2(level, -down[2]))
        points, links = rigid.struck(turn, together)
        spots, near = rigid.spots(turn, points, links), set(rigid.struck(turn, max(NEAR_GROUND, together))[1].tolist())
        scene = rigid.scene(turn, -speed * UP, np.zeros(3), spots, ())
        yield _landing(
            rigid, scene, turn, fall=f"{posture} {name}".strip(), number=1, struck={spot.link: speed for spot in spots},
            near=tuple(sorted(near - set(links.tolist()))),
            motion="is in the air", rotation=0.0, rate=0.0, energy=0.5 * rigid.mass * speed**2,
        )  # fmt: skip


def _box_attitudes(rigid: Rigid) -> dict[str, Array]:
    """Unit vectors (3,) from the centre of mass to the faces, edges and corners of the box around the posture, by name."""
    points, _ = rigid.points(np.vstack([np.eye(3), -np.eye(3)]))
    low, high = points.min(axis=0) - rigid.com, points.max(axis=0) - rigid.com
    found: dict[str, Array] = {}
    for kind, count in (("face", 1), ("edge", 2), ("corner", 3)):
        for signs in np.ndindex(3, 3, 3):
            if sum(sign != 1 for sign in signs) == count:
                place = np.array([(low[k], 0.0, high[k])[sign] for k, sign in enumerate(signs)])
                name = "-".join(filter(None, (SIDES[k][sign] for k, sign in enumerate(signs))))
                found[f"{kind} {name}"] = place / np.linalg.norm(place)
    return found


def _spread(count: int) -> dict[str, Array]:
    """Unit vectors (3,) spread evenly over the sphere along a spiral; rotation about the vertical does not matter."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    return {f"attitude {i + 1}": np.array([r[i] * math.cos(angle[i]), r[i] * math.sin(angle[i]), z[i]]) for i in range(count)}


def _evaluated(strikes: Sequence[FallStrike], robot: Robot, texts: Sequence[str], trace: Trace) -> Table:
    """The landings of all strikes, with columns that tell them apart and the worst value of each quantity."""
    cases = {strike.name: (strike.scene, robot) for strike in strikes}
    if len(cases) < len(strikes):
        raise StudyError("two falls have one name; give each posture and heading once")
    evaluation = Evaluation(landings_by_name(cases, trace), prove=None, look=lambda profile: profile)
    table = evaluation.table()
    others = {model: _trunks_with(strikes, robot, model, trace) for model in ("free", "locked")}
    trunks = [others["free"], {i: _trunk(profile) for i, profile in table.looks.items()}, others["locked"]]
    looks = {
        i: _result(strikes[i], profile, texts, tuple(own.get(i, math.nan) for own in trunks)) for i, profile in table.looks.items()
    }
    columns = {
        key: np.array([getattr(one, key) for one in strikes]) for key in ("fall", "number", "motion", "rate", "speed", "energy")
    }
    columns |= {"struck": np.array(["+".join(one.struck) for one in strikes])}
    columns |= {"rotation": np.degrees([one.rotation for one in strikes])}
    for text in texts:
        columns[text] = np.array([looks[i].values[text] if i in looks else np.nan for i in range(len(strikes))])
        columns[f"{text} at"] = np.array([looks[i].places[text] if i in looks else "" for i in range(len(strikes))])
    trunk = np.array([looks[i].trunk if i in looks else (np.nan,) * 3 for i in range(len(strikes))])
    columns |= {f"trunk {model}": trunk[:, k] for k, model in enumerate(("free", "as modelled", "locked"))}
    units = {"rotation": "deg", "rate": "rad/s", "speed": "m/s", "energy": "J"} | {f"{text} at": "" for text in texts}
    units |= {name: "m/s" for name in columns if name.startswith("trunk ")}
    return replace(table, columns={**columns, "proven": table.columns["proven"]}, looks=looks, label_units=units)


def _trunks_with(strikes: Sequence[FallStrike], robot: Robot, model: Literal["free", "locked"], trace: Trace) -> dict[int, float]:
    """The same with other joints, by the number of each strike of which there is a verdict."""
    cases = {strike.name: (replace(strike.scene, joints=Joints(model=model)), robot) for strike in strikes}
    return dict(Evaluation(landings_by_name(cases, trace), prove=None, look=_trunk).table().looks)


def _trunk(profile: ShockProfile) -> float:
    """|Δv| of the heaviest body's centre of mass, with friction where it is given [m/s]."""
    key = "shock_com" if profile.scene.friction is None else "shock_com_friction"
    return float(profile.value(key, "body")[int(np.argmax(profile.robot.masses))]) * profile.v_in


def _result(strike: FallStrike, profile: ShockProfile, texts: Sequence[str], trunk: tuple[float, ...]) -> StrikeResult:
    values, places = {}, {}
    for text in texts:
        values[text], places[text] = math.nan, ""
        key, at, place = text.partition("@")
        if profile.scene.friction is None:
            key = key.removesuffix("_friction")  # as its remark says
        if select(key).quantity.lacks(profile.landing):
            continue
        selection, where = selected(profile.landing, key + at + place)
        numbers = profile.numbers(selection, where) if len(where) else np.zeros(0)
        if np.isfinite(numbers).any():
            k = int(np.argmax(selection.worse(numbers)))
            values[text], places[text] = float(numbers[k]), where[k].name
    return StrikeResult(strike, values, places, trunk, _first_stop(profile), profile)


def _first_stop(profile: ShockProfile) -> tuple[str, float] | None:
    """The joint that reaches a limit first after a strike, and when [s]; of joints that are within their limits."""
    times, key = {}, "delta_qd" if profile.scene.friction is None else "delta_qd_friction"
    for place, rate in zip(profile.places("joint"), profile.value(key, "joint").tolist(), strict=True):
        joint = profile.robot.joint(place.name)
        if joint.kind in ("revolute", "prismatic") and abs(rate) > 1e-9:
            left = joint.limits[rate > 0.0] - joint.value(profile.q)
            if math.isfinite(left) and left * rate > 0.0 and abs(left) > LIMIT_SLACK:
                times[joint.name] = left / rate
    return min(times.items(), key=lambda one: one[1]) if times else None
