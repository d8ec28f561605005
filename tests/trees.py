"""Random mechanisms, drawn as bodies and joints in the world and only then hung on a root.

A mechanism knows no root, no link frames and no joint values: those are choices of whoever writes
it down as a file. So the same one can be written in many ways, and `least_energy_jump` answers for
it without any of them.
"""

import functools
import os
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from hypothesis import strategies as st

from shockpc import Contact, Posture, Robot, Scene, ShockProfile, Strike, load_robot, shock_profile
from shockpc.core.spatial import cross_matrix

URDF_KINDS = ("revolute", "continuous", "prismatic")
MJCF_KINDS = ("revolute", "prismatic", "spherical", "planar")
STICKS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
SLIDES = ((0.0, 0.0, 1.0),)


class Joint(NamedTuple):
    """A joint between bodies a and b: its kind, a point on it [m] and its axis, in the world."""

    a: int
    b: int
    kind: str
    point: np.ndarray
    axis: np.ndarray


class Mechanism(NamedTuple):
    """Bodies in the world: masses (n,), centres of mass (n, 3), inertias about them (n, 3, 3), and
    the joints of a tree.
    """

    mass: np.ndarray
    com: np.ndarray
    inertia: np.ndarray
    joints: tuple[Joint, ...]


class Hit(NamedTuple):
    """A point of a body, in the world, that the ground stops along some directions."""

    body: int
    point: np.ndarray
    directions: tuple[tuple[float, ...], ...] = STICKS
    restitution: float = 0.0


class Landing(NamedTuple):
    """A mechanism, what strikes, and how fast (3,) [m/s]."""

    mechanism: Mechanism
    hits: tuple[Hit, ...]
    strike: np.ndarray


class Written(NamedTuple):
    """A mechanism as a file: its text, and the posture in which it stands as drawn."""

    text: str
    posture: Posture
    origins: np.ndarray
    rotations: np.ndarray


# Drawing


@st.composite
def mechanisms(draw, kinds=URDF_KINDS, most=15, planar=False, decades=1.5):
    """Trees of 1 to `most` bodies with masses over 2 · `decades` decades; a planar one lies in x–z
    and turns about y.
    """
    n = draw(st.integers(1, most))
    parents = [draw(st.integers(0, i - 1)) for i in range(1, n)]
    chosen = [draw(st.sampled_from(kinds)) for _ in parents]
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return random_mechanism(rng, parents, chosen, planar, decades)


def random_mechanism(rng, parents, kinds, planar=False, decades=1.5):
    n = len(parents) + 1
    flat = np.array([1.0, 0.0, 1.0]) if planar else np.ones(3)
    mass = 10.0 ** rng.uniform(-decades, decades, n)
    sides = 10.0 ** rng.uniform(-1.2, 0.0, (n, 3))
    com = np.zeros((n, 3))
    joints = []
    for i, (parent, kind) in enumerate(zip(parents, kinds, strict=True), start=1):
        point = com[parent] + flat * rng.normal(0.0, 0.3, 3)
        com[i] = point + flat * rng.normal(0.0, 0.3, 3)
        axis = rng.normal(size=3)
        if planar:
            axis = flat * axis if kind == "prismatic" else np.array([0.0, 1.0, 0.0])
        joints.append(Joint(parent, i, kind, point, axis / np.linalg.norm(axis)))
    turn = np.broadcast_to(np.eye(3), (n, 3, 3)) if planar else random_rotations(rng, n)
    moments = mass[:, None] / 12.0 * (np.sum(sides**2, axis=1, keepdims=True) - sides**2)
    inertia = turn @ (moments[:, :, None] * np.swapaxes(turn, -1, -2))
    return Mechanism(mass, com, inertia, tuple(joints))


def random_rotations(rng, n):
    return np.stack(
        [pin.Quaternion(*(q / np.linalg.norm(q))).matrix() for q in rng.normal(size=(n, 4))]
    )


