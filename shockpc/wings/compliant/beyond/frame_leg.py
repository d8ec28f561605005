"""A planar leg of two tubes in frame elements of Euler and Bernoulli.

It has a trunk, a thigh and a shank, with a rotor in each joint.

Between two nodes a tube stretches and bends with cubic shapes; mass and stiffness are those of its
shapes, nothing is lumped.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

TRUNK, TRUNK_INERTIA, ROTOR = 5.0, 0.05, 5e-3
"""Mass [kg] and moment of inertia of the trunk, and inertia of each rotor [kg m²].

The moment is that at the hip; the rotor's inertia is that behind its gear.
"""

LENGTH, OUTER, INNER, YOUNG, DENSITY = 0.2, 0.025, 0.021, 70e9, 2700.0
"""Length, diameters, Young's modulus and density of each tube, of aluminium [m, Pa, kg/m³]."""

AREA, SECOND = np.pi / 4.0 * (OUTER**2 - INNER**2), np.pi / 64.0 * (OUTER**4 - INNER**4)
EI, EA, MASS = YOUNG * SECOND, YOUNG * AREA, DENSITY * AREA * LENGTH
"""Stiffness of each tube against bending [N m²] and stretch [N], and its mass [kg]."""

ANGLES = 0.6, -0.7
"""Angles of thigh and shank, from straight down towards −x [rad]."""

ELEMENTS = 12
"""Number of elements of each tube."""


OF_BENDING = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
OF_INERTIA = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
"""Stiffness and inertia of a beam element, in EI/L³ and m/420.

They are in its displacements across and its angles at both ends.
"""


class FrameLeg(NamedTuple):
    """The leg in n coordinates: trunk (x, z, angle), then the nodes of the tubes.

    The tubes share x and z at hip and knee.

    Attributes:
        M: (n, n) inertia.
        K: (n, n) stiffness.
        foot: (2, n) the foot's x and z.
        knee: (n,) the angle between shank and thigh.
        falling: (n,) velocities with which all of it moves down with unit speed.
    """

    M: Array
    K: Array
    foot: Array
    knee: Array
    falling: Array


def frame_leg(rotor: float = ROTOR) -> FrameLeg:
    """The leg. Args: rotor, inertia of each rotor behind its gear [kg m²]."""
    # Nodes along thigh and shank: x, z and angle each; the angle at a joint is the tube's own.
    m = 3 * ELEMENTS
    thigh = [[0, 1, 3], *_nodes(4)]
    hinge, first = thigh[-1], 4 + m
    shank = [[hinge[0], hinge[1], first], *_nodes(first + 1)]
    n = first + 1 + m
    M, K, turns = np.zeros((n, n)), np.zeros((n, n)), np.zeros((2, n))
    M[0, 0] = M[1, 1] = TRUNK
    M[2, 2] = TRUNK_INERTIA
    # Rotors of hip and knee turn by the angles between what they join.
    turns[0, 2], turns[0, 3] = -1.0, 1.0
    turns[1, hinge[2]], turns[1, first] = -1.0, 1.0
    M += rotor * turns.T @ turns
    for nodes, angle in ((thigh, ANGLES[0]), (shank, ANGLES[1])):
        k, mass = _element(angle)
        for start, end in pairwise(nodes):
            where = np.ix_([*start, *end], [*start, *end])
            K[where] += k
            M[where] += mass
    # The leg falls with unit speed: every height of a node, and no other coordinate.
    heights = [1, *(node[1] for node in thigh[1:]), *(node[1] for node in shank[1:])]
    falling = np.zeros(n)
    falling[heights] = -1.0
    return FrameLeg(M, K, np.eye(n)[shank[-1][:2]], turns[1], falling)


def _nodes(first: int) -> list[list[int]]:
    """The coordinates x, z and angle of the further nodes of a tube, from a number on."""
    return np.arange(first, first + 3 * ELEMENTS).reshape(-1, 3).tolist()


def _element(angle: float) -> tuple[Array, Array]:
    """Stiffness and inertia (6, 6) of one element, along x and z and about y at both ends.

    Args: angle, of its tube [rad].
    """
    length, mass = LENGTH / ELEMENTS, MASS / ELEMENTS
    along = np.array([-np.sin(angle), -np.cos(angle)])
    across = np.array([np.cos(angle), -np.sin(angle)])
    # to displacements along and across the element, and angles from `along` to `across`
    turn = np.zeros((6, 6))
    for end in (0, 3):
        turn[end, end : end + 2] = along
        turn[end + 1, end : end + 2] = across
        turn[end + 2, end + 2] = -1.0
    stretch, bend = np.ix_([0, 3], [0, 3]), np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    # Angles times the length are displacements.
    scale = np.array([1.0, length, 1.0, length])
    size = np.outer(scale, scale)
    k, inertia = np.zeros((6, 6)), np.zeros((6, 6))
    # A rod, EA / l and m / 6, and a beam of Euler and Bernoulli, EI / l³ and m / 420, times
    # constant matrices.
    k[stretch] = EA / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    k[bend] = EI / length**3 * size * OF_BENDING
    inertia[stretch] = mass / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    inertia[bend] = mass / 420.0 * size * OF_INERTIA
    return turn.T @ k @ turn, turn.T @ inertia @ turn


def urdf() -> str:
    """The leg with rigid tubes, straight down."""

    def link(name: str, mass: float, z: float, about: float, along: float) -> str:
        inertia = f'<inertia ixx="{about}" iyy="{about}" izz="{along}" ixy="0" ixz="0" iyz="0"/>'
        return (
            f'<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass '
            f'value="{mass}"/>{inertia}</inertial></link>'
        )

    def joint(name: str, parent: str, child: str, z: float, kind: str = "continuous") -> str:
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        return (
            f'<joint name="{name}" type="{kind}">{ends}<origin xyz="0 0 {z}"/><axis xyz="0 1 '
            f'0"/></joint>'
        )

    tube = MASS, -LENGTH / 2.0, MASS * LENGTH**2 / 12.0, 1e-7
    return (
        '<robot name="leg">'
        + link("trunk", TRUNK, 0.0, TRUNK_INERTIA, TRUNK_INERTIA)
        + link("thigh", *tube)
        + link("shank", *tube)
        + '<link name="foot"/>'
        + joint("hip", "trunk", "thigh", 0.0)
        + joint("knee", "thigh", "shank", -LENGTH)
        + joint("ankle", "shank", "foot", -LENGTH, "fixed")
        + "</robot>"
    )
