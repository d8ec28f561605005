"""The robot of an MJCF: compiled by MuJoCo, which means defaults, frames, replicas and compiler settings as it does.

MuJoCo never sees a path: includes are inserted, and meshes that give mass are passed on as bytes, both read from the open folders.

The bodies of a compiled model and the links of the robot have the same names: `compiled` names those that have none, so that
`model.body(i).name` is the name of a link in `Robot.frames`, whose frame is MuJoCo's body frame. A MuJoCo body without joints
belongs to the body that carries it. `model.geom_bodyid`, `geom_pos` and `geom_quat` place a geom in its link's frame.
"""

import contextlib
import fnmatch
import functools
import math
import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias
from xml.etree.ElementTree import Element, tostring

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import RobotError
from shockpc.paths import read_file
from shockpc.printed import listed
from shockpc.robot.files import OpenFolders, parse_xml, read_xml
from shockpc.robot.limits import refuse_number, refuse_tree
from shockpc.robot.robot import Frame, Loop, Mimic, Robot, add_joint, axis_joint, rotation
from shockpc.robot.source import RobotSource

__all__ = ["Compiled", "MeshFile", "build_mjcf", "compiled", "insert_includes"]

# Sections and attributes that change no mass and no motion, some of which name files.
_UNUSED_SECTIONS = ("contact", "custom", "sensor", "statistic", "visual")
_UNUSED_ELEMENTS = ("hfield", "light", "material", "skin", "texture")
_UNUSED_ATTRIBUTES = ("material", "texture")
_LARGEST = 20_000  # elements; MuJoCo takes several seconds for so many, which grow with the square
_NOT_FINITE = re.compile(r"[+-]?(nan(\(\w*\))?|inf|infinity)", re.IGNORECASE)
_FREE, _BALL, _SLIDE, _HINGE = range(4)  # mjtJoint
_CONNECT, _WELD, _JOINT, _TENDON = range(4)  # mjtEq
_WRAPPED_JOINT = 1  # mjtWrap
_MESH = 7  # mjtGeom; its frame depends on the file of the mesh
_SITE = 6  # mjtObj
# Where Pinocchio's coordinates of a joint are among MuJoCo's, whose quaternions begin with the scalar part.
_COORDINATES = {_FREE: (0, 1, 2, 4, 5, 6, 3), _BALL: (1, 2, 3, 0), _SLIDE: (0,), _HINGE: (0,)}

Equality: TypeAlias = tuple[int, list[int], list[int]]
"""Its number, its objects (−1 for none), and their bodies (0 for the world)."""


class MeshFile(NamedTuple):
    """A mesh of an MJCF whose file is read when its shape is asked for.

    Attributes:
        name: in the MJCF.
        file: as named there.
        scale: (3,) along the axes of the file, applied last [1].
        origin: (3,) of the mesh in the file's coordinates [m].
        rotation: (4,) quaternion w x y z of the mesh's axes in the file's.
    """

    name: str
    file: str
    scale: Array
    origin: Array
    rotation: Array


class Compiled(NamedTuple):
    """An MJCF compiled by MuJoCo.

    Attributes:
        model: the `mujoco.MjModel`; every body and joint has a name.
        keys: keyframes of the file: name and qpos in MuJoCo's order.
        meshes: by the number of a geom, the file of a mesh that gives no mass; the geom itself is a small box in its place.
        warnings: of MuJoCo.
    """

    model: Any
    keys: tuple[tuple[str, tuple[float, ...]], ...]
    meshes: Mapping[int, MeshFile]
    warnings: tuple[str, ...]


def insert_includes(root: Element, folders: OpenFolders) -> str:
    """Replace every <include> of a <mujoco> element by the contents of its file, and return the text of the whole model.

    The path of every mesh is written relative to the main file. The element is changed in place.

    Raises:
        RobotError: an included file is missing, outside the open folders, or included twice.
    """
    _include(root, folders, [folders.file])
    meshdir, strip = "", False
    for compiler in root.findall("compiler"):
        meshdir = compiler.attrib.pop("meshdir", compiler.attrib.pop("assetdir", meshdir))
        strip = compiler.attrib.pop("strippath", str(strip).lower()) == "true"
    for mesh in root.findall("asset/mesh[@file]"):
        file = Path(mesh.get("file", ""))
        mesh.attrib.setdefault("name", file.stem)
        mesh.set("file", str(Path(meshdir) / (file.name if strip else file)))
    return tostring(root, encoding="unicode")


