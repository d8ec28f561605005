"""Planar mechanisms of slender beams, solved to fifty digits: lengths, masses and angles in, the jump of every beam out.

Maximal coordinates: each beam has three velocities of its own, and hinges and contacts are rows. Nothing here knows of trees,
joint-space inertia or robot files. x points right, z up, and angles count counter-clockwise on the page.
"""

from typing import NamedTuple

import mpmath
import numpy as np
from mpmath import mp, mpf

mp.dps = 50


class Beam(NamedTuple):
    """A slender uniform beam between two points.

    Attributes:
        start: one end [m].
        end: the other [m].
        mass: [kg].
    """

    start: tuple
    end: tuple
    mass: mpf

    @property
    def com(self):
        return tuple((a + b) / 2 for a, b in zip(self.start, self.end, strict=True))

    @property
    def inertia(self):
        return self.mass * sum((a - b) ** 2 for a, b in zip(self.start, self.end, strict=True)) / 12


def pointing(angle_deg):
    """The unit vector at that angle from straight down."""
    angle = mpf(angle_deg) * mp.pi / 180
    return mpmath.sin(angle), -mpmath.cos(angle)


def beam(start, angle_deg, length, mass):
    """A beam from a point, pointing at an angle from straight down."""
    d = pointing(angle_deg)
    return Beam(tuple(start), tuple(s + mpf(length) * u for s, u in zip(start, d, strict=True)), mpf(mass))


def at(one: Beam, share):
    """The point of a beam at a share of its length."""
    return tuple(a + mpf(share) * (b - a) for a, b in zip(one.start, one.end, strict=True))


def solve(beams, hinges, contacts, strike, rotors=()):
    """Jump (ω, v_x, v_z at the centre of mass) of every beam.

    Args:
        beams: the bodies.
        hinges: (body, body, point) each.
        contacts: (body, point, directions) each; what strikes there stops along these.
        strike: velocity of everything before the impact [m/s].
        rotors: (body, body, inertia): a rotor on the second that turns with the first.
    """
    n = len(beams)
    M = mpmath.zeros(3 * n)
    for i, one in enumerate(beams):
        M[3 * i, 3 * i], M[3 * i + 1, 3 * i + 1], M[3 * i + 2, 3 * i + 2] = one.inertia, one.mass, one.mass
    for i, j, inertia in rotors:
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            M[3 * a, 3 * b] += sign * mpf(inertia)
    rows, undone = [], []

    def row(body, point, direction, sign, into):
        x, z = (p - c for p, c in zip(point, beams[body].com, strict=True))
        into[3 * body] += sign * (-z * direction[0] + x * direction[1])
        into[3 * body + 1] += sign * direction[0]
        into[3 * body + 2] += sign * direction[1]

    for i, j, point in hinges:
        for direction in ((1, 0), (0, 1)):
            one = [mpf(0)] * (3 * n)
            row(i, point, direction, 1, one)
            row(j, point, direction, -1, one)
            rows.append(one)
            undone.append(mpf(0))
    for i, point, directions in contacts:
        for direction in directions:
            one = [mpf(0)] * (3 * n)
            row(i, point, direction, 1, one)
            rows.append(one)
            undone.append(direction[0] * strike[0] + direction[1] * strike[1])
    J = mpmath.matrix(rows)
    M_J = mpmath.inverse(M) * J.T
    impulse = mpmath.lu_solve(J * M_J, -mpmath.matrix(undone))
    jump = M_J * impulse
    return [tuple(jump[3 * i + k] for k in range(3)) for i in range(n)]


def falling(angle_deg):
    """A strike of 1 m/s, that many degrees from the vertical, positive forward."""
    return pointing(angle_deg)


STICKS = ((1, 0), (0, 1))


def difference(profile, names, jumps):
    """Largest difference between a profile and a solution, over every named body [m/s, rad/s], relative to 1 or to the rate."""
    worst = 0.0
    for name, (omega, vx, vz) in zip(names, jumps, strict=True):
        i = profile.bodies.index(name)
        R = profile.rotation[i]
        turn = R @ profile.delta_omega[i]
        v = R @ (profile.delta_v[i] + np.cross(profile.delta_omega[i], profile.robot.bodies[i].com))
        # Counter-clockwise on the page is about −y.
        found = np.array([-turn[1], v[0], v[2]])
        expected = np.array([float(omega), float(vx), float(vz)])
        across = np.abs([turn[0], turn[2], v[1]]).max()
        worst = max(worst, float(np.max(np.abs(found - expected) / np.maximum(1.0, np.abs(expected)))), float(across))
    return worst
