"""Run times of the package: analyses, commands, many postures, and rows of sweeps.

Many postures are compared with Pinocchio and MuJoCo.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from shockpc import Contact, Joints, Rotor, SolveError, resolve, shock_maps, shock_profile
from shockpc.bench.cases import known_robot, landing
from shockpc.bench.found_touchdowns import found_touchdowns
from shockpc.bench.many_postures import STRUCK, in_symbols, many_postures
from shockpc.bench.measure import cost, timed
from shockpc.bench.measured import measured_landings, measured_steps, measured_tosses
from shockpc.bench.methods import all_quantities, double_jumps, system_of
from shockpc.bench.soft_and_stiff import stiff_contacts
from shockpc.core.impulse import solve_impact
from shockpc.core.percussion import translation
from shockpc.core.spatial import Array
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.executor import processes
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.method.dynamics import dynamics
from shockpc.quantities.of_bodies import percussion
from shockpc.robot.robot import Robot
from shockpc.show.row_files import RowFiles
from shockpc.show.tables import Row, Sheet
from shockpc.studies.analyze.report import landing_report
from shockpc.studies.sweep.study import sweep
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

ANALYZE = ("-m", "shockpc", "analyze", "anymal_b", "--contact", "LF_FOOT")
COMMANDS = {
    "import pinocchio": ("-c", "import pinocchio"),
    "shockpc analyze --format json": (*ANALYZE, "--format", "json"),
    "shockpc analyze --out, with the figure": (*ANALYZE, "--out", "FOLDER"),
}
"""Arguments of Python by the name of the row, with FOLDER for a folder that is removed.

