"""The design that a landing is computed of, as a baseline holds it, and what changed since: bodies,
joints, and points on them.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.names import glob_of
from shockpc.text.printed import few, printable

MODEL = {"joint_model": "joint model", "drives": "drives"}
"""What a design has once, with its name in texts."""

KINDS = ("bodies", "joints", "points")
"""What a design has several of, each by name."""

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


def six_digits(value: float) -> float:
    """A value to six significant digits, as a baseline holds it; rounding of zero is zero."""
    return 0.0 if abs(value) < ZERO else float(f"{value:.6g}")


def design_record(landing: PosedLanding) -> dict[str, Any]:
    """Mass, centre of mass, inertia and placement of each body, what drives each joint, and where
    contacts and points are.

    Bodies are in their frames, inertias about their centres of mass; places are origins in the
    frame of the body that carries a body or a point, with all joints at zero, and `axes` the
    rotation there by rows, left out where there is none.
    """
    robot, model = landing.robot, landing.joint_model
    bodies, joints, points = dict[str, Any](), dict[str, Any](), dict[str, Any]()
    names = [body.name for body in robot.bodies]
    for body, joint in zip(robot.bodies, robot.joints, strict=True):
        R, p = joint.rotation @ body.rotation, joint.rotation @ body.offset + joint.offset
        if joint.parent >= 0:
            carrier = robot.bodies[joint.parent]
            R, p = carrier.rotation.T @ R, carrier.rotation.T @ (p - carrier.offset)
        moments = [*np.diag(body.inertia), *body.inertia[[0, 0, 1], [1, 2, 2]]]
        mass_properties = {"mass": body.mass, "com": body.com, "inertia": moments}
        bodies[body.name] = _entry(
            names[joint.parent] if joint.parent >= 0 else "world", p, R, **mass_properties
        )
    for part in robot.single_joints:
        if part.kind != "free":
            v, kind = part.v, part.kind + ", locked" * bool(model.locked[part.v].all())
            soft = np.where(np.isfinite(model.drive_stiffness[v]), model.drive_stiffness[v], 0.0)
            driven = {
                "armature": model.armature[v],
                "coupling": model.coupling[v],
                "rotor": model.rotor[v],
                "drive_stiffness": soft,
                "stiffness": model.stiffness[v],
            }
            joints[part.name] = {"kind": kind} | _numbers(
                axis=() if part.axis is None else part.axis, **driven
            )
    frames = [robot.frame(contact.frame) for contact in landing.scene.contact]
    placed = [(frame.name, frame.body, frame.offset, frame.rotation) for frame in frames]
    for name, carrying, p, R in (
        *placed,
        *((point.name, point.body, point.r, point.axes) for point in landing.points),
    ):
        points[name] = _entry(names[carrying] if carrying >= 0 else "world", p, R)
    return {
        "joint_model": model.name,
        "drives": model.drives,
        "bodies": bodies,
        "joints": joints,
        "points": points,
    }


def _entry(carrier: str, place: Array, rotation: Array, **numbers: Any) -> dict[str, Any]:
    """What is known of a body or a point."""
    turned = (
        {}
        if np.allclose(rotation, np.eye(3), atol=ZERO)
        else {"axes": [six_digits(x) for x in rotation.ravel().tolist()]}
    )
    return {"carrier": carrier} | _numbers(place=place, **numbers) | turned


def _numbers(**values: Any) -> dict[str, Any]:
    """Numbers that are not zero, to six digits; a single one without a list."""
    lists = {key: [six_digits(float(x)) for x in np.ravel(value)] for key, value in values.items()}
    return {
        key: entries[0] if len(entries) == 1 else entries
        for key, entries in lists.items()
        if any(entries)
    }


def read_design(table: Mapping[str, Any]) -> dict[str, Any]:
    """A design from its JSON. Raises ValueError, KeyError or TypeError if it is none."""
    for kind in KINDS:
        for entry in table[kind].values():
            for key in ("axes", *NUMBERS):
                values = np.atleast_1d(np.asarray(entry.get(key, 0.0)))
                # Texts of numbers would become numbers here, and stay texts in what is returned.
                if (
                    values.dtype.kind not in "iuf"
                    or values.ndim > 1
                    or not len(values)
                    or not (np.abs(values) <= LARGEST_NUMBER).all()
                ):
                    raise ValueError("not numbers of a robot")
            np.reshape(entry.get("axes", np.eye(3)), (3, 3))
    return {key: table[key] if key in KINDS else str(table[key]) for key in (*MODEL, *KINDS)}


def design_changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """What changed between two designs; the same change of several parts is one text."""
    for key, title in MODEL.items():
        if before[key] != now[key]:
            yield f"{title} {printable(before[key]) or 'none'} → {now[key] or 'none'}"
    for kind in KINDS:
        old, new = before[kind], now[kind]
        changes: dict[str, list[str]] = {}
        for name in new:
            for text in (
                _changes(old[name], new[name]) if name in old else ["is new"] * (kind != "points")
            ):
                changes.setdefault(text, []).append(name)
        changes |= (
            {"is gone": gone}
            if kind != "points" and (gone := [name for name in old if name not in new])
            else {}
        )
        for text, names in changes.items():
            yield printable(f"{glob_of(names, {**old, **new}) or few(names, 4)} {text}")


def _changes(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[str]:
    """The changes of one body, joint or point."""
    for key, word in (("carrier", "carried by"), ("kind", "kind")):
        if old.get(key) != new.get(key):
            yield f"{word} {old.get(key)} → {new.get(key)}"
    for key, (title, unit) in NUMBERS.items():
        a, b = np.atleast_1d(old.get(key, 0.0)), np.atleast_1d(new.get(key, 0.0))
        n = max(len(a), len(b))
        if len(a) != len(b) and 1 not in (len(a), len(b)):
            yield f"{title} of another kind of joint"
            continue
        a, b = np.broadcast_to(a, n), np.broadcast_to(b, n)
        scale = max(np.abs(a).max(), np.abs(b).max())
        differ = np.abs(b - a) > SAME * scale
        if new.get("kind", "").startswith("prismatic"):
            unit = {"kg m²": "kg", "N m/rad": "N/m"}.get(unit, unit)
        if key == "inertia" and differ.any():
            factor = np.linalg.norm(b) / (np.linalg.norm(a) or 1.0)
            uniform = (
                np.abs(b - factor * a).max() <= 10.0 * SAME * scale and abs(factor - 1.0) > 1e-3
            )
            yield (
                f"inertia × {factor:.4g}"
                if uniform
                else f"inertia changed by up to {100.0 * np.abs(b - a).max() / scale:.2g} %"
            )
        elif unit == "m" and differ.sum() > 1:  # the same on the left and on the right
            yield f"{title} moved by {1e3 * np.linalg.norm(b - a):.3g} mm"
        else:
            for k in np.flatnonzero(differ):
                yield f"{title}{f' {AXIS_NAMES[k]}' * (unit in ('m', ''))} {_pair(a[k], b[k])} {unit}".rstrip()
    R, S = (np.reshape(entry.get("axes", np.eye(3)), (3, 3)) for entry in (old, new))
    angle = math.degrees(2.0 * math.asin(min(1.0, float(np.linalg.norm(R - S)) / math.sqrt(8.0))))
    if angle > 1e-3:
        yield f"rotated by {angle:.3g} deg"


def _pair(a: float, b: float) -> str:
    """Two values with as many digits as tell them apart."""
    texts: Sequence[str] = ()
    for digits in (3, 4, 5, 6):
        texts = [f"{value:.{digits}g}" for value in (a, b)]
        if texts[0] != texts[1]:
            break
    return " → ".join(texts)
