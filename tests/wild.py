"""Robot files of other projects: each is analysed with the numbers of a plain solution, or refused for a reason of physics.

    python tests/wild.py FOLDER...

Tried is every URDF, xacro and MJCF file below each folder that Pinocchio or MuJoCo loads and whose moving bodies have mass; what
they cannot load is no robot by itself (a macro, a part of a model). The plain solution shares no code with the package:
Pinocchio's or MuJoCo's own inertia matrix and Jacobians in one dense system. Each file is computed in a process of its own.
"""

import contextlib
import multiprocessing
import os
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable
from multiprocessing.connection import Connection
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import xacro
from xacro import substitution_args

from shockpc.errors import ShockError
from shockpc.model.contact import Contact
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene, Strike

SECONDS = 100
STRIKE = np.array([0.3, -0.1, -1.0])
TOLERANCE = 1e-9
RANK = 1e-9
"""Relative size of a singular value below which a row repeats others."""
ROUNDING = 1e-14
"""Rounding of the plain solution, times its condition: a difference below it is its own."""

PHYSICS = {
    "no mass": r"",
}
"""What no program can compute, by the words of the refusal; the remedy that it names is tried."""

Jumps = dict[str, np.ndarray]


def dense(M: np.ndarray, J: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, float]:
    """The jump of the velocities that M Δq̇ = Jᵀ λ and J Δq̇ = (−STRIKE, 0, …) give, and the condition of the system."""
    whole = np.zeros(len(free))
    M, J = M[np.ix_(free, free)], J[:, free]
    J, b = J[J.any(axis=1)], np.concatenate([-STRIKE, np.zeros(len(J) - 3)])[J.any(axis=1)]
    s = 1.0 / np.sqrt(np.diag(M))
    L = np.linalg.cholesky(M * np.outer(s, s))
    W = np.linalg.solve(L, (J * s).T).T
    values = np.linalg.svd(W, compute_uv=False)
    kept = values[values > RANK * values[0]]
    whole[free] = s * np.linalg.solve(L.T, np.linalg.pinv(W, rcond=RANK) @ b)
    return whole, float(np.linalg.cond(L) ** 2 * kept[0] / kept[-1])


def by_pinocchio(model: pin.Model, text: str, profile: ShockProfile) -> tuple[Jumps, float]:
    """The landing of a URDF by plain Pinocchio, with a row for each joint that mimics another."""
    data, q, column = model.createData(), profile.q, {name: joint.idx_v for name, joint in zip(model.names, model.joints, strict=True)}
    held = []
    for joint in ElementTree.fromstring(text).iter("joint"):
        for mimic in joint.findall("mimic"):
            if joint.get("name") in column:
                held.append(np.eye(model.nv)[column[joint.get("name")]])
                if mimic.get("joint") in column:
                    held[-1][column[mimic.get("joint")]] -= float(mimic.get("multiplier", "1"))
    M = pin.crba(model, data, q)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)

    def jacobian(link: str, axes: pin.ReferenceFrame) -> np.ndarray:
        return pin.getFrameJacobian(model, data, model.getFrameId(link, pin.FrameType.BODY), axes)

    free = np.ones(model.nv, dtype=bool)
    free[:6] = profile.scene.base == "free"
    M = np.triu(M) + np.triu(M, 1).T
    J = jacobian(profile.scene.contact[0].frame, pin.LOCAL_WORLD_ALIGNED)[:3]
    jump, condition = dense(M, np.concatenate([J, np.reshape(held, (-1, model.nv))]), free)
    twists = {body: jacobian(body, pin.LOCAL) @ jump for body in profile.bodies}
    return {body: np.roll(twist, 3) for body, twist in twists.items()}, condition


