"""Entries of the JSON document of a landing beside its tables, schema `shockpc.profile/2`.

The tables hold the quantities.
"""

import math
from typing import Any

from shockpc.impact.springs import spring_time
from shockpc.judgement.first_number import first_deciding, first_place, first_range, shock_of
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.document import record
from shockpc.text.wings import from_wings


def content(profile: ShockProfile, spectrum: bool = False) -> dict[str, Any]:
    """The document of a profile without its head and tables.

    Args:
        profile: the landing.
        spectrum: whether it has the shock response spectra of the points, with a contact stiffness.
    """
    robot, assembly, friction = profile.robot, profile.assembly, profile.friction
    entries = {
        "unknowns": profile.unknowns,
        "range": _range(profile),
        "robot": {
            "name": robot.name,
            "file": robot.label,
            "n_bodies": len(robot.bodies),
            "nv": robot.model.nv,
        },
        "scene": profile.scene,
        "bodies": [
            {"body": body.name, "links": body.links, "rotation": R}
            for body, R in zip(robot.bodies, profile.rotation, strict=True)
        ],
        "joint_model": profile.joint_model,
        "drives": _drives(profile),
        "health": profile.health,
        "loads_unique": profile.health.rank == profile.health.rows,
        "assembly": assembly
        and {
            **record(assembly, "gap", "turn", "left", "retried"),
            "moved": [{"joint": name, "by": by} for name, by, _ in assembly.moved],
        },
        "friction": friction
        and {
            "coefficient": profile.scene.friction,
            "unchanged": friction.impact is None,
            "solutions": friction.solutions,
        },
    }
    for document_of in from_wings("report", "document"):
        entries |= document_of(profile, spectrum)
    return entries


def _range(profile: ShockProfile) -> dict[str, Any] | None:
    """The range of the first number over the drives, and the joints that decide.

    None where all drives are known exactly.
    """
    if (over_drives := first_range(profile)) is None:
        return None
    wanted, place = shock_of(profile), first_place(profile)
    (value,) = profile.numbers(wanted, [place]).tolist()
    first = {"quantity": wanted.quantity.key, "at": place.name, "value": value}
    return {**first, **over_drives._asdict(), "deciding": first_deciding(profile)}


def _drives(profile: ShockProfile) -> dict[str, Any]:
    """The source of the drives, the joints with unknown ones, and those with springs.

    It also has the time when springs count [s].
    """
    model = profile.landing.joint_model
    joints = [joint for joint in profile.robot.single_joints if joint.kind != "free"]
    return {
        "source": model.drives or None,
        "unknown": [joint.name for joint in joints if model.unknown[joint.v].any()],
        "springs": [joint.name for joint in joints if model.springs[joint.v].any()],
        "spring_time": springs_count(profile),
    }


def springs_count(profile: ShockProfile) -> float | None:
    """The time when the first spring has an effect [s]; None where no spring has any."""
    time = spring_time(profile.landing)
    return time if math.isfinite(time) else None
