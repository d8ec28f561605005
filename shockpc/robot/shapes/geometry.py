"""The geometry of a robot's bodies, as its file gives it, and how large the robot is by it.

Nothing is read before it is asked for, and no mesh unless that kind of geometry has one. A shape
that cannot be read is left out and reported; the others remain. The shapes of a URDF are taken from
its XML: importing yourdfpy takes longer than an analysis without meshes.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterable, Iterator
from typing import Literal, NamedTuple, TypeAlias
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.extremes import Pieces
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.robot.files.reading import shared_xml
from shockpc.robot.pinocchio_joints import rotation
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.shapes.convex import Shape, checked_shape, primitive
from shockpc.robot.shapes.mesh import Mesh, outer_vertices
from shockpc.robot.shapes.mesh_files import read_mesh
from shockpc.robot.tolerances import inertia_fault
from shockpc.robot.urdf.numbers import finite_numbers
from shockpc.text.errors import RobotError
from shockpc.text.paths import read_file
from shockpc.text.printed import few, listed

GeometryKind: TypeAlias = Literal["collision", "visual"]
Loader: TypeAlias = Callable[[str], tuple[Mesh, Array]]
"""Reads a mesh by its name in the file, and points of which it is the hull."""

_URDF_SIZES = {
    "box": (("size", 3, 0.5),),
    "sphere": (("radius", 1, 1.0),),
    "cylinder": (("radius", 1, 1.0), ("length", 1, 0.5)),
    "capsule": (("radius", 1, 1.0), ("length", 1, 0.5)),
    "ellipsoid": (("a", 1, 1.0), ("b", 1, 1.0), ("c", 1, 1.0)),
}
"""Attributes, how many numbers each holds, and what makes of them the sizes that MuJoCo has."""
_NO_SHAPES = ("declare_convex", "material", "proximity_properties")
"""The elements that may stand beside a shape in the geometry of a URDF."""
_MJCF_PRIMITIVES = {2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box"}  # mjtGeom
_MJCF_MESH = 7

_Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

UNKNOWN, SMALL, NEGLIGIBLE = 10.0, 0.3, 0.01
"""Largest size of a robot without shapes, as a multiple of the distances between its frames [1];
least value of these distances [m]; share of its body's mass times the robot's size squared below
which the moments of inertia of a link do not matter [1].
"""

TELLING = 3
"""Links of different masses whose inertias say about which point they are given; one or two may
look like anything.
"""


class UnreadShape(NamedTuple):
    """A shape that cannot be read: its link, its mesh, which may be "", and why."""

    link: str
    mesh: str
    reason: str


class Outline(NamedTuple):
    """The shapes of a robot.

    Attributes:
        shapes: one tuple for each body, in the order of `robot.bodies`; empty for a body that has
            no such geometry.
        pieces: the same as points in one array.
        unread: the shapes that could not be read.
        warnings: at most one line, about those.
    """

    shapes: tuple[tuple[Shape, ...], ...]
    pieces: Pieces
    unread: tuple[UnreadShape, ...]
    warnings: tuple[str, ...]


@memoized()
def outline(robot: Robot, kind: GeometryKind, reduced: bool = True) -> Outline:
    """The collision or visual shapes of every body, as the robot's file gives them.

    Primitives are exact; meshes keep their triangles beside their outer vertices, or all of them
    without `reduced`. A shape that cannot be read is left out and named in the warning. The robot
    holds the result.
    """
    shapes: list[list[Shape]] = [[] for _ in robot.bodies]
    unread: list[UnreadShape] = []
    incomplete: set[int] = set()  # bodies with shapes that cannot be read
    for piece in _shapes(robot.source, kind, reduced):
        frame = robot.frames.get(piece.link)
        body = frame.body if frame is not None else -1
        if isinstance(piece, UnreadShape):
            unread.append(piece)
            incomplete.add(body)
        elif frame is not None and body >= 0:
            shapes[body].append(piece.placed(frame.rotation, frame.offset))
    solids = [[(shape.points, shape.rounding) for shape in of_body] for of_body in shapes]
    warnings: tuple[str, ...] = ()
    if unread:
        read = sum(map(len, shapes))
        lost = [i for i in sorted(incomplete) if i >= 0 and not shapes[i]]
        names = [f'"{robot.bodies[body].name}"' for body in lost]
        warnings = (_unread_text(kind, unread, read, names),)
    return Outline(tuple(map(tuple, shapes)), Pieces.of(solids), tuple(unread), warnings)


def _unread_text(kind: str, unread: list[UnreadShape], read: int, lost: list[str]) -> str:
    """A warning about shapes that cannot be read.

    Args:
        kind: of the shapes.
        unread: at least one.
        read: how many others were read.
        lost: bodies that have no shape left.
    """
    consequence = "each of their bodies has other shapes"
    if lost:
        consequence = f"no {kind} geometry is left for {few(lost, 4)}"
    first = unread[0]
    meshes = dict.fromkeys(piece.mesh for piece in unread)
    others = [name for name in meshes if name not in ("", first.mesh)]
    also = f"; also {listed(others, 4)}" if others else ""
    return (
        f"{len(unread)} of {len(unread) + read} {kind} shapes could not be read "
        f'(link "{first.link}": {first.reason}{also}); {consequence}'
    )


@memoized()
def body_outline(robot: Robot) -> Outline:
    """The collision geometry of every body.

    It is the visual one, if the file has no collision geometry.
    """
    return outline(robot, _outline_kind(robot.source))


@memoized()
def shapes_at(robot: Robot, name: str) -> np.ndarray:
    """Mask (n,) of the shapes of `body_outline` that belong to a frame, in order of its pieces."""
    frame = robot.frame(name)
    belongs: list[bool] = []
    for carried in body_outline(robot).shapes:
        belongs += [shape.belongs_to(frame) for shape in carried]
    return np.array(belongs, dtype=bool)


@memoized()
def shapes_of(robot: Robot, name: str) -> tuple[tuple[Shape, ...], tuple[UnreadShape, ...]]:
    """The shapes of a link itself, or the shape of a geom, and those that cannot be read.

    They are as `body_outline` has them.

    No mesh of another link is read, unless one says that y is up, of which all meshes together
    decide.
    """
    frame = robot.frame(name)
    if frame.kind not in ("link", "geom"):
        return (), ()
    shapes: list[Shape] = []
    unread: list[UnreadShape] = []
    for piece in _shapes(robot.source, _outline_kind(robot.source), True, name):
        if isinstance(piece, UnreadShape):
            unread.append(piece)
        elif piece.belongs_to(frame):
            at = robot.frames[piece.link]
            shapes.append(piece.placed(at.rotation, at.offset))
    return tuple(shapes), tuple(unread)


def drawn_outline(robot: Robot) -> Outline:
    """The visual geometry of every body, its meshes with all vertices.

    Where it is the geometry of `body_outline`, its meshes are as there.
    """
    return outline(robot, "visual", not _is_solid(robot.source))


@memoized()
def robot_size(robot: Robot, shapes: bool = True) -> float:
    """Diagonal of the box around a robot in its neutral posture [m].

    The box is around all frames, centres of mass and shapes.

    Args:
        robot: the robot.
        shapes: whether its shapes count, for which meshes are read.
    """
    placements = robot.body_placements(pin.neutral(robot.model))
    R = np.array([placement.rotation for placement in placements])
    p = np.array([placement.translation for placement in placements])

    def placed(bodies: np.ndarray, points: Array) -> Array:
        """Points (n, 3) of bodies (n,) in the world."""
        rotated = R[bodies] @ points[..., None]
        return np.asarray(rotated[..., 0] + p[bodies])

    bodies = list(range(len(robot.bodies)))
    centres_and_frames = [body.com for body in robot.bodies]
    for frame in robot.frames.values():
        if frame.body >= 0:
            bodies.append(frame.body)
            centres_and_frames.append(frame.offset)
    corners = [placed(np.array(bodies), np.array(centres_and_frames))]
    if shapes:
        pieces = body_outline(robot).pieces
        points = placed(pieces.body[pieces.piece], pieces.points)
        # A piece reaches along an axis of the world by the length of that row of R Q.
        reach = np.linalg.norm(R[pieces.body] @ pieces.rounding, axis=2)[pieces.piece]
        corners += [points - reach, points + reach]
    return float(np.linalg.norm(np.ptp(np.concatenate(corners), axis=0)))


@memoized()
def inflated_inertias(robot: Robot) -> tuple[tuple[str, float], ...]:
    """Links whose moments of inertia no body within the robot can have.

    With each comes its radius of gyration [m].

    Mass that lies within a robot is nowhere farther from its centre than the robot is large.
    Moments too small to matter are left out, such as those of a sensor's placeholder. Meshes are
    read only if the frames alone do not decide.
    """
    links = [frame for frame in robot.model.frames if frame.inertia.mass > 0.0]
    radius = {}
    for link in links:
        # k² = tr I / 3 m
        trace = max(np.trace(link.inertia.inertia), 0.0)
        radius[link.name] = math.sqrt(trace / 3.0 / link.inertia.mass)
    size = robot_size(robot, False)
    if max(radius.values(), default=0.0) <= size:
        return ()
    if any(body_outline(robot).shapes):
        size = robot_size(robot)
    else:
        size = UNKNOWN * max(size, SMALL)
    inflated: dict[str, float] = {}
    for link in links:
        if radius[link.name] > size and link.parentJoint:
            least = NEGLIGIBLE * robot.model.inertias[link.parentJoint].mass * size**2
            if np.trace(link.inertia.inertia) > least:
                inflated[link.name] = radius[link.name]
    return tuple(inflated.items())


@memoized()
def inertias_about_origins(robot: Robot) -> tuple[str, ...]:
    """Links whose inertias look as if they were given about the links' origins.

    None unless those of all links that tell do.

    Taken to the centre of mass they stay possible then, for every link whose centre is not near its
    origin; a bar that hangs from its origin, given about its centre as it should be, would have a
    negative moment left.
    """
    names, masses = list[str](), set[float]()
    for frame in robot.model.frames:
        mass, lever, inertia = frame.inertia.mass, frame.inertia.lever, frame.inertia.inertia
        distance = float(lever @ lever)
        if mass > 0.0 and distance > np.trace(inertia) / (4.0 * mass):
            moved = inertia - mass * (distance * np.eye(3) - np.outer(lever, lever))
            if inertia_fault(mass, moved) is not None:
                return ()
            names.append(frame.name)
            masses.add(mass)
    return tuple(names) if len(masses) >= TELLING else ()


def size_text(robot: Robot) -> str:
    """The size of a robot and what was measured for it, for messages."""
    measured = (
        "the robot measures"
        if any(body_outline(robot).shapes)
        else "without shapes, the robot's frames and centres of mass span"
    )
    return f"{measured} {robot_size(robot):.3g} m"


def _outline_kind(source: RobotSource) -> GeometryKind:
    return "collision" if _is_solid(source) else "visual"


def _is_solid(source: RobotSource) -> bool:
    return (
        source.kind == "mjcf"
        or shared_xml(source.xml, source.path.name).find("link/collision") is not None
    )


@memoized()
def _loader(
    source: RobotSource, reduced: bool
) -> "functools._lru_cache_wrapper[tuple[Mesh, Array]]":
    """A reader of the meshes of a file, each once.

    Four legs often share one, and that of a foot may be read before the others.
    """
    spanning = outer_vertices if reduced else np.asarray

    @functools.cache
    def load(uri: str) -> tuple[Mesh, Array]:
        path = source.folders.asset(uri)
        try:
            mesh = read_mesh(
                read_file(path, "mesh", RobotError), path.suffix.lower().removeprefix(".")
            )
        except ValueError as refusal:
            raise ValueError(f'"{uri}": {refusal}') from None
        return mesh, spanning(mesh.vertices)

    return load


@memoized()
def _shapes(
    source: RobotSource, kind: GeometryKind, reduced: bool, only: str | None = None
) -> tuple[Shape | UnreadShape, ...]:
    """The shapes of a file, or only those of a link or geom, each in the frame of its link.

    Variants of a robot share them.
    """
    load = _loader(source, reduced)
    if source.kind == "mjcf":
        shapes = tuple(_mjcf_shapes(source, kind, load, only))
    elif only is None:
        shapes = _of_all_links(source, kind, reduced)
    else:
        shapes = _shapes_as_read(source, kind, reduced, only)
        if any(map(_is_y_up, shapes)):
            every = _shapes(source, kind, reduced)
            return tuple(shape for shape in every if shape.link == only)
    if only is None:
        load.cache_clear()
    return shapes


def _is_y_up(shape: Shape | UnreadShape) -> bool:
    """True if a shape is a mesh whose file says that y is up."""
    return isinstance(shape, Shape) and shape.mesh is not None and shape.mesh.y_up


def _of_all_links(
    source: RobotSource, kind: GeometryKind, reduced: bool
) -> tuple[Shape | UnreadShape, ...]:
    """The shapes of a URDF.

    Meshes whose files say that y is up are turned to z up if they are then twice as close to the
    joints.
    """
    links = _links(source)
    as_read: list[Shape | UnreadShape] = []
    for link in links:
        as_read += _shapes_as_read(source, kind, reduced, link)
    if not any(map(_is_y_up, as_read)):
        return tuple(as_read)
    elements = itertools.chain.from_iterable(links.values())
    turned = tuple(_urdf_shapes(elements, kind, _loader(source, reduced), _Y_TO_Z))
    root = shared_xml(source.xml, source.path.name)
    closer = 2.0 * _distance_to_joints(root, turned) < _distance_to_joints(root, tuple(as_read))
    return turned if closer else tuple(as_read)


@memoized()
def _links(source: RobotSource) -> dict[str, list[Element]]:
    """The links of a URDF by name, in the order of the file."""
    links: dict[str, list[Element]] = {}
    for link in shared_xml(source.xml, source.path.name).findall("link"):
        links.setdefault(link.get("name", ""), []).append(link)
    return links


@memoized()
def _shapes_as_read(
    source: RobotSource, kind: GeometryKind, reduced: bool, link: str
) -> tuple[Shape | UnreadShape, ...]:
    """The shapes of one link of a URDF, of whatever meshes as they are.

    They are read once, for the link and for the whole robot.
    """
    return tuple(
        _urdf_shapes(_links(source).get(link, ()), kind, _loader(source, reduced), np.eye(3))
    )


def _urdf_shapes(
    links: Iterable[Element], kind: GeometryKind, load: Loader, turn: Array
) -> Iterator[Shape | UnreadShape]:
    """Place the shapes of some links of a URDF. Args: turn: (3, 3), of meshes with y up."""
    for link in links:
        name = link.get("name", "")
        for element in link.findall(kind):
            shape = _first_shape(element)
            uri = "" if shape is None else shape.get("filename", "")
            origin = element.find("origin")
            try:
                xyz = _numbers(origin, "xyz", 3, "0 0 0")
                rpy = _numbers(origin, "rpy", 3, "0 0 0")
                if shape is None:
                    raise ValueError(f"a <{kind}> without a shape")
                read = _urdf_shape(name, shape, load, turn)
                yield checked_shape(read.placed(pin.rpy.rpyToMatrix(rpy), xyz))
            except (RobotError, ValueError) as refusal:
                yield UnreadShape(name, uri, str(refusal))


def _first_shape(element: Element) -> Element | None:
    """The shape of a <collision> or <visual>, if it has one."""
    for part in element.iterfind("geometry/*"):
        if part.tag.rpartition(":")[2] not in _NO_SHAPES:
            return part
    return None


def _urdf_shape(link: str, shape: Element, load: Loader, turn: Array) -> Shape:
    """A mesh or primitive of a URDF in its own frame."""
    if shape.tag == "mesh":
        read = load(shape.get("filename", ""))
        scale = _numbers(shape, "scale", 3, "1 1 1")
        axes = turn if read[0].y_up else np.eye(3)
        return _mesh(link, read, scale[:, None] * axes, np.zeros(3))
    tag = shape.tag.removeprefix("drake:")
    sizes = [np.zeros(0)]
    for key, count, factor in _URDF_SIZES.get(tag, ()):
        sizes.append(factor * _numbers(shape, key, count))
    return primitive(link, tag, np.concatenate(sizes))


def _mesh(link: str, read: tuple[Mesh, Array], change: Array, origin: Array) -> Shape:
    """The shape of a mesh as read, with its outer vertices, in other coordinates.

    They follow by a change (3, 3) from an origin (3,) [m].
    """
    mesh, outer = read
    return Shape(
        link,
        (outer - origin) @ change.T,
        mesh=mesh._replace(vertices=(mesh.vertices - origin) @ change.T),
    )


def _distance_to_joints(root: Element, shapes: Iterable[Shape | UnreadShape]) -> float:
    """Sum the distances from the joints of each link to the boxes around its meshes [m].

    The meshes are those of which the file says that y is up.
    """
    places = {link.get("name"): [np.zeros(3)] for link in root.findall("link")}
    for joint in root.iterfind("joint"):
        for parent in joint.iterfind("parent"):
            places[parent.get("link")].append(_numbers(joint.find("origin"), "xyz", 3, "0 0 0"))
    total = 0.0
    for shape in shapes:
        if isinstance(shape, Shape) and shape.mesh is not None and shape.mesh.y_up:
            inside = np.clip(places[shape.link], shape.points.min(axis=0), shape.points.max(axis=0))
            total += float(np.linalg.norm(inside - places[shape.link], axis=1).sum())
    return total


def _numbers(element: Element | None, key: str, size: int, default: str = "") -> Array:
    """The numbers (size,) of an attribute."""
    text = default if element is None else element.get(key, default)
    values = finite_numbers(text, size)
    if values is None:
        raise ValueError(
            f'its {key} is "{text}"; it has to be {size} finite number{"s" * (size > 1)}'
        )
    return values


def _mjcf_shapes(
    source: RobotSource, kind: GeometryKind, load: Loader, only: str | None = None
) -> Iterator[Shape | UnreadShape]:
    """Take the shapes of an MJCF from the compiled model, or only those of a body or geom.

    Planes and height fields are left out.
    """
    from shockpc.robot.mjcf.compiled import compiled

    result = compiled(source)
    m = result.model
    for number in range(m.ngeom):
        geom, file, form = (
            m.geom(number),
            result.meshes.get(number),
            _MJCF_PRIMITIVES.get(int(m.geom_type[number])),
        )
        collides = bool(geom.contype or geom.conaffinity)
        # MuJoCo shows groups 0 to 2 unless it is asked for others.
        wanted = collides if kind == "collision" else not collides or geom.group <= 2
        if not wanted or not (form or m.geom_type[number] == _MJCF_MESH):
            continue
        link = m.body(geom.bodyid[0]).name
        if only not in (None, link, geom.name):
            continue
        try:
            # A mesh without mass was compiled as a box, so that its shape is read from its file.
            if file:
                shape = _mesh(
                    link,
                    load(file.file),
                    file.scale[:, None] * rotation(file.rotation).T,
                    file.origin,
                )
            elif form:
                shape = primitive(link, form, np.array(geom.size))
            else:
                mesh = m.mesh(int(geom.dataid[0]))
                # The compiled model has the vertices and faces of all meshes in one array each.
                first, face = int(mesh.vertadr[0]), int(mesh.faceadr[0])
                vertices = np.array(m.mesh_vert[first : first + int(mesh.vertnum[0])], dtype=float)
                triangles = np.array(
                    m.mesh_face[face : face + int(mesh.facenum[0])], dtype=np.int64
                )
                shape = Shape(link, outer_vertices(vertices), mesh=Mesh(vertices, triangles))
            yield checked_shape(
                shape._replace(name=geom.name).placed(rotation(geom.quat), np.array(geom.pos))
            )
        except (RobotError, ValueError) as refusal:
            yield UnreadShape(link, file.name if file else "", str(refusal))
