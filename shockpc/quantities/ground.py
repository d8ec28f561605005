"""What follows from a coefficient of friction, or from a finite stiffness of the contacts; in
double precision, without a proof.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.impact import DoubleImpact, Impact
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.of_bodies import BODIES
from shockpc.quantities.of_contacts import CONTACTS, IMPULSE
from shockpc.quantities.of_joints import JOINTS
from shockpc.quantities.of_points import POINTS, point_velocity
from shockpc.quantities.of_robot import ROBOT
from shockpc.quantities.quantity import Places, Quantity, cached

if TYPE_CHECKING:
    from shockpc.impact.friction import FrictionResult
    from shockpc.impact.stiffness import CompliantLanding


OF_THE_IMPACT = (*POINTS, *BODIES, *JOINTS, *CONTACTS, *ROBOT)
"""Quantities of the impact on rigid ground, some of which exist for others as well."""

JUMPS = tuple(entry for entry in OF_THE_IMPACT if "stiffness" in entry.also)
"""Quantities of the jumps only, which a landing on finite stiffness has at each time."""

FORCE, MOMENT, ALONG = JOINTS[:3]
"""What a joint carries: linear in accelerations and forces, as it is in jumps and impulses."""

ROUNDING = 1e-10
"""Share of the largest peak through a joint below which a torque is rounding."""

GroundOption: TypeAlias = Literal["friction", "contact_stiffness"]


def solved_on(landing: PosedLanding, key: GroundOption) -> Any:
    """The landing with friction, or on contacts of finite stiffness; what solves it is imported
    where a scene gives the key.
    """
    if key == "friction":
        from shockpc.impact.friction import friction_of

        return friction_of(landing)
    from shockpc.impact.stiffness import compliant_landing

    return compliant_landing(landing)


def _where_given(
    entry: Quantity, key: GroundOption, read: Callable[[Any, Impact, Places], Any]
) -> Quantity:
    """A quantity that exists where the scene gives a key.

    Args:
        entry: the quantity.
        key: of the scene.
        read: its values as those of `Quantity.compute`, of the landing with friction or on contacts
            of finite stiffness.
    """

    def compute(impact: Impact, places: Places) -> Array:
        if getattr(impact.landing.scene, key) is None:
            return np.full((1, 1, len(places), 3) if entry.vector else (1, 1, len(places)), np.nan)
        return np.asarray(read(solved_on(impact.landing, key), impact, places))

    missing = "; or ".join(
        filter(None, [f"the scene gives no {key.replace('_', ' ')}", entry.missing])
    )
    derived = Quantity(
        entry.key, entry.of, entry.title, entry.unit, entry.worse, compute, entry.size, missing
    )
    same = {name: getattr(entry, name) for name in ("vector", "shared", "signed", "flag")}
    return derived._replace(**same, needs_posture=True, unproven=True)


def _with_friction(entry: Quantity) -> Quantity:
    """A quantity of the impact with friction, in many postures too; of a proven impact as that is
    where all contacts stick.
    """
    named = entry._replace(key=f"{entry.key}_friction", title=f"{entry.title}, with friction")
    single = _where_given(
        named,
        "friction",
        lambda friction, impact, places: entry.compute(friction.impact or impact, places),
    )

    def compute(impact: Impact, places: Places) -> Array:
        if not isinstance(impact, DoubleImpact) or impact.landing.scene.friction is None:
            return np.asarray(single.compute(impact, places))
        from shockpc.impact.friction import with_friction

        slipping = with_friction(impact)
        nothing = np.full((1, 1, len(places), *([3] if entry.vector else [])), np.nan)
        return nothing if slipping is None else np.asarray(entry.compute(slipping, places))

    return single._replace(compute=compute, in_doubles=True)


def _sliding(
    key: str,
    of: PlaceKind,
    title: str,
    unit: str,
    read: "Callable[[FrictionResult, Places], Any]",
    vector: bool = False,
) -> Quantity:
    """A quantity that only an impact with friction has; read gives its values (n,) or (n, 3)."""
    entry = Quantity(key, of, title, unit, "greater", read, vector=vector)
    return _where_given(
        entry,
        "friction",
        lambda friction, _, places: np.array(read(friction, places), dtype=float)[None, None],
    )


def _stiff(
    key: str,
    of: PlaceKind,
    title: str,
    unit: str,
    read: "Callable[[CompliantLanding, Places], Array]",
    missing: str = "",
) -> Quantity:
    """A quantity of a landing on contacts of finite stiffness; read gives its values (n,)."""
    entry = Quantity(
        key, of, title, unit, "neither" if unit == "s" else "greater", read, missing=missing
    )
    return _where_given(
        entry, "contact_stiffness", lambda compliant, _, places: read(compliant, places)[None, None]
    )


def _after(entry: Quantity, when: str, title: str, end: int) -> Quantity:
    """A quantity of the jumps from the impact until one of the ends of a landing on contacts of
    finite stiffness.
    """
    compute = cached(entry.compute)
    named = entry._replace(key=f"{entry.key}_{when}", title=f"{entry.title}, {title}")
    return _where_given(
        named,
        "contact_stiffness",
        lambda compliant, _, places: compliant.ends(compute, places)[:, end : end + 1],
    )


def _wrench(impact: Impact, places: Places) -> Array:
    """Forces, moments, and the parts along the axes (N, S, 3 n, 3) that n joints carry, one after
    the other.
    """
    force, moment, along = (
        np.asarray(entry.compute(impact, places)) for entry in (FORCE, MOMENT, ALONG)
    )
    return np.concatenate([force, moment, along[..., None] * np.array([1.0, 0.0, 0.0])], axis=2)


def _loads(impact: Impact, _: Places) -> Array:
    """All whose peaks a landing shows, n vectors (N, S, n, 3): forces of contacts, velocities of
    points and parts, wrenches.
    """
    landing = impact.landing
    shown = (
        (IMPULSE.compute, landing.contact_places),
        (point_velocity, _points(landing)),
        (_wrench, landing.places("joint")),
    )
    return np.concatenate(
        [np.asarray(compute(impact, places)) for compute, places in shown if places], axis=2
    )


def _points(landing: PosedLanding) -> list[Place]:
    """The points and parts that move."""
    return [place for place in (*landing.points, *landing.mounted) if place.body >= 0]


def _contact_peaks(compliant: "CompliantLanding", places: Places) -> Array:
    """Peak forces (n,) of contacts [N], and when each is reached [s]; NaN of the end stop of a
    hinge, which has a torque.
    """
    numbers, hinge = _numbers(places), [not len(block.forces) for block in compliant.landing.blocks]
    return np.where(np.array(hinge)[numbers], np.nan, np.array(compliant.peaks(_loads))[:, numbers])


def point_peaks(compliant: "CompliantLanding", places: Places) -> Array:
    """Peak accelerations (n,) of points [m/s²], and when each is reached [s]."""
    landing = compliant.landing
    index = {
        (place.body, place.r.tobytes()): k
        for k, place in enumerate(_points(landing), len(landing.contact_places))
    }
    columns = [index.get((place.body, place.r.tobytes()), -1) for place in places]
    return (
        np.array(compliant.peaks(point_velocity, places))
        if -1 in columns
        else np.array(compliant.peaks(_loads))[:, columns]
    )


def _joint_peaks(compliant: "CompliantLanding", places: Places) -> Array:
    """Peak forces, moments and torques along the axes (3, n) of joints.

    A torque is zero where it is rounding, and NaN where it is that of a spring before a rotor of
    unknown inertia.
    """
    joints = {place.name: k for k, place in enumerate(compliant.landing.places("joint"))}
    force, moment, along = compliant.peaks(_loads)[0][-3 * len(joints) :].reshape(3, -1)
    least = ROUNDING * max(force.max(initial=0.0), moment.max(initial=0.0))
    peaks = np.array([force, moment, np.where(along <= least, 0.0, along)])
    peaks = peaks[:, [joints[place.name] for place in places]]
    peaks[2, compliant.landing.joint_model.rotor_unknown[_numbers(places)]] = np.nan
    return peaks


def _numbers(places: Places) -> list[int]:
    return [place.number for place in places]


def _of_contacts(values: Array, places: Places) -> Array:
    """Values (n,) of contacts, and none of standing feet. Args: values (c,) of all contacts."""
    return np.array(
        [values[place.number] if place.number < len(values) else np.nan for place in places]
    )


PEAK_TORQUE = _stiff(
    "peak_torque",
    "joint",
    "peak torque along the joint's axis",
    "N m, N",
    lambda found, places: _joint_peaks(found, places)[2],
    "the joint has more than one axis, or a spring before a rotor of unknown inertia",
)

GROUND = (
    *(_with_friction(entry) for entry in OF_THE_IMPACT if "friction" in entry.also),
    _sliding(
        "slip",
        "contact",
        "velocity after the impact with friction, world axes",
        "m/s",
        lambda found, places: found.velocity[_numbers(places)],
        vector=True,
    )._replace(size=lambda i, x: float(i.v_in.max())),
    _sliding(
        "energy_lost_friction",
        "robot",
        "kinetic energy lost, with friction",
        "J",
        lambda found, places: np.array([found.energy_lost]),
    ),
    _sliding(
        "friction_solutions",
        "robot",
        "solutions found with friction",
        "1",
        lambda found, places: np.array([found.solutions]),
    ),
    _sliding(
        "friction_residual",
        "robot",
        "residual of the laws of friction",
        "1",
        lambda found, places: np.array([found.residual]),
    ),
    _stiff(
        "peak_acceleration",
        "point",
        "peak acceleration on contacts of finite stiffness",
        "g",
        lambda found, places: point_peaks(found, places)[0] / GRAVITY,
    ),
    _stiff(
        "peak_acceleration_time",
        "point",
        "time of the peak acceleration",
        "s",
        lambda found, places: point_peaks(found, places)[1],
    ),
    _stiff(
        "duration",
        "contact",
        "duration of 99 % of the normal impulse",
        "s",
        lambda found, places: _of_contacts(found.duration, places),
    ),
    _stiff(
        "peak_force",
        "contact",
        "peak force",
        "N",
        lambda found, places: _contact_peaks(found, places)[0],
    ),
    _stiff(
        "peak_force_time",
        "contact",
        "time of the peak force",
        "s",
        lambda found, places: _contact_peaks(found, places)[1],
    ),
    _stiff(
        "peak_joint_force",
        "joint",
        "peak force through the joint",
        "N",
        lambda found, places: _joint_peaks(found, places)[0],
    ),
    _stiff(
        "peak_joint_moment",
        "joint",
        "peak moment through the joint",
        "N m",
        lambda found, places: _joint_peaks(found, places)[1],
    ),
    PEAK_TORQUE,
    _stiff(
        "peak_stop",
        "joint",
        "peak torque of the joint's end stop",
        "N m, N",
        lambda found, places: np.array([found.stop_peaks.get(place.name, 0.0) for place in places]),
    ),
    _stiff(
        "restitution",
        "contact",
        "restitution, with the contact's damping",
        "1",
        lambda found, places: _of_contacts(found.restitution, places),
    ),
    _stiff(
        "stiffness_difference",
        "robot",
        "difference from the impulse model",
        "1",
        lambda found, places: np.array([found.difference]),
    ),
    _stiff(
        "compression",
        "robot",
        "time at which the contacts are compressed",
        "s",
        lambda found, places: np.array([found.compressed]),
    ),
    *(_after(entry, "compressed", "at the end of compression", 0) for entry in JUMPS),
    *(_after(entry, "separated", "at the end of contact", 1) for entry in JUMPS),
)
