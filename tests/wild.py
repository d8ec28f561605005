"""Robot files of other projects: each is analysed with the numbers of a plain solution, or refused for a reason of physics.

    python tests/wild.py FOLDER...

Tried is every URDF, xacro and MJCF file below each folder that Pinocchio or MuJoCo loads and whose moving bodies have mass; what
they cannot load is no robot by itself (a macro, a part of a model). The plain solution shares no code with the package:
Pinocchio's or MuJoCo's own inertia matrix and Jacobians in one dense system. Where a file is refused, the remedies that the message
names are tried. Each file is computed in a process of its own. Needs what the tests need: `pip install ".[dev]"`.
"""

import contextlib
import multiprocessing
import os
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import xacro
from xacro import substitution_args

from shockpc import Contact, Joints, Posture, Scene, ShockError, ShockProfile, Strike, load_robot, shock_profile

SECONDS = 100
TOLERANCE = 1e-9
RANK = 1e-8
"""Relative size of a singular value below which a row repeats others, as the package has it."""
ROUNDING = 1e-14
"""Rounding of the plain solution, times its condition: a difference below it is its own."""
OUTCOMES = ("no robot", "no mass", "agrees", "option", "refused", "unsound", "unexplained", "disagrees", "crashed")
"""The last three are failures. "option": agrees with an option that the first message asks for. "refused": for a reason of physics,
and agrees with a remedy that the message names. "unsound": differs by rounding of the plain solution."""

Jumps = dict[str, np.ndarray]
Plain = Callable[[ShockProfile], tuple[Jumps, float]]


def dense(M: np.ndarray, J: np.ndarray, held: np.ndarray, free: np.ndarray, scene: Scene) -> tuple[np.ndarray, float]:
    """The jump of the velocities, and the condition of the system that gives it.

    Args:
        M: (nv, nv) inertia.
        J: (3, nv) Jacobian of the contact point, world axes.
        held: (k, nv) rows of the constraints.
        free: (nv,) whether a velocity is free.
        scene: the directions of its contact and its strike.
    """
    axes = dict(zip("xyz", np.eye(3), strict=True))
    D = np.array([axes[name] for name in scene.contact[0].directions])
    whole, b = np.zeros(len(free)), np.concatenate([-D @ scene.strike.velocity, np.zeros(len(held))])
    M, J = M[np.ix_(free, free)], np.concatenate([D @ J, np.reshape(held, (-1, len(free)))])[:, free]
    s = 1.0 / np.sqrt(np.diag(M))
    L = np.linalg.cholesky(M * np.outer(s, s))
    W = np.linalg.solve(L, (J * s).T).T
    values = np.linalg.svd(W, compute_uv=False)
    kept = values[values > RANK * values[0]]
    whole[free] = s * np.linalg.solve(L.T, np.linalg.pinv(W, rcond=RANK) @ b)
    return whole, float(np.linalg.cond(L) ** 2 * kept[0] / kept[-1])


