"""The methods that are compared: ways to find the velocity jump of every body."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.bench.system import System, UnsuitedError
from shockpc.core.spatial import Array
from shockpc.landing import Landing
from shockpc.profile import impact_jumps, shock_profile

__all__ = ["DIRECT", "PROVEN", "Method", "Prepared", "double_jumps"]

PROVEN = "shockpc, proven"


class Prepared(NamedTuple):
    """A method made ready for one system.

    Attributes:
        run: the timed work, from q to the velocities of the bodies.
        read: converts its result to jumps (nb, 6), body axes at the body frames' origins.
        approximates: whether its contact is soft or damped, so that its error depends on how much.
    """

    run: Callable[[], Any]
    read: Callable[[Any], Array]
    approximates: bool = False


Method = Callable[[System], Prepared]
"""Makes a method ready for a system; raises `UnsuitedError` for one that it cannot take."""


def _joint_space(solve: Callable[[Array, Array, Array], Array]) -> Method:
    """A method that solves for joint velocities: assemble, reduce by G, solve, and let Pinocchio carry the jump to the bodies."""

    def prepare(system: System) -> Prepared:
        data, b, G = system.model.createData(), system.b, system.G

        def run() -> Any:
            H, J_c = system.assemble(data)
            delta = solve(H, J_c, b) if G is None else G @ solve(G.T @ H @ G, J_c @ G, b)
            return _motions(system, data, delta)

        return Prepared(run, system.jumps)

    return prepare


def _motions(system: System, data: pin.Data, delta: Array) -> Any:
    """Motions of all joints for joint velocities (nv,)."""
    pin.forwardKinematics(system.model, data, system.landing.q, delta)
    return data.v


def _dense_kkt(H: Array, J_c: Array, b: Array) -> Array:
    """Eq. 4 as it stands, by LU with pivoting."""
    n, m = len(H), len(J_c)
    K = np.zeros((n + m, n + m))
    K[:n, :n], K[:n, n:], K[n:, :n] = H, J_c.T, J_c
    return np.linalg.solve(K, np.concatenate([np.zeros(n), -b]))[:n]


def _schur_cholesky(H: Array, J_c: Array, b: Array) -> Array:
    """With H = L Lᵀ and X = L⁻¹ J_cᵀ: Δq̇ = -L⁻ᵀ X (XᵀX)⁻¹ b, both factors by Cholesky."""
    L = np.linalg.cholesky(H)
    X = np.linalg.solve(L, J_c.T)
    C = np.linalg.cholesky(X.T @ X)
    return np.linalg.solve(L.T, X @ np.linalg.solve(C.T, np.linalg.solve(C, -b)))


def _partition(H: Array, J_c: Array, b: Array) -> Array:
    """Eq. 6: the velocity of the contact point replaces that of the base, Δq̇₁ = -b, Δq̇₂ = -H₂₂⁻¹ H₂₁ Δq̇₁."""
    n = len(H)
    if len(J_c) != 3 or n < 3 or np.linalg.cond(J_c[:, :3]) > 1e3:
        raise UnsuitedError("Eq. 6 needs one sticking point on a free base")
    T = np.eye(n)
    T[:3, :3] = np.linalg.inv(J_c[:, :3])
    T[:3, 3:] = -T[:3, :3] @ J_c[:, 3:]
    H = T.T @ H @ T
    return np.asarray(T @ np.concatenate([-b, np.linalg.solve(H[3:, 3:], H[3:, :3] @ b)]))


def _reduced(H: Array, J_c: Array, b: Array) -> Array:
    """Eq. 7 for all rows: Δq̇ = G Δẏ - J_c⁺ b, where G spans the null space of J_c and GᵀHG Δẏ = GᵀH J_c⁺ b."""
    U, s, Vt = np.linalg.svd(J_c)
    rank = int(np.sum(s > max(J_c.shape) * np.finfo(float).eps * s.max(initial=0.0)))
    met = -Vt[:rank].T @ ((U[:, :rank].T @ b) / s[:rank])
    G = Vt[rank:].T
    return np.asarray(met - G @ np.linalg.solve(G.T @ H @ G, G.T @ (H @ met)))


def _one_restitution(system: System) -> float:
    """The restitution that Pinocchio's functions take; they take no system where something else is held."""
    e = {contact.restitution for contact in system.landing.contacts}
    if len(e) > 1:
        raise UnsuitedError("Pinocchio takes one restitution for all rows")
    if system.G is not None or not system.landing.robot.free_base or system.landing.scene.stance:
        raise UnsuitedError("Pinocchio's impulse has no held joints, mimic joints or standing feet")
    return e.pop()


def _pin_jacobian(system: System) -> Prepared:
    """pin.impulseDynamics with a constraint Jacobian."""
    e, data = _one_restitution(system), system.model.createData()

    def run() -> Any:
        _, J_c = system.assemble(data)  # its crba is the one that the function needs
        return _motions(system, data, pin.impulseDynamics(system.model, data, system.v, J_c, e, 0.0) - system.v)

    return Prepared(run, system.jumps)


def _pin_constraints(mu: float) -> Method:
    """pin.impulseDynamics with rigid constraint models. The damping µ stays in the answer: the function solves once."""

    def prepare(system: System) -> Prepared:
        e, v, q, model = _one_restitution(system), system.v, system.landing.q, system.model
        sticking = all(np.array_equal(c.forces, np.eye(3)) and not len(c.moments) for c in system.landing.contacts)
        if system.landing.loops or not sticking:
            raise UnsuitedError("rigid constraint models are used here for sticking points alone")
        models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        for joint, point in system.contact_points():
            place = pin.SE3(np.eye(3), point)
            models.append(pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, joint, place, pin.LOCAL_WORLD_ALIGNED))
            datas.append(models[-1].createData())
        data, settings = model.createData(), pin.ProximalSettings(1e-12, 1e-12, mu, 1)
        pin.initConstraintDynamics(model, data, models, datas)
        return Prepared(
            lambda: _motions(system, data, pin.impulseDynamics(model, data, q, v, models, datas, e, settings) - v),
            system.jumps,
            approximates=mu > 0.0,
        )

    return prepare


def _proven(system: System) -> Prepared:
    """The package: steps 1 and 2, and the proof; what is derived is computed when it is read."""
    return Prepared(
        lambda: shock_profile(system.landing.scene, system.landing.robot),
        lambda profile: np.concatenate([profile.delta_omega, profile.delta_v], axis=1),
    )


def double_jumps(landing: Landing) -> Array:
    """Steps 1 and 2 in double precision for the scene's strike: jumps (nb, 6) in body coordinates at the body frames' origins."""
    _, _, jumps = impact_jumps(landing, landing.q[None])
    return np.asarray((jumps[0, ..., 3].reshape(-1, 2, 3) @ landing.state.rotation[0]).reshape(-1, 6))


DIRECT: dict[str, Method] = {
    PROVEN: _proven,
    "shockpc, double precision": lambda system: Prepared(lambda: double_jumps(system.landing), np.asarray),
    "dense KKT (Eq. 4)": _joint_space(_dense_kkt),
    "Schur complement, Cholesky": _joint_space(_schur_cholesky),
    "partition (Eq. 6)": _joint_space(_partition),
    "null space (Eq. 7)": _joint_space(_reduced),
    "Pinocchio, Jacobian": _pin_jacobian,
    "Pinocchio, constraints": _pin_constraints(0.0),
    "Pinocchio, constraints, µ = 1e-6": _pin_constraints(1e-6),
}
"""Methods that solve for the jump; those that simulate the landing are in `mujoco_peer`."""