@st.composite
def landings(
    draw,
    kinds=URDF_KINDS,
    most=15,
    planar=False,
    hits=3,
    sticking=False,
    restitution=True,
    decades=1.5,
):
    """Landings on 1 to `hits` points, all with one restitution, sticking, sliding or stopped along
    a slanted direction.
    """
    mechanism = draw(mechanisms(kinds, most, planar, decades))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    flat = np.array([1.0, 0.0, 1.0]) if planar else np.ones(3)
    e = draw(st.sampled_from((0.0, 0.3, 1.0))) if restitution else 0.0
    ways = (STICKS,) if sticking else (STICKS, SLIDES, ((0.6, 0.0, 0.8),))
    struck = []
    for _ in range(draw(st.integers(1, hits))):
        body = draw(st.integers(0, len(mechanism.mass) - 1))
        point = mechanism.com[body] + flat * rng.normal(0.0, 0.3, 3)
        struck.append(Hit(body, point, draw(st.sampled_from(ways)), e))
    strike = flat * np.array([*rng.uniform(-1.0, 1.0, 2), -rng.uniform(0.2, 1.0)])
    return Landing(mechanism, tuple(struck), strike)


# Writing it down as a file, loading it and letting it land


def neighbours(mechanism, root):
    """(body, parent, joint) of every body but the root, parents first."""
    order, seen = [], {root}
    waiting = [root]
    while waiting:
        here = waiting.pop(0)
        for joint in mechanism.joints:
            there = {joint.a: joint.b, joint.b: joint.a}.get(here)
            if there is not None and there not in seen:
                seen.add(there)
                waiting.append(there)
                order.append((there, here, joint))
    return order


def written(mechanism, root=0, seed=0, dialect="urdf", mimics=()):
    """The mechanism hung on `root`, with link frames and joint values that do not matter, drawn
    from the seed.

    Args:
        mechanism: bodies and joints.
        root: body that becomes the base.
        seed: of the link frames and joint values.
        dialect: "urdf" or "mjcf".
        mimics: (follower, leader, multiplier) of joints that follow others, by the bodies that they
            carry; URDF only.
    """
    rng = np.random.default_rng(seed)
    n = len(mechanism.mass)
    R = random_rotations(rng, n)
    x = np.array(mechanism.com)
    x[root] += rng.normal(0.0, 0.3, 3)
    order = neighbours(mechanism, root)
    for body, _, joint in order:
        x[body] = joint.point
    joints, values = [], {}
    for body, parent, joint in order:
        value = 0.0 if joint.kind in ("spherical", "planar") else rng.uniform(-1.5, 1.5)
        axis = R[body].T @ joint.axis
        turned = pin.exp3(axis * value) if joint.kind in ("revolute", "continuous") else np.eye(3)
        rotation = R[parent].T @ R[body] @ turned.T
        slid = joint.axis * value if joint.kind == "prismatic" else np.zeros(3)
        joints.append(
            (body, parent, joint.kind, R[parent].T @ (x[body] - slid - x[parent]), rotation, axis)
        )
        if joint.kind not in ("spherical", "planar"):
            values[f"joint{body}"] = value
    follows = {
        follower: (
            leader,
            multiplier,
            values.pop(f"joint{follower}") - multiplier * values[f"joint{leader}"],
        )
        for follower, leader, multiplier in mimics
    }
    com = [R[i].T @ (mechanism.com[i] - x[i]) for i in range(n)]
    inertia = [R[i].T @ mechanism.inertia[i] @ R[i] for i in range(n)]
    bodies = (mechanism.mass.tolist(), com, inertia)
    text = (
        _mjcf(root, joints, *bodies) if dialect == "mjcf" else _urdf(root, joints, follows, *bodies)
    )
    quaternion = tuple(float(c) for c in pin.Quaternion(R[root]).coeffs())
    posture = Posture(
        base_position=tuple(x[root].tolist()), base_quaternion=quaternion, joints=values
    )
    return Written(text, posture, x, R)


def _numbers(values):
    return " ".join(repr(float(value)) for value in values)


