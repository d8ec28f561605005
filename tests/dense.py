"""A second formulation of a landing: Pinocchio's inertia and Jacobians, and Eq. 4 as one dense
matrix solved by numpy.
"""

import numpy as np
import pinocchio as pin


def inertia(model, q):
    """Joint-space inertia (nv, nv), without the armature of the file."""
    model = pin.Model(model)
    model.armature = np.zeros(model.nv)
    H = pin.crba(model, model.createData(), q)
    return np.triu(H) + np.triu(H, 1).T


def point_rows(model, q, frame, offset=None):
    """Velocity (3, nv) of a point of a frame along world x, y and z, for unit joint velocities."""
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    index = model.getFrameId(frame)
    J = pin.getFrameJacobian(model, data, index, pin.LOCAL_WORLD_ALIGNED)
    offset = np.zeros(3) if offset is None else np.asarray(offset)
    return J[:3] - pin.skew(data.oMf[index].rotation @ offset) @ J[3:]


def solve(H, J, b):
    """Eq. 4 by least squares, for rows may repeat one another: the jump Δq̇, and the impulses of
    minimum norm.
    """
    n = len(H)
    whole = np.block([[H, J.T], [J, np.zeros((len(J), len(J)))]])
    found = np.linalg.lstsq(whole, np.concatenate([np.zeros((n, *b.shape[1:])), -b]), rcond=1e-12)[
        0
    ]
    return found[:n], -found[n:]


def nullspace(K):
    """Columns G (nv, ny) that span the joint velocities which rows K allow; rows may repeat one
    another.
    """
    _, s, Vt = np.linalg.svd(K)
    return Vt[int(np.sum(s > 1e-9 * s[0])) :].T


def velocity(profile, body, r):
    """Jump (3,) of the velocity of a point of a body, world axes.

    Args: body, its index; r (3,) in the body's frame.
    """
    return profile.rotation[body] @ (profile.delta_v[body] + np.cross(profile.delta_omega[body], r))


def momentum(profile, bodies=None, about=(0.0, 0.0, 0.0)):
    """Jump of the linear momentum, and of the angular momentum about a point of the world, summed
    over bodies.
    """
    linear, angular = np.zeros(3), np.zeros(3)
    for i in range(len(profile.bodies)) if bodies is None else bodies:
        body, R = profile.robot.bodies[i], profile.rotation[i]
        change = body.mass * velocity(profile, i, body.com)
        linear += change
        angular += (
            np.cross(profile.position[i] + R @ body.com - about, change)
            + R @ body.inertia @ profile.delta_omega[i]
        )
    return linear, angular


def centre_of_mass(profile):
    """Centre of mass (3,) of the robot, world."""
    places = profile.position + (profile.rotation @ profile.robot.coms[..., None])[..., 0]
    return profile.robot.masses @ places / profile.robot.masses.sum()
