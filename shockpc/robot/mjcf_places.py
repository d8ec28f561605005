"""Every place in an MJCF as a position and a unit quaternion, and no frames: MuJoCo's five ways to write a rotation, in one.

Pinocchio passes over frames with all that is in them, takes an axis-angle's axis for a unit vector, and turns about moving
axes whatever the compiler's eulerseq says.
"""

import math
from typing import TypeAlias
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.robot.urdf_numbers import vector

__all__ = ["ORIENTATIONS", "write_out_places"]

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]  # w, x, y, z, as MuJoCo writes it

ORIENTATIONS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")
_PLACED = ("body", "frame", "inertial", "geom", "site", "camera")
_STRAIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)


def write_out_places(world: Element, compiler: Element | None, file: str) -> None:
    """Write every orientation as a unit quaternion, and dissolve the frames into what they hold.

    Args:
        world: the <worldbody>, its defaults written out and its numbers checked; changed in place.
        compiler: what says in which unit and about which axes angles are meant.
        file: the file's name, for messages.

    Raises:
        RobotError: an orientation has no direction, Euler axes are none, or a site has two places.
    """
    settings = compiler.attrib if compiler is not None else {}
    unit = 1.0 if settings.get("angle", "degree") == "radian" else math.pi / 180
    sequence = settings.get("eulerseq", "xyz")
    if len(sequence) != 3 or not set(sequence.lower()) <= set("xyz"):
        raise RobotError(f'{file}: <compiler eulerseq="{sequence}"> has to name three axes, such as "xyz"')
    if compiler is not None:
        compiler.attrib.pop("eulerseq", None)
    parents = [(world, "world")]
    while parents:
        parent, body = parents.pop()
        for element in list(parent):
            name = element.get("name", "") if element.tag == "body" else body
            if element.tag == "site" and "fromto" in element.attrib:
                if "pos" in element.attrib:
                    raise RobotError(f'{file}: body "{name}": a <site> has both pos and fromto; keep one of them')
                _between_ends(element)
            if element.tag in _PLACED and any(key in element.attrib for key in ORIENTATIONS):
                turned = _orientation(element, unit, sequence)
                if turned is None:
                    raise RobotError(f'{file}: body "{name}": the orientation of its <{element.tag}> has no direction')
                for key in ORIENTATIONS:
                    element.attrib.pop(key, None)
                element.set("quat", _text(turned))
            if element.tag in ("body", "frame"):
                parents.append((element, name))
    _dissolve(world)


