"""What a robot file says its links look like, read piece by piece: a piece that cannot be read costs only itself.

URDF geometry is taken from its text, so that nothing but the wanted pieces is read; MJCF geometry, with its classes and
defaults, by Pinocchio from a copy whose meshes are known to be readable.
"""

import math
import tempfile
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.meshes import Mesh, Meshes, last_words, mesh_of
from shockpc.robot.robot import Robot
from shockpc.robot.source import RobotSource, resolve_asset

__all__ = ["Geometries", "Kind", "Piece", "Unread", "read_geometries"]

Kind: TypeAlias = Literal["collision", "visual"]


class Piece(NamedTuple):
    """One geometry of a link.

    Attributes:
        link: the link's name.
        geometry: a coal shape or a mesh.
        rotation: (3, 3) in the link's frame.
        offset: (3,) origin in the link's frame [m].
    """

    link: str
    geometry: coal.CollisionGeometry | Mesh
    rotation: Array
    offset: Array


class Unread(NamedTuple):
    """A geometry that could not be had: its link, and one line that says what was wrong."""

    link: str
    reason: str


class Geometries(NamedTuple):
    """All that could be read, and all that could not."""

    pieces: tuple[Piece, ...]
    unread: tuple[Unread, ...]


def read_geometries(robot: Robot, kind: Kind) -> Geometries:
    """Every geometry of that kind, in the order of the file. No mesh is touched if the kind has none.

    Args:
        robot: the robot.
        kind: what collides, or what is seen.
    """
    return _from_urdf(robot.source, kind) if robot.source.kind == "urdf" else _from_mjcf(robot, kind)


def _from_urdf(source: RobotSource, kind: Kind) -> Geometries:
    meshes = Meshes(source)
    pieces: list[Piece] = []
    unread: list[Unread] = []
    for link in ElementTree.fromstring(source.xml).iter("link"):
        name = link.get("name", "")
        for element in link.findall(kind):
            try:
                origin = element.find("origin")
                xyz, rpy = ("", "") if origin is None else (origin.get("xyz", ""), origin.get("rpy", ""))
                rotation = pin.rpy.rpyToMatrix(np.array(_numbers(rpy or "0 0 0", 3)))
                offset = np.array(_numbers(xyz or "0 0 0", 3))
                pieces.append(Piece(name, _urdf_shape(element.find("geometry"), meshes), rotation, offset))
            except ValueError as refusal:
                unread.append(Unread(name, str(refusal)))
    return Geometries(tuple(pieces), tuple(unread))


def _urdf_shape(geometry: ElementTree.Element | None, meshes: Meshes) -> coal.CollisionGeometry | Mesh:
    """The shape of a <geometry> element. Raises ValueError (one line) for what no URDF may hold."""
    shape = geometry[0] if geometry is not None and len(geometry) else None
    if shape is None:
        raise ValueError("an empty <geometry>")
    match shape.tag:
        case "box":
            return coal.Box(*_numbers(shape.get("size", ""), 3))
        case "sphere":
            return coal.Sphere(*_numbers(shape.get("radius", ""), 1))
        case "cylinder":
            return coal.Cylinder(*_numbers(shape.get("radius", ""), 1), *_numbers(shape.get("length", ""), 1))
        case "capsule":
            return coal.Capsule(*_numbers(shape.get("radius", ""), 1), *_numbers(shape.get("length", ""), 1))
        case "mesh":
            return meshes.load(shape.get("filename", ""), tuple(_numbers(shape.get("scale", "1 1 1"), 3)))
    raise ValueError(f"<{shape.tag}> is no shape of a URDF")


def _numbers(text: str, count: int) -> list[float]:
    values = [float(word) for word in text.split()]
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ValueError(f'{count} finite numbers are needed, not "{text}"')
    return values


def _from_mjcf(robot: Robot, kind: Kind) -> Geometries:
    meshes = Meshes(robot.source)
    tree, unread = _readable_mjcf(robot.source, meshes)
    wanted = pin.GeometryType.COLLISION if kind == "collision" else pin.GeometryType.VISUAL
    with tempfile.TemporaryDirectory() as folder:
        # Pinocchio reads MJCF from files that end in .xml only.
        copy = Path(folder) / "robot.xml"
        tree.write(copy, encoding="unicode")
        try:
            found = pin.buildGeomFromMJCF(robot.model, str(copy), wanted)
        except (ValueError, RuntimeError, IndexError) as refusal:
            return Geometries((), (*unread, Unread("", f"Pinocchio cannot read the geometry: {last_words(refusal)}")))
    pieces = []
    for item in found.geometryObjects:
        frame = robot.model.frames[item.parentFrame]
        place = frame.placement.inverse() * item.placement
        shape = _mjcf_shape(item, meshes)
        pieces.append(Piece(frame.name, shape, place.rotation.copy(), place.translation.copy()))
    return Geometries(tuple(pieces), tuple(unread))


def _mjcf_shape(item: pin.GeometryObject, meshes: Meshes) -> coal.CollisionGeometry | Mesh:
    """The shape of a geom; what it takes from a file is read here, because coal mixes up a file's parts."""
    if not isinstance(item.geometry, coal.BVHModelBase):
        return item.geometry
    if Path(item.meshPath).is_absolute():
        return meshes.load(item.meshPath, tuple(float(s) for s in item.meshScale))
    return mesh_of(item.geometry)


def _readable_mjcf(source: RobotSource, meshes: Meshes) -> tuple["ElementTree.ElementTree[ElementTree.Element]", list[Unread]]:
    """The MJCF with absolute mesh paths, and without the geoms whose mesh cannot be had."""
    root = ElementTree.fromstring(source.xml)
    unread: list[Unread] = []
    compiler = root.find("compiler")
    if compiler is None:
        compiler = ElementTree.Element("compiler")
        # Pinocchio takes settings for what comes after them.
        root.insert(0, compiler)
    folder = compiler.get("meshdir", compiler.get("assetdir", ""))
    compiler.set("meshdir", "/")
    lost: dict[str, str] = {}
    for assets in root.findall("asset"):
        for mesh in [m for m in assets.findall("mesh") if m.get("file")]:
            uri = str(Path(folder) / mesh.get("file", ""))
            name = mesh.get("name", Path(uri).stem)
            try:
                meshes.load(uri)
                mesh.set("file", str(resolve_asset(source, uri)).lstrip("/"))
                mesh.set("name", name)
            except ValueError as refusal:
                lost[name] = str(refusal)
                assets.remove(mesh)
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            if geom.get("mesh", "") in lost:
                unread.append(Unread(body.get("name", ""), lost[geom.get("mesh", "")]))
                body.remove(geom)
    return ElementTree.ElementTree(root), unread