def _include(parent: Element, folders: OpenFolders, opened: list[Path]) -> None:
    """Insert included files below one element. MuJoCo finds all of them from the folder of the main file."""
    for child in list(parent):
        if child.tag != "include":
            _include(child, folders, opened)
            continue
        named = child.get("file", "")
        path = folders.asset(named)
        if path in opened:
            raise RobotError(f'{folders.file.name} includes "{named}" twice; MuJoCo allows a file once, so save it under two names')
        opened.append(path)
        part = read_xml(path)
        _include(part, folders, opened)
        place = list(parent).index(child)
        parent[place : place + 1] = list(part)


def _size(element: Element) -> int:
    """The number of elements that MuJoCo makes of one."""
    count = math.prod(int(word[:9]) for word in element.get("count", "").split() if word.isdecimal())
    return max(count, 1) * (1 + sum(map(_size, element)))


def _without_files(root: Element, folders: OpenFolders, parts: dict[str, bytes]) -> str:
    """The text of a model without textures, height fields and all else that moves no mass; `parts` receives models attached."""
    size = _size(root)
    if size > _LARGEST:
        instead = "lower the count of <replicate>, <composite> or <flexcomp>"
        raise RobotError(f"{size} elements after replication, and up to {_LARGEST} are read; {instead}")
    root[:] = [section for section in root if section.tag not in _UNUSED_SECTIONS]
    for element in root.iter():
        element[:] = [child for child in element if child.tag not in _UNUSED_ELEMENTS]
        for key in _UNUSED_ATTRIBUTES:
            element.attrib.pop(key, None)
        for key, value in element.attrib.items():
            called = f' "{element.get("name")}"' if "name" in element.attrib else ""
            whose = f'{element.tag}{called}: {key} is "{value}"'
            if element.tag != "key" and key not in ("name", "model") and any(map(_NOT_FINITE.fullmatch, value.split())):
                raise RobotError(f"{whose}; it has to be finite numbers")
            if key == "file" and element.tag not in ("mesh", "model"):
                raise RobotError(f"{whose}, a file that is not read here; write out what it stands for")
    for model in root.findall("asset/model[@file]"):
        path = folders.asset(model.get("file", ""))
        inner = OpenFolders(path, folders.packages, folders.allowed)
        part = read_xml(path)
        insert_includes(part, inner)
        for mesh in part.findall("asset/mesh[@file]"):
            mesh.set("file", str(path.parent / mesh.get("file", "")))
        model.attrib.setdefault("name", part.get("model", path.stem))
        key = f"part_{len(parts)}.xml"
        parts[key] = b""
        parts[key] = _without_files(part, inner, parts).encode()
        model.set("file", key)
    return tostring(root, encoding="unicode")


@functools.lru_cache(maxsize=16)
def compiled(source: RobotSource) -> Compiled:
    """Compile an MJCF; the result is kept, so that asking again costs nothing. Only the meshes that give a body its mass are read.

    Raises:
        RobotError: MuJoCo is not installed or refuses the file, or a mesh that gives a body its mass cannot be read.
    """
    parts: dict[str, bytes] = {}
    try:
        import mujoco
    except ImportError:
        raise RobotError('an MJCF file is read by MuJoCo. Install it: pip install "shockpc[mjcf]"') from None
    text = _without_files(parse_xml(source.xml, source.path.name), source.folders, parts)
    notes: list[str] = []
    try:
        with _caught(mujoco, notes):
            spec = mujoco.MjSpec.from_string(text, include=parts)
            spec.compiler.fusestatic = False  # it would drop links
            keys = tuple((key.name or f"key_{number}", tuple(key.qpos)) for number, key in enumerate(spec.keys))
            for key in list(spec.keys):
                spec.delete(key)
            _name(mujoco, spec)
            boxes = _load_meshes(mujoco, spec, source)
            model = spec.compile()
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as refusal:
        said = "; ".join(line.strip() for line in str(refusal).splitlines() if line.strip())
        # The line numbers are not those of the user's file.
        said = re.sub(r"^(XML )?Error: |, (id -?\d+, )?line \d+|; Element name ''", "", said)
        raise RobotError(f"MuJoCo cannot compile it: {said}") from None
    messages = dict.fromkeys(f"MuJoCo: {' '.join(note.split())}" for note in notes)
    return Compiled(model, keys, {int(geom.id): mesh for geom, mesh in boxes}, tuple(messages))


