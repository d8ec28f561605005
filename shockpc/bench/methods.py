"""The rivals, in one tuple: ways to find what an impact does to every body. What no user needs lives here."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.bench.assembler import assembler
from shockpc.bench.system import System, Unsuited, bodies_from, columns_at, rows_at, velocity_at_impact
from shockpc.core.maximal import solve_maximal
from shockpc.core.spatial import Array
from shockpc.health import DOUBTFUL
from shockpc.model.dynamics import dynamics, tree
from shockpc.model.equation import solve
from shockpc.model.rows import about_com
from shockpc.profile import shock_profile

__all__ = ["DIRECT", "Method", "Prepared", "dense_kkt", "partition", "reduced", "schur_cholesky"]


class Prepared(NamedTuple):
    """A method made ready for one system: `run` is what is timed, `read` turns what it gives into jumps.

    Attributes:
        run: the work, from q to the bodies' velocities.
        read: what run gives → (nb, 6) jumps, body axes at the body frames' origins; NaN where there is none.
        warned: whether the method itself said that the answer is not to be trusted.
        estimate: relative error (nb,) that the method itself expects of each body, if it does.
    """

    run: Callable[[], Any]
    read: Callable[[Any], Array]
    warned: Callable[[Any], bool] = lambda raw: False
    estimate: Callable[[Any], Array | None] = lambda raw: None


@dataclass(frozen=True)
class Method:
    """One way to the answer.

    Attributes:
        name: as in tables.
        what: what it does, in one line.
        prepare: system → the method made ready.
        kind: "product", "direct" or "simulation".
    """

    name: str
    what: str
    prepare: Callable[[System], Prepared] = field(repr=False)
    kind: str = "direct"


def _joint_space(solver: Callable[[Array, Array, Array], Array]) -> Callable[[System], Prepared]:
    """A method that solves for joint velocities: assemble, reduce by G, solve, and let Pinocchio carry the jump to the bodies."""

    def prepare(system: System) -> Prepared:
        data = system.model.createData()
        assemble, q, b, G = assembler(system, data), system.landing.q, system.b, system.G

        def run() -> Any:
            H, J_c = assemble(q)
            delta = solver(H, J_c, b) if G is None else G @ solver(G.T @ H @ G, J_c @ G, b)
            pin.forwardKinematics(system.model, data, q, delta)
            return data.v

        return Prepared(run, lambda raw: bodies_from(system, raw))

    return prepare


def dense_kkt(H: Array, J_c: Array, b: Array) -> Array:
    """Eq. 4 as it stands, by LU with pivoting."""
    n, m = len(H), len(J_c)
    K = np.zeros((n + m, n + m))
    K[:n, :n], K[:n, n:], K[n:, :n] = H, J_c.T, J_c
    return np.linalg.solve(K, np.concatenate([np.zeros(n), -b]))[:n]


def schur_cholesky(H: Array, J_c: Array, b: Array) -> Array:
    """Λ from H = L Lᵀ: X = L⁻¹ J_cᵀ, Δq̇ = −L⁻ᵀ X (XᵀX)⁻¹ b, both factors by Cholesky."""
    L = np.linalg.cholesky(H)
    X = np.linalg.solve(L, J_c.T)
    C = np.linalg.cholesky(X.T @ X)
    return np.linalg.solve(L.T, X @ np.linalg.solve(C.T, np.linalg.solve(C, -b)))


def partition(H: Array, J_c: Array, b: Array) -> Array:
    """Eq. 6: the contact's own velocities as coordinates, Δq̇₁ = −b, Δq̇₂ = −H₂₂⁻¹ H₂₁ Δq̇₁.

    The base's linear velocity gives way to that of the contact point; that takes one sticking point on a free base.
    """
    n = len(H)
    if len(J_c) != 3 or n < 3 or np.linalg.cond(J_c[:, :3]) > 1e3:
        raise Unsuited("Eq. 6 needs contact velocities that can be coordinates: one sticking point on a free base")
    T = np.eye(n)
    T[:3, :3] = np.linalg.inv(J_c[:, :3])
    T[:3, 3:] = -T[:3, :3] @ J_c[:, 3:]
    H = T.T @ H @ T
    return np.asarray(T @ np.concatenate([-b, np.linalg.solve(H[3:, 3:], H[3:, :3] @ b)]))


def reduced(H: Array, J_c: Array, b: Array) -> Array:
    """Eq. 7 taken to its end: Δq̇ = G Δẏ − J_c⁺ b with the columns of G what all rows leave free, GᵀHG Δẏ = GᵀH J_c⁺ b."""
    U, s, Vt = np.linalg.svd(J_c)
    rank = int(np.sum(s > max(J_c.shape) * np.finfo(float).eps * s.max(initial=0.0)))
    met = -Vt[:rank].T @ ((U[:, :rank].T @ b) / s[:rank])
    G = Vt[rank:].T
    return np.asarray(met - G @ np.linalg.solve(G.T @ H @ G, G.T @ (H @ met)))


def _alike(system: System) -> float:
    """The one restitution that Pinocchio's functions take.

    Raises:
        Unsuited: restitutions differ, or loops and followers would bounce too.
    """
    e = {block.restitution for block in system.landing.rows.blocks}
    if len(e) > 1:
        raise Unsuited("Pinocchio takes one restitution for all rows")
    if system.G is not None or not system.robot.free_base:
        raise Unsuited("Pinocchio's impulse has no held or following joints")
    return e.pop()


def _pin_jacobian(damping: float) -> Callable[[System], Prepared]:
    """pin.impulseDynamics with a constraint Jacobian."""

    def prepare(system: System) -> Prepared:
        e, v, q = _alike(system), velocity_at_impact(system), system.landing.q
        data = system.model.createData()
        assemble = assembler(system, data)

        def run() -> Any:
            _, J_c = assemble(q)  # its crba is the one that the function wants
            after = pin.impulseDynamics(system.model, data, v, J_c, e, damping)
            pin.forwardKinematics(system.model, data, q, after - v)
            return data.v

        return Prepared(run, lambda raw: bodies_from(system, raw))

    return prepare


def _pin_constraints(mu: float) -> Callable[[System], Prepared]:
    """pin.impulseDynamics with rigid constraint models: points held along all three axes, µ added to what they hold.

    It takes the settings of a proximal method, but solves once, however many iterations they allow, so that µ stays in the answer.
    """

    def prepare(system: System) -> Prepared:
        e, v, q = _alike(system), velocity_at_impact(system), system.landing.q
        robot, scene = system.robot, system.scene
        if (
            robot.loops
            or scene.closure
            or scene.stance
            or any(len(t.directions) != 3 or len(t.turns) for t in system.landing.touches)
        ):
            raise Unsuited("rigid constraint models are used here for sticking points alone")
        models = pin.StdVec_RigidConstraintModel()
        for touch in system.landing.touches:
            body = robot.bodies[touch.body]
            place = pin.SE3(np.eye(3), body.offset + body.rotation @ touch.point)
            models.append(
                pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, system.model, body.joint, place, pin.LOCAL_WORLD_ALIGNED)
            )
        datas = pin.StdVec_RigidConstraintData()
        for model in models:
            datas.append(model.createData())
        data = system.model.createData()
        pin.initConstraintDynamics(system.model, data, models, datas)
        proximal = pin.ProximalSettings(1e-12, 1e-12, mu, 1)

        def run() -> Any:
            after = pin.impulseDynamics(system.model, data, q, v, models, datas, e, proximal)
            pin.forwardKinematics(system.model, data, q, after - v)
            return data.v

        return Prepared(run, lambda raw: bodies_from(system, raw))

    return prepare


def _maximal(system: System) -> Prepared:
    """The product's second opinion, alone."""

    def run() -> Any:
        state = dynamics(system.robot, system.landing.q[None])
        rows = rows_at(system, state)
        bodies = tree(system.robot, state, system.landing.drives.armature, columns_at(system, state))
        W = about_com(rows.W[0], bodies)
        return state, solve_maximal(bodies, W, rows.b[0, :, -1:]).twists[..., 0]

    def read(raw: Any) -> Array:
        state, twists = raw
        R = np.swapaxes(state.rotation[0], -1, -2)
        omega, v = (R @ twists[:, :3, None])[..., 0], (R @ twists[:, 3:, None])[..., 0]
        com = np.stack([body.com for body in system.robot.bodies])
        return np.concatenate([omega, v - np.cross(omega, com)], axis=1)

    return Prepared(run, read)


