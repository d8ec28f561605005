"""What the package costs: a warm analysis in this process, and the command in processes of its own."""

import functools
import os
import subprocess
import sys
import tempfile
from statistics import median
from typing import NamedTuple

import numpy as np

from shockpc.bench.cases.family import on
from shockpc.bench.cases.robots import known_robot
from shockpc.bench.measure import timed
from shockpc.bench.methods import double_jumps
from shockpc.core.percussion import percussion, translation
from shockpc.core.spatial import Array
from shockpc.errors import SolveError
from shockpc.landing import Landing, resolve
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["Cost", "analysis_costs", "command_costs"]

LANDINGS = {
    "ANYmal B, one foot": ("anymal_b", ("LF_FOOT",), 3.0),
    "Talos, both feet": ("talos", ("left_sole_link", "right_sole_link"), 12.0),
}
"""Robot, feet and target [ms] of the analyses that are timed."""

COMMANDS = {
    "analyze anymal_b --contact LF_FOOT --format json": "the bodies' jumps and all derived numbers, no figure",
    "analyze anymal_b --contact LF_FOOT --out DIR": "with figures, tables and the scene as files",
}
"""Commands that are timed, and what they compute; the difference is what leaving out saves."""

PEAK = """
import sys
from pathlib import Path
try:
    from shockpc.cli.main import main
    main(sys.argv[1:])
except SystemExit as end:
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    sys.stderr.write("".join(line.split()[1] for line in lines if line.startswith("VmHWM")))
    raise
"""
"""Runs a command and writes the largest memory that the process used [kB] to standard error."""


class Cost(NamedTuple):
    """What something costs.

    Attributes:
        what: is measured.
        milliseconds: median [ms].
        target: largest value that is aimed at, as text.
        ratio: to `import pinocchio`; None for a part of a process.
        memory: largest memory of the process [MB]; None where it is not measured.
    """

    what: str
    milliseconds: float
    target: str = ""
    ratio: float | None = None
    memory: float | None = None


def analysis_costs(budget: float) -> list[Cost]:
    """Warm analyses in this process. Args: budget, time to spend on each clock [s]."""
    found = []
    for name, (robot_name, feet, target) in LANDINGS.items():
        robot = known_robot(robot_name)
        scene = Scene(robot=robot_name, contact=on(*feet))
        _, timing = timed(functools.partial(shock_profile, scene, robot), budget)
        found.append(Cost(f"shock_profile, {name}", 1e3 * timing.median, f"{target:g} ms"))
        _with_everything(scene, robot)  # reads the meshes, once
        _, timing = timed(functools.partial(_with_everything, scene, robot), budget)
        found.append(Cost(f"shock_profile with all derived numbers, {name}", 1e3 * timing.median))
    landing = resolve(Scene(robot="anymal_b", contact=on("LF_FOOT")), known_robot("anymal_b"))
    _, timing = timed(lambda: _double_percussion(landing), budget)
    found.append(Cost("steps 1-3 in double precision, ANYmal B, one foot", 1e3 * timing.median, "0.25 ms"))
    return found


def _with_everything(scene: Scene, robot: Robot) -> list[object]:
    """A profile with everything that is otherwise computed only when it is read."""
    profile = shock_profile(scene, robot)
    return [
        getattr(profile, name)
        for name, value in vars(ShockProfile).items()
        if isinstance(value, property | functools.cached_property)
    ]


def _double_percussion(landing: Landing) -> Array:
    """Steps 1 to 3 in double precision: radii of percussion (nb,) [m]."""
    jumps = double_jumps(landing)
    omega, v, normal = jumps[:, :3], jumps[:, 3:], landing.plane.normal @ landing.state.rotation[0]
    return np.asarray(percussion(omega, v, normal, 1.0, *translation(omega, v, normal, 1.0, 1.0, 1e-9)).ropc)


def command_costs(runs: int) -> list[Cost]:
    """The command against `import pinocchio`, in alternating processes. Args: runs of each.

    Raises:
        SolveError: a process failed; the text is the last line of its output.
    """
    importing = [sys.executable, "-c", "import pinocchio"]
    with tempfile.TemporaryDirectory() as folder:
        words = {text: text.replace("DIR", folder).split() for text in COMMANDS}
        seconds: dict[str, list[float]] = {text: [] for text in ("import pinocchio", *COMMANDS)}
        for _ in range(runs):
            seconds["import pinocchio"].append(_seconds(importing))
            for text, given in words.items():
                seconds[text].append(_seconds([sys.executable, "-m", "shockpc", *given]))
        memory = {text: _run([sys.executable, "-c", PEAK, *given]).stderr for text, given in words.items()}
    start = median(seconds["import pinocchio"])
    found = [Cost("python -c 'import pinocchio'", 1e3 * start, ratio=1.0)]
    for text, what in COMMANDS.items():
        own = median(seconds[text])
        peak = memory[text].strip()
        target = "1.6 × import pinocchio" if "json" in text else ""
        found.append(Cost(f"shockpc {text}: {what}", 1e3 * own, target, own / start, float(peak) / 1024.0 if peak else None))
    return found


def _seconds(command: list[str]) -> float:
    """Run time of a process [s]."""
    _, timing = timed(lambda: _run(command), 0.0)
    return timing.median


def _run(command: list[str]) -> subprocess.CompletedProcess[str]:
    """A process that has to succeed."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | {"MPLBACKEND": "agg"})
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no output"])[-1]
        raise SolveError(f"a process of the benchmark failed ({' '.join(command[1:])}): {last}")
    return done
