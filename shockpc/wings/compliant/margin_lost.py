"""The stiffness of the contacts from which on a margin of a part or a joint is lost."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import in_body_axes
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.landed import solved
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.ratings import torque_limits
from shockpc.landing.resolve import landing_of
from shockpc.quantities.of_parts import part_margin, torque_share
from shockpc.text.errors import SceneError, SolveError
from shockpc.wings.compliant.course import compliant_landing

SOFTEST, STIFFEST = 1e2, 1e9
"""Stiffness of contacts between which that is sought from which on a margin is lost [N/m]."""

START, STEPS, CLOSE = 1e5, 40, 1e-3
"""The first value of it [N/m]; how many are tried; and how far from 1 a margin may be there."""

MOST_SEGMENTS = 1500
"""Bound of the number of segments of all motions together that are computed for it."""


class MarginLost(NamedTuple):
    """Where a margin is lost.

    Attributes:
        contact_stiffness: smallest stiffness of the contacts on which a part has a margin below 1,
            or a joint more than its torque limit [N/m]; 0 if that is so on `SOFTEST`, infinite if
            not even on `STIFFEST`; NaN where it is not known.
        place: the name of that part or joint; empty if there is none.
        refused: why it is not known; empty if it is.
    """

    contact_stiffness: float
    place: str
    refused: str


def margin_lost(landing: PosedLanding) -> MarginLost | None:
    """The contact stiffness from which on a margin is lost, of parts and of joints with a torque or
    an effort limit.

    Contacts stick. Without springs in joints peaks are as the root of the stiffness, so that k
    times the squared margin is the answer; with them it is the next value, which a bracket keeps.

    Returns: None where there is neither a part nor a limit, or an end stop strikes.
    """
    if any(block.kind == "stop" for block in landing.contacts):
        return None
    try:
        margins = _Margins(landing)
        return _lost(margins) if margins.exist else None
    except (SceneError, SolveError) as refusal:
        return MarginLost(math.nan, "", str(refusal))


def _lost(margins: "_Margins") -> MarginLost:
    """Where the smallest margin is 1. Raises: SolveError: a motion cannot be followed."""
    low, high, k = SOFTEST, STIFFEST, margins.start
    for _ in range(STEPS):
        margin, name = margins.smallest(k)
        if margin >= 1.0:
            low = k
        else:
            high = k
        if abs(margin - 1.0) < CLOSE or low == STIFFEST or high == SOFTEST:
            break
        # margin ~ 1 / √k
        k = float(np.clip(k * min(margin, 1e4) ** 2, SOFTEST, STIFFEST))
        if not low <= k <= high:
            k = math.sqrt(low * high)
    if high == SOFTEST:
        k = 0.0
    elif low == STIFFEST:
        k, name = math.inf, ""
    return MarginLost(k, name, "")


class _Margins:
    """The smallest margin of a landing, by the stiffness of its contacts.

    Args:
        landing: its pulse and friction are left out.

    Attributes:
        start: the scene's stiffness, or `START` [N/m].
        exist: whether there is a margin.

    Raises:
        SceneError: the scene does not allow a contact stiffness.
        SolveError: the impact cannot be computed.
    """

    def __init__(self, landing: PosedLanding) -> None:
        scene = landing.scene
        self.start = scene.contact_stiffness or START
        self._along_share = None
        if scene.tangential_stiffness is not None:
            self._along_share = scene.tangential_stiffness / self.start
        bare = replace(scene, contact_stiffness=self.start, pulse=None, range_g=None, friction=None)
        self._landing = landing if bare == scene else landing_of(bare, landing.robot)
        self._equation, self._solution, jumps = solved(self._landing)
        self._jumps = in_body_axes(jumps, self._equation.state.rotation)
        self._parts = self._landing.parts
        self._joints = self._judged_joints()
        unknown = self._landing.joint_model.rotor_unknown
        of_parts = any(part.joint < 0 or not unknown[part.joint] for part in self._parts)
        self.exist = of_parts or bool(self._joints)
        self._segments = 0

    def _judged_joints(self) -> list[Place]:
        """The joints with a torque limit, of which no part is."""
        landing = self._landing
        limits = torque_limits(landing.robot, ())[0]
        judged = ~np.isnan(limits) & ~landing.joint_model.rotor_unknown
        rated = {place.joint for place in self._parts}
        joints = landing.places("joint")
        return [p for p in joints if p.number not in rated and judged[p.number]]

    def smallest(self, k: float) -> tuple[float, str]:
        """The smallest margin on contacts of a stiffness, and whose it is.

        Raises:
            SolveError: the motion cannot be followed, or all have more than `MOST_SEGMENTS`.
        """
        along = None if self._along_share is None else self._along_share * k
        scene = replace(self._landing.scene, contact_stiffness=k, tangential_stiffness=along)
        varied = self._landing
        if scene != varied.scene:
            varied = replace(varied, scene=scene)
        impact = DoubleImpact(varied, self._equation, self._solution, self._jumps)
        margins = []
        with np.errstate(divide="ignore"):
            if varied.parts:
                margins.append(part_margin(impact, varied.parts)[0, 0])
            if self._joints:
                margins.append(1.0 / torque_share(impact, self._joints)[0, 0])
        known = np.nan_to_num(np.concatenate(margins).astype(float), nan=np.inf)
        worst = int(np.argmin(known))
        self._segments += len(compliant_landing(varied).motion.segments)
        if self._segments > MOST_SEGMENTS:
            raise SolveError(
                f"the elements change {self._segments} times in the motions that were computed for "
                f"it, too often"
            )
        return float(known[worst]), [*varied.parts, *self._joints][worst].name
