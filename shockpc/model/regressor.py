"""How the inertia depends on the inertial parameters: H(q) a is linear in them, so its derivative is one matrix, the regressor."""

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.record import Robot

__all__ = ["INERTIA_ENTRIES", "inertia_regressor", "parameter_directions"]

INERTIA_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""The entries of an inertia by row and column; those off the diagonal stand for both of their places."""


def inertia_regressor(robot: Robot, q: Array, a: Array) -> Array:
    """The derivative (nv, nb, 10) of H(q) a with respect to the inertial parameters of every body.

    The parameters of a body are its mass, its first moment m c (3) and the six entries of its inertia about the origin of its
    joint's frame, in the axes of that frame and in Pinocchio's order.

    Args:
        robot: the robot.
        q: (nq,) configuration.
        a: (nv,) any joint velocities.
    """
    model = robot.model.copy()
    model.gravity = pin.Motion.Zero()
    found = pin.computeJointTorqueRegressor(model, model.createData(), q, np.zeros(model.nv), a)
    return np.asarray(found, dtype=float).reshape(model.nv, len(robot.bodies), 10)


def parameter_directions(robot: Robot, body: int) -> Array:
    """How (10, 11) the parameters of `inertia_regressor` change with quantities that a designer knows.

    Columns: mass alone, as of a point at the centre of mass [kg]; mass and inertia in proportion [1]; position of the centre of
    mass along x, y and z of the body's frame [m]; `INERTIA_ENTRIES` about the centre of mass, axes of the body's frame [kg m²].
    """
    own, rotation = robot.model.inertias[robot.bodies[body].joint], robot.bodies[body].rotation
    m, c, zero = float(own.mass), np.array(own.lever), np.zeros((3, 3))

    def parameters(mass: float, lever: Array, inertia: Array) -> Array:
        return np.asarray(pin.Inertia(mass, lever, inertia).toDynamicParameters())

    columns = [parameters(1.0, c, zero), own.toDynamicParameters()]
    # They are quadratic in the centre of mass, so a central difference is the derivative.
    columns += [(parameters(m, c + axis, zero) - parameters(m, c - axis, zero)) / 2.0 for axis in rotation.T]
    for i, j in INERTIA_ENTRIES:
        entry = np.outer(rotation[:, i], rotation[:, j])
        columns.append(parameters(0.0, np.zeros(3), entry if i == j else entry + entry.T))
    return np.stack(columns, axis=1)