def by_mujoco(m: mujoco.MjModel, profile: ShockProfile) -> tuple[Jumps, float]:
    """The landing of an MJCF by plain MuJoCo, with its equality constraints."""
    off = mujoco.mjtDisableBit
    m.opt.disableflags |= off.mjDSBL_CONTACT | off.mjDSBL_LIMIT | off.mjDSBL_FRICTIONLOSS
    m.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data, taken = mujoco.MjData(m), 0
    number = {m.body(i).name or f"body_{i}": i for i in range(m.nbody)}
    computed = {int(m.body_rootid[number[body]]) for body in profile.bodies}
    for joint in range(m.njnt):
        if m.body_rootid[m.jnt_bodyid[joint]] in computed:
            size, at = (7, 4, 1, 1)[m.jnt_type[joint]], m.jnt_qposadr[joint]
            values = profile.q[taken : taken + size]
            data.qpos[at : at + size] = values if size == 1 else np.concatenate([values[:-4], np.roll(values[-4:], 1)])
            taken += size
    mujoco.mj_forward(m, data)
    M, J = np.zeros((m.nv, m.nv)), np.zeros((3, m.nv))
    mujoco.mj_fullM(m, data, M)
    mujoco.mj_jacBody(m, data, J, None, number[profile.scene.contact[0].frame])
    held = np.asarray(data.efc_J).reshape(-1, m.nv)[np.asarray(data.efc_type) == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
    jump, condition = dense(M, np.concatenate([J, held]), np.ones(m.nv, dtype=bool))
    jumps = {}
    for body in profile.bodies:
        linear, angular, R = np.zeros((3, m.nv)), np.zeros((3, m.nv)), data.xmat[number[body]].reshape(3, 3)
        mujoco.mj_jacBody(m, data, linear, angular, number[body])
        jumps[body] = np.concatenate([R.T @ angular @ jump, R.T @ linear @ jump])
    return jumps, condition


def plain(path: Path, packages: dict[str, str]) -> tuple[float, Callable[[ShockProfile], tuple[Jumps, float]]] | None:
    """The mass that moves in a file, and its landing without the package; None if the file is no robot by itself."""
    try:
        if path.suffix == ".xml":
            m = mujoco.MjModel.from_xml_path(str(path))
            return float(m.body_mass[m.body_weldid > 0].sum()), lambda profile: by_mujoco(m, profile)
        text = path.read_text(errors="replace")
        if path.suffix == ".xacro":
            substitution_args._eval_find = substitution_args._eval_dict["find"] = lambda name: packages[name]
            text = xacro.process_file(str(path)).toxml()
        model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
        return sum(inertia.mass for inertia in model.inertias.tolist()[1:]), lambda profile: by_pinocchio(model, text, profile)
    except Exception:  # whatever a library says, it does not load the file
        return None


def contact(robot: Robot) -> Contact:
    """The origin of the body with mass that most joints carry."""
    depth: dict[int, int] = {-1: 0}
    for body, parent in enumerate(robot.parents):
        depth[body] = depth[parent] + 1
    return Contact(frame=robot.bodies[max(range(len(robot.bodies)), key=lambda i: (robot.masses[i] > 0.0, depth[i]))].name)


def landed(path: Path, packages: dict[str, str]) -> ShockProfile:
    """The landing of a file, with all that a report reads of it."""
    robot = load_robot(str(path), packages=packages)
    profile = shock_profile(Scene(robot=str(path), contact=(contact(robot),), strike=Strike(velocity=tuple(STRIKE))), robot)
    _ = profile.health, profile.loads, profile.contacts, profile.directions, profile.percussion
    return profile


def tried(path: Path, packages: dict[str, str], answer: Connection) -> None:
    """Compute one file; sends its outcome and a message, first of all one that stands if the process dies."""
    devnull = os.open(os.devnull, os.O_WRONLY)
    os.dup2(devnull, 1), os.dup2(devnull, 2)
    os.chdir(tempfile.mkdtemp())
    found = plain(path, packages)
    if found is None or not found[0] > 0.0:
        answer.send(("no robot" if found is None else "no mass", ""))
        return
    answer.send(("crashed", "it loads, and then the process ends"))
    profile, remedies = None, {}
    while profile is None:
        try:
            profile = landed(path, remedies)
        except ShockError as refusal:
            named = re.search(r"--package (\S+)=DIR", str(refusal))
            if named and named[1] in packages and named[1] not in remedies:
                remedies[named[1]] = packages[named[1]]
                continue
            physical = any(re.search(words, str(refusal)) for words in PHYSICS.values() if words)
            answer.send(("refused" if physical else "unexplained", str(refusal)))
            return
        except Exception as fault:
            answer.send(("crashed", f"{type(fault).__name__}: {fault}"))
            return
    jumps, condition = found[1](profile)
    theirs = np.array([jumps[body] for body in profile.bodies])
    ours = np.concatenate([profile.delta_omega, profile.delta_v], axis=1)
    largest = np.abs(ours).reshape(-1, 2, 3).max(axis=(0, 2))
    largest[0] = max(largest[0], 1e-3 * largest[1])
    off = float((np.abs(ours - theirs).reshape(-1, 2, 3).max(axis=(0, 2)) / largest).max())
    said = f"differs by {off:.1e}, condition {condition:.1e}"
    answer.send(("agrees" if off <= TOLERANCE else "unsound" if off < ROUNDING * condition else "disagrees", said))


def outcome(path: Path, packages: dict[str, str]) -> tuple[str, str]:
    """What became of a file, in a process of its own."""
    receive, send = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=tried, args=(path, packages, send))
    child.start()
    send.close()
    found = ("no robot", "")
    with contextlib.suppress(EOFError):
        while True:
            if not receive.poll(SECONDS):
                found = ("crashed", f"no result within {SECONDS} s")
                child.kill()
                break
            found = receive.recv()
    child.join()
    return found


def robot_files(folder: Path) -> Iterable[Path]:
    """URDF, xacro and MJCF files below a folder."""
    for path in sorted(folder.rglob("*")):
        if path.suffix in (".urdf", ".xacro") and path.is_file():
            yield path
        elif path.suffix == ".xml" and path.is_file() and re.search(rb"<(?![?!])\s*(\w+)", path.read_bytes())[1] == b"mujoco":
            yield path


def main(folders: list[str]) -> int:
    """Print a table, and each file that is not analysed; returns 1 if one of them is refused without a reason of physics."""
    names = ("no robot", "no mass", "agrees", "unsound", "refused", "unexplained", "disagrees", "crashed")
    rows, listed = [], []
    for folder in map(Path, folders):
        packages = {path.parent.name: str(path.parent) for path in folder.rglob("package.xml")}
        counts: Counter[str] = Counter()
        for path in robot_files(folder):
            what, said = outcome(path, packages)
            counts[what] += 1
            if what not in ("no robot", "no mass", "agrees"):
                listed.append(f"{what}: {folder.name}/{path.relative_to(folder)}: {said}")
                print(listed[-1], flush=True)
        rows.append((folder.name, counts))
    print(f"\n{'folder':24}{'files':>12}" + "".join(f"{name:>12}" for name in names))
    for name, counts in rows:
        print(f"{name:24}{counts.total():12}" + "".join(f"{counts[key]:12}" for key in names))
    return int(any(counts[key] for _, counts in rows for key in ("unexplained", "disagrees", "crashed")))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
