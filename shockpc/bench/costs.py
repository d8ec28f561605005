"""What the package costs: a warm analysis in this process, the command in processes of its own, and rows of sweeps."""

import functools
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from shockpc.bench.cases import known_robot, landing
from shockpc.bench.measure import timed
from shockpc.bench.methods import double_jumps
from shockpc.core.impulse import solve_impact
from shockpc.core.percussion import percussion, translation
from shockpc.core.spatial import Array
from shockpc.errors import SolveError
from shockpc.executor import InProcess, executor
from shockpc.landing import Landing, resolve
from shockpc.model.dynamics import dynamics
from shockpc.profile import shock_maps, shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.scene import Scene
from shockpc.show.parts import open_sweep, write_parts
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.sweep.rows import Sweep
from shockpc.studies.sweep.study import sweep_of

__all__ = ["package_costs", "sweep_costs"]

LANDINGS = (
    ("ANYmal B, one foot", "anymal_b", ("LF_FOOT",), "3 ms"),
    ("Talos, both feet", "talos", ("left_sole_link", "right_sole_link"), "12 ms"),
)
"""Name, robot, feet and target of the analyses that are timed."""

IMPORT = ("-c", "import pinocchio")
ANALYZE = ("-m", "shockpc", "analyze", "anymal_b", "--contact", "LF_FOOT", "--format", "json")

RUNS = 5
"""Of each command."""

SWEPT = {"hyq": "lf_foot", "anymal_b": "LF_FOOT", "talos": "left_sole_link"}
"""Robots of the sweeps and the frame that strikes."""

ROWS = 16384
"""Of each sweep; sixteen times as many where processes are compared."""


def package_costs(budget: float) -> Sheet:
    """Warm analyses, and commands against `import pinocchio` in alternating processes. Args: budget for each clock [s].

    Raises:
        SolveError: a process failed; the text is the last line of its output.
    """
    rows: list[tuple[Cell, ...]] = []

    def add(what: str, run: Callable[[], Any], target: str | None = None) -> None:
        rows.append((what, f"{1e3 * median(timed(run, budget)[1]):.3g}", target, None))

    for name, robot_name, feet, target in LANDINGS:
        robot, scene = landing(known_robot(robot_name), *feet)
        add(f"shock_profile, {name}", functools.partial(shock_profile, scene, robot), target)
        _with_everything(scene, robot)  # reads the meshes, once
        add(f"shock_profile with all derived numbers, {name}", functools.partial(_with_everything, scene, robot))
    robot, scene = landing(known_robot("anymal_b"), "LF_FOOT")
    add(
        "steps 1-3 in double precision, ANYmal B, one foot", functools.partial(_double_percussion, resolve(scene, robot)), "0.25 ms"
    )

    times = np.median([[_process_time(arguments) for arguments in (IMPORT, ANALYZE)] for _ in range(RUNS)], axis=0)
    for what, aim, seconds in zip(
        ("import pinocchio", "shockpc analyze --format json"), (None, "1.6 × import"), times, strict=True
    ):
        rows.append((what, f"{1e3 * seconds:.3g}", aim, f"{seconds / times[0]:.2f}"))
    return Sheet("run time of the package", ("what", "median [ms]", "target", "× import"), rows)


def _with_everything(scene: Scene, robot: Robot) -> list[object]:
    """A profile with everything that is otherwise computed only when it is read."""
    profile = shock_profile(scene, robot)
    computed = (property, functools.cached_property)
    return [getattr(profile, name) for name, value in vars(ShockProfile).items() if isinstance(value, computed)]


def _double_percussion(found: Landing) -> Array:
    """Steps 1 to 3 in double precision: radii of percussion (nb,) [m]."""
    jumps = double_jumps(found)
    omega, v, normal = jumps[:, :3], jumps[:, 3:], found.plane.normal @ found.state.rotation[0]
    return np.asarray(percussion(omega, v, normal, 1.0, *translation(omega, v, normal, 1.0, 1.0, 1e-9)).ropc)


def _process_time(arguments: tuple[str, ...]) -> float:
    """Run time of a Python process that has to succeed [s]."""
    start = time.perf_counter()
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no output"])[-1]
        raise SolveError(f"a process of the benchmark failed ({' '.join(arguments)}): {last}")
    return time.perf_counter() - start


def sweep_costs(budget: float) -> Sheet:
    """Rows of sweeps against the maps alone, what dominates them, and two processes against one. Args: budget for a clock [s]."""
    one, two = (_in_processes(_sample("hyq", 16 * ROWS), jobs) for jobs in (1, 2))
    notes = (
        "row: joints drawn within limits, shock at one point with its most severe direction, friction and condition, in Parquet; "
        "maps: shock_maps of all bodies in the same postures",
        f"{16 * ROWS} rows of hyq: {one:.2f} s in one process, {two:.2f} s in two: {one / two:.2f} times as fast",
    )
    header = ("robot", "bodies × velocities", "row [µs]", "maps [µs]", "row / maps", "row: Pinocchio [%]", "row: Eq. 4 [%]")
    return Sheet("sweeps", header, [_sweep_row(name, budget) for name in SWEPT], notes)


def _sweep_row(name: str, budget: float) -> tuple[Cell, ...]:
    """Time for one row of a sample, for its maps, and the shares of Pinocchio's calls and of Eq. 4 in it."""
    made = _sample(name, ROWS)
    found, Q = resolve(made.scene, made.robot), made.configurations(0)
    block, armature = Q[:256], found.joint_model.armature
    equation = found.equation(dynamics(made.robot, block, armature), False)
    row, maps, calls, solution = (
        median(timed(run, budget)[1]) / count
        for run, count in (
            (lambda: _written(made, InProcess(), 0), ROWS),
            (lambda: shock_maps(found, Q[:4096]), len(Q[:4096])),
            (lambda: dynamics(made.robot, block, armature), len(block)),
            (lambda: solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms), len(block)),
        )
    )
    times = (
        f"{1e6 * row:.1f}",
        f"{1e6 * maps:.1f}",
        f"{row / maps:.2f}",
        *(f"{100.0 * part / row:.0f}" for part in (calls, solution)),
    )
    return name, str(len(made.robot.bodies) * made.robot.model.nv), *times


def _sample(name: str, rows: int) -> Sweep:
    """Random postures of a robot, with the shock at the origin of its base."""
    robot, scene = landing(known_robot(name), SWEPT[name])
    return sweep_of(scene, robot, sample=rows, prove=0, at=[robot.bodies[0].name])


def _in_processes(made: Sweep, jobs: int) -> float:
    """Time for a sweep in so many processes, after they have started [s]; one has a process too, so that both do the same."""
    with executor(jobs, processes=True) as workers:
        # Long enough to keep a worker busy until the other one has started as well.
        for future in [workers.submit(time.sleep, 0.5) for _ in range(jobs)]:
            future.result()
        start = time.perf_counter()
        _written(made, workers, 4 * jobs)
        return time.perf_counter() - start


def _written(made: Sweep, workers: Executor, ahead: int) -> int:
    """Compute a sweep and write it into a folder that is removed; the number of rows."""
    with tempfile.TemporaryDirectory() as folder:
        open_sweep(made, Path(folder), "parquet", False)
        return sum(write_parts(made, Path(folder), "parquet", workers, ahead))
