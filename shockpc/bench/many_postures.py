"""Many postures: the batched path against loops over Pinocchio and MuJoCo, and against symbols."""

import ctypes
import math
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pinocchio as pin

from shockpc import ShockMaps, StudyError, shock_maps, symbolic
from shockpc.bench.cases import chain, known_robot, landing
from shockpc.bench.measure import cost
from shockpc.bench.methods import PinocchioSystem, Prepared, UnsuitedError, system_of
from shockpc.bench.mujoco_peer import batch_in_mujoco
from shockpc.core.spatial import Array
from shockpc.profile import ILL_CONDITIONED
from shockpc.show.tables import Heading, Row, Sheet
from shockpc.wings.symbols.export.code import Samples, code_files
from shockpc.wings.symbols.programs import BLOCK
from shockpc.wings.symbols.symbolic import ACCURACY, SymbolicLanding

STRUCK = {
    "anymal_b": "LF_FOOT",
    "talos": "left_sole_link",
    "chain of 100 links": "link0",
    "hyq": "lf_foot",
    "go2": "FL_foot",
    "g1": "left_ankle_roll_link",
}
"""Robots and the frame that strikes."""

MANY_POSTURES = 512
"""Postures of each robot for the peers."""

IN_SYMBOLS = ("anymal_b", "go2", "g1")
"""Robots whose landings are computed in symbols."""

WITH_DERIVATIVES = 256
"""Postures in which maps have derivatives, which take much memory."""

Way: TypeAlias = Callable[[PinocchioSystem, Array], Prepared]
"""Makes what computes a landing in postures (N, nq) ready.

It raises `UnsuitedError` or `StudyError` where it cannot.
"""


def many_system(name: str) -> PinocchioSystem:
    """The landing of a robot of `STRUCK`, in one posture."""
    if name.startswith("chain"):
        robot = chain(np.ones(100), np.full(100, 0.05))
    else:
        robot = known_robot(name)
    return system_of(*landing(robot, STRUCK[name]))


def random_postures(system: PinocchioSystem, n: int) -> Array:
    """Random postures (n, nq) around the scene's: joints and base are rotated by about 20°."""
    steps = 0.35 * np.random.default_rng(20).normal(size=(n, system.model.nv))
    steps[:, :3] = 0.0
    return np.stack([pin.integrate(system.model, system.landing.q, step) for step in steps])


def _bare_loop(system: PinocchioSystem, Q: Array) -> Prepared:
    """The shortest loop in Pinocchio: a frame's Jacobian, and impulseDynamics for one direction.

    It gives joint velocities alone.
    """
    model = system.model
    data = model.createData()
    frame = model.getFrameId(system.landing.scene.contact[0].frame)
    velocity = system.landing.before.velocity
    before = np.zeros((len(Q), model.nv))
    before[:, :3] = [pin.Quaternion(q[3:7]).matrix().T @ velocity for q in Q]
    out = np.empty((len(Q), model.nv))

    def run() -> Array:
        for k, (q, v) in enumerate(zip(Q, before, strict=True)):
            pin.crba(model, data, q)
            J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
            out[k] = pin.impulseDynamics(model, data, v, J, 0.0, 0.0)
        return out

    def read(after: Array) -> Array:
        jumps = []
        for q, v in zip(Q, after - before, strict=True):
            jumps.append(system.jumps(system.motions(data, v, q)))
        return np.array(jumps)[..., None]

    return Prepared(run, read)


def _batched(system: PinocchioSystem, Q: Array) -> Prepared:
    """The batched path of the package; its maps are in world axes."""

    def read(result: ShockMaps) -> Array:
        maps = result.maps.reshape(len(Q), -1, 2, 3, 3)
        return (np.swapaxes(result.rotation, -1, -2)[:, :, None] @ maps).reshape(len(Q), -1, 6, 3)

    return Prepared(lambda: shock_maps(system.landing, Q), read)


PEERS: dict[str, Way] = {
    "Pinocchio in a Python loop: 1 direction, joint velocities": _bare_loop,
    "shockpc, batched: 3 directions, all bodies": _batched,
    "MuJoCo in a Python loop: 3 directions, all bodies": batch_in_mujoco,
}
"""Run times are compared with that of the first; what is read are jumps."""


def _comparison(
    robots: Sequence[str],
    ways: dict[str, Way],
    n: int,
    expected: Callable[[PinocchioSystem, Array], Callable[[Array], Array]],
    budget: float,
) -> Sheet:
    """Results of several ways in many postures, and their run times against that of the first.

    Args:
        robots: of `STRUCK`.
        ways: by name.
        n: number of postures.
        expected: makes of a system and postures what says what should be read, which has the shape
            of what is.
        budget: for each clock [s].
    """
    rows: list[Row] = []
    for name in robots:
        system = many_system(name)
        Q = random_postures(system, n)
        right = expected(system, Q)
        first = math.nan
        for way, prepare in ways.items():
            try:
                prepared = prepare(system, Q)
            except (UnsuitedError, StudyError) as reason:
                rows.append((name, way, None, None, None, str(reason)))
                continue
            result = prepared.read(prepared.run())
            seconds = cost(prepared.run, budget, len(result))
            if math.isnan(first):
                first = seconds
            difference = _largest_difference(result, right(result))
            rows.append((name, way, seconds, seconds / first, difference, None))
    off_by = Heading("difference", "difference", "-", zero=0.0)
    header = ("robot", "method", "per posture [µs]", "× Pinocchio loop [-]", off_by, "remark")
    return Sheet("", header, rows)


