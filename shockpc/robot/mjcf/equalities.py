"""The equalities of a compiled MJCF: loops that they close, and joints that they couple."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.robot.bodies_and_joints import Frame, Loop, Mimic
from shockpc.robot.mjcf.kinds import (
    CONNECT,
    JOINT,
    NO_EQUALITY,
    SITE,
    TENDON,
    WELD,
    WRAPPED_JOINT,
)
from shockpc.robot.pinocchio_joints import rotation
from shockpc.robot.robot import Robot
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed


class Equality(NamedTuple):
    """An equality that is active.

    Attributes:
        number: in the model.
        ends: numbers of its two objects; −1 for none.
        bodies: numbers of the bodies that it couples; 0 for the world.
    """

    number: int
    ends: tuple[int, int]
    bodies: list[int]


def frame_at(position: Array, quaternion: Array) -> pin.SE3:
    """A frame from its origin and its quaternion, whose scalar part comes first."""
    return pin.SE3(rotation(quaternion), np.array(position))


def equalities_of(m: Any) -> Iterator[Equality]:
    """The equalities that are active."""
    if m.opt.disableflags & NO_EQUALITY:
        return
    for number in np.flatnonzero(m.eq_active0).tolist():
        ends = (int(m.eq_obj1id[number]), int(m.eq_obj2id[number]))
        kind = int(m.eq_type[number])
        bodies: list[int] = []
        if kind in (JOINT, TENDON):
            for end in ends:
                bodies += [int(m.jnt_bodyid[joint]) for joint in _terms(m, kind, end) or ()]
        elif kind in (CONNECT, WELD) and m.eq_objtype[number] == SITE:
            bodies = [int(m.site_bodyid[end]) for end in ends]
        elif kind in (CONNECT, WELD):
            bodies = list(ends)
        yield Equality(number, ends, bodies)


def loops_of(m: Any, robot: Robot, equalities: Sequence[Equality]) -> Iterator[Loop]:
    """The loops that connect and weld equalities close, where MuJoCo holds them."""
    ground = Frame("world", -1, np.eye(3), np.zeros(3), "link")
    for equality in equalities:
        kind = int(m.eq_type[equality.number])
        if kind > WELD:
            continue
        links: list[Frame] = []
        for body in equality.bodies:
            links.append(robot.frames[m.body(body).name] if body else ground)
        bodies = links[0].body, links[1].body
        if bodies[0] == bodies[1]:  # fixed to one another already
            continue
        ends: list[pin.SE3] = []
        names: list[str] = []
        for link, held in zip(links, _held_frames(m, equality), strict=True):
            ends.append(pin.SE3(link.rotation, link.offset) * held)
            names.append(robot.bodies[link.body].name if link.body >= 0 else ground.name)
        torque_scale = m.eq_data[equality.number, 10]
        first, second = ends
        yield Loop(
            name="–".join(names),
            bodies=bodies,
            points=(read_only(first.translation), read_only(second.translation)),
            rotations=(read_only(first.rotation), read_only(second.rotation)),
            axes=np.eye(3),
            holds_orientation=bool(kind == WELD and torque_scale != 0.0),
        )


def _held_frames(m: Any, equality: Equality) -> tuple[pin.SE3, pin.SE3]:
    """The frames that a connect or weld holds together, each in the frame of its body."""
    first, second = equality.ends
    if m.eq_objtype[equality.number] == SITE:
        return (
            frame_at(m.site_pos[first], m.site_quat[first]),
            frame_at(m.site_pos[second], m.site_quat[second]),
        )
    data = np.array(m.eq_data[equality.number])
    if m.eq_type[equality.number] == WELD:
        # Its data: the anchor in body 2, then the position and quaternion of body 2 in body 1.
        return frame_at(data[3:6], data[6:10]), pin.SE3(np.eye(3), data[:3])
    # Data of a connect: the anchor in body 1, then in body 2.
    return pin.SE3(np.eye(3), data[:3]), pin.SE3(np.eye(3), data[3:6])


def mimics_of(m: Any, equalities: Sequence[Equality]) -> tuple[Mimic, ...]:
    """The joints that equalities of joints and tendons couple.

    x₁ − x₁₀ = a₀ + a₁ (x₂ − x₂₀), where x is the value of a joint, or the length of a fixed
    tendon, which is a sum of multiples of such values. Without x₂ the right side is a₀.

    Raises:
        RobotError: an equality is not of this form, or all its joints follow others already.
    """
    mimics: list[Mimic] = []
    for equality in equalities:
        if m.eq_type[equality.number] >= JOINT:
            followers = {mimic.joint for mimic in mimics}
            mimics.append(_mimic(m, equality, followers))
    return tuple(mimics)


def _mimic(m: Any, equality: Equality, followers: set[str]) -> Mimic:
    """One equality, solved for a joint that does not follow yet.

    Of those joints, one of the first object is taken before others, then the largest multiple.
    """
    kind = int(m.eq_type[equality.number])
    name = m.equality(equality.number).name
    title = f'the equality "{name}"' if name else "the equality"
    offset, slope = _line(m, equality, title)

    # Σ multiple · q = constant, by joint
    multiples: dict[str, float] = {}
    constant = offset
    for end, factor in zip(equality.ends, (1.0, -slope), strict=True):
        for joint, multiple in (_terms(m, kind, end) or {}).items():
            joint_name = m.joint(joint).name
            multiples[joint_name] = multiples.get(joint_name, 0.0) + factor * multiple
            constant += factor * multiple * float(m.qpos0[m.jnt_qposadr[joint]])

    acting = {name: multiple for name, multiple in multiples.items() if multiple}
    free = [name for name in acting if name not in followers]
    if not free:
        raise RobotError(
            f"{title} couples {listed(multiples)}, but each of these follows already, and a joint "
            f'can follow only once; set active="false" on one of them to do without it',
            joints=multiples,
        )
    of_first = {m.joint(joint).name for joint in _terms(m, kind, equality.ends[0]) or ()}
    follower = max(free, key=lambda name: (name in of_first, abs(multiples[name])))
    divisor = acting.pop(follower)
    leaders = {name: -multiple / divisor for name, multiple in acting.items()}
    return Mimic(follower, leaders, constant / divisor)


def _line(m: Any, equality: Equality, title: str) -> tuple[float, float]:
    """Offset a₀ and slope a₁ of an equality of joints or fixed tendons; others are refused."""
    kind = int(m.eq_type[equality.number])
    if kind > TENDON or any(_terms(m, kind, end) is None for end in equality.ends):
        raise RobotError(
            f"{title} couples tendons that are not fixed, or flexible parts, but only connect, "
            'weld, joint and fixed tendons can be computed; set active="false" to leave it out'
        )
    polynomial = [float(value) for value in m.eq_data[equality.number, :5]]
    if any(polynomial[2:]) and equality.ends[1] >= 0:
        curve = " ".join(f"{a:g}" for a in polynomial)
        raise RobotError(
            f"{title} couples joints by a curve, polycoef {curve}; only proportion can be "
            f"computed: give it as a0 a1 0 0 0, the slope at the posture of interest"
        )
    return polynomial[0], polynomial[1]


def _terms(m: Any, kind: int, number: int) -> dict[int, float] | None:
    """The multiple of each joint in an object of an equality, by the joint's number.

    Empty without an object; None of a tendon that is not fixed.
    """
    if number < 0:
        return {}
    if kind == JOINT:
        return {number: 1.0}
    first = m.tendon_adr[number]
    wraps = range(first, first + m.tendon_num[number])
    if any(m.wrap_type[wrap] != WRAPPED_JOINT for wrap in wraps):
        return None
    return {int(m.wrap_objid[wrap]): float(m.wrap_prm[wrap]) for wrap in wraps}