def _urdf(root, joints, follows, mass, com, inertia):
    lines = ['<robot name="tree">']
    for i in [root, *(joint[0] for joint in joints)]:
        (xx, xy, xz), (_, yy, yz), (*_, zz) = inertia[i].tolist()
        lines.append(
            f'<link name="body{i}"><inertial><origin xyz="{_numbers(com[i])}"/><mass '
            f'value="{mass[i]!r}"/>'
            f'<inertia ixx="{xx!r}" ixy="{xy!r}" ixz="{xz!r}" iyy="{yy!r}" iyz="{yz!r}" '
            f'izz="{zz!r}"/></inertial></link>'
        )
    for body, parent, kind, offset, rotation, axis in joints:
        limit = (
            "" if kind == "continuous" else '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
        )
        if body in follows:
            leader, multiplier, start = follows[body]
            limit += (
                f'<mimic joint="joint{leader}" multiplier="{multiplier!r}" offset="{start!r}"/>'
            )
        lines.append(
            f'<joint name="joint{body}" type="{kind}"><parent link="body{parent}"/><child '
            f'link="body{body}"/>'
            f'<origin xyz="{_numbers(offset)}" rpy="{_numbers(pin.rpy.matrixToRpy(rotation))}"/>'
            f'<axis xyz="{_numbers(axis)}"/>{limit}</joint>'
        )
    return "\n".join([*lines, "</robot>"])


def _mjcf(root, joints, mass, com, inertia):
    children = {}
    for joint in joints:
        children.setdefault(joint[1], []).append(joint)
    kinds = {"revolute": "hinge", "prismatic": "slide", "spherical": "ball", "planar": ""}

    def body(i, opening):
        (xx, xy, xz), (_, yy, yz), (*_, zz) = inertia[i].tolist()
        full = _numbers((xx, yy, zz, xy, xz, yz))
        inner = [
            f'{opening}<inertial pos="{_numbers(com[i])}" mass="{mass[i]!r}" fullinertia="{full}"/>'
        ]
        for child, _, kind, offset, rotation, axis in children.get(i, []):
            x, y, z, w = pin.Quaternion(rotation).coeffs()
            head = (
                f'<body name="body{child}" pos="{_numbers(offset)}" '
                f'quat="{_numbers((w, x, y, z))}">'
            )
            across = np.linalg.svd(axis[None])[2][1:]
            parts = (
                [("slide", across[0]), ("slide", across[1]), ("hinge", axis)]
                if kind == "planar"
                else [(kinds[kind], axis)]
            )
            for letter, (name, along) in zip(
                "abc" if kind == "planar" else ("",), parts, strict=True
            ):
                head += f'<joint name="joint{child}{letter}" type="{name}"'
                head += "/>" if kind == "spherical" else f' axis="{_numbers(along)}"/>'
            inner.append(body(child, head))
        return "\n".join([*inner, "</body>"])

    tree = body(root, f'<body name="body{root}"><freejoint name="base"/>')
    return f'<mujoco model="tree"><compiler angle="radian"/><worldbody>{tree}</worldbody></mujoco>'


