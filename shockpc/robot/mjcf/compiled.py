"""An MJCF compiled by MuJoCo.

MuJoCo gives defaults, frames, replicas and compiler settings their meaning.

MuJoCo never sees a path: includes are inserted, and meshes that give mass are passed on as bytes,
both read from the open folders.
"""

import functools
import importlib.util
import math
import os
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree.ElementTree import Element, tostring

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.robot.files.limited_process import LIMITS, in_child
from shockpc.robot.files.reading import OpenFolders, parse_xml, read_xml
from shockpc.text.errors import RobotError
from shockpc.text.paths import read_file
from shockpc.text.printed import listed

if TYPE_CHECKING:
    from shockpc.robot.robot import RobotSource

# Sections and attributes that change no mass and no motion, some of which name files, and <size>
# reserves memory of the simulation.
_UNUSED_SECTIONS = ("contact", "custom", "sensor", "size", "statistic", "visual")
_UNUSED_ELEMENTS = ("hfield", "light", "material", "skin", "texture")
_UNUSED_ATTRIBUTES = ("material", "texture")
_OPTION = ("flag", "equality")
"""All of <option> that can change an impact: whether equalities hold."""
_LARGEST = 20_000  # elements; MuJoCo takes several seconds for so many, which grow with the square
_TOO_LARGE = (
    f"MuJoCo cannot compile it within {LIMITS}; look for a count, a size or models within models "
    f"that grow without end"
)
_NOT_FINITE = re.compile(r"[+-]?(nan(\(\w*\))?|inf|infinity)", re.IGNORECASE)


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
        meshes: by the number of a geom, the file of a mesh that gives no mass; the geom itself is a
            small box in its place.
        warnings: of MuJoCo.
    """

    model: Any
    keys: tuple[tuple[str, tuple[float, ...]], ...]
    meshes: Mapping[int, MeshFile]
    warnings: tuple[str, ...]


def insert_includes(root: Element, folders: OpenFolders) -> str:
    """Replace every <include> of a <mujoco> element by the contents of its file.

    Returns the text of the whole model.

    The path of every mesh is written relative to the main file; one that is not found from there
    may lie beside the included file that names it. The element is changed in place.

    Raises:
        RobotError: an included file is missing, outside the open folders, or included twice.
    """
    included: dict[Element, Path] = {}
    _include(root, folders, folders, [folders.file], included)
    meshdir, strip = "", False
    for compiler in root.findall("compiler"):
        meshdir = compiler.attrib.pop("meshdir", compiler.attrib.pop("assetdir", meshdir))
        strip = compiler.attrib.pop("strippath", str(strip).lower()) == "true"
    for mesh in root.findall("asset/mesh[@file]"):
        file = Path(mesh.get("file", ""))
        mesh.attrib.setdefault("name", file.stem)
        file = Path(file.name) if strip else file
        path = Path(meshdir) / file
        # MuJoCo then leaves out the folder of meshes, too
        if mesh in included and not _found(folders, path):
            beside = Path(os.path.relpath(included[mesh].parent / file, folders.file.parent))
            path = beside if _found(folders, beside) else path
        mesh.set("file", str(path))
    return tostring(root, encoding="unicode")


def _found(folders: OpenFolders, path: Path) -> bool:
    try:
        folders.asset(str(path))
    except RobotError:
        return False
    return True


def _include(
    parent: Element,
    folders: OpenFolders,
    part_folders: OpenFolders,
    opened: list[Path],
    included: dict[Element, Path],
) -> None:
    """Insert included files below one element.

    They are found from the folder of the main file, or else of the file that includes them.

    Their meshes are added to `included`, with the file that names each one.
    """
    for child in list(parent):
        if child.tag != "include":
            _include(child, folders, part_folders, opened, included)
            continue
        uri = child.get("file", "")
        try:
            path = folders.asset(uri)
        except RobotError as missing:
            try:
                path = part_folders.asset(uri)
            except RobotError:
                raise missing from None
        if path in opened:
            raise RobotError(
                f'{folders.file.name} includes "{uri}" twice; MuJoCo allows a file once, so save '
                f"it under two names"
            )
        opened.append(path)
        part = read_xml(path)
        included |= dict.fromkeys(part.iter("mesh"), path)
        _include(part, folders, folders._replace(file=path), opened, included)
        index = list(parent).index(child)
        parent[index : index + 1] = list(part)


def _size(element: Element) -> int:
    """The number of elements that MuJoCo makes of one."""
    words = element.get("count", "").replace("+", "").split()
    count = math.prod(int(word[:9]) for word in words if word.isdecimal())
    return max(count, 1) * (1 + sum(map(_size, element)))


def _without_files(root: Element, folders: OpenFolders, parts: dict[str, bytes]) -> str:
    """The text of a model without textures, height fields and all else that moves no mass.

    `parts` receives models attached.
    """
    # Counted before MuJoCo expands them, because a few characters may stand for any number of
    # bodies.
    size = _size(root)
    if size > _LARGEST:
        remedy = "lower the count of <replicate>, <composite> or <flexcomp>"
        raise RobotError(
            f"{size} elements after replication, and up to {_LARGEST} are read; {remedy}"
        )
    root[:] = [section for section in root if section.tag not in _UNUSED_SECTIONS]
    # files keep attributes that other versions of MuJoCo had, which it refuses
    for option in root.findall("option"):
        option.attrib.clear()
        for part in option:
            part.attrib = {
                key: value for key, value in part.attrib.items() if (part.tag, key) == _OPTION
            }
    for element in root.iter():
        element[:] = [child for child in element if child.tag not in _UNUSED_ELEMENTS]
        for key in _UNUSED_ATTRIBUTES:
            element.attrib.pop(key, None)
        for key, value in element.attrib.items():
            title = f' "{element.get("name")}"' if "name" in element.attrib else ""
            subject = f'{element.tag}{title}: {key} is "{value}"'
            if (
                element.tag != "key"
                and key not in ("name", "model")
                and any(map(_NOT_FINITE.fullmatch, value.split()))
            ):
                raise RobotError(f"{subject}; it has to be finite numbers")
            if key == "file" and element.tag not in ("mesh", "model"):
                raise RobotError(
                    f"{subject}, a file that is not read here; write out what it stands for"
                )
    for model in root.findall("asset/model[@file]"):
        path = folders.asset(model.get("file", ""))
        inner = folders._replace(file=path)
        part = read_xml(path)
        insert_includes(part, inner)
        # Paths in an attached model are relative to its own file.
        for mesh in part.findall("asset/mesh[@file]"):
            mesh.set("file", str(path.parent / mesh.get("file", "")))
        model.attrib.setdefault("name", part.get("model", path.stem))
        key = f"part_{len(parts)}.xml"
        # The name is taken at once, because models attached to this one take the next.
        parts[key] = b""
        parts[key] = _without_files(part, inner, parts).encode()
        model.set("file", key)
    return tostring(root, encoding="unicode")


@memoized()
def compiled(source: "RobotSource") -> Compiled:
    """Compile an MJCF; the result is kept, so that asking again costs nothing.

    Only the meshes that give a body its mass are read.

    MuJoCo compiles in a child process, because a small file can ask for any amount of time and
    memory.

    Raises:
        RobotError: MuJoCo is not installed or refuses the file, or a mesh that gives a body its
            mass cannot be read.
    """
    if importlib.util.find_spec("mujoco") is None:
        raise RobotError(
            'MJCF files need the package "mujoco"; install it with: pip install mujoco'
        )
    work = functools.partial(_compile, source.xml, source.folders, source.freed)
    answer = in_child(work, libraries=("mujoco", __name__))
    if answer is None:
        raise RobotError(_TOO_LARGE)
    import mujoco

    compiled_here, binary, seen = answer
    source.folders.seen.update(seen)
    return compiled_here._replace(
        model=mujoco.MjModel.from_binary_path("model.mjb", {"model.mjb": binary})
    )


def _compile(
    xml: str, folders: OpenFolders, freed: bool
) -> tuple[Compiled, bytes, Mapping[Path, Any]]:
    """The compiled model without the model itself, that model, and the state of the files read.

    The model is given as MuJoCo saves it.

    Args: xml, folders and freed, of a `RobotSource`, whose import would take the child as long as
    that of MuJoCo.
    """
    import mujoco

    parts: dict[str, bytes] = {}
    notes: list[str] = []
    # by default it writes to standard error and into a file
    mujoco.set_mju_user_warning(notes.append)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            text = _without_files(parse_xml(xml, folders.file.name), folders, parts)
            spec = mujoco.MjSpec.from_string(text, include=parts)
            spec.compiler.fusestatic = False  # it would drop links
            added = freed and _free_base(mujoco, spec)
            keys = _without_keyframes(spec)
            _name(mujoco, spec)
            boxes = _load_meshes(mujoco, spec, folders)
            model = spec.compile()
            # A keyframe without a base has it where the model starts.
            if added:
                base = tuple(model.qpos0[:7])
                keys = tuple((name, qpos and base + qpos) for name, qpos in keys)
    # RuntimeError when an array is too large, or a model is attached to itself
    except (MemoryError, RuntimeError):
        raise RobotError(_TOO_LARGE) from None
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as refusal:
        message = "; ".join(line.strip() for line in str(refusal).splitlines() if line.strip())
        # The line numbers are not those of the user's file.
        message = re.sub(r"^(XML )?Error: |, (id -?\d+, )?line \d+|; Element name ''", "", message)
        raise RobotError(f"MuJoCo cannot compile it: {message}") from None
    notes += [str(warning.message) for warning in caught]
    messages = dict.fromkeys(f"MuJoCo: {' '.join(note.split())}" for note in notes)
    binary = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, binary)
    result = Compiled(None, keys, {int(geom.id): mesh for geom, mesh in boxes}, tuple(messages))
    return result, binary.tobytes(), folders.seen


def _without_keyframes(spec: Any) -> tuple[tuple[str, tuple[float, ...]], ...]:
    """The names of keyframes with their coordinates, which are taken out of the model.

    With an added base they are too short for MuJoCo.
    """
    keys: list[tuple[str, tuple[float, ...]]] = []
    for number, key in enumerate(list(spec.keys)):
        keys.append((key.name or f"key_{number}", tuple(key.qpos)))
        spec.delete(key)
    return tuple(keys)


def _free_base(mujoco: Any, spec: Any) -> bool:
    """Give the one top-level body that moves a free joint; whether that was needed.

    Raises:
        RobotError: there are several, or it hangs on the world by a further joint.
    """
    tops = [
        body for body in spec.worldbody.bodies if body.find_all(mujoco.mjtObj.mjOBJ_JOINT)
    ] or list(spec.worldbody.bodies)
    joints: list[Any] = []
    for body in tops:
        joints += body.joints
    if any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in joints) or not tops:
        return False
    if len(tops) > 1:
        reason = (
            f"{len(tops)} bodies hang on the world apart from one another "
            f"({listed([body.name for body in tops], 4)})"
        )
        raise RobotError(
            f"its base cannot be freed: {reason}; put them into one body, the trunk, with a "
            f"<freejoint/>"
        )
    if joints:
        joint = f'body "{tops[0].name}" hangs on the world by joint "{joints[0].name}"'
        raise RobotError(
            f"its base cannot be freed: {joint}; give it a <freejoint/> instead, or the world a "
            f"body that carries it"
        )
    tops[0].add_freejoint()
    return True


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
            if joint.type == mujoco.mjtJoint.mjJNT_FREE:
                kind = "free"
            elif len(body.joints) == 1:
                kind = "joint"
            else:
                kind = f"joint_{index}"
            joint.name = joint.name or free(f"{body.name}_{kind}")


def _load_meshes(mujoco: Any, spec: Any, folders: OpenFolders) -> list[tuple[Any, MeshFile]]:
    """Read the meshes that give mass, and return the geoms of others with their files.

    Such geoms become boxes without mass in their places.
    """
    meshes, boxes, assets = {mesh.name: mesh for mesh in spec.meshes}, [], {}
    needed: dict[str, str] = {}
    for geom in list(spec.geoms):
        mesh = meshes.get(geom.meshname)
        if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD:  # the ground
            spec.delete(geom)
        elif mesh is not None and mesh.file:
            # A primitive with a mesh is fitted to it.
            if geom.type != mujoco.mjtGeom.mjGEOM_MESH or _weighs(mujoco, spec, geom):
                needed.setdefault(mesh.name, geom.parent.name)
            else:
                boxes.append(
                    (
                        geom,
                        MeshFile(
                            mesh.name,
                            mesh.file,
                            *map(np.array, (mesh.scale, mesh.refpos, mesh.refquat)),
                        ),
                    )
                )
                geom.type, geom.size, geom.mass = mujoco.mjtGeom.mjGEOM_BOX, [1e-3] * 3, 0.0
                geom.name = geom.meshname = ""
    for number, mesh in enumerate(meshes.values()):
        if mesh.file and mesh.name not in needed:
            spec.delete(mesh)
        elif mesh.file:
            try:
                path = folders.asset(mesh.file)
                mesh.file = f"mesh_{number}{path.suffix}"
                assets[mesh.file] = read_file(path, "mesh", RobotError)
            except RobotError as refusal:
                raise RobotError(
                    f'body "{needed[mesh.name]}" takes its mass from mesh "{mesh.name}", which '
                    f"cannot be "
                    f"read: {refusal}. Give the mesh, or give the body an <inertial>"
                ) from None
    spec.assets = assets
    return boxes


def _weighs(mujoco: Any, spec: Any, geom: Any) -> bool:
    """True if MuJoCo takes part of a body's mass from a geom."""
    rule, (low, high) = spec.compiler.inertiafromgeom, spec.compiler.inertiagrouprange
    from_geoms = (
        rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE or not geom.parent.explicitinertial
    )
    if (
        rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
        or not from_geoms
        or not low <= geom.group <= high
    ):
        return False
    body, moves = geom.parent, spec.compiler.settotalmass > 0
    while body is not None and not moves:
        body, moves = body.parent, bool(body.joints)
    return bool(moves and (geom.density if np.isnan(geom.mass) else geom.mass))
