"""A profile as the JSON document that everybody reads: schema `shockpc.profile/1`.

`null` stands where a thing does not exist: CoPc and RoPc of a body that does not turn in the plane, pitch of one that does not
turn, extremes of a body without geometry, impulses that are not unique, an error estimate where no digit is sure. Keys added to the
schema come last in their object.
Keys keep their order and numbers are Python's shortest that read back the same.
"""

import json
import math
from typing import Any

import numpy as np

import shockpc
from shockpc.core.directions import ExtremeDirections
from shockpc.core.spatial import Array
from shockpc.model.dynamics import PINOCCHIO
from shockpc.result import ShockProfile
from shockpc.scene import scene_table

__all__ = ["SCHEMA", "document", "to_json"]

SCHEMA = "shockpc.profile/1"


def document(profile: ShockProfile) -> dict[str, Any]:
    """The document of one profile; positions in metres, world or body axes as `ShockProfile` says."""
    robot = profile.robot
    return {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        "robot": {
            "name": robot.name,
            "file": robot.label,
            "mass": robot.mass,
            "n_bodies": len(robot.bodies),
            "nv": robot.model.nv,
        },
        "scene": scene_table(profile.scene),
        "v_in": profile.v_in,
        "bodies": [_body(profile, i) for i in range(len(robot.bodies))],
        "points": [
            {
                "frame": point.frame,
                "body": point.body,
                "delta_v": _vector(point.delta_v),
                "shock": point.shock,
                **_strikes(point.directions),
                "peak_g": point.peak_g,
            }
            for point in profile.points
        ],
        "contacts": [
            {
                "frame": contact.frame,
                "point": _vector(contact.point),
                "impulse": None if contact.impulse is None else _vector(contact.impulse),
                "friction_needed": contact.friction_needed,
                "approach": _vector(contact.approach),
                "mass_sticking": _number(contact.mass_sticking),
                "mass_frictionless": _number(contact.mass_frictionless),
                "mitigation": contact.mitigation,
                "moment": None if contact.moment is None else _vector(contact.moment),
            }
            for contact in profile.contacts
        ],
        "joint_model": profile.joint_model,
        "health": {
            "rank": profile.health.rank,
            "rows": profile.health.rows,
            "error_bound": profile.health.error_bound,
            "body_error_bounds": list(profile.health.body_error_bounds),
            "double_error": _number(profile.health.double_error),
            "data_sensitivity": _number(profile.health.data_sensitivity),
            "bits": profile.health.bits,
            "warnings": [str(warning) for warning in profile.health.warnings],
        },
        "stance": [
            {
                "frame": foot.frame,
                "point": _vector(foot.point),
                "impulse": None if foot.impulse is None else _vector(foot.impulse),
                "friction_needed": foot.friction_needed,
            }
            for foot in profile.stance
        ],
        "total": {"impulse": _vector(profile.total_impulse), "moment": _vector(profile.total_moment)},
        "energy": {"lost": profile.energy_lost, "share": profile.energy_share},
        "joints": [
            {"joint": load.joint, "force": _vector(load.force), "moment": _vector(load.moment), "along": load.along}
            for load in profile.loads
        ],
        "bracket": [{"place": b.place, "free": b.free, "as_modelled": b.as_modelled, "locked": b.locked} for b in profile.bracket],
        "assembly": None
        if profile.assembly is None
        else {
            "gap": profile.assembly.gap,
            "turn": profile.assembly.turn,
            "moved": [{"joint": name, "by": by} for name, by, _ in profile.assembly.moved],
        },
        "loads_unique": profile.health.rank == profile.health.rows,
    }


def to_json(profiles: list[ShockProfile]) -> str:
    """One document, or a list of them where a contact pattern made several cases."""
    documents = [document(profile) for profile in profiles]
    return json.dumps(documents[0] if len(documents) == 1 else documents, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _body(profile: ShockProfile, i: int) -> dict[str, Any]:
    """The row of one body."""
    return {
        "body": profile.bodies[i],
        "links": list(profile.robot.bodies[i].links),
        "placement": {
            "position": _vector(profile.position[i]),
            "rotation": [_vector(row) for row in profile.rotation[i]],
        },
        "delta_omega": _vector(profile.delta_omega[i]),
        "delta_v": _vector(profile.delta_v[i]),
        "copc": None if profile.translates[i] else _vector(profile.copc[i]),
        "copc_world": None if profile.translates[i] else _vector(profile.copc_world[i]),
        "ropc": _number(profile.ropc[i]),
        "translates": bool(profile.translates[i]),
        "pitch": _number(profile.pitch[i]),
        "off_plane": float(profile.off_plane[i]),
        "shock_com": float(profile.shock_com[i]),
        "shock_min": _number(profile.shock_min[i]),
        "shock_max": _number(profile.shock_max[i]),
        **_strikes(ExtremeDirections(*(found[i] for found in profile.directions))),
    }


def _strikes(found: ExtremeDirections) -> dict[str, Any]:
    """The most and the least severe strike strike for one place."""
    return {
        "most_severe": {"direction": _vector(found.most_severe), "shock": float(found.most_severe_shock)},
        "least_severe": {"direction": _vector(found.least_severe), "shock": float(found.least_severe_shock)},
    }


def _number(value: np.float64 | float) -> float | None:
    """A number, or None where there is none to give."""
    return float(value) if math.isfinite(value) else None


def _vector(values: Array) -> list[float]:
    """An array as plain numbers; adding zero keeps -0.0 out of the file."""
    return [float(value) for value in np.asarray(values) + 0.0]
