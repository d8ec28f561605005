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
from shockpc.model.dynamics import PINOCCHIO
from shockpc.result import ShockProfile
from shockpc.scene import scene_table

__all__ = ["SCHEMA", "document", "plain", "to_json"]

SCHEMA = "shockpc.profile/1"

BODY = (
    "delta_omega", "delta_v", "copc", "copc_world", "ropc", "translates", "pitch", "off_plane", "shock_com",
    "shock_min", "shock_max",
)  # fmt: skip
CONTACT = ("frame", "point", "impulse", "friction_needed", "approach", "mass_sticking", "mass_frictionless", "mitigation", "moment")
HEALTH = ("rank", "rows", "error_bound", "body_error_bounds", "double_error", "data_sensitivity", "bits")


def document(profile: ShockProfile) -> dict[str, Any]:
    """The document of one profile; positions in metres, world or body axes as `ShockProfile` says."""
    robot, assembly = profile.robot, profile.assembly
    size = {"name": robot.name, "file": robot.label, "mass": robot.mass, "n_bodies": len(robot.bodies), "nv": robot.model.nv}
    return {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        "robot": plain(size),
        "scene": scene_table(profile.scene),
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
            {**_record(one, "frame", "body", "delta_v", "shock"), **_directions(one.directions), **_record(one, "peak_g")}
            for one in profile.points
        ],
        "contacts": [_record(one, *CONTACT) for one in profile.contacts],
        "joint_model": profile.joint_model,
        "health": {**_record(profile.health, *HEALTH), "warnings": [str(warning) for warning in profile.health.warnings]},
        "stance": [_record(one, "frame", "point", "impulse", "friction_needed") for one in profile.stance],
        "total": {"impulse": plain(profile.total_impulse), "moment": plain(profile.total_moment)},
        "energy": {"lost": plain(profile.energy_lost), "share": plain(profile.energy_share)},
        "joints": [_record(one, "joint", "force", "moment", "along") for one in profile.loads],
        "bracket": [_record(one, "place", "free", "as_modelled", "locked") for one in profile.bracket],
        "assembly": None
        if assembly is None
        else {**_record(assembly, "gap", "turn"), "moved": [{"joint": name, "by": plain(by)} for name, by, _ in assembly.moved]},
        "loads_unique": profile.health.rank == profile.health.rows,
    }


def to_json(profiles: list[ShockProfile]) -> str:
    """One document, or a list of them where a contact pattern made several cases."""
    documents = [document(profile) for profile in profiles]
    return json.dumps(documents[0] if len(documents) == 1 else documents, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _record(record: object, *keys: str) -> dict[str, Any]:
    """Some attributes of a record."""
    return {key: plain(getattr(record, key)) for key in keys}


def _directions(found: ExtremeDirections) -> dict[str, Any]:
    """The most and the least severe impact direction of one place."""
    return {
        "most_severe": {"direction": plain(found.most_severe), "shock": plain(found.most_severe_shock)},
        "least_severe": {"direction": plain(found.least_severe), "shock": plain(found.least_severe_shock)},
    }


def plain(value: Any) -> Any:
    """A value as JSON holds it: arrays as lists, null for a number or a vector that is not finite, no -0.0."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list):
        parts = [plain(part) for part in value]
        return None if parts and all(part is None for part in parts) else parts
    if isinstance(value, tuple):
        return [plain(part) for part in value]
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    return value
