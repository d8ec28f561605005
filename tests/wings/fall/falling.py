"""Falls of a robot with held joints in MuJoCo: over an edge that is a hinge, or on a floor with
friction.

python tests/wings/fall/falling.py [free] [ROBOT...]    # compares five robots in four directions, in some minutes
python tests/wings/fall/falling.py mjcf                 # compares G1's URDF with the MJCF that MuJoCo makes of it
"""

import math
import re
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from shockpc import Joints, Posture, Scene, fall, load_robot
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.robot.shapes.convex import Shape
from shockpc.wings.fall.body import UP, Rigid
from shockpc.wings.fall.cross_section import CrossSection, SectionMotion
from shockpc.wings.fall.planar_fall import Fall, follow_fall
from shockpc.wings.fall.tip_over import _support

ROBOTS = ("g1", "talos", "go2", "anymal_b", "bolt")
HEADINGS = (0.0, 90.0, 180.0, -90.0)


class First(NamedTuple):
    """The first strike of a part that was not on the ground: link, rotation [deg], rate [rad/s],
    speed of its point [m/s].
    """

    links: set[str]
    rotation: float
    rate: float
    speed: float


def _add(spec: Any, body: Any, shape: Shape, number: int) -> None:
    """A shape as MuJoCo has it: hulls of points, and round ones as they are."""
    semi, geom = np.linalg.norm(shape.rounding, axis=0), mujoco.mjtGeom
    quat = np.zeros(4)
    if not semi.any():
        mesh = spec.add_mesh(
            name=f"mesh{number}",
            uservert=shape.points.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        body.add_geom(type=geom.mjGEOM_MESH, meshname=mesh.name, name=f"{number}")
        return
    middle = shape.points.mean(axis=0)
    if len(shape.points) == 2:
        kind = geom.mjGEOM_CYLINDER if semi.min() < 1e-9 * semi.max() else geom.mjGEOM_CAPSULE
        along = shape.points[1] - shape.points[0]
        mujoco.mju_quatZ2Vec(quat, along)
        body.add_geom(
            type=kind,
            pos=middle,
            quat=quat,
            size=[semi.max(), np.linalg.norm(along) / 2.0, 0.0],
            name=f"{number}",
        )
        return
    axes = shape.rounding / semi
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    mujoco.mju_mat2Quat(quat, axes.ravel())
    body.add_geom(type=geom.mjGEOM_ELLIPSOID, pos=middle, quat=quat, size=semi, name=f"{number}")


def simulated(
    rigid: Rigid,
    section: CrossSection,
    forward: Any,
    start: SectionMotion,
    corner: int,
    friction: float | None,
    step: float,
) -> First:
    """The first strike in MuJoCo.

    Args: friction, of the floor, None for a hinge at a corner of the section; step, of time [s].
    """
    spec, left = mujoco.MjSpec(), np.cross(UP, forward)
    spec.option.gravity, spec.option.timestep = (0.0, 0.0, -GRAVITY), step
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 100.0
    a, b = section.corners[corner % len(section.corners)]
    edge = rigid.com + a * forward + b * UP
    lowest = edge[2]
    body = spec.worldbody.add_body(
        mass=rigid.mass,
        ipos=rigid.com,
        fullinertia=rigid.inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)],
        explicitinertial=True,
    )
    if friction is None:
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=left, pos=edge)
    else:
        body.add_freejoint()
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for number, shape in enumerate(rigid.shapes):
        _add(spec, body, shape, number)
    for geom in body.geoms if friction is None else ():
        # What stands turns through the floor.
        if rigid.shapes[int(geom.name)].link in standing_links(rigid):
            geom.contype = geom.conaffinity = 0
    floor = spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=[10, 10, 1], pos=[0, 0, lowest], name="floor"
    )
    turn = np.array([math.cos(start.theta / 2.0), *(math.sin(start.theta / 2.0) * left)])
    if friction is not None:
        floor.friction = [friction, 0.0, 0.0]
        floor.pos, floor.priority, floor.solref = [0.0, 0.0, 0.0], 1, [0.002, 1.0]
    model = spec.compile()
    data = mujoco.MjData(model)
    standing = standing_links(rigid)
    if friction is None:
        data.qpos[0], data.qvel[0] = start.theta, start.omega
    else:
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, turn)
        com = R.reshape(3, 3) @ rigid.com
        data.qpos[:3] = start.z * UP - com
        data.qpos[3:7] = turn
        data.qvel[:3] = start.vx * forward + start.vz * UP - np.cross(start.omega * left, com)
        data.qvel[3:6] = R.reshape(3, 3).T @ (start.omega * left)
    while data.time < 10.0:
        mujoco.mj_step1(model, data)
        hit = {
            rigid.shapes[int(model.geom(max(c.geom)).name)].link
            for c in data.contact
            if c.dist <= 0.0
        } - standing
        if hit:
            break
        mujoco.mj_step2(model, data)
    if friction is None:
        omega, theta = float(data.qvel[0]), float(data.qpos[0])
    else:
        R = data.xmat[1].reshape(3, 3)
        omega, theta = (
            float(left @ R @ data.qvel[3:6]),
            math.atan2(float(-(R @ forward) @ UP), float((R @ UP) @ UP)),
        )
    of_body = [
        c for c in data.contact if rigid.shapes[int(model.geom(max(c.geom)).name)].link in hit
    ]
    deepest = min(of_body, key=lambda c: c.dist)
    return First(hit, math.degrees(theta), omega, -_speed(model, data, deepest.pos))