def _batch_of_one(system: System) -> Prepared:
    """The product's steps 1 and 2 for one posture, without its second opinion."""

    def run() -> Any:
        state = dynamics(system.robot, system.landing.q[None])
        G = columns_at(system, state)
        return solve(system.robot, state, rows_at(system, state), system.landing.drives.armature, G).jumps

    return Prepared(run, lambda raw: raw[0, :, :, -1])


def _analyze(system: System) -> Prepared:
    """All that `shockpc analyze` computes."""
    return Prepared(
        lambda: shock_profile(system.scene, system.robot),
        lambda profile: np.concatenate([profile.delta_omega, profile.delta_v], axis=1),
        lambda profile: profile.health.error_estimate > DOUBTFUL and bool(profile.health.warnings),
        lambda profile: np.array(profile.health.body_errors),
    )


DIRECT = (
    Method("shockpc", "the product: both solutions, steps 1 to 3, loads, energy, extremes, estimate", _analyze, "product"),
    Method("shockpc, steps 1–2", "the product's batch path, for a single posture", _batch_of_one, "product"),
    Method("dense KKT (Eq. 4)", "LU of the whole matrix", _joint_space(dense_kkt)),
    Method("Schur, Cholesky of H", "Λ by two Cholesky factors", _joint_space(schur_cholesky)),
    Method("partition (Eq. 6)", "contact velocities as coordinates", _joint_space(partition)),
    Method("reduced (Eq. 7)", "coordinates that the rows leave free", _joint_space(reduced)),
    Method("maximal coordinates", "six unknowns a body, rows as they are", _maximal),
    Method("pin.impulseDynamics, Jacobian", "Pinocchio with J_c, no damping", _pin_jacobian(0.0)),
    Method("pin.impulseDynamics, damped", "Pinocchio with J_c, damping 1e-8", _pin_jacobian(1e-8)),
    Method("pin.impulseDynamics, constraints", "Pinocchio's rigid constraints, default settings", _pin_constraints(0.0)),
    Method("pin.impulseDynamics, constraints, µ = 1e-6", "the same, damped by µ, in one shot", _pin_constraints(1e-6)),
)
"""Methods that solve for the jump; those that simulate the landing are in `simulate` and `mujoco_peer`."""
