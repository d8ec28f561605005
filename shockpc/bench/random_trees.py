"""Random trees and their landings.

Tree number n is the same on every machine: 1 to 30 bodies, masses over eight decades, joints of every kind, one to three contacts,
and now and then a closed loop.
"""

import numpy as np
import pinocchio as pin

from shockpc.bench.build import Link, robot_of
from shockpc.core.spatial import Array
from shockpc.model.closure import Closure, Place
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.posture import Posture, configuration
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["random_landing"]

DECADES = (-4.0, 4.0)
"""Masses lie between 1e-4 and 1e4 kg."""

KINDS = (("revolute", "continuous", "prismatic"), ("revolute", "prismatic", "spherical", "planar"))
"""Joints of even trees and of odd ones."""


def random_landing(number: int) -> tuple[Robot, Scene]:
    """Tree number n and its landing."""
    rng = np.random.default_rng([2021, number])
    # A URDF has continuous joints, an MJCF has ball joints and planar ones: every other tree is written as the one or the other.
    kinds = KINDS[number % 2]
    n = int(rng.integers(1, 31))
    links = [_link(rng, int(rng.integers(max(0, i - 3), i)) if i else -1, str(rng.choice(kinds))) for i in range(n)]
    robot = robot_of(links, f"tree{number}")
    joints = {
        name: float(rng.uniform(-1.5, 1.5))
        for name in robot.joint_names
        if robot.model.joints[robot.model.getJointId(name)].nv == 1
    }
    quaternion = tuple(float(c) for c in _unit(rng, 4))
    posture = Posture(base_quaternion=quaternion, joints=joints)  # type: ignore[arg-type]
    e = float(rng.choice((0.0, 0.0, 0.5, 1.0)))
    contacts = tuple(_contact(rng, n, e) for _ in range(int(rng.integers(1, 4))))
    strike = Strike(velocity=(float(rng.uniform(-1, 1)), float(rng.uniform(-1, 1)), -float(rng.uniform(0.2, 1.0))))
    closure = (_closure(rng, robot, posture, n),) if n > 3 and rng.random() < 0.25 else ()
    return robot, Scene(robot=f"tree{number}", posture=posture, strike=strike, contact=contacts, closure=closure)


def _unit(rng: np.random.Generator, n: int) -> Array:
    v = rng.normal(size=n)
    return np.asarray(v / np.linalg.norm(v))


def _link(rng: np.random.Generator, parent: int, kind: str) -> Link:
    """A box of random sides, anywhere within its reach."""
    mass = float(10.0 ** rng.uniform(*DECADES))
    sides = 10.0 ** rng.uniform(-1.5, 0.0, 3)
    turn = pin.Quaternion(*_unit(rng, 4)).matrix()
    moments = mass / 12.0 * (np.sum(sides**2) - sides**2)
    inertia = turn @ np.diag(moments) @ turn.T
    rpy = tuple(float(a) for a in rng.uniform(-1.5, 1.5, 3))
    origin, com = rng.normal(0.0, 0.3, 3), rng.normal(0.0, 0.2, 3)
    return Link(parent, kind, origin, _unit(rng, 3), mass, com, 0.5 * (inertia + inertia.T), rpy)  # type: ignore[arg-type]


def _contact(rng: np.random.Generator, n: int, e: float) -> Contact:
    """A point of any link, sticking, sliding, or stopped along a slant."""
    kept = (("x", "y", "z"), ("z",), ((0.6, 0.0, 0.8),))[int(rng.integers(3))]
    offset = tuple(float(x) for x in rng.normal(0.0, 0.3, 3))
    return Contact(frame=f"link{int(rng.integers(n))}", offset=offset, directions=kept, restitution=e)  # type: ignore[arg-type]


def _closure(rng: np.random.Generator, robot: Robot, posture: Posture, n: int) -> Closure:
    """Two links held together where a point of the first is: the loop is closed as drawn."""
    a, b = (int(i) for i in rng.choice(n, 2, replace=False))
    state = dynamics(robot, configuration(robot, posture)[None])
    index = {body.name: i for i, body in enumerate(robot.bodies)}
    i, j = index[f"link{a}"], index[f"link{b}"]
    point = rng.normal(0.0, 0.3, 3)
    place = state.position[0, i] + state.rotation[0, i] @ point
    other = state.rotation[0, j].T @ (place - state.position[0, j])
    ends = [tuple(float(x) for x in values) for values in (point, other)]
    return Closure(a=Place(frame=f"link{a}", offset=ends[0]), b=Place(frame=f"link{b}", offset=ends[1]))  # type: ignore[arg-type]
