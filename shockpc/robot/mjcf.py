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
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from shockpc.errors import RobotError
from shockpc.robot.files import parse_xml, read_bytes
from shockpc.robot.meshes import UnreadShape
from shockpc.robot.mjcf_text import without_files
from shockpc.robot.source import RobotSource

__all__ = ["Compiled", "compiled", "geom_kinds"]


class Compiled(NamedTuple):
    """An MJCF compiled by MuJoCo.

    Attributes:
        model: the `mujoco.MjModel`; every body and joint has a name.
        keys: keyframes of the file: name and qpos in MuJoCo's order.
        unread: every mesh geom that was removed because its file cannot be read.
        warnings: of MuJoCo.
    """

    model: Any
    keys: tuple[tuple[str, tuple[float, ...]], ...]
    unread: tuple[UnreadShape, ...]
    warnings: tuple[str, ...]


def geom_kinds(geom: Any) -> tuple[str, ...]:
    """Say what a geom of a specification or of a model is for. MuJoCo shows groups 0 to 2 unless it is asked for others."""
    collides = bool(geom.contype or geom.conaffinity)
    shown = not collides or geom.group <= 2
    return ("collision",) * collides + ("visual",) * bool(shown)


@functools.lru_cache(maxsize=16)
def compiled(source: RobotSource, meshes: bool = False) -> Compiled:
    """Compile an MJCF; the result is kept, so that asking again costs nothing.

    Without `meshes` only the meshes that give a body its mass are read, and all other mesh geoms are removed.

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
            found = _compile(mujoco, source, meshes)
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


def _compile(mujoco: Any, source: RobotSource, meshes: bool) -> Compiled:
    """Compile with or without the meshes that give no mass."""
    parts: dict[str, bytes] = {}
    text = without_files(parse_xml(source.xml, source.path.name), source.folders, parts)
    try:
        spec = mujoco.MjSpec.from_string(text, include=parts)
        spec.compiler.fusestatic = False  # it would drop links
        keys = tuple((key.name or f"key_{number}", tuple(key.qpos)) for number, key in enumerate(spec.keys))
        for key in list(spec.keys):
            spec.delete(key)
        _name(mujoco, spec)
        unread = _load_meshes(mujoco, spec, source, meshes)
        return Compiled(spec.compile(), keys, unread, ())
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


def _load_meshes(mujoco: Any, spec: Any, source: RobotSource, everything: bool) -> tuple[UnreadShape, ...]:
    """Pass the files of the meshes that are needed on as bytes, and remove the other mesh geoms and all height fields.

    Returns:
        Every geom that was to be kept and cannot be.
    """
    users: dict[str, list[Any]] = {}
    weighing: dict[str, str] = {}
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD:
            spec.delete(geom)
        elif geom.meshname:
            weighs = _weighs(mujoco, spec, geom)
            if weighs:
                weighing.setdefault(geom.meshname, geom.parent.name)
            if weighs or everything:
                users.setdefault(geom.meshname, []).append(geom)
            else:
                spec.delete(geom)
    assets: dict[str, bytes] = {}
    unread = []
    for number, mesh in enumerate(list(spec.meshes)):
        geoms = users.get(mesh.name, [])
        reason = ""
        if geoms and mesh.file:
            try:
                path = source.folders.asset(mesh.file)
                mesh.file = f"mesh_{number}{path.suffix}"
                assets[mesh.file] = read_bytes(path)
                if everything:
                    _try(mujoco, mesh, assets[mesh.file])
            except (RobotError, ValueError) as refusal:
                reason = _reason(refusal) if isinstance(refusal, ValueError) else str(refusal)
                if mesh.name in weighing:
                    raise RobotError(
                        f'{source.path.name}: body "{weighing[mesh.name]}" takes its mass from mesh "{mesh.name}", which cannot be '
                        f"read: {reason}. Give the mesh, or give the body an <inertial>"
                    ) from None
        if reason:
            unread += [UnreadShape(geom.parent.name, mesh.name, reason, geom_kinds(geom)) for geom in geoms]
            for geom in geoms:
                spec.delete(geom)
        if reason or not geoms:
            spec.delete(mesh)
    spec.assets = assets
    return tuple(unread)


def _try(mujoco: Any, mesh: Any, data: bytes) -> None:
    """Compile one mesh alone. Raises ValueError if MuJoCo cannot read it."""
    spec = mujoco.MjSpec()
    spec.assets = {mesh.file: data}
    spec.add_mesh(name="m", file=mesh.file, scale=mesh.scale, inertia=mesh.inertia)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="m")
    spec.compile()


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