def _speed(model: Any, data: Any, point: Any) -> float:
    J = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, J, None, point, 1)
    return float(J[2] @ data.qvel)


def standing_links(rigid: Rigid) -> set[str]:
    """Links that are within 2 cm of the ground in the posture; they stand."""
    points, links = rigid.points(-UP[None])
    return set(links[points[:, 2] <= points[:, 2].min() + 0.02].tolist())


def predicted(
    rigid: Rigid, section: CrossSection, forward: Any, found: Fall, without: set[str]
) -> First:
    """The first strike of another part.

    Args: without, links that stand; on a hinge they are no part of the fall.
    """
    left = np.cross(UP, forward)
    skew = np.array([[0.0, -left[2], left[1]], [left[2], 0.0, -left[0]], [-left[1], left[0], 0.0]])
    for impact in found.impacts:
        theta = impact.before.theta
        turn = np.eye(3) + math.sin(theta) * skew + (1.0 - math.cos(theta)) * skew @ skew
        points, links = rigid.points(-turn[2:])
        points = (points - rigid.com) @ turn.T
        a, b = section.at(impact.corner, theta)
        near = (np.abs(points @ forward - a) < 0.01) & (np.abs(points[:, 2] - b) < 1e-3)
        if new := set(links[near].tolist()) - without:
            return First(new, math.degrees(theta), impact.before.omega, impact.speed)
    raise AssertionError("nothing but what stands strikes")


def compared(
    name: str, heading: float, friction: float | None, step: float = 1e-4
) -> tuple[First, First]:
    """The first strike as computed here, and in MuJoCo.

    On a hinge, links that stand are points at the edge alone.
    """
    robot = load_robot(name)
    rigid = Rigid.of(Scene(robot=name), robot)
    forward = rigid.edge(math.radians(heading), 1e-3)[0]
    section = rigid.section(forward)
    corner, theta = section.balance(_support(section, 1e-3)[0])
    length, _, kappa = section.arm(corner)
    nudge = math.radians(2.0)
    if friction is None:
        angle = np.linspace(0.0, 2.0 * math.pi, 1440)
        points, links = rigid.points(np.outer(np.cos(angle), forward) + np.outer(np.sin(angle), UP))
        edge = section.corners[corner % len(section.corners)]
        others = (points[~np.isin(links, list(standing_links(rigid)))] - rigid.com) @ np.stack(
            [forward, UP], axis=1
        )
        section = CrossSection.of(rigid.mass, section.inertia, np.vstack([others, edge]))
        corner = int(np.argmin(np.abs(section.corners - edge).sum(axis=1)))
        corner -= len(section.corners) * (section.side(corner - 1) > theta)
    start = section.pivoting(
        corner, theta + nudge, math.sqrt(2.0 * kappa * GRAVITY / length * (1.0 - math.cos(nudge)))
    )
    found = follow_fall(section, corner, start, friction, hinged=0.0 if friction is None else None)
    return predicted(rigid, section, forward, found, standing_links(rigid)), simulated(
        rigid, section, forward, start, corner, friction, step
    )


