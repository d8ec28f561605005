"""Sweeps: the cost of a row, against the maps alone; what dominates it; and two processes against one."""

import tempfile
import time
from concurrent.futures import Executor
from pathlib import Path
from typing import NamedTuple

from shockpc.bench.measure import timed
from shockpc.core.impulse import solve_impact
from shockpc.executor import InProcess, executor
from shockpc.landing import resolve
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.profile import shock_maps
from shockpc.robot.robot import load_robot
from shockpc.scene import Scene
from shockpc.show.parts import open_sweep, write_parts
from shockpc.studies.sweep.study import Sweep, sweep_of

__all__ = ["ProcessCost", "SweepCost", "process_costs", "sweep_costs"]

ROBOTS = {"hyq": "lf_foot", "anymal_b": "LF_FOOT", "talos": "left_sole_link"}
"""Robots and the frame that strikes."""

BLOCK = 256
"""Postures whose parts are timed."""


class SweepCost(NamedTuple):
    """The cost of one row of a sample: joints drawn, shock at one point and its most severe direction, written to Parquet.

    Attributes:
        robot: its name.
        size: bodies times velocities.
        row: time for a row [s].
        maps: time of `shock_maps` for the same posture [s].
        dynamics: share of Pinocchio's calls in the time for a row [1].
        solution: share of the solution of Eq. 4 [1].
    """

    robot: str
    size: int
    row: float
    maps: float
    dynamics: float
    solution: float


class ProcessCost(NamedTuple):
    """The same sample in one process and in two, after they have started.

    Attributes:
        rows: of the sample.
        one: time in one worker process [s].
        two: time in two [s].
    """

    rows: int
    one: float
    two: float


def sweep_costs(rows: int, budget: float) -> list[SweepCost]:
    """Measure rows of three robots.

    Args:
        rows: of each sample.
        budget: time to spend on each clock [s].
    """
    return [_cost(robot, foot, rows, budget) for robot, foot in ROBOTS.items()]


def _cost(robot: str, foot: str, rows: int, budget: float) -> SweepCost:
    made = _sample(robot, foot, rows)
    landing, Q = resolve(made.scene, made.robot), made.configurations(0)
    block = Q[:BLOCK]
    equation = landing.equation(dynamics(made.robot, block, landing.joint_model.armature), False)
    _, whole = timed(lambda: _written(made, InProcess(), 0), budget)
    _, maps = timed(lambda: [shock_maps(landing, Q[k : k + 4096]) for k in range(0, len(Q), 4096)], budget)
    _, calls = timed(lambda: dynamics(made.robot, block, landing.joint_model.armature), budget)
    _, solution = timed(lambda: solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms), budget)
    row = whole.median / rows
    shares = (calls.median / len(block) / row, solution.median / len(block) / row)
    return SweepCost(robot, len(made.robot.bodies) * made.robot.model.nv, row, maps.median / len(Q), *shares)


def _sample(robot: str, foot: str, rows: int) -> Sweep:
    """Random postures of a robot, with the shock at the origin of its base."""
    loaded = load_robot(robot)
    scene = Scene(robot=robot, contact=(Contact(frame=foot),))
    return sweep_of(scene, loaded, sample=rows, prove=0, at=[loaded.bodies[0].name])


def process_costs(rows: int) -> ProcessCost:
    """Measure one worker process and two on the first robot of `ROBOTS`."""
    made = _sample(*next(iter(ROBOTS.items())), rows)
    seconds = []
    for jobs in (1, 2):
        # A pool of one process, so that both have the same work besides computing.
        with executor(jobs, processes=True) as workers:
            for future in [workers.submit(_imported, 0.5) for _ in range(jobs)]:
                future.result()
            start = time.perf_counter()
            _written(made, workers, 4 * jobs)
            seconds.append(time.perf_counter() - start)
    return ProcessCost(rows, *seconds)


def _imported(pause: float) -> None:
    """Keep a worker busy until the other one has started as well."""
    time.sleep(pause)


def _written(made: Sweep, executor: Executor, ahead: int) -> int:
    """Compute a sweep and write it into a folder that is removed; the number of rows."""
    with tempfile.TemporaryDirectory() as folder:
        open_sweep(made, Path(folder), "parquet", False)
        return sum(write_parts(made, Path(folder), "parquet", executor, ahead))