def _largest_difference(result: Array, right: Array) -> float:
    """The largest difference of results (n, …) from right ones, relative to the largest of each."""
    off = np.abs(result - right).reshape(len(result), -1).max(axis=1)
    size = np.abs(right).reshape(len(result), -1).max(axis=1)
    return float(np.max(off / size))


def many_postures(budget: float) -> Sheet:
    """The batched path and its peers. Args: budget for each clock [s]."""

    def expected(system: PinocchioSystem, Q: Array) -> Callable[[Array], Array]:
        batched, velocity = _batched(system, Q), system.landing.before.velocity
        maps = batched.read(batched.run())
        return lambda jumps: maps if jumps.shape[-1] == 3 else (maps @ velocity)[..., None]

    sheet = _comparison(
        ("anymal_b", "talos", "chain of 100 links"), PEERS, MANY_POSTURES, expected, budget
    )
    return sheet._replace(
        title="many postures",
        notes=("difference: from the batched path, relative to the fastest body",),
    )


def _loop_to_shocks(system: PinocchioSystem, Q: Array) -> Prepared:
    loop, speed = _bare_loop(system, Q), np.linalg.norm(system.landing.before.velocity)
    return loop._replace(
        read=lambda after: np.linalg.norm(loop.read(after)[..., 3:, 0], axis=-1) / speed
    )


def _maps(derivatives: bool, system: PinocchioSystem, Q: Array) -> Prepared:
    Q = Q[:WITH_DERIVATIVES] if derivatives else Q
    names = [body.name for body in system.landing.robot.bodies]
    return Prepared(
        partial(shock_maps, system.landing, Q, derivatives),
        lambda maps: np.stack([maps.shock(name) for name in names], axis=1),
    )


def _symbols(bodies: int | None, system: PinocchioSystem) -> SymbolicLanding:
    """The shock of so many bodies, or of all, in symbols."""
    robot = system.landing.robot
    return symbolic(
        system.landing.scene, [f"shock@{body.name}" for body in robot.bodies[:bodies]], robot=robot
    )


def _in_numpy(bodies: int | None, system: PinocchioSystem, Q: Array) -> Prepared:
    symbols = _symbols(bodies, system)
    return Prepared(
        partial(symbols.value, Q),
        lambda numbers: np.stack(list(numbers.values())[: -len(ACCURACY)], axis=1),
    )


def _slope_in_numpy(system: PinocchioSystem, Q: Array) -> Prepared:
    return Prepared(
        partial(_symbols(1, system).slopes, Q),
        lambda slopes: np.stack(list(slopes[0].values()), axis=1),
    )


LOOP = """#include "landing.h"
void many(long n, const double *q, const double *strike, double *out)
{
    for (long k = 0; k < n; k++)
        landing(q + k * %d, strike, out + k * LANDING_OUTPUTS);
}
"""


def _in_c(bodies: int | None, system: PinocchioSystem, Q: Array) -> Prepared:
    """The code that `shockpc export` writes, compiled."""
    if not shutil.which("cc"):
        raise UnsuitedError("cc is not installed")
    program = _symbols(bodies, system).program
    nq, strike = Q.shape[1], system.landing.before.velocity
    m = len(program.outputs) - len(ACCURACY)
    names = [f"number_{k}" for k in range(len(program.outputs))]
    untested = Samples(np.zeros((1, nq + 3)), np.zeros((1, m)), np.ones(m))
    files = code_files("c", program, {"q": nq, "strike": 3}, names, (), ILL_CONDITIONED, untested)
    many = _compiled({**files, "many.c": LOOP % nq})
    out = np.empty((len(Q), len(names)))
    arrays = np.ascontiguousarray(Q), strike.copy(), out
    return Prepared(lambda: many(len(Q), *arrays), lambda _: out[:, :m])


def _compiled(files: dict[str, str]) -> Any:
    """The function `many` of files in C, compiled; it takes a number and three arrays."""
    options = ("-std=c99", "-O1", "-fPIC", "-shared", "-o", "landing.so")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        subprocess.run(["cc", *options, "landing.c", "many.c", "-lm"], cwd=folder, check=True)
        many = ctypes.CDLL(f"{folder}/landing.so").many
    many.argtypes = (ctypes.c_long, *[np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")] * 3)
    return many


WAYS: dict[str, Way] = {
    "Pinocchio in a Python loop: 1 direction, joint velocities": _loop_to_shocks,
    "shock_maps: 3 directions, all bodies": partial(_maps, False),
    "shock_maps with derivatives": partial(_maps, True),
    "symbols in NumPy: shock of all bodies": partial(_in_numpy, None),
    "symbols in NumPy: one shock": partial(_in_numpy, 1),
    "symbols in NumPy: one shock with its gradient": _slope_in_numpy,
    "code in C: shock of all bodies": partial(_in_c, None),
    "code in C: one shock": partial(_in_c, 1),
}
"""Ways to compute many postures by name; shocks of the first bodies are read."""


def in_symbols(budget: float) -> Sheet:
    """Maps, and numbers of the same landings in symbols. Args: budget for each clock [s]."""

    def expected(system: PinocchioSystem, Q: Array) -> Callable[[Array], Array]:
        maps = _maps(False, system, Q)
        shocks = maps.read(maps.run())
        return lambda result: shocks[: len(result), : result.shape[1]]

    sheet = _comparison(IN_SYMBOLS, WAYS, BLOCK, expected, budget)
    note = (
        f"{BLOCK} postures, {WITH_DERIVATIVES} of them with derivatives of maps; difference: of "
        f"shocks, from shock_maps"
    )
    return sheet._replace(title="landings in symbols", notes=(note,))
