"""Falls of a robot: it tips over an edge of its support or is dropped.

Each strike is a separate landing.

Between strikes the robot is one rigid body, its joints held, in the plane of the fall. A strike is
solved as any other landing, with the drives of the joints. Of the points that meet the ground
together, the landing has those that press.
"""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.named_scenes import common_robot, named_scenes
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.scene_grid import scene_grid
from shockpc.evaluation.variations.vary import Vary, pairs
from shockpc.landing.bandwidths import low_passes_of
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.scene_fields import CONTACT, STRIKE, Option
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import drawn_outline, outline
from shockpc.text.diagnostic import Diagnostic, warn
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.printed import count, listed
from shockpc.text.trace import Trace
from shockpc.wings.fall.body import Rigid
from shockpc.wings.fall.drops import drops
from shockpc.wings.fall.margins import EFFORTS, StrikeMargin, judged_kinds, smallest_margins
from shockpc.wings.fall.results import StrikeResult, landings_of_strikes, strikes_table
from shockpc.wings.fall.strikes import FallStrike, strikes_of
from shockpc.wings.fall.tip_over import Tip, tip_over

HEADINGS = {"front": 0.0, "left": 90.0, "back": 180.0, "right": -90.0}
"""Directions of a fall from forward to the left [deg]."""

LEAST = 0.1
"""Default of the smallest speed of strikes that are listed [m/s]."""

STANDARD = ("delta_v_max", "delta_v", "joint_impulse")
WITH_FRICTION = ("delta_v_friction", "joint_impulse_friction")
"""Quantities of every strike: of contacts that stick, or with friction."""


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
    margins: tuple[StrikeMargin, ...]

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
    judged = judged_kinds(scenes.values(), robot)
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
    results_by_name, refused = landings_of_strikes(motion.strikes, robot, selections, texts, trace)
    if not results_by_name:
        raise next(iter(refused.values()))
    worse = selections[0].worse  # the first is that by which strikes are ranked
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
        table=strikes_table(motion.strikes, results_by_name, refused, texts),
        failures=tuple((motion.failures | refused).items()),
        drop=drop,
        notes=tuple(dict.fromkeys(motion.notes)),
        margins=smallest_margins(results) if any(judged) else (),
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
        judged: as `judged_kinds` gives it.
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
