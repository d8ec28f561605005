"""A profile as a JSON document, schema `shockpc.profile/1`.

`null` where a thing does not exist: CoPc and RoPc of a body that does not rotate in the plane, pitch of one that does not rotate,
extremes of a body without geometry, impulses that are not unique; so a number that is not finite, and a list of such numbers.
Keys are in the order of the table of quantities. Numbers are the shortest that give the same double.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

import shockpc
from shockpc.core.spatial import Array
from shockpc.landing.dynamics import PINOCCHIO
from shockpc.landing.places import PlaceKind
from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import scene_table
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.table import quantities_of, quantity

if TYPE_CHECKING:
    from shockpc.impact.stiffness import CompliantLanding


def document(profile: ShockProfile, spectrum: bool = False) -> dict[str, Any]:
    """The document of one profile, as it is printed and written. Args: as `content`."""
    return headed("profile", content(profile, spectrum))


def content(profile: ShockProfile, spectrum: bool = False) -> dict[str, Any]:
    """The document of a profile without its head: every quantity at every place; positions in metres, axes as the table says.

    Args:
        profile: the landing.
        spectrum: whether it has the shock response spectra of the points, with a contact stiffness.
    """
    robot, assembly = profile.robot, profile.assembly
    (whole,) = _selected(profile, "robot")
    size = {"name": robot.name, "file": robot.label, "mass": whole.pop("mass"), "n_bodies": len(robot.bodies), "nv": robot.model.nv}
    bodies, contacts = _selected(profile, "body"), _selected(profile, "contact")
    places = [{"position": body.pop("position"), "rotation": R} for body, R in zip(bodies, profile.rotation, strict=True)]
    named = [{"body": body.name, "links": body.links} for body in robot.bodies]
    carriers = ["world" if place.body < 0 else robot.bodies[place.body].name for place in profile.places("point")]
    feet = [{"frame": place.name} | contact for place, contact in zip(profile.places("contact"), contacts, strict=True)]
    return {
        "robot": size,
        "scene": profile.scene,
        "v_in": whole.pop("v_in"),
        "bodies": [name | {"placement": place} | body for name, place, body in zip(named, places, bodies, strict=True)],
        "points": [
            {"frame": place.name, "body": carrier} | point
            for place, carrier, point in zip(profile.places("point"), carriers, _selected(profile, "point"), strict=True)
        ],
        "contacts": feet[: len(profile.landing.contacts)],
        "joint_model": profile.joint_model,
        "health": profile.health,
        "stance": feet[len(profile.landing.contacts) :],
        "total": whole.pop("total"),
        "energy": whole.pop("energy"),
        "joints": [
            {"joint": place.name, "position": position} | joint
            for place, position, joint in zip(profile.places("joint"), positions(profile), _selected(profile, "joint"), strict=True)
        ],
        "bracket": profile.bracket,
        "assembly": assembly
        and {
            **record(assembly, "gap", "turn", "left", "retried"),
            "moved": [{"joint": name, "by": by} for name, by, _ in assembly.moved],
        },
        "loads_unique": profile.health.rank == profile.health.rows,
        **whole,
        "friction": _friction(profile),
        "stiffness": _stiffness(profile, spectrum),
        "drives": _drives(profile),
        "margin_lost": profile.margin_lost,
        "parts": [
            {"part": one.part, "body": one.body, "joint": one.joint or None}
            | {"critical": None if one.joint else one.strength, "withstands": one.strength if one.joint else None}
            | quantities
            | {"governed_by": one.governed_by or None, "missing": one.missing or None}
            for one, quantities in zip(profile.parts, _selected(profile, "part"), strict=True)
        ],
    }


def positions(profile: ShockProfile) -> list[float | Array]:
    """Where each joint stands [rad, m]: its value, or of one with several degrees of freedom its coordinates in q."""
    joints = [profile.robot.joint(place.name) for place in profile.places("joint")]
    return [profile.q[joint.q] if joint.axis is None else joint.value(profile.q) for joint in joints]


def _selected(profile: ShockProfile, kind: PlaceKind, section: str = "") -> list[dict[str, Any]]:
    """The quantities of every place of a kind, those that stand there, or in a section of the document."""
    rows: list[dict[str, Any]] = [{} for _ in profile.places(kind)]
    for entry in quantities_of(kind):
        home, _, path = (entry.path or entry.key).rpartition(":")
        if entry.path is None or home != section:
            continue
        *groups, key = path.split(".")
        for row, value in zip(rows, profile.values(entry), strict=True):
            for group in groups:
                row = row.setdefault(group, {})
            row[key] = bool(value) if entry.flag else value
    return rows


def _named(profile: ShockProfile, section: str) -> dict[str, list[dict[str, Any]]]:
    """The quantities of a section at all its places, each with the name of the place."""
    names: dict[PlaceKind, str] = {"contact": "frame", "body": "body", "point": "frame", "joint": "joint"}
    return {
        {"body": "bodies"}.get(kind, f"{kind}s"): [
            {name: place.name} | row for place, row in zip(profile.places(kind), _selected(profile, kind, section), strict=True)
        ]
        for kind, name in names.items()
    }


def _drives(profile: ShockProfile) -> dict[str, Any]:
    """Where the drives are from, of which joints they are unknown, which have springs, and when these count [s]."""
    model, time = profile.landing.joint_model, profile.spring_time
    joints = [joint for joint in profile.robot.single_joints if joint.kind != "free"]
    return {
        "source": model.drives or None,
        "unknown": [joint.name for joint in joints if model.unknown[joint.v].any()],
        "springs": [joint.name for joint in joints if model.springs[joint.v].any()],
        "spring_time": time if math.isfinite(time) else None,
    }


def _friction(profile: ShockProfile) -> dict[str, Any] | None:
    """The impact with friction, in double precision; None without a coefficient."""
    if (friction := profile.friction) is None:
        return None
    (whole,), places = _selected(profile, "robot", "friction"), _named(profile, "friction")
    contacts = zip(places.pop("contacts"), friction.state, strict=True)
    return {
        "coefficient": profile.scene.friction,
        "unchanged": friction.impact is None,
        **whole,
        "solutions": friction.solutions,
        "contacts": [{"frame": contact.pop("frame"), "state": state, **contact} for contact, state in contacts],
        **places,
    }


def _stiffness(profile: ShockProfile, spectrum: bool) -> dict[str, Any] | None:
    """The landing on contacts of finite stiffness, in double precision; None without a stiffness."""
    if (stiffness := profile.stiffness) is None:
        return None
    contacts = profile.places("contact")[: len(profile.landing.contacts)]
    modes, shares = stiffness.motion.modes, stiffness.force_shares
    (whole,) = _selected(profile, "robot", "stiffness")
    return {
        "contact_stiffness": profile.scene.contact_stiffness,
        **whole,
        **_named(profile, "stiffness"),
        "modes": [
            {
                "frequency": modes.frequency[k],
                "energy": modes.energy[k],
                "force_share": {place.name: shares[c, k] for c, place in enumerate(contacts)},
                "contacts_share": modes.participation[stiffness.number >= 0, k].sum(),
            }
            for k in range(len(modes.frequency))
        ],
        "springs_count": profile.spring_time if math.isfinite(profile.spring_time) else None,
        "spectra": _spectra(profile, stiffness) if spectrum else None,
    }


def _spectra(profile: ShockProfile, stiffness: "CompliantLanding") -> dict[str, Any]:
    """The shock response spectra of the points [g]."""
    from shockpc.impact.stiffness import DAMPING, SPECTRUM

    points = [place for place in profile.places("point") if place.body >= 0]
    compute = quantity("point", "delta_v").compute
    spectra = [stiffness.spectrum(compute, points, damping) / GRAVITY for damping in DAMPING]
    return {
        "frequencies": list(SPECTRUM),
        "damping": list(DAMPING),
        "points": [{"frame": place.name, "response": [one[:, k] for one in spectra]} for k, place in enumerate(points)],
    }


def headed(name: str, content: dict[str, Any], version: int = 1) -> dict[str, Any]:
    """A document: its schema, what computed it, and what was found, as JSON holds it."""
    return {"schema": f"shockpc.{name}/{version}", "shockpc": shockpc.__version__, "pinocchio": PINOCCHIO, **_plain(content)}


def record(instance: object, *keys: str) -> dict[str, Any]:
    """Some attributes of a record."""
    return {key: getattr(instance, key) for key in keys}


def _plain(value: Any) -> Any:
    """A value as JSON holds it: named tuples are objects, a scene its table; no -0.0."""
    match value:
        case None | str() | int():
            return value
        case float():
            return value + 0.0 if math.isfinite(value) else None
        case np.ndarray() if value.dtype.kind == "f" and np.isfinite(value).all():
            return (value + 0.0).tolist()
        case np.ndarray() | np.generic():
            return _plain(value.tolist())
        case Mapping():
            return {key: _plain(part) for key, part in value.items()}
        case list():
            parts = [_plain(part) for part in value]
            return None if parts and all(part is None for part in parts) else parts
        case tuple():
            return _plain(value._asdict()) if hasattr(value, "_asdict") else [_plain(part) for part in value]
        case Scene():
            return scene_table(value)
        case _:
            return str(value)
