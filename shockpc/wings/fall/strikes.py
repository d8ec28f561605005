"""The strikes of a fall, each with its landing.

Of the points that meet the ground together, the landing has those that press.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from shockpc.core.coulomb import solve_friction
from shockpc.core.spatial import Array
from shockpc.impact.contact_rows import contact_rows
from shockpc.impact.friction import friction_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError, SolveError
from shockpc.text.printed import few
from shockpc.wings.fall.body import UP, Rigid, Spot, tilt
from shockpc.wings.fall.cross_section import CrossSection, SectionMotion
from shockpc.wings.fall.planar_fall import STICKS, CornerImpact, Kind
from shockpc.wings.fall.tip_over import Tip

SINKS = 1e-6
"""Speed into the ground, as a share of the strike's, above which a point takes part in it [1]."""

NEAR_GROUND = 5e-3
"""Height up to which a part nearly strikes together with others [m]."""

ASIDE = 0.3
"""Share of the change of rotation at the first strike above which there is a warning [1].

The share is that of the rotation out of the plane of the fall.
"""


@dataclass(frozen=True, eq=False, kw_only=True)
class FallStrike:
    """A strike, and its landing.

    Attributes:
        fall: name of the fall: posture, then heading or attitude.
        number: of the strike in its fall, from 1.
        struck: links that meet the ground together, the fastest first, with the speed of each
            towards the ground [m/s].
        near: links less than `NEAR_GROUND` above the ground then.
        motion: how the robot moved before.
        rotation: since the posture in which the fall began [rad].
        rate: angular velocity before [rad/s].
        energy: kinetic energy before [J].
        scene: of the landing.
        pressing: those of the struck links that press on the ground; the others separate.
        stands: links that are on the ground already, on the edge about which the robot turns, and
            press on it.
        forward: (3,) level unit vector in which the robot tips; None of a drop.
        remark: what of the strike the landing does not describe, and why; empty if all.
    """

    fall: str
    number: int
    struck: Mapping[str, float]
    near: tuple[str, ...]
    motion: Kind
    rotation: float
    rate: float
    energy: float
    scene: Scene = field(repr=False)
    pressing: tuple[str, ...] = ()
    stands: tuple[str, ...] = ()
    forward: Array | None = None
    remark: str = ""

    @property
    def name(self) -> str:
        """Name of the landing."""
        return f"{self.fall} {self.number}" if self.forward is not None else self.fall

    @property
    def speed(self) -> float:
        """Speed of the fastest of the struck points towards the ground [m/s]."""
        return max(self.struck.values())

    @property
    def struck_text(self) -> str:
        """Text of what strikes: each link, its speed where these differ, and if it separates."""
        if len(self.struck) == 1:
            return next(iter(self.struck))
        speeds = {link: f"{speed:.3g}" for link, speed in self.struck.items()}
        differ = len(set(speeds.values())) > 1
        words = []
        for link, speed in speeds.items():
            word = f"{link} {speed}" if differ else link
            if link not in self.pressing:
                word += " (separates)"
            words.append(word)
        return few(words, 4)


def strikes_of(rigid: Rigid, tip: Tip, together: float, least: float) -> Iterator[FallStrike]:
    """The strikes of a fall that are fast enough, each with its landing.

    Args:
        rigid: the robot.
        tip: its fall.
        together: height within which parts strike together [m].
        least: smallest speed of strikes that are listed [m/s].
    """
    kinds = {phase.end: phase.kind for phase in tip.fall.phases}
    number = 0
    last = tip.fall.impacts[0]
    for impact in tip.fall.impacts:
        if impact.speed < least:
            continue
        if number and _struck_before(tip.section, last, impact, together):
            continue
        number += 1
        last = impact
        yield _strike(rigid, tip, impact, number, kinds[impact.before], together)


def _struck_before(
    section: CrossSection, last: CornerImpact, impact: CornerImpact, together: float
) -> bool:
    """True if a corner was near the ground at the last strike, and did not stand there.

    Near is within the height `together`: it was part of that strike.
    """
    ahead, height = section.at(impact.corner, last.before.theta)
    ground = section.at(last.corner, last.before.theta)[1]
    return height - ground <= together and not _stood(section, last, ahead)


