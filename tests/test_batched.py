"""The shock of a batch of states from inertias and Jacobians, as a simulator has them: against maps
in doubles and profiles.
"""

import importlib
import importlib.util
import sys

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

    found = shock(
        *map(torch.tensor, arrays), **{k: torch.tensor(value) for k, value in options.items()}
    )
    return type(found)(*(part.numpy() for part in found))


def batch(joints, n=20, feet=FEET):
    """A landing, postures, and what Pinocchio has there: inertias, Jacobians of feet and a sensor,
    velocities of one strike.
    """
    landing, rng = (
        resolve(on("anymal_b", *feet, at="frame", joints=joints), known_robot("anymal_b")),
        np.random.default_rng(0),
    )
    model, rows = landing.robot.model, []
    data, Q = model.createData(), np.tile(landing.q, (n, 1))
    Q[:, 7:] += rng.uniform(-0.4, 0.4, (n, 12))
    for q in Q:
        H = np.triu(pin.crba(model, data, q))
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        J = [
            pin.getFrameJacobian(model, data, model.getFrameId(frame), pin.LOCAL_WORLD_ALIGNED)[:3]
            for frame in (*feet, "imu_link")
        ]
        v = np.zeros(model.nv)
        v[:3] = pin.Quaternion(q[3:7]).toRotationMatrix().T @ STRIKE
        rows.append(
            (
                H + np.triu(H, 1).T + np.diag(landing.joint_model.armature),
                np.array(J[:-1]),
                np.array(J[-1:]),
                v,
            )
        )
    return landing, Q, tuple(map(np.array, zip(*rows, strict=True)))


LIBRARIES = ["numpy", "torch"] if TORCH else ["numpy"]


@pytest.mark.parametrize("library", LIBRARIES)
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


@pytest.mark.parametrize("library", LIBRARIES)
def test_feet_that_do_not_strike_and_restitution(library):
    """A foot that is left out of a state is as if it were not there; what rebounds has a larger
    impulse; rows may be one normal.
    """
    _, Q, arrays = batch(Joints(), n=4)
    strikes = np.array([[True, True], [True, False], [False, True], [False, False]])
    found = shock_of(library, *arrays, contacts=strikes, v_in=np.full(4, np.linalg.norm(STRIKE)))
    assert found.shock[3] == 0.0
    assert not found.impulse[~strikes].any()
    for k, foot in ((1, "LF_FOOT"), (2, "RH_FOOT")):
        landing = batch(Joints(), n=1, feet=(foot,))[0]
        np.testing.assert_allclose(
            found.shock[k, 0],
            shock_maps(landing, Q[k : k + 1]).shock("imu_link", STRIKE)[0],
            rtol=1e-9,
        )
    rebound = shock_of(library, *arrays, restitution=np.full((4, 2, 1), 0.3))
    np.testing.assert_allclose(
        rebound.impulse, 1.3 * shock_of(library, *arrays).impulse, rtol=1e-10
    )


def test_dependent_rows_are_told():
    """Three points of a rigid robot have nine rows, of which six are independent; twice the same
    foot is half the impulse each.
    """
    landing, _, (M, J_c, J_p, v) = batch(Joints(), n=2, feet=("LF_FOOT",))
    twice = batched_shock(np, M, np.concatenate([J_c, J_c], axis=1), J_p, v)
    assert (np.abs(twice.pivot) < 1e-8).all()
    once = batched_shock(np, M, J_c, J_p, v)
    np.testing.assert_allclose(
        once.shock[0, 0],
        shock_maps(landing, batch(Joints(), n=1)[1]).shock("imu_link", STRIKE)[0],
        rtol=1e-9,
    )
    assert (once.pivot > 1e-3).all()


