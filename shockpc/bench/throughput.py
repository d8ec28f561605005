"""Many postures of one landing: the batched path against Pinocchio and MuJoCo in a Python loop."""

import math
from collections.abc import Callable
from statistics import median

import numpy as np
import pinocchio as pin

from shockpc.bench.cases import chain, known_robot, landing
from shockpc.bench.measure import timed
from shockpc.bench.methods import Prepared
from shockpc.bench.mujoco_peer import batch_in_mujoco
from shockpc.bench.system import System, UnsuitedError, system_of
from shockpc.core.spatial import Array
from shockpc.profile import shock_maps
from shockpc.result import ShockMaps
from shockpc.show.tables import Cell, Sheet

__all__ = ["PEERS", "many_system", "postures", "throughput"]

STRUCK = {"anymal_b": "LF_FOOT", "talos": "left_sole_link", "chain of 100 links": "link0"}
"""Robots and the frame that strikes."""

MANY = 512
"""Postures."""


def many_system(name: str) -> System:
    """The landing of a robot of `STRUCK`, in one posture."""
    robot = chain(np.ones(100), np.full(100, 0.05)) if name.startswith("chain") else known_robot(name)
    return system_of(*landing(robot, STRUCK[name]))


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
    out, before = np.empty((len(Q), model.nv)), np.zeros((len(Q), model.nv))
    before[:, :3] = [pin.Quaternion(q[3:7]).matrix().T @ velocity for q in Q]

    def run() -> Array:
        for k, (q, v) in enumerate(zip(Q, before, strict=True)):
            pin.crba(model, data, q)
            J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
            out[k] = pin.impulseDynamics(model, data, v, J, 0.0, 0.0)
        return out

    def read(after: Array) -> Array:
        jumps = []
        for q, v in zip(Q, after - before, strict=True):
            pin.forwardKinematics(model, data, q, v)
            jumps.append(system.jumps(data.v))
        return np.array(jumps)[..., None]

    return Prepared(run, read)


PEERS: dict[str, Callable[[System, Array], Prepared]] = {
    "Pinocchio in a Python loop: 1 direction, joint velocities": _bare_loop,
    "shockpc, batched: 3 directions, all bodies": _batched,
    "MuJoCo in a Python loop: 3 directions, all bodies": batch_in_mujoco,
}
"""Run times are compared with that of the first."""


def throughput(budget: float) -> Sheet:
    """Compare the results of all peers in many postures, and their run times. Args: budget for each clock [s]."""
    rows: list[tuple[Cell, ...]] = []
    for name in STRUCK:
        system = many_system(name)
        Q = postures(system, MANY)
        batched = _batched(system, Q)
        maps = batched.read(batched.run())
        jump = (maps @ system.landing.before.velocity)[..., None]
        base = math.nan
        for peer, prepare in PEERS.items():
            try:
                prepared = prepare(system, Q)
            except UnsuitedError as reason:
                rows.append((name, peer, None, None, None, str(reason)))
                continue
            raw, times = timed(prepared.run, budget)
            result = prepared.read(raw)
            own = maps if result.shape[-1] == 3 else jump
            difference = np.max(np.abs(result - own).max(axis=(1, 2, 3)) / np.abs(own).max(axis=(1, 2, 3)))
            seconds = median(times) / MANY
            base = seconds if prepare is _bare_loop else base
            rows.append((name, peer, f"{1e6 * seconds:.1f}", f"{seconds / base:.2f}", f"{difference:.1e}", None))
    header = ("robot", "method", "per posture [µs]", "× Pinocchio loop", "difference [-]", "remark")
    return Sheet("many postures", header, rows, ("difference: from the batched path, relative to the fastest body",))
