"""The methods that are compared: ways to find the velocity jump of every body of a landing."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc import Robot, Scene, SceneError, ShockProfile, resolve, shock_profile
from shockpc.core.spatial import Array
from shockpc.impact.landed import solved
from shockpc.landing.landing import PosedLanding
from shockpc.method.approach import approach_speeds
from shockpc.method.constraints import Constraint, constraint_axes, constraint_point
from shockpc.quantities.selection import QUANTITIES

PROVEN = "shockpc, exact"
WORLD_AXES = pin.LOCAL_WORLD_ALIGNED


class UnsuitedError(SceneError):
    """A method cannot take a scene; the text says why."""


class FrameConstraint(NamedTuple):
    """What a contact, a standing foot or a loop holds.

    Attributes:
        axes: (n, 6) world axes of forces and moments.
        ends: frames, one on each body that is held, with 1, or −1 for the opposite impulse.
    """

    axes: Array
    ends: list[tuple[int, float]]


class PinocchioSystem(NamedTuple):
    """A landing ready for every method.

    Attributes:
        landing: the scene resolved on the robot.
        model: the robot's Pinocchio model with the scene's reflected inertia in it, and a frame at
            every point that is held.
        constraints: rows of each contact, standing foot and loop.
        v: (nv,) joint velocities before the impact in Pinocchio's layout; a base without joint is
            at rest.
        b: (nc,) speed to be undone along every row.
        G: (nv, ny) columns of the free velocities, or None where all are free.
    """

    landing: PosedLanding
    model: pin.Model
    constraints: list[FrameConstraint]
    v: Array
    b: Array
    G: Array | None

    def assemble(self, data: pin.Data) -> tuple[Array, Array]:
        """H (nv, nv) and J_c (nc, nv) in the posture of the landing, computed from q."""
        H = pin.crba(self.model, data, self.landing.q, pin.Convention.WORLD)
        J_c = []
        for axes, ends in self.constraints:
            jacobians = []
            for frame, sign in ends:
                jacobian = pin.getFrameJacobian(self.model, data, frame, WORLD_AXES)
                jacobians.append(sign * jacobian)
            J_c.append(axes @ sum(jacobians))
        return H, np.concatenate(J_c)

    def motions(self, data: pin.Data, v: Array, q: Array | None = None) -> Any:
        """Motions of the world and of all joints for joint velocities (nv,).

        By default they are in the posture of the landing.
        """
        pin.forwardKinematics(self.model, data, self.landing.q if q is None else q, v)
        return data.v

    def jumps(self, motions: Sequence[pin.Motion]) -> Array:
        """Jumps (nb, 6) of the bodies, body axes at their frames' origins.

        Args: motions of the world and of Pinocchio's joints.
        """
        twists = (
            pin.SE3(body.rotation, body.offset).actInv(motions[body.joint])
            for body in self.landing.robot.bodies
        )
        return np.array([[*motion.angular, *motion.linear] for motion in twists])

    @property
    def sticking(self) -> bool:
        """True if all contacts are points that stop in all directions."""
        return all(
            np.array_equal(contact.forces, np.eye(3)) and not len(contact.moments)
            for contact in self.landing.contacts
        )

    def contact_points(self) -> list[tuple[int, Array]]:
        """Pinocchio's joint, and point in its frame [m], of every contact."""
        points = []
        for held in self.constraints[: len(self.landing.contacts)]:
            frame = self.model.frames[held.ends[0][0]]
            points.append((frame.parentJoint, frame.placement.translation))
        return points


def system_of(robot: Robot, scene: Scene) -> PinocchioSystem:
    """Prepare a scene.

    Raises:
        ShockError: the scene cannot be computed.
    """
    landing = resolve(scene, robot)
    model = pin.Model(robot.model)
    model.armature = landing.joint_model.armature
    rows = landing.rows(landing.state)
    constraints = [_held(landing, constraint, model) for constraint in rows]
    b = approach_speeds(landing.state, rows, landing.before)
    G = landing.free_columns(landing.state)
    v = _velocities(landing)
    return PinocchioSystem(landing, model, constraints, v, b[0, :, 3], None if G is None else G[0])


