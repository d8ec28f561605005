"""What follows from a coefficient of friction, or from a finite stiffness of the contacts; in double precision, without a proof."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact import Impact
from shockpc.places import Kind
from shockpc.quantities.bodies import BODIES
from shockpc.quantities.contacts import CONTACTS
from shockpc.quantities.joints import JOINTS
from shockpc.quantities.points import POINTS
from shockpc.quantities.quantity import Places, Quantity
from shockpc.quantities.robot import ROBOT
from shockpc.scene import GRAVITY

if TYPE_CHECKING:
    from shockpc.ground import FrictionResult, StiffnessResult

__all__ = ["GROUND"]

NO_FRICTION = "the scene gives no friction"
NO_STIFFNESS = "the scene gives no contact stiffness"

SLIDING: dict[Kind, Sequence[str]] = {
    "point": ("shock", "delta_v", "peak_g"),
    "body": ("shock_com", "delta_omega", "delta_v", "copc", "ropc"),
    "joint": ("delta_qd", "along", "joint_impulse", "joint_moment"),
    "contact": ("impulse",),
    "robot": ("total_impulse", "total_moment"),
}
"""Quantities that exist for an impact with friction, which is not linear in the strike."""


def _none(places: Places, vector: bool) -> Array:
    """No value (1, 1, n) or (1, 1, n, 3) at some places."""
    return np.full((1, 1, len(places), 3) if vector else (1, 1, len(places)), np.nan)


def _with_friction(entry: Quantity) -> Quantity:
    """A quantity of the impact with friction; as proven where all contacts stick."""

    def compute(impact: Impact, places: Places) -> Array:
        if impact.landing.scene.friction is None:
            return _none(places, entry.vector)
        from shockpc.ground import friction_of

        assert entry.compute is not None
        return np.asarray(entry.compute(friction_of(impact.landing).impact or impact, places))

    missing = "; or ".join(filter(None, [NO_FRICTION, entry.missing]))
    title = f"{entry.title}, with friction"
    return entry._replace(key=f"{entry.key}_friction", title=title, compute=compute, missing=missing, posed=True)


def _sliding(
    key: str, of: Kind, title: str, unit: str, read: "Callable[[FrictionResult, Places], Array]", vector: bool = False
) -> Quantity:
    """A quantity that only an impact with friction has; read gives its values (n,) or (n, 3)."""

    def compute(impact: Impact, places: Places) -> Array:
        if impact.landing.scene.friction is None:
            return _none(places, vector)
        from shockpc.ground import friction_of

        return np.asarray(read(friction_of(impact.landing), places))[None, None]

    return Quantity(key, of, title, unit, "greater", compute, missing=NO_FRICTION, vector=vector, posed=True)


def _stiff(key: str, of: Kind, title: str, unit: str, read: "Callable[[StiffnessResult, Impact, Places], Array]") -> Quantity:
    """A quantity of a landing on contacts of finite stiffness; read gives its values (n,)."""

    def compute(impact: Impact, places: Places) -> Array:
        if impact.landing.scene.contact_stiffness is None:
            return _none(places, False)
        from shockpc.ground import stiffness_of

        return np.asarray(read(stiffness_of(impact.landing), impact, places))[None, None]

    worse = "neither" if unit == "s" else "greater"
    return Quantity(key, of, title, unit, worse, compute, missing=NO_STIFFNESS, posed=True)  # type: ignore[arg-type]


def _numbers(places: Places) -> list[int]:
    return [place.number for place in places]


GROUND = (
    *(_with_friction(entry) for entry in (*POINTS, *BODIES, *JOINTS, *CONTACTS, *ROBOT) if entry.key in SLIDING[entry.of]),
    _sliding("slip", "contact", "velocity after the impact with friction, world axes", "m/s",
        lambda found, places: found.velocity[_numbers(places)], vector=True),
    _sliding("energy_lost_friction", "robot", "kinetic energy lost, with friction", "J",
        lambda found, places: np.array([found.energy_lost])),
    _sliding("friction_solutions", "robot", "solutions found with friction", "1",
        lambda found, places: np.array([found.solutions])),
    _sliding("friction_residual", "robot", "residual of the laws of friction", "1",
        lambda found, places: np.array([found.residual])),
    _stiff("peak_acceleration", "point", "peak acceleration on contacts of finite stiffness", "g",
        lambda found, impact, places: found.accelerations(impact.landing, places)[0] / GRAVITY),
    _stiff("peak_acceleration_time", "point", "time of the peak acceleration", "s",
        lambda found, impact, places: found.accelerations(impact.landing, places)[1]),
    _stiff("duration", "contact", "duration of the contact", "s",
        lambda found, impact, places: found.duration[_numbers(places)]),
    _stiff("peak_force", "contact", "peak force", "N", lambda found, impact, places: found.force[_numbers(places)]),
    _stiff("peak_force_time", "contact", "time of the peak force", "s",
        lambda found, impact, places: found.force_time[_numbers(places)]),
    _stiff("peak_torque", "joint", "peak torque along the joint's axis", "N m, N",
        lambda found, impact, places: found.torque[_numbers(places)]),
    _stiff("stiffness_difference", "robot", "difference from the impulse model", "1",
        lambda found, impact, places: np.array([found.difference])),
)  # fmt: skip
