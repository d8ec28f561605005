"""MJCF compiled by MuJoCo, which means defaults, frames, replicas and compiler settings as it does.

MuJoCo never sees a path: `mjcf_text` inserts the includes, and meshes that give mass are passed on as bytes, both read from the
open folders only.

The bodies of a compiled model and the links of the robot have the same names: `compiled` names those that have none, so that
`model.body(i).name` is the name of a link in `Robot.frames`, whose frame is MuJoCo's body frame. A MuJoCo body without joints
belongs to the body that carries it. `model.geom_bodyid`, `geom_pos` and `geom_quat` place a geom in its link's frame.
"""

import contextlib
import functools
import os
import re
import warnings
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.paths import read_file
from shockpc.robot.files import parse_xml
from shockpc.robot.mjcf_text import without_files
from shockpc.robot.source import RobotSource

__all__ = ["Compiled", "MeshFile", "compiled", "geom_kinds"]


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


def geom_kinds(geom: Any) -> tuple[str, ...]:
    """Say what a geom of a model is for. MuJoCo shows groups 0 to 2 unless it is asked for others."""
    collides = bool(geom.contype or geom.conaffinity)
    shown = not collides or geom.group <= 2
    return ("collision",) * collides + ("visual",) * bool(shown)


@functools.lru_cache(maxsize=16)
def compiled(source: RobotSource) -> Compiled:
    """Compile an MJCF; the result is kept, so that asking again costs nothing. Only the meshes that give a body its mass are read.

    Raises:
        RobotError: MuJoCo is not installed or refuses the file, or a mesh that gives a body its mass cannot be read.
    """
    try:
        import mujoco
    except ImportError:
        raise RobotError(
            f'{source.path.name} is an MJCF file, which is read by MuJoCo. Install it: pip install "shockpc[mjcf]"'
        ) from None
    notes: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(notes.append)  # by default it writes to standard error and into a file
    try:
        with warnings.catch_warnings(record=True) as caught, _silent():
            warnings.simplefilter("always")
            found = _compile(mujoco, source)
    finally:
        mujoco.set_mju_user_warning(before)
    texts = dict.fromkeys(" ".join(str(text).split()) for text in (*notes, *(warning.message for warning in caught)))
    return found._replace(warnings=tuple(f"{source.path.name}: MuJoCo: {text}" for text in texts))


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Discard what native code, such as Qhull's, writes to standard error."""
    kept, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


def _compile(mujoco: Any, source: RobotSource) -> Compiled:
    """Compile without the meshes that give no mass."""
    parts: dict[str, bytes] = {}
    text = without_files(parse_xml(source.xml, source.path.name), source.folders, parts)
    try:
        spec = mujoco.MjSpec.from_string(text, include=parts)
        spec.compiler.fusestatic = False  # it would drop links
        keys = tuple((key.name or f"key_{number}", tuple(key.qpos)) for number, key in enumerate(spec.keys))
        for key in list(spec.keys):
            spec.delete(key)
        _name(mujoco, spec)
        boxes = _load_meshes(mujoco, spec, source)
        model = spec.compile()
        return Compiled(model, keys, {int(geom.id): mesh for geom, mesh in boxes}, ())
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as refusal:
        raise RobotError(f"{source.path.name}: MuJoCo cannot compile it: {_reason(refusal)}") from None


def _reason(refusal: Exception) -> str:
    """MuJoCo's message in one line, without the line numbers, which are not those of the user's file."""
    text = "; ".join(line.strip() for line in str(refusal).splitlines() if line.strip())
    return re.sub(r"^(XML )?Error: |, (id -?\d+, )?line \d+|; Element name ''", "", text)


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
    """Pass the files of the meshes that give mass on as bytes; remove all height fields.

    Returns:
        The geoms of the other meshes with their files: each is a box without mass now, in the place that the file gives the geom.

    Raises:
        RobotError: a mesh that gives a body its mass cannot be read.
    """
    named, boxes, assets = {mesh.name: mesh for mesh in spec.meshes}, [], {}
    needed: dict[str, str] = {}
    for geom in list(spec.geoms):
        mesh = named.get(geom.meshname)
        if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD:
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
                    f'{source.path.name}: body "{needed[mesh.name]}" takes its mass from mesh "{mesh.name}", which cannot be '
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