def _held(landing: PosedLanding, constraint: Constraint, model: pin.Model) -> FrameConstraint:
    """Rows of a constraint, for which frames at its point are added to the model.

    It acts on the second of the bodies that it connects with the opposite sign.
    """
    state = landing.state
    point = constraint_point(state, constraint)[0]
    # Axes of forces and then of torques.
    n = len(constraint.forces)
    axes = np.zeros((constraint.size, 6))
    axes[:n, :3], axes[n:, 3:] = np.split(constraint_axes(state, constraint)[0], [n])
    ends = []
    for i, sign in ((constraint.body, 1.0), (constraint.other_body, -1.0)):
        # An index of −1 is the ground or the world, which does not move.
        if i >= 0:
            body = landing.robot.bodies[i]
            offset = state.rotation[0, i].T @ (point - state.position[0, i])
            in_joint = pin.SE3(np.eye(3), body.offset + body.rotation @ offset)
            name = f"end {len(model.frames)}"
            frame = pin.Frame(name, body.joint, 0, in_joint, pin.FrameType.OP_FRAME)
            ends.append((model.addFrame(frame), sign))
    return FrameConstraint(axes, ends)


def _velocities(landing: PosedLanding) -> Array:
    """Joint velocities (nv,) before the impact, with a free base in the axes of its joint."""
    before = landing.before
    v = np.array(before.joint_rates)
    if landing.robot.free_base:
        to_base = landing.robot.bodies[0].rotation @ landing.state.rotation[0, 0].T
        v[:3] = to_base @ before.velocity
        v[3:6] = to_base @ before.omega
    return v


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


Method = Callable[[PinocchioSystem], Prepared]
"""Makes a method ready for a system; raises `UnsuitedError` for one that it cannot take."""


def _proven(system: PinocchioSystem) -> Prepared:
    """The package: steps 1 and 2, and the proof; what is derived is computed when it is read."""
    return Prepared(
        lambda: shock_profile(system.landing.scene, system.landing.robot),
        lambda profile: np.concatenate([profile.delta_omega, profile.delta_v], axis=1),
    )


def all_quantities(system: PinocchioSystem) -> Prepared:
    """The package: a whole analysis, every number that its document holds."""
    scene, robot = system.landing.scene, system.landing.robot

    def run() -> ShockProfile:
        profile = shock_profile(scene, robot)
        for quantity in QUANTITIES:
            profile.value(quantity.key, quantity.of)
        return profile

    return Prepared(run, _proven(system).read)


def double_jumps(landing: PosedLanding) -> Array:
    """Jumps (nb, 6) for the scene's strike, by steps 1 and 2 in double precision.

    They are in body coordinates at the body frames' origins.
    """
    _, _, jumps = solved(landing, landing.state)
    in_body_axes = jumps[0, ..., 3].reshape(-1, 2, 3) @ landing.state.rotation[0]
    return np.asarray(in_body_axes.reshape(-1, 6))


def _joint_space(
    solve: Callable[[Array, Array, Array], Array], system: PinocchioSystem
) -> Prepared:
    """Solve for joint velocities: assemble, reduce by G, and solve.

    Pinocchio carries the jump to the bodies.
    """
    data, b, G = system.model.createData(), system.b, system.G

    def run() -> Any:
        H, J_c = system.assemble(data)
        if G is None:
            jump = solve(H, J_c, b)
        else:
            jump = G @ solve(G.T @ H @ G, J_c @ G, b)
        return system.motions(data, jump)

    return Prepared(run, system.jumps)


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
    """Eq. 6: the velocity of the contact point replaces that of the base.

    Δq̇₁ = -b, Δq̇₂ = -H₂₂⁻¹ H₂₁ Δq̇₁.
    """
    if len(J_c) != 3 or len(H) < 3 or np.linalg.cond(J_c[:, :3]) > 1e3:
        raise UnsuitedError("Eq. 6 needs one sticking point on a free base")
    # Δq̇ = T (Δq̇₁, Δq̇₂), in which the first three are those of the contact point.
    to_point = np.linalg.inv(J_c[:, :3])
    T = np.eye(len(H))
    T[:3, :3] = to_point
    T[:3, 3:] = -to_point @ J_c[:, 3:]
    H = T.T @ H @ T
    of_others = np.linalg.solve(H[3:, 3:], H[3:, :3] @ b)
    return np.asarray(T @ np.concatenate([-b, of_others]))