def robot_from(text: str, suffix: str = ".urdf", **files: str) -> Robot:
    """Load a robot from the text of its file; `files` (srdf=…) lie beside it while it is read."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"robot{suffix}"
        path.write_text(text)
        beside = {kind: Path(folder) / f"robot.{kind}" for kind in files}
        for kind, content in files.items():
            beside[kind].write_text(content)
        return load_robot(
            os.fspath(path), **{kind: os.fspath(place) for kind, place in beside.items()}
        )


def scene_of(landing, file, **changes):
    """The scene in which the written file lands as drawn."""
    contacts = tuple(
        Contact(
            frame=f"body{hit.body}",
            offset=tuple(
                float(r) for r in file.rotations[hit.body].T @ (hit.point - file.origins[hit.body])
            ),
            directions=hit.directions,
            restitution=hit.restitution,
            restitution_along="directions",
        )
        for hit in landing.hits
    )
    strike = Strike(velocity=tuple(float(v) for v in landing.strike))
    given = {"base": "free", "posture": file.posture, "strike": strike, "contact": contacts}
    return Scene(robot="tree.urdf", **(given | changes))


def land(landing, root=0, seed=0, dialect="urdf", **changes) -> ShockProfile:
    """The profile of a landing, written down in one of its many ways."""
    file = written(landing.mechanism, root, seed, dialect)
    robot = robot_from(file.text, ".xml" if dialect == "mjcf" else ".urdf")
    return shock_profile(scene_of(landing, file, **changes), robot)


# Reading it back, in the world and by the numbers of the mechanism


def twists(profile: ShockProfile) -> np.ndarray:
    """Jump of every body's twist at its centre of mass, world axes (n, 6), in the order of the
    mechanism.
    """
    jumps = np.empty((len(profile.bodies), 6))
    for i, body in enumerate(profile.robot.bodies):
        R = profile.rotation[i]
        v = profile.delta_v[i] + np.cross(profile.delta_omega[i], body.com)
        jumps[int(body.name.removeprefix("body"))] = np.concatenate(
            [R @ profile.delta_omega[i], R @ v]
        )
    return jumps


def in_order(profile: ShockProfile, values: np.ndarray) -> np.ndarray:
    """Rows of a profile in the order of the mechanism."""
    return values[np.argsort([int(name.removeprefix("body")) for name in profile.bodies])]


def gyration(mechanism) -> np.ndarray:
    return np.sqrt(np.trace(mechanism.inertia, axis1=1, axis2=2) / 3.0 / mechanism.mass)


def motion(mechanism, jumps) -> np.ndarray:
    """Size of every twist as one velocity [m/s]: a turn counts by what it does at the radius of
    gyration.
    """
    return np.linalg.norm(jumps[..., 3:], axis=-1) + gyration(mechanism) * np.linalg.norm(
        jumps[..., :3], axis=-1
    )


def point_rows(mechanism, body, point, directions) -> np.ndarray:
    """(n, 6 nb) velocity of a body's point along some directions, over all twists at the centres of
    mass.
    """
    directions = np.asarray(directions, dtype=float)
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    rows = np.zeros((len(directions), len(mechanism.mass), 6))
    rows[:, body, :3] = -directions @ cross_matrix(point - mechanism.com[body])
    rows[:, body, 3:] = directions
    return rows.reshape(len(directions), -1)


def joint_rows(mechanism) -> np.ndarray:
    """What the joints forbid, over all twists: rows that are zero on every motion of the tree."""
    n = len(mechanism.mass)
    rows = [np.zeros((0, 6 * n))]
    for joint in mechanism.joints:
        across = np.linalg.svd(joint.axis[None])[2][1:]
        slip = point_rows(mechanism, joint.b, joint.point, STICKS) - point_rows(
            mechanism, joint.a, joint.point, STICKS
        )
        turn = np.zeros((3, n, 6))
        turn[:, joint.b, :3], turn[:, joint.a, :3] = np.eye(3), -np.eye(3)
        turn = turn.reshape(3, -1)
        match joint.kind:
            case "prismatic":
                rows += [across @ slip, turn]
            case "spherical":
                rows += [slip]
            case "planar":
                rows += [joint.axis[None] @ slip, across @ turn]
            case _:
                rows += [slip, across @ turn]
    return np.concatenate(rows)


def least_energy_jump(landing) -> np.ndarray:
    """The jump of minimum kinetic energy that meets joints and contacts (Gauss; Kelvin), as (n, 6)
    twists at the centres of mass.

    One least-squares solve over free bodies: no tree, no joint rates, no joint-space inertia.
    Minimum norm is minimum energy once every unknown is scaled by the root of its inertia.
    """
    m = landing.mechanism
    n = len(m.mass)
    root = np.zeros((6 * n, 6 * n))
    for i in range(n):
        moments, axes = np.linalg.eigh(m.inertia[i])
        root[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = axes / np.sqrt(moments) @ axes.T
        root[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = np.eye(3) / np.sqrt(m.mass[i])
    rows, asked = [joint_rows(m)], [np.zeros(len(joint_rows(m)))]
    for hit in landing.hits:
        rows.append(point_rows(m, hit.body, hit.point, hit.directions))
        speeds = (
            np.asarray(hit.directions) @ landing.strike / np.linalg.norm(hit.directions, axis=1)
        )
        asked.append(-(1.0 + hit.restitution) * speeds)
    rows, asked = np.concatenate(rows) @ root, np.concatenate(asked)
    length = np.linalg.norm(rows, axis=1)
    scaled, *_ = np.linalg.lstsq(rows / length[:, None], asked / length, rcond=1e-12)
    return (root @ scaled).reshape(n, 6)


@functools.cache
def known_robot(name: str) -> Robot:
    """A robot by its name, loaded once."""
    return load_robot(name)
