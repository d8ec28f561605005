"""Part 4: many postures, against peers on the same work: what one landing does to every body, in thousands of random postures."""

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shockpc.bench.cases.chains import chain
from shockpc.bench.mujoco_peer import batch_in_mujoco
from shockpc.bench.system import System, Unsuited, columns_at, rows_at, system_of
from shockpc.bench.timing import Timing, timed
from shockpc.core.spatial import Array
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.equation import solve
from shockpc.model.robot import Robot, load_robot
from shockpc.scene import Scene, Strike

__all__ = ["PEERS", "WORK", "PeerResult", "Work", "compete", "postures", "shock_of_many"]

CHUNK = 256
"""Postures that go through the product together: their matrices stay in the cache."""

ALIKE = 1e-9
"""Peers whose results differ by more than this, relative to the fastest body, did not do the same work."""


@dataclass(frozen=True)
class Work:
    """A robot that lands in many postures.

    Attributes:
        name: of the robot.
        foot: the frame that strikes.
        full: postures in the full suite.
        quick: postures in the quick suite.
    """

    name: str
    foot: str
    full: int
    quick: int

    def system(self) -> System:
        """The landing, in one posture."""
        scene = Scene(robot=self.name, contact=(Contact(frame=self.foot),), strike=Strike(speed=1.0, strike_angle_deg=20.0))
        return system_of(_robot(self.name), scene)


WORK = (
    Work("anymal_b", "LF_FOOT", 4096, 512),
    Work("talos", "left_sole_link", 2048, 256),
    Work("chain of 100 links", "link0", 256, 32),
)


@functools.cache
def _robot(name: str) -> Robot:
    return chain(np.full(100, 1.0), np.full(100, 0.05)) if name.startswith("chain") else load_robot(name)


@dataclass(frozen=True)
class PeerResult:
    """How a peer did.

    Attributes:
        work: the robot's name.
        peer: its name.
        postures: how many.
        apart: largest difference from the product's result, relative to the fastest body [1]; None if it cannot do the work.
        timing: for one posture.
        message: why it cannot.
    """

    work: str
    peer: str
    postures: int
    apart: float | None
    timing: Timing | None
    message: str = ""


def postures(system: System, n: int) -> Array:
    """Random postures (n, nq) around the scene's own: every joint, and the base, turned by about 20°."""
    rng = np.random.default_rng(20)
    step = 0.35 * rng.normal(size=(n, system.model.nv))
    step[:, :3] = 0.0
    return np.stack([pin.integrate(system.model, system.setting.q, s) for s in step])


def shock_of_many(system: System, Q: Array) -> Array:
    """The product: jumps (N, nb, 6) in body axes, with the maps of all strike directions besides, in chunks."""
    armature = system.setting.drives.armature
    parts = []
    for start in range(0, len(Q), CHUNK):
        state = dynamics(system.robot, Q[start : start + CHUNK])
        parts.append(solve(system.robot, state, rows_at(system, state), armature, columns_at(system, state)).jumps[..., -1])
    return np.concatenate(parts)


def _angular_first(twists: Array) -> Array:
    """Velocities (N, nb, 6) from Pinocchio's order to ours; these robots' bodies have their joints' frames."""
    return np.concatenate([twists[..., 3:], twists[..., :3]], axis=-1)


def _naive(system: System, Q: Array) -> Array:
    """What one writes first: crba, a frame's Jacobian, the KKT matrix in numpy, forwardKinematics, one posture after another."""
    model, data, v_in = system.model, system.model.createData(), system.setting.before.velocity
    frame, nv = model.getFrameId(system.scene.contact[0].frame), system.model.nv
    out = np.empty((len(Q), len(system.robot.bodies), 6))
    for k, q in enumerate(Q):
        H = pin.crba(model, data, q)
        J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
        K = np.block([[H, J.T], [J, np.zeros((3, 3))]])
        delta = np.linalg.solve(K, np.concatenate([np.zeros(nv), -v_in]))[:nv]
        pin.forwardKinematics(model, data, q, delta)
        out[k] = [twist.vector for twist in data.v.tolist()[1:]]
    return _angular_first(out)


def _pinocchio(system: System, Q: Array, read: bool = True) -> Array:
    """The shortest way in Pinocchio: impulseDynamics with a rigid constraint, forwardKinematics, one posture after another."""
    model, data, touch = system.model, system.model.createData(), system.setting.touches[0]
    body = system.robot.bodies[touch.body]
    place = pin.SE3(np.eye(3), touch.point)
    models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    models.append(pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, body.joint, place, pin.LOCAL_WORLD_ALIGNED))
    datas.append(models[0].createData())
    pin.initConstraintDynamics(model, data, models, datas)
    out = np.empty((len(Q), len(system.robot.bodies), 6))
    before = np.zeros(model.nv)
    for k, q in enumerate(Q):
        before[:3] = pin.Quaternion(q[3:7]).matrix().T @ system.setting.before.velocity
        after = pin.impulseDynamics(model, data, q, before, models, datas)
        pin.forwardKinematics(model, data, q, after - before)
        if read:
            out[k] = [twist.vector for twist in data.v.tolist()[1:]]
    return _angular_first(out)


PEERS: tuple[tuple[str, Callable[[System, Array], Array]], ...] = (
    ("shockpc, batch path", shock_of_many),
    ("naive script (crba, numpy KKT)", _naive),
    ("pin.impulseDynamics in a loop", _pinocchio),
    ("MuJoCo in a loop", batch_in_mujoco),
)
"""The product first: the others are held against its results."""

UNREAD = "pin.impulseDynamics in a loop, bodies left unread"
"""Less work than the others do: what Pinocchio's algorithms take when called from Python, and nothing comes out."""


def compete(work: Work, n: int, budget: float) -> list[PeerResult]:
    """Let every peer do the work: results compared first, then timed.

    Args:
        work: what to do.
        n: postures.
        budget: time to spend on each clock [s].
    """
    system = work.system()
    Q = postures(system, n)
    found: list[PeerResult] = []
    ours = shock_of_many(system, Q)
    size = np.abs(ours).max(axis=(1, 2), keepdims=True)
    for name, peer in PEERS:
        try:
            apart = float(np.abs((peer(system, Q) - ours) / size).max())
        except Unsuited as reason:
            found.append(PeerResult(work.name, name, n, None, None, str(reason)))
            continue
        message = "" if apart <= ALIKE else "its results differ, so its time says nothing"
        _, all_of_it = timed(functools.partial(peer, system, Q), budget)
        each = Timing(all_of_it.median / n, all_of_it.low / n, all_of_it.high / n, all_of_it.runs)
        found.append(PeerResult(work.name, name, n, apart, each, message))
    _, all_of_it = timed(functools.partial(_pinocchio, system, Q, False), budget)
    each = Timing(all_of_it.median / n, all_of_it.low / n, all_of_it.high / n, all_of_it.runs)
    found.append(PeerResult(work.name, UNREAD, n, None, each, "does less: nothing is read"))
    return found