def _reduced(H: Array, J_c: Array, b: Array) -> Array:
    """Eq. 7 for all rows: Δq̇ = G Δẏ - J_c⁺ b.

    G spans the null space of J_c, and GᵀHG Δẏ = GᵀH J_c⁺ b.
    """
    # J_c = U diag(s) Vᵀ, whose first columns span the range of J_cᵀ, and the others its complement.
    U, s, Vt = np.linalg.svd(J_c)
    least = max(J_c.shape) * np.finfo(float).eps * s.max(initial=0.0)
    rank = int(np.sum(s > least))
    # −J_c⁺ b
    particular = -Vt[:rank].T @ ((U[:, :rank].T @ b) / s[:rank])
    G = Vt[rank:].T
    HG = G.T @ H @ G
    return np.asarray(particular - G @ np.linalg.solve(HG, G.T @ (H @ particular)))


def _one_restitution(system: PinocchioSystem) -> float:
    """The restitution that Pinocchio's functions take.

    They take no system where something else is held.
    """
    e = {contact.restitution for contact in system.landing.contacts}
    if len(e) > 1:
        raise UnsuitedError("Pinocchio takes one restitution for all rows")
    if any(e) and any(
        contact.rebound is not None and contact.size > 1 for contact in system.landing.contacts
    ):
        raise UnsuitedError(
            "Pinocchio's restitution reverses the speed along all rows, not only along the normal"
        )
    if system.G is not None or not system.landing.robot.free_base or system.landing.scene.stance:
        raise UnsuitedError("Pinocchio's impulse has no held joints, mimic joints or standing feet")
    return float(e.pop())


def _pin_jacobian(system: PinocchioSystem) -> Prepared:
    """pin.impulseDynamics with a constraint Jacobian."""
    e, data = _one_restitution(system), system.model.createData()

    def run() -> Any:
        _, J_c = system.assemble(data)  # its crba is the one that the function needs
        after = pin.impulseDynamics(system.model, data, system.v, J_c, e, 0.0)
        return system.motions(data, after - system.v)

    return Prepared(run, system.jumps)


def _pin_constraints(mu: float, system: PinocchioSystem) -> Prepared:
    """pin.impulseDynamics with rigid constraint models.

    The damping µ stays in the answer: the function solves once.
    """
    e = _one_restitution(system)
    if system.landing.loops or not system.sticking:
        raise UnsuitedError("rigid constraint models are used here for sticking points only")
    model, q, v = system.model, system.landing.q, system.v
    models = pin.StdVec_RigidConstraintModel()
    datas = pin.StdVec_RigidConstraintData()
    for joint, point in system.contact_points():
        at_point = pin.SE3(np.eye(3), point)
        kind = pin.ContactType.CONTACT_3D
        models.append(pin.RigidConstraintModel(kind, model, joint, at_point, WORLD_AXES))
        datas.append(models[-1].createData())
    data = model.createData()
    settings = pin.ProximalSettings(1e-12, 1e-12, mu, 1)
    pin.initConstraintDynamics(model, data, models, datas)

    def run() -> Any:
        after = pin.impulseDynamics(model, data, q, v, models, datas, e, settings)
        return system.motions(data, after - v)

    return Prepared(run, system.jumps, approximates=mu > 0.0)


DIRECT: dict[str, Method] = {
    PROVEN: _proven,
    "shockpc, double precision": lambda system: Prepared(
        lambda: double_jumps(system.landing), np.asarray
    ),
    "dense KKT (Eq. 4)": partial(_joint_space, _dense_kkt),
    "Schur complement, Cholesky": partial(_joint_space, _schur_cholesky),
    "partition (Eq. 6)": partial(_joint_space, _partition),
    "null space (Eq. 7)": partial(_joint_space, _reduced),
    "Pinocchio, Jacobian": _pin_jacobian,
    "Pinocchio, constraints": partial(_pin_constraints, 0.0),
    "Pinocchio, constraints, µ = 1e-6": partial(_pin_constraints, 1e-6),
}
"""Methods that solve for the jump; those that simulate the landing are in `mujoco_peer`."""