@contextlib.contextmanager
def _caught(mujoco: Any, notes: list[str]) -> Iterator[None]:
    """Collect MuJoCo's warnings, and discard what native code, such as Qhull's, writes to standard error."""
    before, kept, nothing = mujoco.get_mju_user_warning(), os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        mujoco.set_mju_user_warning(notes.append)  # by default it writes to standard error and into a file
        os.dup2(nothing, 2)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
        notes += [str(warning.message) for warning in caught]
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)
        mujoco.set_mju_user_warning(before)


def _name(mujoco: Any, spec: Any) -> None:
    """Name bodies after their number and joints after their body where the file gives no name."""
    taken = {item.name for item in (*spec.bodies, *spec.joints)}

    def free(name: str) -> str:
        while name in taken:
            name += "_"
        taken.add(name)
        return name

    for number, body in enumerate(spec.bodies):
        body.name = body.name or free(f"body_{number}")
        for index, joint in enumerate(body.joints, start=1):
            kind = "free" if joint.type == mujoco.mjtJoint.mjJNT_FREE else "joint" if len(body.joints) == 1 else f"joint_{index}"
            joint.name = joint.name or free(f"{body.name}_{kind}")


def _load_meshes(mujoco: Any, spec: Any, source: RobotSource) -> list[tuple[Any, MeshFile]]:
    """Read the meshes that give mass; the geoms of others, returned with their files, become boxes without mass in their places."""
    named, boxes, assets = {mesh.name: mesh for mesh in spec.meshes}, [], {}
    needed: dict[str, str] = {}
    for geom in list(spec.geoms):
        mesh = named.get(geom.meshname)
        if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD:  # the ground
            spec.delete(geom)
        elif mesh is not None and mesh.file:
            # A primitive with a mesh is fitted to it.
            if geom.type != mujoco.mjtGeom.mjGEOM_MESH or _weighs(mujoco, spec, geom):
                needed.setdefault(mesh.name, geom.parent.name)
            else:
                boxes.append((geom, MeshFile(mesh.name, mesh.file, *map(np.array, (mesh.scale, mesh.refpos, mesh.refquat)))))
                geom.type, geom.size, geom.mass = mujoco.mjtGeom.mjGEOM_BOX, [1e-3] * 3, 0.0
                geom.name = geom.meshname = ""
    for number, mesh in enumerate(named.values()):
        if mesh.file and mesh.name not in needed:
            spec.delete(mesh)
        elif mesh.file:
            try:
                path = source.folders.asset(mesh.file)
                mesh.file = f"mesh_{number}{path.suffix}"
                assets[mesh.file] = read_file(path, "mesh", RobotError)
            except RobotError as refusal:
                raise RobotError(
                    f'body "{needed[mesh.name]}" takes its mass from mesh "{mesh.name}", which cannot be '
                    f"read: {refusal}. Give the mesh, or give the body an <inertial>"
                ) from None
    spec.assets = assets
    return boxes


def _weighs(mujoco: Any, spec: Any, geom: Any) -> bool:
    """Whether MuJoCo takes part of a body's mass from a geom."""
    rule, (low, high) = spec.compiler.inertiafromgeom, spec.compiler.inertiagrouprange
    own = rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE or not geom.parent.explicitinertial
    if rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE or not own or not low <= geom.group <= high:
        return False
    body, moves = geom.parent, spec.compiler.settotalmass > 0
    while body is not None and not moves:
        body, moves = body.parent, bool(body.joints)
    return bool(moves and (geom.density if np.isnan(geom.mass) else geom.mass))


