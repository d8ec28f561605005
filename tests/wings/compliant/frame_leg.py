"""The leg of frame elements until its foot lifts, a second time: by the modes of leg and spring
together, sampled.
"""

import numpy as np
from scipy.linalg import eigh

from shockpc.wings.compliant.beyond.frame_leg import ROTOR, frame_leg


def modes(K, M):
    """Frequencies [rad/s], from the lowest, and shapes of unit modal mass."""
    squares, shapes = eigh(K, M)
    return np.sqrt(np.maximum(squares, 0.0)), shapes


def first_frequency():
    """Of the free leg [Hz]; it has five motions without deformation: x, z, and three angles."""
    leg = frame_leg()
    return modes(leg.K, leg.M)[0][5] / 2.0 / np.pi


def strike(stiffness, samples=4000):
    """Of a strike at 1 m/s the time at which the foot lifts [s], and until then the peaks of its
    force and of the knee's torque.
    """
    leg = frame_leg()
    omega, shapes = modes(leg.K + stiffness * leg.foot.T @ leg.foot, leg.M)
    amplitude = shapes.T @ leg.M @ leg.falling
    t = np.linspace(0.0, 2.0 * np.pi * np.sqrt(2.0 / stiffness), samples)
    swing = np.where(
        omega > 1.0, np.sin(np.outer(t, omega)) / np.where(omega > 1.0, omega, 1.0), t[:, None]
    )
    force = -stiffness * (swing * amplitude) @ (leg.foot @ shapes).T
    lifts = int(np.argmax((force[:, 1] < 0.0) & (t > 0.0)))
    torque = ROTOR * (-np.sin(np.outer(t, omega)) * omega * amplitude) @ (leg.knee @ shapes)
    return t[lifts], np.linalg.norm(force[:lifts], axis=1).max(), np.abs(torque[:lifts]).max()