def by_pinocchio(model: pin.Model, text: str, profile: ShockProfile) -> tuple[Jumps, float]:
    """The landing of a URDF by plain Pinocchio, with a row for each joint that mimics another."""
    if model.nq != len(profile.q):  # the root is the world, and a floating joint of the file carries the robot
        model = pin.buildModelFromXML(text)
        model.jointPlacements[1] = pin.SE3.Identity()
    data, column = model.createData(), {name: joint.idx_v for name, joint in zip(model.names, model.joints, strict=True)}
    held = []
    joints = {joint.get("name"): joint for joint in ElementTree.fromstring(text).iter("joint")}
    for joint in joints.values():
        for mimic in joint.findall("mimic"):
            if joint.get("name") in column and mimic.get("joint") in joints:
                held.append(np.eye(model.nv)[column[joint.get("name")]])
                if mimic.get("joint") in column:
                    held[-1][column[mimic.get("joint")]] -= float(mimic.get("multiplier", "1"))
    M = pin.crba(model, data, profile.q)
    pin.computeJointJacobians(model, data, profile.q)
    pin.updateFramePlacements(model, data)

    def jacobian(link: str, axes: pin.ReferenceFrame) -> np.ndarray:
        return pin.getFrameJacobian(model, data, model.getFrameId(link, pin.FrameType.BODY), axes)

    free = ~profile.landing.joint_model.locked
    free[:6] = profile.scene.base == "free"
    struck = profile.scene.contact[0]
    J = jacobian(struck.frame, pin.LOCAL_WORLD_ALIGNED)
    lever = data.oMf[model.getFrameId(struck.frame, pin.FrameType.BODY)].rotation @ struck.offset
    J = J[:3] - pin.skew(lever) @ J[3:]
    jump, condition = dense(np.triu(M) + np.triu(M, 1).T, J, held, free, profile.scene)
    return {body: np.roll(jacobian(body, pin.LOCAL) @ jump, 3) for body in profile.bodies}, condition


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

    def jacobian(body: int, offset: np.ndarray) -> np.ndarray:
        linear, angular, point = np.zeros((3, m.nv)), np.zeros((3, m.nv)), data.xpos[body] + data.xmat[body].reshape(3, 3) @ offset
        mujoco.mj_jac(m, data, linear, angular, point, body)
        return np.concatenate([angular, linear])

    M, struck = np.zeros((m.nv, m.nv)), profile.scene.contact[0]
    mujoco.mj_fullM(m, data, M)
    held = np.asarray(data.efc_J).reshape(-1, m.nv)[np.asarray(data.efc_type) == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
    J = jacobian(number[struck.frame], np.array(struck.offset))[3:]
    jump, condition = dense(M, J, held, np.ones(m.nv, dtype=bool), profile.scene)
    jumps = {}
    for body in profile.bodies:
        R = data.xmat[number[body]].reshape(3, 3)
        jumps[body] = np.concatenate([R.T @ part for part in np.split(jacobian(number[body], np.zeros(3)) @ jump, 2)])
    return jumps, condition


def plain(path: Path, packages: dict[str, str]) -> tuple[float, Plain] | None:
    """The mass that moves in a file, and its landing without the package; None if the file is no robot by itself."""
    try:
        if path.suffix == ".xml":
            m = mujoco.MjModel.from_xml_path(str(path))
            return float(m.body_mass[m.body_weldid > 0].sum()), lambda profile: by_mujoco(m, profile)
        text = path.read_text(errors="replace").strip()
        if path.suffix == ".xacro":
            substitution_args._eval_find = substitution_args._eval_dict["find"] = lambda name: packages[name]
            text = xacro.process_file(str(path)).toxml()
        text = re.sub(r'="\s*([^"]*?)\s*"', r'="\1"', text)  # Pinocchio drops an inertia with a blank before a number
        model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
        return sum(inertia.mass for inertia in model.inertias.tolist()[1:]), lambda profile: by_pinocchio(model, text, profile)
    except Exception:  # whatever a library says, it does not load the file
        return None


@dataclass(frozen=True)
class Attempt:
    """How a file is landed: the file, the folders that may be read, and what of the scene is not a plain landing."""

    path: Path
    packages: dict[str, str]
    beside: bool = False
    bent: bool = False
    turned: bool = False
    base: str | None = None
    locked: tuple[str, ...] = ()
    plane: str = "xz"
    strike: tuple[float, float, float] = (0.3, 0.0, -1.0)
    directions: tuple[str, ...] = ("x", "y", "z")

    def landed(self) -> ShockProfile:
        """The landing on the body with mass that most joints carry, with all that a report reads of it."""
        robot = load_robot(str(self.path), packages=self.packages)
        depth: dict[int, int] = {-1: 0}
        for number, parent in enumerate(robot.parents):
            depth[number] = depth[parent] + 1
        body = max(range(len(robot.bodies)), key=lambda i: (robot.masses[i] > 0.0, depth[i]))
        offset = tuple(map(float, robot.coms[body] + 0.1)) if self.beside else (0.0, 0.0, 0.0)
        contact = Contact(frame=robot.bodies[body].name, offset=offset, directions=self.directions)
        followers = {mimic.joint for mimic in robot.mimics}
        single = [joint.name for joint in robot.single_joints if joint.axis is not None and joint.name not in followers]
        aside = (0.0, -0.1 * robot.free_base, 0.0)  # so that nothing is symmetric by accident; many fixed bases are planar robots
        strike = Strike(velocity=tuple(map(sum, zip(self.strike, aside, strict=True))))
        turned = (0.0, 80.0, 0.0) if self.turned else None
        posture = Posture(joints=dict.fromkeys(single, 0.35) if self.bent else {}, base_rpy_deg=turned)
        joints = Joints(
            model=None if self.path.suffix == ".xml" else "free", locked=self.locked
        )  # rotors in a URDF are not Pinocchio's
        scene = Scene(
            robot=str(self.path),
            contact=(contact,),
            strike=strike,
            posture=posture,
            base=self.base,
            plane=self.plane,
            joints=joints,
        )
        profile = shock_profile(scene, robot)
        _ = profile.health, profile.loads, profile.contacts, profile.directions, profile.copc
        return profile


def opened(attempt: Attempt, refusal: re.Match[str]) -> Attempt:
    """The folder in which a mesh or an included file lies is opened."""
    return replace(attempt, packages={**attempt.packages, f"part_{len(attempt.packages)}": str(Path(refusal[1]).parent)})


def locked(attempt: Attempt, refusal: re.Match[str]) -> Attempt:
    """The joints that would move fast are locked."""
    return replace(attempt, locked=tuple(re.findall('"([^"]+)" at ', refusal[0])))


def weighed(attempt: Attempt, refusal: re.Match[str]) -> Attempt:
    """Links get the mass and the moments of inertia that they lack, in a copy of the file."""
    root = ElementTree.parse(attempt.path).getroot()
    for link in root.iter("link"):
        inertial = link.find("inertial") if link.find("inertial") is not None else ElementTree.SubElement(link, "inertial")
        for tag, keys in (("mass", ("value",)), ("inertia", ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))):
            part = inertial.find(tag) if inertial.find(tag) is not None else ElementTree.SubElement(inertial, tag)
            for key in keys:
                least = {"value": 0.1, "ixx": 1e-4, "iyy": 1e-4, "izz": 1e-4}.get(key, -np.inf)
                part.set(key, part.get(key) if float(part.get(key, "-inf")) > least * 1e-6 else str(max(least, 0.0)))
    copy = Path(tempfile.mkdtemp()) / attempt.path.name
    ElementTree.ElementTree(root).write(copy)
    return replace(attempt, path=copy)