def build_mjcf(source: RobotSource, frames: Sequence[str] = ()) -> Robot:
    """Build the Pinocchio model of an MJCF.

    A body with several joints has one composite joint. A free base stands where its configuration says; `body_pos` is only
    where it starts. Its armature, which MuJoCo adds to the inertia matrix like any other, is added to the base as mass and
    rotational inertia at the body's frame, which gives the same matrix; no joint model takes it away.

    Of several robots in one file that is built which has the first of the `frames` asked for, names or globs of bodies, sites and
    geoms, or else the most joints, with those that equalities tie to it.

    Raises:
        RobotError: MuJoCo refuses the file, or it holds a coupling that cannot be computed.
    """
    found = compiled(source)
    m = found.model
    names = [m.body(body).name if body else "" for body in range(m.nbody)]
    refuse_tree({names[body]: names[m.body_parentid[body]] for body in range(1, m.nbody)})
    for what, unit in (("mass", "kg"), ("inertia", "kg m²"), ("pos", "m"), ("ipos", "m")):
        for name, value in zip(names, np.abs(getattr(m, f"body_{what}")).reshape(m.nbody, -1).max(axis=1), strict=True):
            refuse_number(f'body "{name}"', what, value, unit)
    kept, notes = _kept(m, frames)
    model = _model(m, kept)
    model.name = source.robot_name
    # Both count bodies, and the joints of a body, in the same order.
    joints = np.flatnonzero(np.isin(m.jnt_bodyid, kept)).tolist()
    order = np.array([m.jnt_qposadr[joint] + k for joint in joints for k in _COORDINATES[int(m.jnt_type[joint])]])
    limited = np.flatnonzero(m.jnt_limited & (m.jnt_type >= _SLIDE))
    limits = np.tile([-np.inf, np.inf], (m.nq, 1))
    limits[m.jnt_qposadr[limited]] = m.jnt_range[limited]
    model.lowerPositionLimit, model.upperPositionLimit = limits[order].T
    model.armature = _armature(m)[np.isin(m.dof_jntid, joints)]
    floats = model.joints[1].shortname() == "JointModelFreeFlyer"
    if floats:
        extra = float(model.armature[0])
        model.armature[:6] = 0.0
        if extra:
            base = model.frames[model.getFrameId(model.names[1], pin.FrameType.JOINT)]
            base.inertia = pin.Inertia(extra, np.zeros(3), extra * np.eye(3))
            model.inertias[1] += base.inertia
            notes += (
                f'joint "{model.names[1]}" is free and has armature {extra:g}, which adds {extra:g} kg and '
                f'{extra:g} kg m² to the base, as in MuJoCo; if that is not meant, set armature="0" there or use a <freejoint/>',
            )
    start = pin.neutral(model)
    postures, more = _postures(found, order)
    robot = Robot(source, model, start, postures, (), (), (*found.warnings, *notes, *more))
    equalities = [equality for equality in _equalities(m) if set(equality[2]) <= set(kept)]
    loops = tuple(_loops(m, robot, equalities))
    if floats and any(-1 in loop.bodies for loop in loops):  # where they meet
        start[:7] = m.qpos0[order][:7]
    return replace(robot, start=read_only(start), loops=loops, mimics=_mimics(m, equalities))


