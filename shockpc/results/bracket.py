"""The same landing with free, modelled and locked joints: the choice that changes the answer most."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import solve_impact
from shockpc.errors import SceneError, SolveError
from shockpc.exact.proof import Enclosure
from shockpc.model.dynamics import dynamics
from shockpc.model.joint_model import JointModel
from shockpc.results.points import spots
from shockpc.results.proof import proven
from shockpc.results.solved import Solved, shock_in

__all__ = ["Bracket", "joint_bracket"]


class Bracket(NamedTuple):
    """The same landing with three models of the joints; shock at one place [1].

    Attributes:
        place: a body (its centre of mass), or a sensor.
        free: no reflected inertia; None if massless bodies then make it unsolvable.
        as_modelled: as the scene says.
        locked: every joint holds; None if there is no verdict then, because the contact cannot move as the impact asks.
    """

    place: str
    free: float | None
    as_modelled: float | None
    locked: float | None


def joint_bracket(of: Solved) -> tuple[Bracket, ...]:
    """Shock with free, modelled and locked joints: at the heaviest body's centre of mass and at every sensor and point."""
    robot, heaviest = of.robot, int(np.argmax(of.robot.masses))
    places = [(robot.bodies[heaviest].name, heaviest, robot.coms[heaviest])]
    places += [(label, frame.body, r) for label, frame, r in spots(robot, of.landing.scene.point) if frame.body >= 0]
    bodies, r = [body for _, body, _ in places], np.array([point for *_, point in places])
    shocks = []
    for name, locked in (("free", np.zeros_like(robot.driven)), ("", None), ("locked", robot.driven)):
        enclosure = _enclosure(of, name, locked)
        found = None if enclosure is None else enclosure.read(lambda impact: shock_in(impact, of.landing, bodies, r))
        shocks.append([None] * len(places) if found is None else found.tolist())
    return tuple(Bracket(name, *found) for (name, *_), found in zip(places, zip(*shocks, strict=True), strict=True))


def _enclosure(of: Solved, name: str, locked: np.ndarray | None) -> Enclosure | None:
    """The landing without reflected inertia and with other joints locked, or as modelled; None where that has no verdict."""
    if locked is None or of.landing.joint_model.name == name:
        return of.proof.enclosure
    changed = replace(of.landing, joint_model=JointModel(np.zeros(len(locked)), locked, name))
    try:
        equation = changed.equation(dynamics(of.robot, of.landing.q[None]))
        return proven(changed, equation, solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms)).enclosure
    except (SceneError, SolveError):
        return None
