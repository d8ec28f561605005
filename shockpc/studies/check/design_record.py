"""The design that a landing is computed of, as a baseline holds it, and what changed since.

It consists of bodies, joints, and points on them.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.joint_model import JointModel
from shockpc.landing.landing import PosedLanding
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import Robot
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.names import glob_of
from shockpc.text.printed import few, printable

MODEL = {"joint_model": "joint model", "drives": "drives"}
"""Entries that a design has once, with their names in texts."""

KINDS = ("bodies", "joints", "points")
"""Entries that a design has several of, each by name."""

NUMBERS = {
    "mass": ("mass", "kg"),
    "com": ("centre of mass", "m"),
    "inertia": ("inertia", "kg m²"),
    "place": ("place", "m"),
    "axis": ("axis", ""),
    "armature": ("armature", "kg m²"),
    "coupling": ("coupling of its rotor", "kg m²"),
    "rotor": ("rotor", "kg m²"),
    "drive_stiffness": ("stiffness of the drive", "N m/rad"),
    "stiffness": ("stiffness", "N m/rad"),
}
"""Properties that are numbers, left out where all are zero: name in texts, and unit."""

AXIS_NAMES = "xyz"

SAME = 2e-5
"""Relative difference of two values of six digits that is rounding."""

ZERO = 1e-12
"""A value below this is rounding of zero."""

LEAST_FACTOR = 1e-3
"""By how much a factor of all moments of inertia differs from 1, to be one."""

LEAST_ROTATION = 1e-3
"""Smallest rotation that is a change [deg]."""

PRISMATIC = {"kg m²": "kg", "N m/rad": "N/m"}
"""Units of prismatic joints by those of revolute ones."""

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
"""No rotation, by rows."""


def six_digits(value: float) -> float:
    """A value to six significant digits, as a baseline holds it; rounding of zero is zero."""
    return 0.0 if abs(value) < ZERO else float(f"{value:.6g}")


def design_record(landing: PosedLanding) -> dict[str, Any]:
    """The design of a landing: its bodies, the drives of its joints, and its contacts and points.

    A body has a mass, a centre of mass, an inertia and a placement. Bodies are in their frames,
    inertias about their centres of mass; places are origins in the frame of the body that carries a
    body or a point, with all joints at zero, and `axes` the rotation there by rows, left out where
    there is none.
    """
    robot, model = landing.robot, landing.joint_model
    joints = {}
    for joint in robot.single_joints:
        if joint.kind != "free":
            joints[joint.name] = _joint(model, joint)
    points = {}
    for contact in landing.scene.contact:
        frame = robot.frame(contact.frame)
        points[frame.name] = _entry(robot, frame.body, frame.offset, frame.rotation)
    for point in landing.points:
        points[point.name] = _entry(robot, point.body, point.r, point.axes)
    return {
        "joint_model": model.name,
        "drives": model.drives,
        "bodies": {body.name: _body(robot, i) for i, body in enumerate(robot.bodies)},
        "joints": joints,
        "points": points,
    }


def _body(robot: Robot, i: int) -> dict[str, Any]:
    """A body by its number: its frame in that of the body that carries it, and its inertia."""
    body, joint = robot.bodies[i], robot.joints[i]
    # With the joint at zero, the body's frame in the joint's parent is
    # R = R_j R_b, p = R_j p_b + p_j.
    R = joint.rotation @ body.rotation
    p = joint.rotation @ body.offset + joint.offset
    if joint.parent >= 0:
        # In the frame of the carrier c: R_cᵀ R, R_cᵀ (p − p_c).
        carrier = robot.bodies[joint.parent]
        R = carrier.rotation.T @ R
        p = carrier.rotation.T @ (p - carrier.offset)
    moments = [*np.diag(body.inertia), *body.inertia[[0, 0, 1], [1, 2, 2]]]
    return _entry(robot, joint.parent, p, R, mass=body.mass, com=body.com, inertia=moments)


def _joint(model: JointModel, joint: Joint) -> dict[str, Any]:
    """The drive of a joint."""
    v = joint.v
    kind = str(joint.kind)
    if model.locked[v].all():
        kind += ", locked"
    # A drive without a spring is infinitely stiff, and has no number.
    stiffness = model.drive_stiffness[v]
    numbers = _numbers(
        axis=() if joint.axis is None else joint.axis,
        armature=model.armature[v],
        coupling=model.coupling[v],
        rotor=model.rotor[v],
        drive_stiffness=np.where(np.isfinite(stiffness), stiffness, 0.0),
        stiffness=model.stiffness[v],
    )
    return {"kind": kind} | numbers


def _entry(
    robot: Robot, carrier: int, place: Array, rotation: Array, **numbers: Any
) -> dict[str, Any]:
    """The record of a body or a point.

    Args:
        robot: the robot.
        carrier: number of the body that carries it; −1 for the world.
        place: (3,) in the frame of that body [m].
        rotation: (3, 3) to that frame.
        numbers: its properties.
    """
    name = robot.bodies[carrier].name if carrier >= 0 else "world"
    entry = {"carrier": name} | _numbers(place=place, **numbers)
    if not np.allclose(rotation, np.eye(3), atol=ZERO):
        entry["axes"] = [six_digits(x) for x in rotation.ravel().tolist()]
    return entry


def _numbers(**values: Any) -> dict[str, Any]:
    """Numbers that are not zero, to six digits; a single one without a list."""
    numbers: dict[str, Any] = {}
    for key, value in values.items():
        digits = [six_digits(float(x)) for x in np.ravel(value)]
        if any(digits):
            numbers[key] = digits[0] if len(digits) == 1 else digits
    return numbers


def read_design(table: Mapping[str, Any]) -> dict[str, Any]:
    """A design from its JSON. Raises ValueError, KeyError or TypeError if it is none."""
    design = {key: str(table[key]) for key in MODEL}
    for kind in KINDS:
        design[kind] = table[kind]
        for entry in table[kind].values():
            for key in ("axes", *NUMBERS):
                _refuse_no_numbers(entry.get(key, 0.0))
            np.reshape(entry.get("axes", np.eye(3)), (3, 3))
    return design


def _refuse_no_numbers(value: Any) -> None:
    """Refuse, by a ValueError, what is neither a number of a robot nor a list of such."""
    values = np.atleast_1d(np.asarray(value))
    # Texts of numbers would become numbers here, and stay texts in what is returned.
    of_numbers = values.dtype.kind in "iuf" and values.ndim == 1 and len(values) > 0
    if not (of_numbers and (np.abs(values) <= LARGEST_NUMBER).all()):
        raise ValueError("not numbers of a robot")


def design_changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Texts of the changes between two designs; the same change of several parts is one text."""
    for key, title in MODEL.items():
        if before[key] != now[key]:
            yield f"{title} {printable(before[key]) or 'none'} → {now[key] or 'none'}"
    for kind in KINDS:
        old, new = before[kind], now[kind]
        names_by_change: dict[str, list[str]] = {}
        for name in new:
            for change in _changes_of(name, old, new, kind):
                names_by_change.setdefault(change, []).append(name)
        gone = [name for name in old if name not in new]
        if gone and kind != "points":
            names_by_change["is gone"] = gone
        for change, names in names_by_change.items():
            pattern = glob_of(names, {**old, **new}) or few(names, 4)
            yield printable(f"{pattern} {change}")