def _model(m: Any, bodies: Sequence[int]) -> pin.Model:
    """The model of some bodies, carriers first, with their sites and named collision geoms (many are feet)."""
    model = pin.Model()
    at: dict[int, tuple[int, pin.SE3]] = {}
    for body in bodies:
        joint, place = 0, pin.SE3.Identity()
        if body:
            (joint, carrier), first = at[int(m.body_parentid[body])], int(m.body_jntadr[body])
            place = carrier * _place(m.body_pos[body], m.body_quat[body])
            if m.body_jntnum[body]:
                joint, place = _add_joint(m, model, joint, place, range(first, first + int(m.body_jntnum[body])))
            R = rotation(m.body_iquat[body])
            moments = R @ np.diag(m.body_inertia[body]) @ R.T
            inertia = pin.Inertia(float(m.body_mass[body]), np.array(m.body_ipos[body]), (moments + moments.T) / 2.0)
            model.addFrame(pin.Frame(m.body(body).name, joint, 0, place, pin.FrameType.BODY, inertia))
        at[body] = joint, place
        named = [(m.site(number), pin.FrameType.OP_FRAME) for number in np.flatnonzero(m.site_bodyid == body)]
        solid = (m.geom_bodyid == body) & (m.geom_type != _MESH) & ((m.geom_contype | m.geom_conaffinity) != 0)
        named += [(m.geom(number), pin.FrameType.SENSOR) for number in np.flatnonzero(solid)]
        for item, kind in named:
            if item.name and not any(model.existFrame(item.name, one) for one in (pin.FrameType.OP_FRAME, pin.FrameType.SENSOR)):
                model.addFrame(pin.Frame(item.name, joint, 0, place * _place(item.pos, item.quat), kind), False)
    return model


def _add_joint(m: Any, model: pin.Model, carrier: int, place: pin.SE3, numbers: range) -> tuple[int, pin.SE3]:
    """Add the joint of a body placed so in the carrier's frame; return its index, and the body's frame in the joint's."""
    name = "+".join(m.joint(number).name for number in numbers)
    if model.existJointName(name) or name.count("+") >= max(len(numbers), 2):
        raise RobotError(f'joint "{name}" has a name that is used here for something else; rename it')
    if m.jnt_type[numbers[0]] == _FREE:  # it stands where its configuration says; its place in the file is only a start
        return add_joint(model, carrier, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name), pin.SE3.Identity()
    parts, steps = [], []
    for number in numbers:
        anchor = pin.SE3(np.eye(3), np.array(m.jnt_pos[number]))
        kind, axis, drawn = int(m.jnt_type[number]), np.array(m.jnt_axis[number]), float(m.qpos0[m.jnt_qposadr[number]])
        # Where its coordinate is 0, in the frame where it is `drawn`, its value in the model as drawn.
        rest, part = pin.SE3.Identity(), pin.JointModelSpherical()
        if kind == _SLIDE:
            rest.translation, part = -drawn * axis, axis_joint("prismatic", axis)
        elif kind == _HINGE:
            rest.rotation, part = pin.AngleAxis(-drawn, axis).matrix(), axis_joint("revolute", axis)
        parts.append(part)
        steps.append(place * anchor * rest)
        place = anchor.inverse()
    joint = parts[0]
    if len(parts) > 1:
        joint = pin.JointModelComposite()
        for part, step in zip(parts, [pin.SE3.Identity(), *steps[1:]], strict=True):
            joint.addJoint(part, step)
    return add_joint(model, carrier, joint, steps[0], name), place


def _place(position: Array, quaternion: Array) -> pin.SE3:
    """A frame from its origin and its quaternion, whose scalar part comes first."""
    return pin.SE3(rotation(quaternion), np.array(position))


def _armature(m: Any) -> Array:
    """Reflected inertia (nv,) of joints, and of actuators that act on a joint: gear² times the actuator's own."""
    armature = np.array(m.dof_armature)
    refused = [("tendon", m.tendon(number).name) for number in np.flatnonzero(getattr(m, "tendon_armature", ()))]
    for number in np.flatnonzero(getattr(m, "actuator_armature", ())):
        joint = int(m.actuator_trnid[number, 0])
        if m.actuator_trntype[number] > 1 or m.jnt_type[joint] < _SLIDE:
            refused.append(("actuator", m.actuator(number).name))
        else:
            armature[m.jnt_dofadr[joint]] += m.actuator_armature[number] * m.actuator_gear[number, 0] ** 2
    refused += [("joint", m.joint(m.dof_jntid[dof]).name) for dof in np.flatnonzero(armature < 0)]
    for kind, name in refused:
        instead = "give one not below zero to the hinge or slide joints, that of an actuator times gear², or set it to 0"
        raise RobotError(f'{kind} "{name}" has an armature that is not computed; {instead}')
    return armature