def _strike(
    rigid: Rigid, tip: Tip, impact: CornerImpact, number: int, kind: Kind, together: float
) -> FallStrike:
    """The strike of an impact.

    Args:
        rigid: the robot.
        tip: its fall.
        impact: of the fall.
        number: of the strike.
        kind: how the robot moved before.
        together: height within which parts strike together [m].
    """
    before = impact.before
    attitude = tilt(tip.forward, before.theta)
    points, links = rigid.on_ground(attitude, together)
    stood = np.array([_stood(tip.section, impact, x) for x in (points @ tip.forward).tolist()])
    # A disc that lands flat is one point, as far from the edge on which it stood as from the
    # other.
    if stood.all():
        stood[:] = False
    standing = rigid.spots(attitude, points[stood], links[stood])
    striking = rigid.spots(attitude, points[~stood], links[~stood])
    down = _speeds_down(rigid, tip.forward @ attitude, impact, striking)
    striking = tuple(spot for spot in striking if spot.link in down)
    striking = tuple(sorted(striking, key=lambda spot: -down[spot.link]))
    strike = FallStrike(
        fall=tip.name,
        number=number,
        struck=down,
        near=near_links(rigid, attitude, links, together),
        motion=kind,
        rotation=before.theta,
        rate=before.omega,
        forward=tip.forward,
        energy=tip.section.energy(before) - rigid.mass * GRAVITY * before.z,
        scene=_scene(rigid, tip.forward, before, striking, standing, kind == "slides"),
    )
    strike = with_pressing_contacts(strike, rigid.landing.robot)
    # Later strikes are computed as if the fall stayed in its plane, so that the first is checked.
    if number > 1:
        return strike
    aside = _turns_aside(rigid, tip.forward, before, (*striking, *standing))
    if aside <= ASIDE:
        return strike
    text = (
        f"{100.0 * aside:.0f} % of its change of rotation is out of the plane of the fall, in "
        "which later strikes are computed"
    )
    return replace(strike, remark="; ".join(filter(None, [strike.remark, text])))


def _scene(
    rigid: Rigid,
    forward: Array,
    motion: SectionMotion,
    striking: tuple[Spot, ...],
    standing: tuple[Spot, ...],
    slides: bool,
) -> Scene:
    """The landing with all contacts.

    Args:
        rigid: the robot.
        forward: (3,) level unit vector in which it tips.
        motion: before the strike.
        striking: what strikes.
        standing: what is on the ground already.
        slides: whether that slides.
    """
    velocity, omega = _in_world(forward, motion)
    attitude = tilt(forward, motion.theta)
    scene = rigid.scene(attitude, velocity, omega, striking, standing, slides)
    # By default landings are looked at in the plane of the fall.
    if scene.plane == "auto":
        scene = replace(scene, plane=tuple(np.cross(forward, UP).tolist()))
    # On finite stiffness only what strikes is a contact.
    if scene.yields:
        scene = replace(scene, contact=scene.contact[: len(striking)], stance=())
    return scene


def _in_world(forward: Array, motion: SectionMotion) -> tuple[Array, Array]:
    """Velocity (3,) of the centre of mass [m/s], and angular velocity (3,) [rad/s], world axes."""
    velocity = motion.vx * forward + motion.vz * UP
    return velocity, motion.omega * np.cross(UP, forward)


def _speeds_down(
    rigid: Rigid, forward: Array, impact: CornerImpact, spots: Sequence[Spot]
) -> dict[str, float]:
    """Speeds towards the ground [m/s] of links that go on into it, or of the fastest; by name.

    They are ω x − v_z at x forward of the centre of mass; the fastest is the first.

    Args:
        rigid: the robot.
        forward: (3,) level unit vector in the axes of the posture.
        impact: of the fall.
        spots: on the ground.
    """
    down: dict[str, float] = {}
    for spot in spots:
        x = float(forward @ (spot.point - rigid.com))
        down[spot.link] = impact.before.omega * x - impact.before.vz
    fastest = sorted(down, key=lambda link: -down[link])
    sinking = [link for link in fastest if down[link] > SINKS * impact.speed]
    return {link: down[link] for link in sinking or fastest[:1]}


def near_links(
    rigid: Rigid, attitude: Array, links: np.ndarray, together: float
) -> tuple[str, ...]:
    """Names of links that nearly strike.

    Args:
        rigid: the robot.
        attitude: (3, 3) rotation from the posture.
        links: those that strike or stand.
        together: height within which parts strike together [m].
    """
    near = set(rigid.on_ground(attitude, max(NEAR_GROUND, together))[1].tolist())
    return tuple(sorted(near - set(links.tolist())))


def _turns_aside(
    rigid: Rigid, forward: Array, motion: SectionMotion, spots: Sequence[Spot]
) -> float:
    """Share of the change of rotation at a strike that is not about the edge [1].

    The robot is rigid. Args: motion, before the strike.
    """
    velocity, omega = _in_world(forward, motion)
    attitude = tilt(forward, motion.theta)
    left = np.cross(UP, forward)
    axes = np.array([forward, left, UP])
    arms = (np.array([spot.point for spot in spots]) - rigid.com) @ attitude.T
    # Rows of the velocity of each spot by (v, ω), J, and M⁻¹ Jᵀ.
    J = np.concatenate([np.hstack([axes, np.cross(arm, axes)]) for arm in arms])
    inertia = attitude @ rigid.inertia @ attitude.T
    response = np.vstack([J[:, :3].T / rigid.mass, np.linalg.solve(inertia, J[:, 3:].T)])
    speeds = (J @ np.concatenate([velocity, omega])).reshape(-1, 3)
    impulses, _ = _impulses(J @ response, speeds, rigid.landing.scene.friction)
    # Δω, and its part that is not about the edge.
    change = response[3:] @ impulses.ravel()
    across = change - (change @ left) * left
    return float(np.linalg.norm(across) / (np.linalg.norm(change) or 1.0))