def _changes_of(
    name: str, old: Mapping[str, Any], new: Mapping[str, Any], kind: str
) -> Iterable[str]:
    """The changes of one body, joint or point. Args: old, new, those of its kind by name."""
    if name in old:
        return _changes(old[name], new[name])
    return ["is new"] if kind != "points" else []


def _changes(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[str]:
    """The changes of one entry."""
    for key, word in (("carrier", "carried by"), ("kind", "kind")):
        if old.get(key) != new.get(key):
            yield f"{word} {old.get(key)} → {new.get(key)}"
    slides = new.get("kind", "").startswith("prismatic")
    for key, (title, unit) in NUMBERS.items():
        a = np.atleast_1d(old.get(key, 0.0))
        b = np.atleast_1d(new.get(key, 0.0))
        lengths = {len(a), len(b)}
        if len(lengths) > 1 and 1 not in lengths:
            yield f"{title} of another kind of joint"
            continue
        a, b = np.broadcast_arrays(a, b)
        if slides:
            unit = PRISMATIC.get(unit, unit)
        yield from _changed_numbers(key, title, unit, a, b)
    rotation = _angle_between(old.get("axes", IDENTITY), new.get("axes", IDENTITY))
    if rotation > LEAST_ROTATION:
        yield f"rotated by {rotation:.3g} deg"


def _changed_numbers(key: str, title: str, unit: str, a: Array, b: Array) -> Iterator[str]:
    """The change of one property from numbers a (n,) to b (n,)."""
    scale = max(np.abs(a).max(), np.abs(b).max())
    differ = np.abs(b - a) > SAME * scale
    if not differ.any():
        return
    if key == "inertia":
        # b = factor · a, as of another density
        factor = np.linalg.norm(b) / (np.linalg.norm(a) or 1.0)
        uniform = np.abs(b - factor * a).max() <= 10.0 * SAME * scale
        if uniform and abs(factor - 1.0) > LEAST_FACTOR:
            yield f"inertia × {factor:.4g}"
        else:
            yield f"inertia changed by up to {100.0 * np.abs(b - a).max() / scale:.2g} %"
    elif unit == "m" and differ.sum() > 1:
        # The length is the same on the left and on the right.
        yield f"{title} moved by {1e3 * np.linalg.norm(b - a):.3g} mm"
    else:
        for k in np.flatnonzero(differ):
            axis = f" {AXIS_NAMES[k]}" if unit in ("m", "") else ""
            yield f"{title}{axis} {_pair(a[k], b[k])} {unit}".rstrip()


def _angle_between(axes: Any, other_axes: Any) -> float:
    """The angle between two rotations, given by rows [deg]."""
    R, S = (np.reshape(matrix, (3, 3)) for matrix in (axes, other_axes))
    # |R − S|_F = √8 |sin(angle / 2)|
    sine = float(np.linalg.norm(R - S)) / math.sqrt(8.0)
    return math.degrees(2.0 * math.asin(min(1.0, sine)))


def _pair(a: float, b: float) -> str:
    """Two values with as many digits as tell them apart."""
    texts: Sequence[str] = ()
    for digits in (3, 4, 5, 6):
        texts = [f"{value:.{digits}g}" for value in (a, b)]
        if texts[0] != texts[1]:
            break
    return " → ".join(texts)
