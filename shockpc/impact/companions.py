"""A landing with other joints (free, locked, locked but for springs) or without friction."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.landed import LandingProof, proven
from shockpc.impact.stops import with_stops
from shockpc.landing.feet.auto_contact import with_own_faces
from shockpc.landing.joint_model import without_springs
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import Constraint
from shockpc.method.dynamics import dynamics
from shockpc.text.errors import SceneError, SolveError

Other = Literal["free", "locked", "springs_free"]
"""The joints that move: all, none, or those with springs."""

OTHERS: tuple[Other, ...] = ("free", "locked", "springs_free")
"""All of these."""


def companion(landing: PosedLanding, name: Other) -> PosedLanding | None:
    """The landing with other joints; None without springs that could be free.

    Raises:
        SceneError: it cannot be posed.
    """
    locked = _locked(landing, name)
    if locked is None:
        return None
    state = dynamics(landing.robot, landing.q[None])
    joints = without_springs(np.zeros(len(locked)), locked, name)
    locked_landing = with_own_faces(replace(landing.without_stops, joint_model=joints, state=state))
    return with_stops(locked_landing) if landing.scene.stops else locked_landing


def _locked(landing: PosedLanding, name: Other) -> Array | None:
    """Mask (nv,) of locked joint velocities; None without springs that could be free."""
    driven, springs = landing.robot.actuated_dofs, landing.joint_model.springs
    if name == "springs_free":
        return driven & ~springs if springs.any() else None
    return driven if name == "locked" else np.zeros_like(driven)


def frictionless(landing: PosedLanding) -> PosedLanding:
    """The landing with contacts that push only along the ground's normal.

    A flat contact keeps its moments about axes in the ground.
    """
    contacts = list[Constraint]()
    for constraint in landing.contacts:
        n = constraint.normal
        tilts = constraint.moments[np.abs(constraint.moments @ n) < 0.5]
        contacts.append(constraint._replace(forces=n[None], moments=tilts, rebound=n))
    return replace(landing, contacts=tuple(contacts))


class Companions:
    """The proofs of a landing with other joints; each is computed when it is asked for, and kept.

    Args:
        landing: the landing.
        proof: of it, which is that of a companion with the same joints.
    """

    def __init__(self, landing: PosedLanding, proof: LandingProof) -> None:
        self._landing, self._proof = landing, proof
        self._known: dict[Other, LandingProof | str | None] = {}

    def proof(self, name: Other) -> LandingProof | None:
        """The proof of a companion; None where it has no verdict, or the landing no springs."""
        proof = self._computed(name)
        return None if isinstance(proof, str) else proof

    @property
    def refused(self) -> Mapping[str, str]:
        """Why companions have no verdict, by their names."""
        refused: dict[str, str] = {}
        for name in OTHERS:
            proof = self._computed(name)
            if isinstance(proof, str):
                refused[name] = proof
        return refused

    def _computed(self, name: Other) -> LandingProof | str | None:
        """The proof, why there is none, or None without springs."""
        if name not in self._known:
            self._known[name] = self._compute(name)
        return self._known[name]

    def _compute(self, name: Other) -> LandingProof | str | None:
        if self._landing.joint_model.name == name:
            return self._proof
        locked = _locked(self._landing, name)
        if locked is not None and name != "free" and not locked.any():
            return self._computed("free")
        try:
            landing = companion(self._landing, name)
            return None if landing is None else proven(landing)
        except (SceneError, SolveError) as refusal:
            return str(refusal)