def _equalities(m: Any) -> Iterator[Equality]:
    """Every active equality."""
    for number in np.flatnonzero(m.eq_active0):
        ends = [int(m.eq_obj1id[number]), int(m.eq_obj2id[number])]
        match int(m.eq_type[number]):
            case 2 | 3 as kind:  # joint, tendon
                bodies = [int(m.jnt_bodyid[joint]) for end in ends for joint in _terms(m, kind, end) or ()]
            case 0 | 1:  # connect, weld
                bodies = [int(m.site_bodyid[end]) for end in ends] if m.eq_objtype[number] == _SITE else ends
            case _:
                bodies = []
        yield int(number), ends, bodies


def _kept(m: Any, frames: Sequence[str]) -> tuple[list[int], tuple[str, ...]]:
    """The bodies that belong to the robot, with the world and what is fixed to it, and a warning of others that move."""
    roots = np.unique(m.body_rootid[m.body_jntnum > 0])
    mass = {int(root): float(m.body_mass[m.body_rootid == root].sum()) for root in roots}
    if not mass:
        raise RobotError("no body in it has a joint, so nothing moves; give the robot's base a <freejoint/>")
    owners = ((m.body, range(m.nbody)), (m.site, m.site_bodyid), (m.geom, m.geom_bodyid))
    places = [(item(k).name, int(body)) for item, bodies in owners for k, body in enumerate(bodies)]
    asked = [int(m.body_rootid[body]) for frame in frames for name, body in places if name and fnmatch.fnmatchcase(name, frame)]
    largest = max(mass, key=lambda root: (int(m.body_jntnum[m.body_rootid == root].sum()), mass[root]))  # a box may weigh more
    chosen = next((root for root in asked if root in mass), largest)
    kept = {chosen}
    ties = [{int(m.body_rootid[body]) for body in bodies} & set(mass) for _, _, bodies in _equalities(m)]
    while any(tie & kept and not tie <= kept for tie in ties):
        kept |= set().union(*(tie for tie in ties if tie & kept))
    if len(kept) > 1 and any(m.body_jntnum[root] and m.jnt_type[m.body_jntadr[root]] == _FREE for root in kept):
        tied = listed(m.body(root).name for root in sorted(kept))
        alone = 'with a floating base only one top-level body that moves can be computed; set active="false" on them'
        raise RobotError(f"equalities tie {tied} together, and {alone}")
    left = [root for root in mass if root not in kept]
    bodies = np.flatnonzero(~np.isin(m.body_rootid, left)).tolist()
    if not left:
        return bodies, ()
    others = ", ".join(f'"{m.body(root).name}" ({mass[root]:.3g} kg)' for root in left)
    said = f'"{m.body(chosen).name}", {"which has the contact" if chosen in asked else "with the most joints"}, is computed'
    return bodies, (f"it holds {len(mass)} robots that move on their own: {said}, and {others} left out",)


def _loops(m: Any, robot: Robot, equalities: Sequence[Equality]) -> Iterator[Loop]:
    """The loops that connect and weld equalities close, where MuJoCo holds them."""
    ground = Frame("world", -1, np.eye(3), np.zeros(3), "link")
    for number, ends, bodies in equalities:
        carried = [robot.frames[m.body(body).name] if body else ground for body in bodies]
        if m.eq_type[number] > _WELD or carried[0].body == carried[1].body:  # the same: fixed to one another already
            continue
        # Data of a connect: the anchors in body 1 and 2; of a weld: the anchor in body 2, then the frame of body 2 in body 1.
        weld, data = m.eq_type[number] == _WELD, np.array(m.eq_data[number])
        if m.eq_objtype[number] == _SITE:
            held = [_place(m.site_pos[end], m.site_quat[end]) for end in ends]
        elif weld:
            held = [_place(data[3:6], data[6:10]), pin.SE3(np.eye(3), data[:3])]
        else:
            held = [pin.SE3(np.eye(3), data[:3]), pin.SE3(np.eye(3), data[3:6])]
        first, second = (pin.SE3(place.rotation, place.offset) * frame for place, frame in zip(carried, held, strict=True))
        yield Loop(
            name="–".join(robot.bodies[place.body].name if place.body >= 0 else ground.name for place in carried),
            bodies=(carried[0].body, carried[1].body),
            points=(read_only(first.translation), read_only(second.translation)),
            rotations=(read_only(first.rotation), read_only(second.rotation)),
            axes=np.eye(3),
            turns=bool(weld and data[10] != 0.0),
        )