def _between_ends(site: Element) -> None:
    """Place a site that is given by its two ends as MuJoCo does: midway, its z axis from the second to the first."""
    x0, y0, z0, x1, y1, z1 = vector(site.attrib.pop("fromto"), 6) or (0.0,) * 6
    for key in ORIENTATIONS:
        site.attrib.pop(key, None)
    site.set("pos", _text(((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)))
    site.set("zaxis", _text((x0 - x1, y0 - y1, z0 - z1)))


def _dissolve(world: Element) -> None:
    """Put what a frame holds in the frame's place, innermost frames last."""
    parents = [world]
    while parents:
        parent = parents.pop()
        while (frame := parent.find("frame")) is not None:
            at, turn = _place(frame)
            place = list(parent).index(frame)
            parent.remove(frame)
            for offset, element in enumerate(frame):
                _move(element, at, turn)
                parent.insert(place + offset, element)
        parents += parent.findall("body")


def _move(element: Element, at: Vector, turn: Quaternion) -> None:
    """Shift and turn one element from its frame's coordinates into those around the frame."""
    if element.tag in ("joint", "light"):
        element.set("pos", _text(_sum(at, _turned(turn, _vector(element, "pos", (0.0, 0.0, 0.0))))))
        direction = "axis" if element.tag == "joint" else "dir"
        if element.get("type") not in ("free", "ball"):
            default = (0.0, 0.0, 1.0) if element.tag == "joint" else (0.0, 0.0, -1.0)
            element.set(direction, _text(_turned(turn, _vector(element, direction, default))))
    elif element.tag == "geom" and "fromto" in element.attrib:
        ends = vector(element.get("fromto"), 6) or (0.0,) * 6
        element.set("fromto", " ".join(_text(_sum(at, _turned(turn, (x, y, z)))) for x, y, z in (ends[:3], ends[3:])))
    elif element.tag in _PLACED:
        inner, inner_turn = _place(element)
        element.set("pos", _text(_sum(at, _turned(turn, inner))))
        element.set("quat", _text(_product(turn, inner_turn)))


def _place(element: Element) -> tuple[Vector, Quaternion]:
    """Position and unit quaternion of an element whose orientation is written out."""
    w, x, y, z = vector(element.get("quat"), 4) or _STRAIGHT
    return _vector(element, "pos", (0.0, 0.0, 0.0)), (w, x, y, z)


def _vector(element: Element, key: str, default: Vector) -> Vector:
    x, y, z = vector(element.get(key), 3) or default
    return x, y, z


def _orientation(element: Element, unit: float, sequence: str) -> Quaternion | None:
    """The unit quaternion of an element, in whichever way it is written; None if it has no direction."""
    if quat := vector(element.get("quat"), 4):
        return _unit_quaternion(*quat)
    if axisangle := vector(element.get("axisangle"), 4):
        x, y, z, angle = axisangle
        return _about((x, y, z), angle * unit)
    if euler := vector(element.get("euler"), 3):
        turned = _STRAIGHT
        for letter, angle in zip(sequence, euler, strict=True):
            step = _about((float(letter in "xX"), float(letter in "yY"), float(letter in "zZ")), angle * unit) or _STRAIGHT
            # Small letters turn about axes that turn along, capitals about fixed ones.
            turned = _product(turned, step) if letter.islower() else _product(step, turned)
        return turned
    if xyaxes := vector(element.get("xyaxes"), 6):
        return _from_axes(_unit(*xyaxes[:3]), (xyaxes[3], xyaxes[4], xyaxes[5]))
    if zaxis := vector(element.get("zaxis"), 3):
        upright = _unit(*zaxis)
        if upright is None:
            return None
        sine = math.hypot(upright[0], upright[1])
        return _about((-upright[1], upright[0], 0.0) if sine > 0 else (1.0, 0.0, 0.0), math.atan2(sine, upright[2]))
    return None


def _from_axes(x: Vector | None, y: Vector) -> Quaternion | None:
    """The rotation that takes the first axis to x, and the second as near to y as it goes: the best of four ways to write it."""
    if x is None:
        return None
    along = x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
    square = _unit(y[0] - along * x[0], y[1] - along * x[1], y[2] - along * x[2])
    if square is None:
        return None
    (a, b, c), (d, e, f) = x, square
    g, h, i = b * f - c * e, c * d - a * f, a * e - b * d
    ways = (
        (1 + a + e + i, f - h, g - c, b - d),
        (f - h, 1 + a - e - i, b + d, g + c),
        (g - c, b + d, 1 - a + e - i, f + h),
        (b - d, g + c, f + h, 1 - a - e + i),
    )
    return _unit_quaternion(*max(ways, key=lambda way: math.hypot(*way)))


def _about(axis: Vector, angle: float) -> Quaternion | None:
    """The rotation by an angle [rad] about an axis; None if the axis has no direction."""
    unit = _unit(*axis)
    if unit is None:
        return None
    sine = math.sin(angle / 2)
    return math.cos(angle / 2), unit[0] * sine, unit[1] * sine, unit[2] * sine


def _unit(x: float, y: float, z: float) -> Vector | None:
    """A vector scaled to length 1; None if it has none."""
    length = math.hypot(x, y, z)
    return (x / length, y / length, z / length) if length > 0 else None


def _unit_quaternion(w: float, x: float, y: float, z: float) -> Quaternion | None:
    """A quaternion scaled to length 1; None if it has none."""
    length = math.hypot(w, x, y, z)
    return (w / length, x / length, y / length, z / length) if length > 0 else None


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """First b, then a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def _turned(turn: Quaternion, v: Vector) -> Vector:
    """A vector, rotated."""
    w, x, y, z = turn
    _, a, b, c = _product(_product(turn, (0.0, *v)), (w, -x, -y, -z))
    return a, b, c


def _sum(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _text(values: tuple[float, ...]) -> str:
    return " ".join(repr(value) for value in values)
