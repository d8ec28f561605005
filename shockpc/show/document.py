"""A profile as a JSON document, schema `shockpc.profile/1`.

`null` where a thing does not exist: CoPc and RoPc of a body that does not rotate in the plane, pitch of one that does not rotate,
extremes of a body without geometry, impulses that are not unique; so a number that is not finite, and a list of such numbers.
Keys keep their order, and new ones are added at the end of their object. Numbers are the shortest that give the same double.
"""

import json
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

import shockpc
from shockpc.core.directions import ExtremeDirections
from shockpc.diagnostic import Diagnostic
from shockpc.model.dynamics import PINOCCHIO
from shockpc.result import ShockProfile
from shockpc.scene import Scene, scene_table

__all__ = ["document", "headed", "json_text", "record", "to_json"]

BODY = (
    "delta_omega", "delta_v", "copc", "copc_world", "ropc", "translates", "pitch", "off_plane", "shock_com",
    "shock_min", "shock_max",
)  # fmt: skip
CONTACT = ("frame", "point", "impulse", "friction_needed", "approach", "mass_sticking", "mass_frictionless", "mitigation", "moment")


def document(profile: ShockProfile) -> dict[str, Any]:
    """The document of one profile; positions in metres, world or body axes as `ShockProfile` says."""
    robot, assembly = profile.robot, profile.assembly
    size = {"name": robot.name, "file": robot.label, "mass": robot.mass, "n_bodies": len(robot.bodies), "nv": robot.model.nv}
    found = {
        "robot": size,
        "scene": profile.scene,
        "v_in": profile.v_in,
        "bodies": [
            {
                "body": body.name,
                "links": body.links,
                "placement": {"position": profile.position[i], "rotation": profile.rotation[i]},
                **{key: getattr(profile, key)[i] for key in BODY},
                **_directions(ExtremeDirections(*(part[i] for part in profile.directions))),
            }
            for i, body in enumerate(robot.bodies)
        ],
        "points": [
            {**record(one, "frame", "body", "delta_v", "shock"), **_directions(one.directions), "peak_g": one.peak_g}
            for one in profile.points
        ],
        "contacts": [record(one, *CONTACT) for one in profile.contacts],
        "joint_model": profile.joint_model,
        "health": profile.health,
        "stance": profile.stance,
        "total": {"impulse": profile.total_impulse, "moment": profile.total_moment},
        "energy": {"lost": profile.energy_lost, "share": profile.energy_share},
        "joints": profile.loads,
        "bracket": profile.bracket,
        "assembly": assembly
        and {**record(assembly, "gap", "turn"), "moved": [{"joint": name, "by": by} for name, by, _ in assembly.moved]},
        "loads_unique": profile.health.rank == profile.health.rows,
    }
    return headed("profile", found)


def to_json(profiles: list[ShockProfile]) -> str:
    """One document, or a list of them where a contact pattern made several cases."""
    documents = [document(profile) for profile in profiles]
    return json_text(documents[0] if len(documents) == 1 else documents)


def json_text(document: Any) -> str:
    """A document as text, in which JSON's own escapes stand for what a terminal or a CI runner would interpret."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False).replace("##", "#\\u0023")
    return re.sub("[^ -~\n]", lambda sign: sign[0] if sign[0].isprintable() else json.dumps(sign[0])[1:-1], text) + "\n"


def headed(name: str, found: dict[str, Any]) -> dict[str, Any]:
    """A document: its schema, what computed it, and what was found, as JSON holds it."""
    return {"schema": f"shockpc.{name}/1", "shockpc": shockpc.__version__, "pinocchio": PINOCCHIO, **_plain(found)}


def record(one: object, *keys: str) -> dict[str, Any]:
    """Some attributes of a record."""
    return {key: getattr(one, key) for key in keys}


def _directions(found: ExtremeDirections) -> dict[str, Any]:
    """The most and the least severe impact direction of one place."""
    return {
        "most_severe": {"direction": found.most_severe, "shock": found.most_severe_shock},
        "least_severe": {"direction": found.least_severe, "shock": found.least_severe_shock},
    }


def _plain(value: Any) -> Any:
    """A value as JSON holds it: named tuples are objects, a scene its table, warnings and other records their text; no -0.0."""
    match value:
        case None | str() | int():
            return value
        case float():
            return value + 0.0 if math.isfinite(value) else None
        case np.ndarray() | np.generic():
            return _plain(value.tolist())
        case Mapping():
            return {key: _plain(part) for key, part in value.items()}
        case list():
            parts = [_plain(part) for part in value]
            return None if parts and all(part is None for part in parts) else parts
        case Diagnostic():
            return str(value)
        case tuple():
            return _plain(value._asdict()) if hasattr(value, "_asdict") else [_plain(part) for part in value]
        case Scene():
            return scene_table(value)
        case _:
            return str(value)
