"""What of a foot carries: soles whose corners push or leave the ground, against an independent solution."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import nnls
from standing import soles

from shockpc import Scene, shock_profile
from shockpc.core.corners import corner_impulse, nonnegative_least_squares
from shockpc.landing.joint_options import Joints
from shockpc.landing.scene import Contact
from shockpc.landing.strike import Strike
from shockpc.robot.load import load_robot

SOLE = np.array([(x, y, -0.09) for x in (-0.08, 0.14) for y in (-0.045, 0.045)])
"""Corners of the soles of the biped of `standing.soles`, in the frame of the foot [m]."""


@pytest.fixture(scope="module")
def biped(tmp_path_factory):
    """A biped whose feet are boxes on ankles that pitch and roll."""
    return load_robot(soles(tmp_path_factory.mktemp("robots"), "biped"))


def unilateral(robot, q, corners, velocity, locked=(), restitution=0.0):
    """The jump (nv,) of a robot that lands on corners which push or leave the ground, from Pinocchio's inertia and Jacobians.

    Each foot sticks along the ground and does not twist about the vertical. Those rows are eliminated, and SciPy finds the pushes.

    Args:
        robot: the robot.
        q: (nq,) its posture.
        corners: (n, 3) of each foot by the name of its frame, in the frame [m].
        velocity: (3,) before the impact [m/s].
        locked: joints that hold.
        restitution: along the normal.
    """
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    H = pin.crba(model, data, q)
    H = np.triu(H) + np.triu(H, 1).T
    before = np.zeros(model.nv)
    before[:3] = data.oMf[model.getFrameId(robot.links[0])].rotation.T @ velocity
    held, rising = [], []
    for name, points in corners.items():
        frame = model.getFrameId(name)
        place = data.oMf[frame]
        J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        at = [J[:3] - pin.skew(place.rotation @ point) @ J[3:] for point in points]
        held += [at[0][0], at[0][1], J[5]]
        rising += [rows[2] for rows in at]
    free = [k for k in range(model.nv) if not any(model.joints[model.getJointId(name)].idx_v == k for name in locked)]
    F, C = np.array(held)[:, free], np.array(rising)[:, free]
    L = np.linalg.cholesky(H[np.ix_(free, free)])
    # In the metric of the kinetic energy the jump is x = F̃ᵀ f + C̃ᵀ y.
    F, C = np.linalg.solve(L, F.T), np.linalg.solve(L, C.T)
    start = L.T @ before[free]
    stopped = np.linalg.lstsq(F.T, -(F.T @ start), rcond=None)[0]
    Q = np.linalg.qr(F)[0]
    across = C - Q @ (Q.T @ C)
    missing = (1.0 + restitution) * (C.T @ start) - C.T @ start + C.T @ (start + stopped)
    # y minimizes ½ yᵀ (across' across) y + missing · y; a vector with those products with the columns stands for it.
    target = np.linalg.lstsq(across.T, -missing, rcond=None)[0]
    y, _ = nnls(across, target)
    u = across.T @ across @ y + missing
    size = np.abs(missing).max()
    assert y.min() >= 0.0
    assert u.min() >= -1e-9 * size
    assert abs(y @ u) <= 1e-9 * size * max(y.max(), 1.0)
    jump = np.zeros(model.nv)
    jump[free] = np.linalg.solve(L.T, stopped + across @ y)
    return jump


def landed(robot, feet, **scene):
    """The profile of a landing on some feet."""
    return shock_profile(Scene(robot=robot.label, contact=tuple(Contact(frame=foot) for foot in feet), **scene), robot)


ROLLS = ("left_ankle_roll", "right_ankle_roll")
PITCH = "left_ankle_pitch"
LANDINGS = {
    "flat": (("left_foot",), (), (0.0, 0.0, -1.0), ("flat",)),
    "both flat": (("left_foot", "right_foot"), (), (0.0, 0.0, -1.0), ("flat", "flat")),
    "edge": (("left_foot",), ROLLS, (0.0, 0.0, -1.0), ("edge",)),
    "both with locked rolls": (("left_foot", "right_foot"), ROLLS, (0.0, 0.0, -1.0), ("flat", "flat")),
    "corner": (("left_foot",), (*ROLLS, PITCH, "left_knee"), (0.8, 0.0, -1.0), ("corner",)),
    "oblique": (("left_foot", "right_foot"), ROLLS, (0.5, 0.4, -1.0), None),
}


@pytest.mark.parametrize("case", LANDINGS)
def test_the_face_that_carries_has_the_jump_of_corners_that_push_or_leave_the_ground(biped, case):
    feet, locked, velocity, kinds = LANDINGS[case]
    profile = landed(biped, feet, joints=Joints(locked=locked), strike=Strike(velocity=velocity))
    expected = unilateral(biped, profile.q, dict.fromkeys(feet, SOLE), np.array(velocity), locked)
    np.testing.assert_allclose(profile.delta_qd, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    if kinds is not None:
        assert tuple(contact.kind for contact in profile.scene.contact) == kinds


def test_permuted_and_doubled_corners_leave_the_ground_at_the_same_speeds():
    """The pushes are not unique with four corners; the speeds and the impulse along the rows are."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        X, free, b = rng.normal(size=(12, 6)), np.eye(6)[:, :3], rng.normal(size=6)
        places = rng.uniform(-0.1, 0.1, size=(4, 2))
        corners = np.zeros((6, 4))
        corners[3], corners[4:] = 1.0, places.T
        order = rng.integers(0, 4, size=9)
        order[:4] = rng.permutation(4)
        once, again = corner_impulse(X, b, free, corners), corner_impulse(X, b, free, corners[:, order])
        np.testing.assert_allclose(again.speed, once.speed[order], atol=1e-10)
        np.testing.assert_allclose(again.impulse, once.impulse, atol=1e-10)
        assert min(once.push.min(), once.speed.min()) >= -1e-12
        assert once.push @ once.speed == pytest.approx(0.0, abs=1e-12)


def test_least_squares_without_negative_unknowns_agree_with_scipy():
    rng = np.random.default_rng(3)
    for _ in range(50):
        B, d = rng.normal(size=(8, 6)), rng.normal(size=8)
        B /= np.linalg.norm(B, axis=0)
        np.testing.assert_allclose(nonnegative_least_squares(B, d), nnls(B, d)[0], atol=1e-12)