def _stood(section: CrossSection, impact: CornerImpact, x: float) -> bool:
    """True if what is on the ground x [m] ahead is nearer to the old corner than to the new one.

    The old corner is the one that was there before an impact.
    """
    new = section.at(impact.corner, impact.before.theta)[0]
    old = section.at(impact.on, impact.before.theta)[0]
    return impact.on >= 0 and abs(x - old) < abs(x - new)


def with_pressing_contacts(strike: FallStrike, robot: Robot) -> FallStrike:
    """A strike whose scene has those of its contacts that press.

    Friction is left out where it has no solution.
    """
    scene = strike.scene
    # The first contacts strike, and the others slide; then come the points that stand.
    struck = len(strike.struck)
    moving = len(scene.contact)
    pressing = [0]
    remark = ""
    if moving + len(scene.stance) > 1:
        pressing, remark = _pressing(landing_of(scene, robot), struck)
    striking = [k for k in pressing if k < struck] or [0]
    sliding = [k for k in pressing if struck <= k < moving]
    contacts = tuple(scene.contact[k] for k in [*striking, *sliding])
    stance = tuple(scene.stance[k - moving] for k in pressing if k >= moving)
    scene = replace(scene, contact=contacts, stance=stance)
    if scene.friction is not None:
        try:
            friction_of(landing_of(scene, robot))
        except (SceneError, SolveError) as refusal:
            remark = f"{refusal}; the numbers are those of contacts that stick"
            scene = replace(scene, friction=None)
    frames = [contact.frame for contact in scene.contact]
    frames += [foot.rpartition(":")[0] for foot in scene.stance]
    return replace(
        strike,
        scene=scene,
        pressing=tuple(frames[: len(striking)]),
        stands=tuple(frames[len(striking) :]),
        remark=remark,
    )


def _pressing(landing: PosedLanding, struck: int) -> tuple[list[int], str]:
    """The contacts and standing points of a landing that press, and what is wrong with that.

    The first `struck` contacts strike. What stands or slides takes part if it would sink otherwise.
    Where contacts stick, those that would be pulled are taken out.
    """
    friction = landing.scene.friction
    pressing = list(range(struck))
    frames = [place.name for place in landing.contact_places]
    try:
        rows = contact_rows(landing)
        A = rows.J @ np.linalg.solve(rows.M, rows.J.T)
        v = rows.speeds.reshape(-1, 3)
    except (np.linalg.LinAlgError, SceneError, SolveError):
        return pressing, ""  # the landing says why
    # The impulses of what strikes; of all, if those drive what stands or slides into the ground.
    for taking_part in dict.fromkeys((struck, len(frames))):
        rows_of = slice(3 * taking_part)
        impulse, pressing = _impulses(A[rows_of, rows_of], v[:taking_part], friction)
        # Speeds into the ground after it, −(v_n + A_n p), as shares of the largest speed before.
        after = v[:, 2] + (A[:, rows_of] @ impulse.ravel())[2::3]
        sinking = -after / np.abs(v).max()
        if sinking.max() <= SINKS:
            break
    worst = int(np.argmax(sinking))
    if sinking[worst] <= 0.01:
        return pressing, ""
    laws = "no impulse was found that obeys the laws of friction"
    if friction is None:
        laws = (
            "no set of contacts that stick or open obeys the laws of contact; with --friction they "
            "may slide"
        )
    return pressing, (
        f"{frames[worst]} would go on into the ground at {100.0 * sinking[worst]:.0f} % of the "
        f"strike's speed: {laws}"
    )


def _impulses(A: Array, velocity: Array, friction: float | None) -> tuple[Array, list[int]]:
    """The impulses (m, 3) of contacts that may open, and which of them press.

    Without a friction, or if none was found with it, contacts stick; those that would be pulled are
    taken out one by one.

    Args:
        A: (3m, 3m) Delassus matrix of rows along two tangents and the normal of each [1/kg].
        velocity: (m, 3) before the impact [m/s].
        friction: µ.
    """
    m = len(velocity)
    mu = STICKS if friction is None else friction
    solution = solve_friction(A, velocity, np.full(m, mu), np.zeros(m))
    pressing = list(range(m))
    if solution:
        pressing = [k for k in pressing if solution[0].state[k] != "separates"]
    if solution and friction is not None:
        return solution[0].impulse, pressing
    while True:
        impulse = _sticking_impulses(A, velocity, pressing)
        pulled = min(pressing, key=lambda k: float(impulse[k, 2]))
        if impulse[pulled, 2] >= -SINKS * np.abs(impulse).max() or len(pressing) == 1:
            return impulse, pressing
        pressing.remove(pulled)


def _sticking_impulses(A: Array, velocity: Array, sticking: list[int]) -> Array:
    """The impulses (m, 3) where some contacts stick and the others open."""
    # A p = −v along the rows of those that stick
    rows = (3 * np.array(sticking)[:, None] + np.arange(3)).ravel()
    p = np.linalg.lstsq(A[np.ix_(rows, rows)], -velocity.ravel()[rows], rcond=1e-12)[0]
    impulses = np.zeros((len(velocity), 3))
    impulses[sticking] = p.reshape(-1, 3)
    return impulses
