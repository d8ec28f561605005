"""Robots of the cases: lists of links, written as URDF with all digits and loaded like a user's robot."""

import functools
import os
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot, load_robot

__all__ = ["Link", "bent", "box", "chain", "known_robot", "robot_of", "rod"]

BEND = (0.7, -0.9, 0.5, -0.3, 0.8, -0.6)


class Link(NamedTuple):
    """A body and the joint that carries it.

    Attributes:
        parent: index of the link that carries the joint; −1 for the root, whose joint is the free base.
        kind: "revolute", "continuous" or "prismatic"; not used for the root.
        origin: (3,) of the joint in the parent's frame [m].
        axis: (3,) unit vector of the joint; the axes of parent and link are parallel at q = 0.
        mass: [kg]
        com: (3,) in the link's frame [m].
        inertia: (3, 3) about the centre of mass [kg m²].
    """

    parent: int
    kind: str
    origin: Array
    axis: Array
    mass: float
    com: Array
    inertia: Array


def rod(mass: float, along: Array) -> tuple[Array, Array]:
    """Centre of mass (3,) and inertia (3, 3) of a rod from the link's origin to `along`, as thick as a fiftieth of its length."""
    length = float(np.linalg.norm(along))
    u = along / length
    across = mass * length**2 * (1.0 / 12.0 + 1.0 / 10000.0)
    return 0.5 * along, across * (np.eye(3) - np.outer(u, u)) + mass * length**2 / 5000.0 * np.outer(u, u)


def box(mass: float, sides: tuple[float, float, float]) -> Array:
    """Inertia (3, 3) of a box about its centre [kg m²]. Args: sides [m]."""
    squares = np.square(sides)
    return np.asarray(mass / 12.0 * np.diag(squares.sum() - squares))


@functools.cache
def known_robot(name: str) -> Robot:
    """A robot by its name, loaded once."""
    return load_robot(name)


def robot_of(links: list[Link], name: str = "tree") -> Robot:
    """Write the links as a file and load it. Link i is called "link<i>" and its joint "joint<i>"; the first link is the root.

    Raises:
        RobotError: the links are not a robot.
    """
    lines = [f'<robot name="{name}">']
    for i, link in enumerate(links):
        moments = " ".join(f'i{"xyz"[r]}{"xyz"[c]}="{float(link.inertia[r, c])!r}"' for r in range(3) for c in range(r, 3))
        lines.append(
            f'<link name="link{i}"><inertial><origin xyz="{_numbers(link.com)}"/><mass value="{float(link.mass)!r}"/>'
            f"<inertia {moments}/></inertial></link>"
        )
    for i, link in enumerate(links[1:], start=1):
        limit = "" if link.kind == "continuous" else '<limit lower="-100" upper="100" effort="1" velocity="1"/>'
        lines.append(
            f'<joint name="joint{i}" type="{link.kind}"><parent link="link{link.parent}"/><child link="link{i}"/>'
            f'<origin xyz="{_numbers(link.origin)}"/><axis xyz="{_numbers(link.axis)}"/>{limit}</joint>'
        )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text("\n".join([*lines, "</robot>"]), encoding="utf-8")
        return load_robot(os.fspath(path))


def _numbers(values: Array) -> str:
    """Numbers with all digits."""
    return " ".join(repr(float(value)) for value in values)


def chain(masses: Array, lengths: Array) -> Robot:
    """A chain of rods, each hinged to the end of the last; hinges turn about y, and every third about x."""
    x, y, z = np.eye(3)
    origins = [0.0 * z, *(length * z for length in lengths[:-1])]
    links = [
        Link(i - 1, "revolute", origin, x if i % 3 == 2 else y, mass, *rod(mass, length * z))
        for i, (mass, length, origin) in enumerate(zip(masses, lengths, origins, strict=True))
    ]
    return robot_of(links, "chain")


def bent(robot: Robot, scale: float = 1.0) -> Posture:
    """A chain that is bent at every joint, by angles that repeat."""
    joints = {name: scale * BEND[i % len(BEND)] for i, name in enumerate(robot.joint_names)}
    return Posture(base_rpy_deg=(0.0, 25.0, 0.0), joints=joints)
