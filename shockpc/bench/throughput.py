"""Part 4: many postures, against peers on the same work: what one landing does to every body, in thousands of random postures."""

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shockpc.bench.cases.chains import chain
from shockpc.bench.methods import Prepared
from shockpc.bench.mujoco_peer import batch_in_mujoco
from shockpc.bench.system import System, Unsuited, columns_at, rows_at, system_of
from shockpc.bench.timing import Timing, timed
from shockpc.core.spatial import Array
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.equation import solve
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene, Strike

__all__ = ["CLOCK", "PEERS", "WORK", "PeerResult", "Work", "compete", "postures", "shock_of_many"]

CHUNK = 128
"""Postures that go through the product together: their matrices stay in the cache."""

ALIKE = 1e-6
"""Peers whose results differ by more than this, relative to the fastest body, did not do the same work; the rounding of a hundred
links makes 1e-9."""


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
    Work("chain of 100 links", "link0", 1024, 256),
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
    return np.stack([pin.integrate(system.model, system.landing.q, s) for s in step])


def shock_of_many(system: System, Q: Array) -> Array:
    """The product: jumps (N, nb, 6) in body axes for the scene's own strike, in chunks."""
    armature = system.landing.drives.armature
    parts = []
    for start in range(0, len(Q), CHUNK):
        state = dynamics(system.robot, Q[start : start + CHUNK])
        rows = rows_at(system, state)
        strike = rows._replace(b=rows.b[..., -1:])
        parts.append(solve(system.robot, state, strike, armature, columns_at(system, state)).jumps[..., -1])
    return np.concatenate(parts)


def _ours(system: System, Q: Array) -> Prepared:
    """The product takes plain arrays: there is nothing to make ready, and its own Pinocchio workspace it makes as it goes."""
    return Prepared(lambda: shock_of_many(system, Q), lambda raw: raw)


def _twists(data: pin.Data, bodies: int) -> Array:
    """Velocities (nb, 6) of all bodies in Pinocchio's own memory; read one by one they would cost more than the algorithms."""
    first, second = data.v[1].linear, data.v[2].linear
    step = second.ctypes.data - first.ctypes.data
    return np.lib.stride_tricks.as_strided(first, (bodies, 6), (step, first.itemsize), writeable=False)


def _angular_first(twists: Array) -> Array:
    """Velocities (N, nb, 6) from Pinocchio's order to ours; these robots' bodies have their joints' frames."""
    return np.concatenate([twists[..., 3:], twists[..., :3]], axis=-1)


def _naive(system: System, Q: Array) -> Prepared:
    """What one writes first: crba, a frame's Jacobian, the KKT matrix in numpy, forwardKinematics, one posture after another."""
    model, data, v_in = system.model, system.model.createData(), system.landing.before.velocity
    frame, nv = model.getFrameId(system.scene.contact[0].frame), system.model.nv
    out = np.empty((len(Q), len(system.robot.bodies), 6))
    twists = _twists(data, out.shape[1])

    def run() -> Array:
        for k, q in enumerate(Q):
            H = pin.crba(model, data, q)
            J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
            K = np.block([[H, J.T], [J, np.zeros((3, 3))]])
            delta = np.linalg.solve(K, np.concatenate([np.zeros(nv), -v_in]))[:nv]
            pin.forwardKinematics(model, data, q, delta)
            out[k] = twists
        return out

    return Prepared(run, _angular_first)


def _pinocchio(system: System, Q: Array) -> Prepared:
    """The shortest way in Pinocchio: impulseDynamics with a rigid constraint, forwardKinematics, one posture after another."""
    model, data, touch = system.model, system.model.createData(), system.landing.touches[0]
    body = system.robot.bodies[touch.body]
    place = pin.SE3(np.eye(3), touch.point)
    models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    models.append(pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, body.joint, place, pin.LOCAL_WORLD_ALIGNED))
    datas.append(models[0].createData())
    pin.initConstraintDynamics(model, data, models, datas)
    out = np.empty((len(Q), len(system.robot.bodies), 6))
    twists = _twists(data, out.shape[1])
    before = np.zeros((len(Q), model.nv))
    before[:, :3] = [pin.Quaternion(q[3:7]).matrix().T @ system.landing.before.velocity for q in Q]

    def run() -> Array:
        for k, (q, v) in enumerate(zip(Q, before, strict=True)):
            after = pin.impulseDynamics(model, data, q, v, models, datas)
            pin.forwardKinematics(model, data, q, after - v)
            out[k] = twists
        return out

    return Prepared(run, _angular_first)


PEERS: tuple[tuple[str, Callable[[System, Array], Prepared]], ...] = (
    ("shockpc, batch path", _ours),
    ("naive script (crba, numpy KKT)", _naive),
    ("pin.impulseDynamics in a loop", _pinocchio),
    ("MuJoCo in a loop", batch_in_mujoco),
)
"""The product first: the others are held against its results."""

CLOCK = (
    "All bodies' jumps in many random postures. In the clock is the way from q to the velocities of all bodies, in the peer's own",
    "layout and axes. Out of it are the peer's model and workspace, its inputs turned into its layout, and its results turned into",
    "ours, which are compared before anything is timed. The product's batch path takes plain arrays and keeps nothing from call to",
    f"call: that it makes Pinocchio's workspace anew for every {CHUNK} postures is in its time.",
)
"""What the times of part 4 are, as lines of text."""


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
            prepared = peer(system, Q)
        except Unsuited as reason:
            found.append(PeerResult(work.name, name, n, None, None, str(reason)))
            continue
        apart = float(np.abs((prepared.read(prepared.run()) - ours) / size).max())
        message = "" if apart <= ALIKE else "its results differ, so its time says nothing"
        _, all_of_it = timed(prepared.run, budget)
        each = Timing(all_of_it.median / n, all_of_it.low / n, all_of_it.high / n, all_of_it.runs)
        found.append(PeerResult(work.name, name, n, apart, each, message))
    return found