def drawn(states=4, contacts=2, nv=8):
    """Random inertias, Jacobians and velocities."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(states, nv, nv))
    jacobians = (rng.normal(size=(states, count, 3, nv)) for count in (contacts, 1))
    return (
        root @ root.transpose(0, 2, 1) + nv * np.eye(nv),
        *jacobians,
        rng.normal(size=(states, nv)),
    )


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("spoilt", range(4))
def test_a_state_that_cannot_be_computed_is_nan_and_changes_no_other(library, spoilt):
    """NaN in any array, and an inertia without mass; in float32 a block of dependent rows raised
    for the whole batch.
    """
    arrays = drawn()
    clean = shock_of(library, *arrays)
    for value in (np.nan, 0.0) if spoilt == 0 else (np.nan,):
        wrong = [part.copy() for part in arrays]
        wrong[spoilt][1] = value
        found = shock_of(library, *wrong)
        assert np.isnan(found.shock[1]).all()
        for part, expected in zip(found, clean, strict=True):
            np.testing.assert_array_equal(np.delete(part, 1, 0), np.delete(expected, 1, 0))


@pytest.mark.parametrize("library", LIBRARIES)
def test_dependent_rows_of_many_states_raise_nothing(library):
    """Four corners of a sole: twelve rows, six of them independent; in float32 one of 200 states
    raised, and so did the batch.
    """
    M, J_c, J_p, v = (part.astype(np.float32) for part in drawn(200, 4, 6))
    corner = np.array(
        [[0.1, 0.05, -0.3], [0.1, -0.05, -0.3], [-0.1, 0.05, -0.3], [-0.1, -0.05, -0.3]],
        dtype=np.float32,
    )
    J_c[..., :3] = np.eye(3)
    J_c[..., 3:] = np.cross(np.eye(3)[None, :, None], corner[:, None, None])[..., 0, :].transpose(
        0, 1, 2
    )
    found = shock_of(library, M, J_c, J_p, v)
    assert (np.isnan(found.pivot) | (found.pivot < 3e-4)).all()


def test_the_pivot_bounds_the_least_eigenvalue():
    """Of a matrix A with a unit diagonal: λ_min ≤ min 1 / (A⁻¹)_kk ≤ n λ_min, because (A⁻¹)_kk ≤ 1
    / λ_min ≤ tr A⁻¹.
    """
    M, J_c, J_p, v = drawn(50)
    rows = J_c.reshape(50, 6, 8)
    A = rows @ np.linalg.solve(M, rows.mT)
    scale = np.linalg.diagonal(A) ** -0.5
    least = np.linalg.eigvalsh(A * scale[..., None] * scale[:, None])[:, 0]
    pivot = batched_shock(np, M, J_c, J_p, v).pivot
    assert (pivot >= least * (1.0 - 1e-9)).all()
    assert (pivot <= 6.0 * least).all()


def test_arrays_of_other_shapes_and_types_are_refused():
    """Integers as masks and a column of speeds gave other numbers without a word."""
    M, J_c, J_p, v = drawn()
    arrays = {"M": M, "J_c": J_c, "J_p": J_p, "v": v}
    for name, value, said in (
        ("locked", np.zeros(8, np.uint8), "locked has the type uint8; it has to be bool"),
        ("contacts", np.ones((4, 2), int), "contacts has the type int64; it has to be bool"),
        (
            "contacts",
            np.ones((2, 4), bool),
            r"contacts has the shape \(2, 4\); with J_c \(4, 2, 3, 8\) it has to be \(4, 2\)",
        ),
        ("v_in", np.ones((4, 1)), r"v_in has the shape \(4, 1\).* it has to be \(4,\)"),
        ("restitution", np.ones((4, 2)), r"it has to be \(4, 2, 1\)"),
        ("J_p", J_p[:, 0], r"J_p has the shape \(4, 3, 8\); it needs 4 dimensions"),
        ("v", v.astype(np.float32), "v has the type float32; it has to be float64, as M has"),
        ("M", M.astype(int), "M has the type int64 and J_c float64"),
    ):
        with pytest.raises(ValueError, match=said):
            batched_shock(np, **(arrays | {name: value}))


def test_without_pytorch_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.delitem(sys.modules, "shockpc.torch", raising=False)
    with pytest.raises(
        ImportError, match='needs the package "torch"; install it with: pip install torch'
    ):
        importlib.import_module("shockpc.torch")


@pytest.mark.skipif(not TORCH, reason="needs PyTorch")
def test_no_number_is_read_from_the_device():
    """A program that asks for a number, or whether a matrix is singular, waits for the device: none
    of the operations does.
    """
    from torch.utils._python_dispatch import TorchDispatchMode

    names = []

    class Recorded(TorchDispatchMode):
        def __torch_dispatch__(self, func, types, args=(), kwargs=None):
            names.append(func.name())
            return func(*args, **(kwargs or {}))

    with Recorded():
        shock_of("torch", *drawn(), locked=np.zeros(8, bool))
    assert any("solve_ex" in name for name in names)
    assert [
        name
        for name in names
        if any(word in name for word in ("check_errors", "scalar_dense", "nonzero", "eigh"))
    ] == []
