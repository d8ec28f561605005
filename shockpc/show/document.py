"""A profile as a JSON document, schema `shockpc.profile/1`.

`null` where a thing does not exist: CoPc and RoPc of a body that does not rotate in the plane, pitch of one that does not rotate,
extremes of a body without geometry, impulses that are not unique. Keys keep their order, and new ones are added at the end of their
object. Numbers are the shortest that read back as the same double.
"""

import json
import math
from typing import Any

import numpy as np

import shockpc
from shockpc.core.directions import ExtremeDirections
from shockpc.diagnostic import Diagnostic
from shockpc.model.dynamics import PINOCCHIO
from shockpc.result import ShockProfile
from shockpc.scene import Scene, scene_table

__all__ = ["document", "head", "json_text", "plain", "record", "to_json"]

BODY = (
    "delta_omega", "delta_v", "copc", "copc_world", "ropc", "translates", "pitch", "off_plane", "shock_com",
    "shock_min", "shock_max",
)  # fmt: skip
CONTACT = ("frame", "point", "impulse", "friction_needed", "approach", "mass_sticking", "mass_frictionless", "mitigation", "moment")
HEALTH = ("rank", "rows", "error_bound", "body_error_bounds", "double_error", "data_sensitivity", "bits", "warnings")


def document(profile: ShockProfile) -> dict[str, Any]:
    """The document of one profile; positions in metres, world or body axes as `ShockProfile` says."""
    robot, assembly = profile.robot, profile.assembly
    size = {"name": robot.name, "file": robot.label, "mass": robot.mass, "n_bodies": len(robot.bodies), "nv": robot.model.nv}
    return {
        **head("profile"),
        "robot": plain(size),
        "scene": plain(profile.scene),
        "v_in": plain(profile.v_in),
        "bodies": [
            {
                "body": profile.bodies[i],
                "links": list(robot.bodies[i].links),
                "placement": {"position": plain(profile.position[i]), "rotation": plain(profile.rotation[i])},
                **{key: plain(getattr(profile, key)[i]) for key in BODY},
                **_directions(ExtremeDirections(*(found[i] for found in profile.directions))),
            }
            for i in range(len(robot.bodies))
        ],
        "points": [
            {**record(one, "frame", "body", "delta_v", "shock"), **_directions(one.directions), **record(one, "peak_g")}
            for one in profile.points
        ],
        "contacts": [record(one, *CONTACT) for one in profile.contacts],
        "joint_model": profile.joint_model,
        "health": record(profile.health, *HEALTH),
        "stance": [record(one, "frame", "point", "impulse", "friction_needed") for one in profile.stance],
        "total": {"impulse": plain(profile.total_impulse), "moment": plain(profile.total_moment)},
        "energy": {"lost": plain(profile.energy_lost), "share": plain(profile.energy_share)},
        "joints": [record(one, "joint", "force", "moment", "along") for one in profile.loads],
        "bracket": [record(one, "place", "free", "as_modelled", "locked") for one in profile.bracket],
        "assembly": None
        if assembly is None
        else {**record(assembly, "gap", "turn"), "moved": [{"joint": name, "by": plain(by)} for name, by, _ in assembly.moved]},
        "loads_unique": profile.health.rank == profile.health.rows,
    }


def to_json(profiles: list[ShockProfile]) -> str:
    """One document, or a list of them where a contact pattern made several cases."""
    documents = [document(profile) for profile in profiles]
    return json_text(documents[0] if len(documents) == 1 else documents)


def json_text(document: Any) -> str:
    """A document as text."""
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def head(name: str) -> dict[str, Any]:
    """How every document begins: its schema, and what computed it."""
    return {"schema": f"shockpc.{name}/1", "shockpc": shockpc.__version__, "pinocchio": PINOCCHIO}


def record(one: object, *keys: str) -> dict[str, Any]:
    """Some attributes of a record."""
    return {key: plain(getattr(one, key)) for key in keys}


def _directions(found: ExtremeDirections) -> dict[str, Any]:
    """The most and the least severe impact direction of one place."""
    return {
        "most_severe": {"direction": plain(found.most_severe), "shock": plain(found.most_severe_shock)},
        "least_severe": {"direction": plain(found.least_severe), "shock": plain(found.least_severe_shock)},
    }


def plain(value: Any) -> Any:
    """A value as JSON holds it.

    Arrays and tuples are lists; a number that is not finite, and a list of such numbers alone, are null; there is no -0.0. A scene
    is its table; other records, such as warnings, are their text.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list):
        parts = [plain(part) for part in value]
        return None if parts and all(part is None for part in parts) else parts
    if isinstance(value, Diagnostic):
        return str(value)
    if isinstance(value, tuple):
        return [plain(part) for part in value]
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    if isinstance(value, Scene):
        return scene_table(value)
    return value if value is None or isinstance(value, str | int) else str(value)
