"""Robots of the families: a list of links, written as a file and read back the way a user's robot is.

URDF where it can say what is needed, MJCF for ball joints and for planar ones in any plane. Numbers are written with all their
digits, so the model holds exactly what the list says (its rotations rounded by the reader).
"""

import os
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot, load_robot

__all__ = ["Link", "box", "robot_of", "rod"]

_MJCF_ONLY = ("spherical", "planar")


class Link(NamedTuple):
    """A body and the joint that it hangs on.

    Attributes:
        parent: index of the link it hangs on; −1 for the root, whose joint is the free base.
        kind: "revolute", "continuous", "prismatic", "spherical" or "planar"; of no account for the root.
        origin: (3,) of the joint in the parent's frame [m].
        axis: (3,) unit vector of the joint, parent's and link's axes alike at q = 0; normal of a planar one.
        mass: [kg]
        com: (3,) in the link's frame [m].
        inertia: (3, 3) about the centre of mass [kg m²].
        rpy: roll, pitch and yaw of the link in the parent's frame at q = 0 [rad].
    """

    parent: int
    kind: str
    origin: Array
    axis: Array
    mass: float
    com: Array
    inertia: Array
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)


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


def robot_of(links: list[Link], name: str = "tree") -> Robot:
    """Write the links as a file and load it. Link i is called "link<i>" and its joint "joint<i>"; the first link is the root.

    Raises:
        RobotError: the file holds what no robot has.
    """
    mjcf = any(link.kind in _MJCF_ONLY for link in links[1:])
    text = _mjcf(links, name) if mjcf else _urdf(links, name)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / ("robot.xml" if mjcf else "robot.urdf")
        path.write_text(text, encoding="utf-8")
        return load_robot(os.fspath(path))


def _numbers(values: Array | tuple[float, ...] | list[float]) -> str:
    """Numbers that read back the same."""
    return " ".join(repr(float(value)) for value in values)


def _urdf(links: list[Link], name: str) -> str:
    """The links as URDF text."""
    lines = [f'<robot name="{name}">']
    for i, link in enumerate(links):
        I = link.inertia  # noqa: E741 - the field's own symbol
        moments = " ".join(f'i{"xyz"[r]}{"xyz"[c]}="{float(I[r, c])!r}"' for r in range(3) for c in range(r, 3))
        lines.append(
            f'<link name="link{i}"><inertial><origin xyz="{_numbers(link.com)}"/><mass value="{float(link.mass)!r}"/>'
            f"<inertia {moments}/></inertial></link>"
        )
    for i, link in enumerate(links[1:], start=1):
        limit = "" if link.kind == "continuous" else '<limit lower="-100" upper="100" effort="1" velocity="1"/>'
        lines.append(
            f'<joint name="joint{i}" type="{link.kind}"><parent link="link{link.parent}"/><child link="link{i}"/>'
            f'<origin xyz="{_numbers(link.origin)}" rpy="{_numbers(link.rpy)}"/><axis xyz="{_numbers(link.axis)}"/>{limit}</joint>'
        )
    return "\n".join([*lines, "</robot>"])


def _mjcf(links: list[Link], name: str) -> str:
    """The links as MJCF text."""
    children: dict[int, list[int]] = {}
    for i, link in enumerate(links):
        children.setdefault(link.parent, []).append(i)

    def body(i: int) -> str:
        link = links[i]
        I = link.inertia  # noqa: E741
        full = _numbers((I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]))
        joint = '<freejoint name="base"/>' if i == 0 else _mjcf_joint(i, link)
        x, y, z, w = pin.Quaternion(pin.rpy.rpyToMatrix(*link.rpy)).coeffs()
        head = f'<body name="link{i}" pos="{_numbers(link.origin)}" quat="{_numbers((w, x, y, z))}">'
        inertial = f'<inertial pos="{_numbers(link.com)}" mass="{float(link.mass)!r}" fullinertia="{full}"/>'
        return "\n".join([head, joint, inertial, *(body(child) for child in children.get(i, [])), "</body>"])

    return f'<mujoco model="{name}"><compiler angle="radian"/><worldbody>{body(0)}</worldbody></mujoco>'


def _mjcf_joint(i: int, link: Link) -> str:
    """A joint as MJCF writes it; a planar one as two slides and a hinge."""
    if link.kind == "spherical":
        return f'<joint name="joint{i}" type="ball"/>'
    if link.kind != "planar":
        kind = "slide" if link.kind == "prismatic" else "hinge"
        return f'<joint name="joint{i}" type="{kind}" axis="{_numbers(link.axis)}"/>'
    first = np.cross(link.axis, np.eye(3)[np.argmin(np.abs(link.axis))])
    first /= np.linalg.norm(first)
    parts = (("slide", first), ("slide", np.cross(link.axis, first)), ("hinge", link.axis))
    return "".join(
        f'<joint name="joint{i}{letter}" type="{kind}" axis="{_numbers(axis)}"/>'
        for letter, (kind, axis) in zip("abc", parts, strict=True)
    )