def _mimics(m: Any, equalities: Sequence[Equality]) -> tuple[Mimic, ...]:
    """The joints that equalities of joints and tendons couple: x₁ − x₁₀ = a₀ + a₁ (x₂ − x₂₀), or a constant without x₂."""
    found: list[Mimic] = []
    for number, ends, _ in equalities:
        kind, called = int(m.eq_type[number]), m.equality(number).name
        called = f' "{called}"' if called else ""
        if kind < _JOINT:
            continue
        if kind > _TENDON or any(_terms(m, kind, end) is None for end in ends):
            valid = 'valid are connect, weld, joint, and fixed tendons; set active="false" to do without it on purpose'
            raise RobotError(f"the equality{called} couples tendons that are not fixed, or flexible parts; {valid}")
        polynomial = [float(value) for value in m.eq_data[number, :5]]
        if any(polynomial[2:]) and ends[1] >= 0:
            instead = "only proportion can be computed: give it as a0 a1 0 0 0, the slope at the posture of interest"
            curve = " ".join(f"{a:g}" for a in polynomial)
            raise RobotError(f"the equality{called} couples joints by a curve, polycoef {curve}; {instead}")
        # x is the value of a joint, or the length of a fixed tendon, a sum of multiples of such values. The equality is solved for
        # a joint that does not follow yet, of the first object if there is one, with the largest multiple.
        sums: dict[str, float] = {}
        constant = polynomial[0]
        for end, factor in zip(ends, (1.0, -polynomial[1]), strict=True):
            for joint, multiple in (_terms(m, kind, end) or {}).items():
                name = m.joint(joint).name
                sums[name] = sums.get(name, 0.0) + factor * multiple
                constant += factor * multiple * float(m.qpos0[m.jnt_qposadr[joint]])
        first = [m.joint(joint).name for joint in _terms(m, kind, ends[0]) or ()]
        free = [name for name, by in sums.items() if by and all(mimic.joint != name for mimic in found)]
        if not free:
            instead = 'and a joint can follow only once; set active="false" on one of them to do without it'
            raise RobotError(f"the equality{called} ties {listed(sums)}, but each of these follows already, {instead}")
        own = max(free, key=lambda name: (name in first, abs(sums[name])))
        leaders = {name: -by / sums[own] for name, by in sums.items() if by and name != own}
        found.append(Mimic(own, leaders, constant / sums[own]))
    return tuple(found)


def _terms(m: Any, kind: int, number: int) -> dict[int, float] | None:
    """The multiple of each joint in an object of an equality, none without an object; None of a tendon that is not fixed."""
    if number < 0 or kind == _JOINT:
        return {number: 1.0} if number >= 0 else {}
    wraps = range(m.tendon_adr[number], m.tendon_adr[number] + m.tendon_num[number])
    fixed = all(m.wrap_type[wrap] == _WRAPPED_JOINT for wrap in wraps)
    return {int(m.wrap_objid[wrap]): float(m.wrap_prm[wrap]) for wrap in wraps} if fixed else None


def _postures(found: Compiled, order: Array) -> tuple[dict[str, Array], tuple[str, ...]]:
    """The keyframes as configurations (nq,), and a warning for each that does not fit the model."""
    from mujoco import mj_normalizeQuat

    postures: dict[str, Array] = {}
    warnings: list[str] = []
    m = found.model
    for name, values in found.keys:
        qpos = np.array(values or m.qpos0)
        if len(qpos) != m.nq or not np.isfinite(qpos).all():
            warnings.append(f'keyframe "{name}" does not hold {m.nq} finite numbers; the posture is left out')
            continue
        mj_normalizeQuat(m, qpos)
        postures[name] = read_only(qpos[order])
    return postures, tuple(warnings)