def as_mjcf(urdf: Path, folder: Path) -> Path:
    """The MJCF that MuJoCo makes of a URDF with a free base, with its meshes, in a folder."""
    text, meshes = urdf.read_text(), urdf.parents[2]
    for name in set(re.findall(r'filename="([^"]+)"', text)):
        shutil.copy(meshes / name.split("/", 4)[-1], folder)
        text = text.replace(name, str(folder / Path(name).name))
    options = (
        '<compiler strippath="false" discardvisual="false" fusestatic="false" '
        'balanceinertia="true"/>'
    )
    model = mujoco.MjModel.from_xml_string(
        text.replace("</robot>", f"<mujoco>{options}</mujoco></robot>")
    )
    mujoco.mj_saveLastXML(str(file := folder / "robot.xml"), model)
    root = load_robot(str(urdf)).bodies[0].name
    file.write_text(
        re.sub(f'(<body name="{root}"[^>]*>)', r"\1<freejoint/>", file.read_text(), count=1)
    )
    return file


def file_formats(name: str) -> None:
    """Print the largest relative differences of falls and strikes between a robot's URDF and MJCF."""
    with tempfile.TemporaryDirectory() as folder:
        robots = (
            str(load_robot(name).source.path),
            str(as_mjcf(load_robot(name).source.path, Path(folder))),
        )
        common = {
            "friction": 0.5,
            "joints": Joints(model="free"),
            "posture": Posture(reference="neutral"),
        }
        one, other = (fall(Scene(robot=robot, **common)) for robot in robots)
    off = np.zeros(3)
    for a, b in zip(one.tips, other.tips, strict=True):
        off[0] = max(off[0], abs(a.balance / b.balance - 1.0), abs(a.hinged / b.hinged - 1.0))
    for a, b in zip(one.strikes, other.strikes, strict=True):
        assert (a.name, [*a.struck], a.motion) == (b.name, [*b.struck], b.motion)
        off[1] = max(off[1], abs(a.rotation / b.rotation - 1.0), abs(a.speed / b.speed - 1.0))
    for a, b in zip(one.results, other.results, strict=True):
        assert (a.strike.name, a.places) == (b.strike.name, b.places)
        off[2] = max(off[2], *(abs(a.values[key] / b.values[key] - 1.0) for key in a.values))
    print(f"{name}, {len(one.strikes)} strikes, as URDF and MJCF: falls, strikes, quantities:", off)


if __name__ == "__main__":
    if "mjcf" in sys.argv:
        file_formats("g1")
        sys.exit()
    free = "free" in sys.argv
    worst = np.zeros(3)
    for robot_name in [word for word in sys.argv[1:] if word != "free"] or ROBOTS:
        for direction in HEADINGS:
            here, there = compared(
                robot_name, direction, 0.5 if free else None, 1e-4 if free else 5e-5
            )
            off = np.abs(
                [
                    here.rotation - there.rotation,
                    here.rate / there.rate - 1.0,
                    here.speed / there.speed - 1.0,
                ]
            )
            worst = np.maximum(worst, off)
            print(
                robot_name,
                direction,
                "same" if here.links & there.links else f"{here.links} {there.links}",
                here[1:],
                off.round(5),
            )
    print("worst: rotation [deg], rate, speed [1]:", worst.round(5))
