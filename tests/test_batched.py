"""The shock of a batch of states from inertias and Jacobians, as a simulator has them: against maps in doubles and profiles."""

import importlib.util

import numpy as np
import pinocchio as pin
import pytest
from test_derivatives import on
from trees import known_robot

from shockpc import Joints, resolve, shock_maps
from shockpc.core.batched import batched_shock

TORCH = importlib.util.find_spec("torch") is not None
"""Whether PyTorch is installed; the formulas are tested by NumPy in any case."""

FEET, STRIKE = ("LF_FOOT", "RH_FOOT"), np.array([0.3, 0.1, -1.0])


def shock_of(library, *arrays, **options):
    if library == "numpy":
        return batched_shock(np, *arrays, **options)
    import torch

    from shockpc.torch import shock

    found = shock(*map(torch.tensor, arrays), **{k: torch.tensor(value) for k, value in options.items()})
    return type(found)(*(part.numpy() for part in found))


def batch(joints, n=20, feet=FEET):
    """A landing, postures, and what Pinocchio has there: inertias, Jacobians of feet and a sensor, velocities of one strike."""
    landing, rng = resolve(on("anymal_b", *feet, at="frame", joints=joints), known_robot("anymal_b")), np.random.default_rng(0)
    model, rows = landing.robot.model, []
    data, Q = model.createData(), np.tile(landing.q, (n, 1))
    Q[:, 7:] += rng.uniform(-0.4, 0.4, (n, 12))
    for q in Q:
        H = np.triu(pin.crba(model, data, q))
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        J = [
            pin.getFrameJacobian(model, data, model.getFrameId(frame), pin.LOCAL_WORLD_ALIGNED)[:3] for frame in (*feet, "imu_link")
        ]
        v = np.zeros(model.nv)
        v[:3] = pin.Quaternion(q[3:7]).toRotationMatrix().T @ STRIKE
        rows.append((H + np.triu(H, 1).T + np.diag(landing.joint_model.armature), np.array(J[:-1]), np.array(J[-1:]), v))
    return landing, Q, tuple(map(np.array, zip(*rows, strict=True)))


@pytest.mark.parametrize("library", ["numpy", "torch"] if TORCH else ["numpy"])
def test_shock_is_that_of_maps(library):
    for joints in (Joints(armature={"*": 0.02}), Joints(model="free", locked=("*_HAA", "RH*"))):
        landing, Q, arrays = batch(joints)
        held = {"locked": landing.joint_model.locked} if landing.joint_model.locked.any() else {}
        found, maps = shock_of(library, *arrays, **held), shock_maps(landing, Q)
        np.testing.assert_allclose(found.shock[:, 0], maps.shock("imu_link", STRIKE), rtol=1e-9)
        impulse = maps.impulse(arrays[-1])
        np.testing.assert_allclose(found.impulse, impulse, atol=1e-9 * np.abs(impulse).max())
        assert ((found.pivot > 1e-6) & (found.pivot <= 1.0)).all()
        single = shock_of(library, *(part.astype(np.float32) for part in arrays), **held)
        assert single.shock.dtype == np.float32
        np.testing.assert_allclose(single.shock, found.shock, rtol=2e-3)


@pytest.mark.parametrize("library", ["numpy", "torch"] if TORCH else ["numpy"])
def test_feet_that_do_not_strike_and_restitution(library):
    """A foot that is left out of a state is as if it were not there; what rebounds has a larger impulse; rows may be one normal."""
    _, Q, arrays = batch(Joints(), n=4)
    strikes = np.array([[True, True], [True, False], [False, True], [False, False]])
    found = shock_of(library, *arrays, contacts=strikes, v_in=np.full(4, np.linalg.norm(STRIKE)))
    assert found.shock[3] == 0.0
    assert not found.impulse[~strikes].any()
    for k, foot in ((1, "LF_FOOT"), (2, "RH_FOOT")):
        landing = batch(Joints(), n=1, feet=(foot,))[0]
        np.testing.assert_allclose(found.shock[k, 0], shock_maps(landing, Q[k : k + 1]).shock("imu_link", STRIKE)[0], rtol=1e-9)
    rebound = shock_of(library, *arrays, restitution=np.full((4, 2, 1), 0.3))
    np.testing.assert_allclose(rebound.impulse, 1.3 * shock_of(library, *arrays).impulse, rtol=1e-10)


def test_dependent_rows_are_told():
    """Three points of a rigid robot have nine rows, of which six are independent; twice the same foot is half the impulse each."""
    landing, _, (M, J_c, J_p, v) = batch(Joints(), n=2, feet=("LF_FOOT",))
    twice = batched_shock(np, M, np.concatenate([J_c, J_c], axis=1), J_p, v)
    assert (np.abs(twice.pivot) < 1e-8).all()
    once = batched_shock(np, M, J_c, J_p, v)
    np.testing.assert_allclose(
        once.shock[0, 0], shock_maps(landing, batch(Joints(), n=1)[1]).shock("imu_link", STRIKE)[0], rtol=1e-9
    )
    assert (once.pivot > 1e-3).all()
