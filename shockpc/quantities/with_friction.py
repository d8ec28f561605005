"""Quantities of a landing with friction, in double precision."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.impact import DoubleImpact, Impact
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import PlaceKind
from shockpc.quantities.of_bodies import BODIES
from shockpc.quantities.of_contacts import CONTACTS
from shockpc.quantities.of_joints import JOINTS
from shockpc.quantities.of_points import POINTS
from shockpc.quantities.of_robot import ROBOT
from shockpc.quantities.quantity import IN_DOUBLES, Places, Quantity, Relations, Scope, no_values

if TYPE_CHECKING:
    from shockpc.impact.friction import FrictionResult

OF_THE_IMPACT = (*POINTS, *BODIES, *JOINTS, *CONTACTS, *ROBOT)
"""Quantities of the impact on rigid ground, some of which exist for others as well."""


def friction_result(landing: PosedLanding) -> "FrictionResult":
    """The landing with friction; what solves it is imported where a scene gives friction."""
    from shockpc.impact.friction import friction_of

    return friction_of(landing)


def where_given(
    entry: Quantity,
    key: str,
    solve: Callable[[PosedLanding], Any],
    read: Callable[[Any, Impact, Places], Any],
) -> Quantity:
    """A quantity that exists where the scene gives a key.

    Args:
        entry: the quantity.
        key: of the scene.
        solve: the landing with what the scene gives, such as `friction_result`.
        read: its values as those of `Quantity.compute`, of what `solve` returns.
    """

    def compute(impact: Impact, places: Places) -> Array:
        if getattr(impact.landing.scene, key) is None:
            return no_values(entry, places)
        return np.asarray(read(solve(impact.landing), impact, places))

    why = f"the scene gives no {key.replace('_', ' ')}"
    missing = "; or ".join(filter(None, [why, entry.scope.missing]))
    return entry._replace(
        compute=compute,
        scope=Scope(missing, shared=entry.scope.shared),
        computation=IN_DOUBLES,
        relations=Relations(),
    )


def _with_friction(entry: Quantity) -> Quantity:
    """A quantity of the impact with friction, in many postures too.

    It is that of the exact impact where all contacts stick.
    """
    named = entry._replace(key=f"{entry.key}_friction", title=f"{entry.title}, with friction")
    single = where_given(
        named,
        "friction",
        friction_result,
        lambda friction, impact, places: entry.compute(friction.impact or impact, places),
    )

    def compute(impact: Impact, places: Places) -> Array:
        if not isinstance(impact, DoubleImpact) or impact.landing.scene.friction is None:
            return np.asarray(single.compute(impact, places))
        from shockpc.impact.friction import with_friction

        sliding = with_friction(impact)
        if sliding is None:
            return no_values(entry, places)
        return np.asarray(entry.compute(sliding, places))

    return single._replace(
        compute=compute, computation=single.computation._replace(postures="clear")
    )


def _sliding(
    key: str,
    of: PlaceKind,
    title: str,
    unit: str,
    read: "Callable[[FrictionResult, Places], Any]",
    form: Literal["number", "vector"] = "number",
) -> Quantity:
    """A quantity that only an impact with friction has; read gives its values (n,) or (n, 3)."""
    entry = Quantity(key, of, title, unit, "greater", read, form=form)
    return where_given(
        entry,
        "friction",
        friction_result,
        lambda friction, _, places: np.array(read(friction, places), dtype=float)[None, None],
    )


def _numbers(places: Places) -> list[int]:
    return [place.number for place in places]


WITH_FRICTION = (
    *(_with_friction(entry) for entry in OF_THE_IMPACT if "friction" in entry.relations.also),
    _sliding(
        "slip",
        "contact",
        "velocity after the impact with friction, world axes",
        "m/s",
        lambda friction, places: friction.velocity[_numbers(places)],
        form="vector",
    )._replace(size=lambda i, x: float(i.v_in.max())),
    _sliding(
        "energy_lost_friction",
        "robot",
        "kinetic energy lost, with friction",
        "J",
        lambda friction, places: np.array([friction.energy_lost]),
    ),
    _sliding(
        "friction_solutions",
        "robot",
        "solutions found with friction",
        "1",
        lambda friction, places: np.array([friction.solutions]),
    ),
    _sliding(
        "friction_residual",
        "robot",
        "residual of the laws of friction",
        "1",
        lambda friction, places: np.array([friction.residual]),
    ),
)
