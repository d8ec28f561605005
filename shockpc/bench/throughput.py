"""Many postures of one landing: the batched path against Pinocchio and MuJoCo in a Python loop."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.bench.cases.chains import chain
from shockpc.bench.cases.family import SLANTED, on
from shockpc.bench.cases.robots import known_robot
from shockpc.bench.measure import timed
from shockpc.bench.methods import Prepared
from shockpc.bench.mujoco_peer import batch_in_mujoco
from shockpc.bench.system import System, UnsuitedError, system_of
from shockpc.core.spatial import Array
from shockpc.profile import shock_maps
from shockpc.result import ShockMaps
from shockpc.scene import Scene

__all__ = ["PEERS", "SCENES", "PeerResult", "compete", "many_system", "postures"]

SCENES = {"anymal_b": "LF_FOOT", "talos": "left_sole_link", "chain of 100 links": "link0"}
"""Robots and the frame that strikes."""


class PeerResult(NamedTuple):
    """Run time of a peer.

    Attributes:
        robot: its name.
        peer: its name, and what it computes.
        difference: largest difference from the batched path, relative to the fastest body [1]; None if it cannot do the work.
        seconds: median run time for one posture [s]; None if it cannot do the work.
        message: why it cannot.
    """

    robot: str
    peer: str
    difference: float | None = None
    seconds: float | None = None
    message: str = ""


def many_system(name: str) -> System:
    """The landing of a robot of `SCENES`, in one posture."""
    robot = chain(np.ones(100), np.full(100, 0.05)) if name.startswith("chain") else known_robot(name)
    return system_of(robot, Scene(robot=name, contact=on(SCENES[name]), strike=SLANTED))


def postures(system: System, n: int) -> Array:
    """Random postures (n, nq) around the scene's own: every joint, and the base, rotated by about 20°."""
    steps = 0.35 * np.random.default_rng(20).normal(size=(n, system.model.nv))
    steps[:, :3] = 0.0
    return np.stack([pin.integrate(system.model, system.landing.q, step) for step in steps])


def _batched(system: System, Q: Array) -> Prepared:
    """The batched path of the package; its maps are in world axes."""

    def read(found: ShockMaps) -> Array:
        maps = found.maps.reshape(len(Q), -1, 2, 3, 3)
        return (np.swapaxes(found.rotation, -1, -2)[:, :, None] @ maps).reshape(len(Q), -1, 6, 3)

    return Prepared(lambda: shock_maps(system.landing, Q), read)


def _bare_loop(system: System, Q: Array) -> Prepared:
    """The shortest loop in Pinocchio: a frame's Jacobian and impulseDynamics for one direction; joint velocities alone."""
    model, data, velocity = system.model, system.model.createData(), system.landing.before.velocity
    frame = model.getFrameId(system.landing.scene.contact[0].frame)
    out = np.empty((len(Q), model.nv))
    before = np.zeros((len(Q), model.nv))
    before[:, :3] = [pin.Quaternion(q[3:7]).matrix().T @ velocity for q in Q]

    def run() -> Array:
        for k, (q, v) in enumerate(zip(Q, before, strict=True)):
            pin.crba(model, data, q)
            J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
            out[k] = pin.impulseDynamics(model, data, v, J, 0.0, 0.0)
        return out

    def read(after: Array) -> Array:
        jumps = np.empty((len(Q), len(system.landing.robot.bodies), 6))
        for k, (q, v) in enumerate(zip(Q, after - before, strict=True)):
            pin.forwardKinematics(model, data, q, v)
            jumps[k] = [[*data.v[i].angular, *data.v[i].linear] for i in range(1, model.njoints)]
        return jumps[..., None]

    return Prepared(run, read)


PEERS: dict[str, Callable[[System, Array], Prepared]] = {
    "shockpc, batched: 3 directions, all bodies": _batched,
    "Pinocchio in a Python loop: 1 direction, joint velocities": _bare_loop,
    "MuJoCo in a Python loop: 3 directions, all bodies": batch_in_mujoco,
}
"""The package first: the results of the others are compared with its own."""


def compete(name: str, n: int, budget: float) -> list[PeerResult]:
    """Compare results first, then measure run times.

    Args:
        name: of the robot in `SCENES`.
        n: postures.
        budget: time to spend on each clock [s].
    """
    system = many_system(name)
    Q = postures(system, n)
    batched = _batched(system, Q)
    maps = batched.read(batched.run())
    jump = maps @ system.landing.before.velocity
    found: list[PeerResult] = []
    for peer, prepare in PEERS.items():
        try:
            prepared = prepare(system, Q)
        except UnsuitedError as reason:
            found.append(PeerResult(name, peer, message=str(reason)))
            continue
        result = prepared.read(prepared.run())
        own = maps if result.shape[-1] == 3 else jump[..., None]
        difference = float((np.abs(result - own).max(axis=(1, 2, 3)) / np.abs(own).max(axis=(1, 2, 3))).max())
        found.append(PeerResult(name, peer, difference, timed(prepared.run, budget)[1].median / n))
    return found
