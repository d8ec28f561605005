"""Part 3: what leaving out saves. The same scenes with only what they need, and with every part forced on: time and memory.

Each runs in a process of its own, for what is imported counts too: `python -m shockpc.bench.saving needed anymal_b`.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shockpc.bench.system import system_of
from shockpc.errors import SolveError
from shockpc.model.contact import Contact
from shockpc.model.dynamics import tree
from shockpc.model.equation import solve
from shockpc.model.rows import about_com
from shockpc.profile import shock_profile
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene, Strike

__all__ = ["PARTS", "SCENES", "Saving", "measure_saving", "run_alone"]

SCENES = {
    "anymal_b": ("anymal_b", "LF_FOOT"),
    "talos": ("talos", "left_sole_link"),
    "icub": ("icub", "l_sole"),
}
"""Scenes that need little: one foot, no loop, no drive, no picture."""

PARTS = (
    "pictures: matplotlib and shapely imported, the figure drawn",
    "check-up: yourdfpy imported, the file read a second time",
    "geometry: visual meshes read besides the collision ones",
    "reduction by a G that holds nothing (Eq. 7), drives of zero inertia",
    "second solution refined and sampled, needed or not",
)
"""What is forced on."""


@dataclass(frozen=True)
class Saving:
    """What one way of running a scene costs.

    Attributes:
        scene: its name.
        parts: "needed" or "everything".
        start: imports and robot file [s].
        work: the analysis, median of three after the first [s].
        memory: largest the process ever was [MB].
    """

    scene: str
    parts: str
    start: float
    work: float
    memory: float


def measure_saving(scene: str) -> list[Saving]:
    """Run a scene both ways, each in a process of its own.

    Raises:
        SolveError: one of them failed; the text is what it said last.
    """
    found = []
    for parts in ("needed", "everything"):
        command = [sys.executable, "-m", "shockpc.bench.saving", parts, scene]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            said = done.stderr.strip().splitlines() or ["nothing"]
            raise SolveError(f"the bench's own process failed ({' '.join(command[2:])}): {said[-1]}")
        found.append(Saving(scene, parts, **json.loads(done.stdout)))
    return found


def run_alone(parts: str, scene: str) -> dict[str, float]:
    """Do the work in this process: seconds until the robot is there, seconds of the analysis, megabytes."""
    begin = time.perf_counter()
    robot_name, foot = SCENES[scene]
    robot = load_robot(robot_name)
    if parts == "everything":
        import shockpc.show.figure.landing  # noqa: F401 - importing it is what is timed
        from shockpc.robot.geometry import outline

        outline(robot, "visual")
    landing = Scene(robot=robot_name, contact=(Contact(frame=foot),), strike=Strike(speed=1.0, strike_angle_deg=20.0))
    start = time.perf_counter() - begin
    seconds = []
    for _ in range(4):
        begin = time.perf_counter()
        _work(robot, landing, parts == "everything")
        seconds.append(time.perf_counter() - begin)
    return {"start": start, "work": sorted(seconds[1:])[1], "memory": _most_memory()}


def _most_memory() -> float:
    """The largest that this process ever was [MB]."""
    status = Path("/proc/self/status")
    if status.exists():
        # What getrusage says begins with the size of the process that started this one.
        line = next(line for line in status.read_text(encoding="utf-8").splitlines() if line.startswith("VmHWM"))
        return float(line.split()[1]) / 1024.0
    unit = 2.0**20 if sys.platform == "darwin" else 2.0**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def _work(robot: Robot, landing: Scene, everything: bool) -> None:
    """One analysis; with everything forced on, all that it would otherwise leave out."""
    shock_profile(landing, robot)
    if not everything:
        return
    from shockpc.core.maximal import refine, solve_maximal
    from shockpc.core.rounding import units_of
    from shockpc.health import SAMPLES
    from shockpc.robot.checkup import check_robot
    from shockpc.show.figure.landing import save_figure

    check_robot(robot)
    system = system_of(robot, landing)
    state, rows, nv = system.landing.state, system.landing.rows, robot.model.nv
    nothing_held = np.eye(nv)[None]
    no_inertia = np.full(nv, np.finfo(float).tiny)
    solve(robot, state, rows, no_inertia, nothing_held)
    bodies = tree(robot, state, no_inertia, nothing_held)
    W = about_com(rows.W[0], bodies)
    refine(bodies, W, solve_maximal(bodies, W, rows.b[0]), SAMPLES, units_of(state.rotation[0]))
    with tempfile.TemporaryDirectory() as folder:
        save_figure(shock_profile(landing, robot), Path(folder))


if __name__ == "__main__":
    sys.stdout.write(json.dumps(run_alone(sys.argv[1], sys.argv[2])) + "\n")
