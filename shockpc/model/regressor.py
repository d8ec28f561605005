"""How the inertia depends on the inertial parameters: H(q) a is linear in them, so its derivative is one matrix, the regressor."""

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot

__all__ = ["INERTIA_ENTRIES", "inertia_regressor", "parameter_directions"]

INERTIA_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""The entries of an inertia by row and column; those off the diagonal stand for both of their places."""

PACKED = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""The same in the order in which Pinocchio stores them."""


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
    m, c, eye = float(own.mass), np.array(own.lever), np.eye(3)

    def column(mass: float, moment: Array, inertia: Array) -> Array:
        return np.array([mass, *moment, *(inertia[i, j] for i, j in PACKED)])

    mass = column(1.0, c, c @ c * eye - np.outer(c, c))
    columns = [mass, m * mass + column(0.0, np.zeros(3), np.array(own.inertia))]
    for axis in rotation.T:
        cross = np.outer(c, axis)
        columns.append(column(0.0, m * axis, m * (2.0 * (c @ axis) * eye - cross - cross.T)))
    for i, j in INERTIA_ENTRIES:
        entry = np.outer(rotation[:, i], rotation[:, j])
        columns.append(column(0.0, np.zeros(3), entry if i == j else entry + entry.T))
    return np.stack(columns, axis=1)