UPRIGHT = {"plane": "xz", "strike": (0.3, 0.0, -1.0), "directions": ("z",)}
FROM_ABOVE = {"plane": "xy", "strike": (0.3, -1.0, 0.0), "directions": ("y",)}
REMEDIES: tuple[tuple[str, str, dict[str, object] | Callable[[Attempt, re.Match[str]], Attempt]], ...] = (
    (r'leads to "([^"]+)", outside .* --package', "--package", opened),
    (r"--base fixed", "--base fixed", {"base": "fixed"}),
    (r"its base is fixed and no joint is free; free", "--base free", {"base": "free"}),
    (r"cannot be stopped.* contact point", "--offset", {"beside": True}),
    (r"cannot be stopped.* out of the contact", "--slide", UPRIGHT),
    (r"cannot be stopped.* or of the strike", "--plane xy --velocity", FROM_ABOVE),
    (r"cannot be stopped.* posture", "--set", {"bent": True, **UPRIGHT}),
    (r"cannot be stopped.* or of the strike", "--set --plane xy --velocity", FROM_ABOVE),
    (r"cannot be stopped.* posture", "--base-rpy", {"turned": True, **UPRIGHT}),
    (r"no verdict: body .* would move .* --lock", "--lock", locked),
    (r"give mass and inertia in the file|i[xyz]{2} is missing; it has to be", "inertia in the file", weighed),
)
"""Words of a refusal, the remedy that they name as a user types it, and the next attempt. The first is for no reason of physics."""


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
    attempt, used, first, profile = Attempt(path, packages if path.suffix == ".xacro" else {}), [], "", None
    while profile is None:
        try:
            profile = attempt.landed()
        except ShockError as refusal:
            said = str(refusal)
            first = first or said
            for words, name, change in REMEDIES:
                match = re.search(words, said)
                if match and name not in used:
                    used.append(name)
                    attempt = replace(attempt, **change) if isinstance(change, dict) else change(attempt, match)
                    break
            else:
                answer.send(("unexplained", first + "".join(f" → {name}" for name in used) + (f" → {said}" if used else "")))
                return
        except Exception as fault:
            answer.send(("crashed", f"{type(fault).__name__}: {fault}"))
            return
    jumps, condition = (found if attempt.path == path else plain(attempt.path, packages))[1](profile)
    theirs = np.array([jumps[body] for body in profile.bodies])
    ours = np.concatenate([profile.delta_omega, profile.delta_v], axis=1)
    largest = np.abs(ours).reshape(-1, 2, 3).max(axis=(0, 2))
    largest = np.maximum(largest, 1e-3 * largest[::-1])
    off = float((np.abs(ours - theirs).reshape(-1, 2, 3).max(axis=(0, 2)) / largest).max())
    agrees = "option" if used == ["--package"] else "refused" if used else "agrees"
    said = f"{first}{''.join(f' → {name}' for name in used)} [differs by {off:.1e}, condition {condition:.1e}]"
    answer.send((agrees if off <= TOLERANCE else "unsound" if off < ROUNDING * condition else "disagrees", said))


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
        elif path.suffix == ".xml" and path.is_file():
            root = re.search(rb"<(?![?!])\s*(\w+)", path.read_bytes())
            if root and root[1] == b"mujoco":
                yield path


def main(folders: list[str]) -> int:
    """Print each file that is not analysed at once, and a table; returns 1 if one is refused for no reason of physics."""
    table, said = [], Counter()
    for folder in (Path(name).resolve() for name in folders):
        packages = {path.parent.name: str(path.parent) for path in folder.rglob("package.xml")}
        counts: Counter[str] = Counter()
        for path in robot_files(folder):
            what, message = outcome(path, packages)
            counts[what] += 1
            if what not in OUTCOMES[:3]:
                print(f"{what}: {folder.name}/{path.relative_to(folder)}: {message}", flush=True)
                said[
                    f"{what}: " + re.sub(r' \[differs.*|"[^"]*"(, )?|\S*\d\S*| and … more|\S+\.(urdf|xml|xacro): ', "", message)
                ] += 1
        table.append((folder.name, counts))
    print("\n" + "\n".join(f"{count:5} {message}" for message, count in said.most_common()))
    print(f"\n{'folder':24}{'files':>12}" + "".join(f"{name:>12}" for name in OUTCOMES))
    for name, counts in table:
        print(f"{name:24}{counts.total():12}" + "".join(f"{counts[key]:12}" for key in OUTCOMES))
    return int(any(counts[key] for _, counts in table for key in OUTCOMES[-3:]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
