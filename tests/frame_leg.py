"""A planar leg of two tubes on a spring, a second time: frame elements of Euler and Bernoulli, and modes until the foot lifts."""

from itertools import pairwise

import numpy as np
from scipy.linalg import eigh

TRUNK, TRUNK_INERTIA, ROTOR = 5.0, 0.05, 5e-3
LENGTH, OUTER, INNER, YOUNG, DENSITY = 0.2, 0.025, 0.021, 70e9, 2700.0
AREA, SECOND = np.pi / 4.0 * (OUTER**2 - INNER**2), np.pi / 64.0 * (OUTER**4 - INNER**4)
EI, EA, MASS = YOUNG * SECOND, YOUNG * AREA, DENSITY * AREA * LENGTH
ANGLES = 0.6, -0.7  # of thigh and shank from straight down, towards −x
ELEMENTS = 12


def matrices():
    """M and K of trunk (x, z, angle), then of the nodes of thigh and shank, which share x and z at the knee; rows of the foot."""
    m = 3 * ELEMENTS
    thigh = [[0, 1, 3]] + [[4 + 3 * i + c for c in range(3)] for i in range(ELEMENTS)]
    knee, first = thigh[-1], 4 + m
    shank = [[knee[0], knee[1], first]] + [[first + 1 + 3 * i + c for c in range(3)] for i in range(ELEMENTS)]
    n = first + 1 + m
    M, K = np.zeros((n, n)), np.zeros((n, n))
    M[0, 0] = M[1, 1] = TRUNK
    M[2, 2] = TRUNK_INERTIA
    for one, other in ((2, 3), (knee[2], first)):
        row = np.zeros(n)
        row[one], row[other] = -1.0, 1.0
        M += ROTOR * np.outer(row, row)
    length = LENGTH / ELEMENTS
    for nodes, angle in ((thigh, ANGLES[0]), (shank, ANGLES[1])):
        along, across = np.array([-np.sin(angle), -np.cos(angle)]), np.array([np.cos(angle), -np.sin(angle)])
        turn = np.zeros((6, 6))  # to displacements along and across the element, and angles from `along` to `across`
        for end in (0, 3):
            turn[end, end : end + 2], turn[end + 1, end : end + 2], turn[end + 2, end + 2] = along, across, -1.0
        k, mass = np.zeros((6, 6)), np.zeros((6, 6))
        a, b = [0, 3], [1, 2, 4, 5]
        k[np.ix_(a, a)] = EA / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
        mass[np.ix_(a, a)] = MASS / ELEMENTS / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        size = np.array([1.0, length, 1.0, length])
        bent = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
        moved = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
        k[np.ix_(b, b)] = EI / length**3 * bent * np.outer(size, size)
        mass[np.ix_(b, b)] = MASS / ELEMENTS / 420.0 * moved * np.outer(size, size)
        for start, end in pairwise(nodes):
            where = np.ix_([*start, *end], [*start, *end])
            K[where] += turn.T @ k @ turn
            M[where] += turn.T @ mass @ turn
    return M, K, np.eye(n)[shank[-1][:2]]


def modes(K, M):
    """Frequencies [rad/s], from the lowest, and shapes of unit modal mass."""
    squares, shapes = eigh(K, M)
    return np.sqrt(np.maximum(squares, 0.0)), shapes


def first_frequency():
    """Of the free leg [Hz]; it has five motions without deformation: x, z, and three angles."""
    M, K, _ = matrices()
    return modes(K, M)[0][5] / 2.0 / np.pi


def strike(stiffness, samples=4000):
    """Of a strike at 1 m/s the time at which the foot lifts [s], and until then the peaks of its force and of the knee's torque."""
    M, K, foot = matrices()
    omega, shapes = modes(K + stiffness * foot.T @ foot, M)
    before = np.zeros(len(M))
    before[1:2] = before[4 + 1 : 4 + 3 * ELEMENTS : 3] = before[4 + 3 * ELEMENTS + 2 :: 3] = -1.0
    amplitude = shapes.T @ M @ before
    t = np.linspace(0.0, 2.0 * np.pi * np.sqrt(2.0 / stiffness), samples)
    swing = np.where(omega > 1.0, np.sin(np.outer(t, omega)) / np.where(omega > 1.0, omega, 1.0), t[:, None])
    force = -stiffness * (swing * amplitude) @ (foot @ shapes).T
    lifts = int(np.argmax((force[:, 1] < 0.0) & (t > 0.0)))
    rotor = shapes[4 + 3 * ELEMENTS] - shapes[4 + 3 * ELEMENTS - 1]
    torque = ROTOR * (-np.sin(np.outer(t, omega)) * omega * amplitude) @ rotor
    return t[lifts], np.linalg.norm(force[:lifts], axis=1).max(), np.abs(torque[:lifts]).max()


def urdf():
    """The leg for shockpc, straight down."""

    def link(name, mass, z, about, along):
        inertia = f'<inertia ixx="{about}" iyy="{about}" izz="{along}" ixy="0" ixz="0" iyz="0"/>'
        return f'<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>{inertia}</inertial></link>'

    def joint(name, parent, child, z, kind="continuous"):
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        return f'<joint name="{name}" type="{kind}">{ends}<origin xyz="0 0 {z}"/><axis xyz="0 1 0"/></joint>'

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