Run times are compared with that of the first.
"""

FEET = tuple(Contact(frame=f"{leg}_foot") for leg in ("FL", "FR", "RL", "RR"))
HOPPING = tuple(replace(foot, restitution=0.1) for foot in FEET)
SERIES_ELASTIC = Joints(rotor={"*": Rotor(inertia=1.11842e-4, gear_ratio=6.33, stiffness=100.0)})
STIFF: dict[str, dict[str, Any]] = {
    "one foot": {"contact": FEET[:1]},
    "one foot, without gravity": {"contact": FEET[:1], "gravity": False},
    "four feet": {"contact": FEET},
    "four feet that open and close again": {"contact": HOPPING, "joints": SERIES_ELASTIC},
    "the same, without gravity": {"contact": HOPPING, "joints": SERIES_ELASTIC, "gravity": False},
}
"""Landings of Go2 on contacts of 1e5 N/m: what their scenes give."""

ROWS = 16384
"""Number of rows of each sweep; sixteen times as many where processes are compared."""


def _package(budget: float) -> Sheet:
    """Warm analyses, and commands against `import pinocchio` in alternating processes.

    Args: budget for each clock [s].

    Raises:
        SolveError: a process failed; the text is the last line of its output.
    """
    rows: list[Row] = []

    def add(name: str, run: Callable[[], Any], target: str | None = None) -> None:
        rows.append((name, cost(run, budget), target, None))

    # Robots are loaded beforehand: these rows are the time of an analysis alone.
    robot, scene = landing(known_robot("anymal_b"), "LF_FOOT")
    talos = landing(known_robot("talos"), "left_sole_link", "right_sole_link")
    for name, landed, target in (
        ("ANYmal B, one foot", (robot, scene), "3 ms"),
        ("Talos, both feet", talos, "12 ms"),
    ):
        add(f"shock_profile, {name}", partial(shock_profile, landed[1], landed[0]), target)
        everything = all_quantities(system_of(*landed)).run
        everything()  # reads the meshes, once
        add(f"shock_profile with all derived numbers, {name}", everything)
    steps = partial(_double_percussion, resolve(scene, robot))
    add("steps 1-3 in double precision, ANYmal B, one foot", steps, "0.25 ms")
    # The cost of an option is the difference from the same landing without it.
    for name, changed in (
        ("finite stiffness", replace(scene, contact_stiffness=1e5)),
        ("friction", replace(scene, friction=0.6)),
    ):
        added, printed = _added(robot, scene, changed, budget)
        of_profile = f"{name} adds to shock_profile, ANYmal B, one foot"
        rows.append((of_profile, float(added), "1 ms", None))
        rows.append((f"{name} adds to shock_profile and its text", float(printed), None, None))
    go2 = known_robot("go2")
    for name, parts in STIFF.items():
        stiff = resolve(Scene(robot="go2", contact_stiffness=1e5, **parts), go2)
        events = len(CompliantLanding(stiff).motion.events)
        run = partial(CompliantLanding, stiff)
        add(f"motion on finite stiffness, Go2, {name}, {events} events", run)
    rows += _commands()
    return Sheet("run time of the package", ("what", "median [ms]", "target", "× import [-]"), rows)


def _commands() -> list[Row]:
    """The times of the commands.

    One process of each in turn, so that a slow moment of the machine does not favour one of them.
    """
    turns = []
    for _ in range(5):
        turns.append([_process_time(arguments) for arguments in COMMANDS.values()])
    times = np.median(turns, axis=0).tolist()
    rows: list[Row] = []
    # The first is the import of Pinocchio.
    for name, target, seconds in zip(
        COMMANDS, (None, "1.6 × import", "1300 ms"), times, strict=True
    ):
        rows.append((name, seconds, target, seconds / times[0]))
    return rows


def _added(robot: Robot, scene: Scene, changed: Scene, budget: float) -> Array:
    """The added processor time (2,) of an analysis if the scene is changed [s].

    It is without the text and with it; the median of alternating runs.
    """
    differences: list[Array] = []

    def seconds(scene: Scene) -> Array:
        start = time.thread_time()
        profile = shock_profile(scene, robot)
        analysed = time.thread_time()
        landing_report(profile).text("table")
        return np.array([analysed, time.thread_time()]) - start

    timed(lambda: differences.append(seconds(changed) - seconds(scene)), 10.0 * budget)
    return np.asarray(np.median(differences, axis=0))


def _double_percussion(resolved: PosedLanding) -> Array:
    """Steps 1 to 3 in double precision: radii of percussion (nb,) [m]."""
    jumps = double_jumps(resolved)
    omega, v = jumps[:, :3], jumps[:, 3:]
    normal = resolved.plane.normal @ resolved.state.rotation[0]
    translates = translation(omega, v, normal, 1.0, 1.0, 1e-9)
    return np.asarray(percussion(omega, v, normal, 1.0, *translates).ropc)


def _process_time(arguments: tuple[str, ...]) -> float:
    with tempfile.TemporaryDirectory() as folder:
        words = [word.replace("FOLDER", folder) for word in arguments]
        start = time.perf_counter()
        # An installed package is compiled once, not in each process.
        env = os.environ | {"PYTHONDONTWRITEBYTECODE": ""}
        process = subprocess.run(
            [sys.executable, *words], capture_output=True, text=True, check=False, env=env
        )
        seconds = time.perf_counter() - start
    if process.returncode:
        last = (process.stderr.strip().splitlines() or ["no output"])[-1]
        raise SolveError(f"a process of the benchmark failed ({' '.join(arguments)}): {last}")
    return seconds


def _sweeps(budget: float) -> Sheet:
    """Rows of sweeps against the maps alone, what dominates them, and two processes against one.

    Args: budget for a clock [s].
    """
    rows = [_sweep_costs(name, budget) for name in ("hyq", "anymal_b", "talos")]
    # A single process is a child too, so that only the number of processes differs.
    single, together = (_in_processes(_sample("hyq", 16 * ROWS), jobs) for jobs in (1, 2))
    notes = (
        "row: joints drawn within limits, shock at one point with its most severe direction, "
        "friction and condition, in Parquet; "
        "maps: shock_maps of all bodies in the same postures; "
        "derivatives: the same with derivatives, in 1024 of them",
        f"{16 * ROWS} rows of hyq: {single:.2f} s in one process, {together:.2f} s in two: "
        f"{single / together:.2f} times as fast",
    )
    header = (
        "robot",
        "bodies × velocities",
        "row [µs]",
        "maps [µs]",
        "row / maps [-]",
        "derivatives / maps [-]",
        "row: Pinocchio [%]",
        "row: Eq. 4 [%]",
    )
    return Sheet("sweeps", header, rows, notes)


def _sweep_costs(name: str, budget: float) -> Row:
    """The costs of a row of a sweep, of maps, and of what dominates a row."""
    evaluation = _sample(name, ROWS)
    landings = evaluation.landings
    robot = landings.robot
    resolved = resolve(landings.scene, robot)
    Q = landings.resolved()[0][:4096]
    # A row as a sweep writes it, against the maps of all bodies (Eqs. 4, 8 and 9) in the same
    # postures.
    row = cost(partial(_written, evaluation, None), budget, ROWS)
    maps = cost(partial(shock_maps, resolved, Q), budget, len(Q))
    without = cost(partial(shock_maps, resolved, Q[:1024], derivatives=False), budget, 1024)
    derivatives = cost(partial(shock_maps, resolved, Q[:1024], derivatives=True), budget, 1024)
    # Shares of a row: Pinocchio's calls, and the solution of Eq. 4.
    pinocchio = partial(dynamics, robot, Q[:256], resolved.joint_model)
    equation = resolved.equation(pinocchio(), False)
    eq_4 = partial(
        solve_impact,
        equation.inertia,
        equation.J_c,
        equation.b,
        equation.terms,
        equation.tolerance,
    )
    return (
        name,
        len(robot.bodies) * robot.model.nv,
        row,
        maps,
        row / maps,
        derivatives / without,
        cost(pinocchio, budget, 256) / row,
        cost(eq_4, budget, 256) / row,
    )


def _in_processes(evaluation: Evaluation[VariedLandings], jobs: int) -> float:
    """Time for a sweep in so many processes, after they have started [s].

    A single one is a process too, so that both do the same.
    """
    with processes(jobs) as workers:
        # Long enough to keep a worker busy until the other one has started as well.
        for future in [workers.submit(time.sleep, 0.5) for _ in range(jobs)]:
            future.result()
        start = time.perf_counter()
        _written(evaluation, workers)
        return time.perf_counter() - start


def _sample(name: str, rows: int) -> Evaluation[VariedLandings]:
    """Random postures of a robot, with the shock at the origin of its base."""
    robot, scene = landing(known_robot(name), STRUCK[name])
    return sweep(scene, robot=robot, sample=rows, prove=0, at=[robot.bodies[0].name])


def _written(evaluation: Evaluation[VariedLandings], workers: Executor | None) -> int:
    """Compute a sweep and write it into a folder that is removed; the number of rows."""
    with tempfile.TemporaryDirectory() as folder:
        files = RowFiles(evaluation, Path(folder), "parquet")
        files.prepare(resume=False)
        return sum(files.write(workers))


COSTS = {
    "costs": _package,
    "soft contacts": stiff_contacts,
    "many postures": many_postures,
    "symbols": in_symbols,
    "sweeps": _sweeps,
    "measured landings": measured_landings,
    "measured tosses": measured_tosses,
    "measured steps": measured_steps,
    "touchdowns in logs": found_touchdowns,
}
"""Tables of the costs of the package, and of the difference of the model from measurements.

The argument is the time for each clock [s].
"""
