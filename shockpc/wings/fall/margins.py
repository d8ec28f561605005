"""Margins of parts and joints to what they withstand, each in its worst strike."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Literal, NamedTuple

import numpy as np

from shockpc.landing.ratings import TorqueStrength, torque_limits
from shockpc.landing.scenes.scene import Scene
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.wings.fall.results import StrikeResult

EFFORTS = "joint_torque_share"
"""Quantity of every strike by which joints are judged."""


class StrikeMargin(NamedTuple):
    """Margin of a part, or a joint, to what it withstands in its worst strike.

    Attributes:
        name: of the part, or of the joint that no part rates.
        kind: "part" or "joint".
        margin: of a part as `part_margin`, of a joint its torque or effort limit over the torque
            [1].
        torque: along the joint's axis; None of a part at a point [N m, N].
        withstands: the torque given, or the effort limit of the robot's file; None of a part at a
            point [N m, N].
        strike: name of the strike.
    """

    name: str
    kind: Literal["part", "joint"]
    margin: float
    torque: float | None
    withstands: float | None
    strike: str


def judged_kinds(scenes: Iterable[Scene], robot: Robot) -> tuple[bool, bool]:
    """Two flags: parts of a scene can be judged, and joints by their torques.

    Torques need a pulse, a stiffness or a part that says how long they last.
    """
    parts = efforts = False
    for scene in scenes:
        limits, durations = torque_limits(robot, scene.part)
        lasts = scene.pulse is not None or scene.yields
        of_joints = bool(np.any(np.isfinite(limits) & (lasts | np.isfinite(durations))))
        efforts |= of_joints
        parts |= any(part.at or of_joints for part in scene.part)
    return parts, efforts


def smallest_margins(results: Sequence[StrikeResult]) -> tuple[StrikeMargin, ...]:
    """The smallest margin over the strikes of every part, and of every joint that no part rates."""
    margins: list[StrikeMargin] = []
    for result in results:
        margins += _part_margins(result)
        margins += _joint_margins(result)
    worst: dict[tuple[str, str], StrikeMargin] = {}
    for margin in sorted(margins, key=lambda margin: margin.margin):
        worst.setdefault((margin.kind, margin.name), margin)
    return tuple(worst.values())


def _part_margins(result: StrikeResult) -> Iterator[StrikeMargin]:
    """The margins of parts in a strike."""
    for part in result.profile.parts:
        if part.part_margin is None:
            continue
        withstands = None
        if isinstance(part.strength, TorqueStrength):
            withstands = part.strength.momentary_torque
        yield StrikeMargin(
            part.part, "part", part.part_margin, part.torque, withstands, result.strike.name
        )


def _joint_margins(result: StrikeResult) -> Iterator[StrikeMargin]:
    """The margins of joints that no part rates in a strike."""
    profile = result.profile
    rated = {part.joint for part in profile.landing.parts}
    joints = [place for place in profile.places("joint") if place.number not in rated]
    if not joints:
        return
    limits = torque_limits(profile.robot, profile.scene.part)[0]
    shares = profile.numbers(select(EFFORTS), joints).tolist()
    for joint, share in zip(joints, shares, strict=True):
        if math.isnan(share):
            continue
        limit = float(limits[joint.number])
        margin = 1.0 / share if share else math.inf
        yield StrikeMargin(joint.name, "joint", margin, share * limit, limit, result.strike.name)
