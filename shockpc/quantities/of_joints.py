"""Quantities of joints: jumps of their rates, and impulses of bearings and gearboxes."""

from typing import Any

import numpy as np

from shockpc.core.percussion import norm
from shockpc.core.spatial import Array, cross
from shockpc.impact.impact import Impact
from shockpc.landing.end_stops import side_of
from shockpc.landing.places import joint_places
from shockpc.method.constraints import slices_of
from shockpc.quantities.quantity import Places, Quantity, Relations, Scope
from shockpc.robot.robot import STOP

ORIGIN = "the joint's origin (of a prismatic joint, where it has slid to)"
MULTIAXIAL = "the joint has more than one axis"
REDUNDANT = "contacts or loops are redundant, so the impulse through a joint is not determined"


def _columns(impact: Impact, places: Places) -> list[slice]:
    """The columns of q̇ with the velocities of each joint."""
    velocities = {joint.name: joint.v for joint in impact.landing.robot.single_joints}
    return [velocities[place.name] for place in places]


def _of_joints(impact: Impact, places: Places, qd: Any) -> Any:
    """The rates (N, S, n) of joints among joint velocities (N, S, nv).

    That of a ball joint is the length; NaN of a joint with two axes or more than three.
    """
    rates = []
    for columns in _columns(impact, places):
        velocity = qd[..., columns]
        axes = columns.stop - columns.start
        if axes == 1:
            rates.append(velocity[..., 0])
        elif axes == 3:
            rates.append(norm(velocity))
        else:
            rates.append(norm(np.nan * velocity))
    return np.stack(rates, axis=-1)


def _delta_qd(impact: Impact, places: Places) -> Any:
    """Jumps (N, S, n) of the rates."""
    return _of_joints(impact, places, impact.along(impact.delta_qd))


def _rate_after(impact: Impact, places: Places) -> Any:
    """Rates (N, S, n) after the impact: those before it and their jumps.

    A motor has to follow them.
    """
    before = impact.exact(np.asarray(impact.landing.before.joint_rates))[..., None, :]
    return _of_joints(impact, places, before + impact.along(impact.delta_qd))


def _fastest(impact: Impact, values: Array) -> float:
    """The largest rate before the impact, and the largest jump [rad/s, m/s]."""
    before = np.abs(impact.landing.before.joint_rates)
    return float(before.max() + _largest_jump(impact, values))


def _largest_jump(impact: Impact, values: Array) -> float:
    """The largest jump of a rate [rad/s, m/s]."""
    del values
    return float(np.abs(impact.along(impact.delta_qd).astype(float)).max())


def _force(impact: Impact, places: Places) -> Any:
    """Impulses (N, S, n, 3) that bodies receive through their joints, world axes [N s]."""
    return impact.joint_loads[:, :, [place.body for place in places], 3:]


def _moment(impact: Impact, places: Places) -> Any:
    """Their moments (N, S, n, 3) about the origins of the joints' frames, world axes [N m s].

    Joints that share a body carry one wrench, each about another origin.
    """
    number = {joint.v.start: k for k, joint in enumerate(impact.landing.robot.single_joints)}
    loads = impact.joint_loads[:, :, [place.body for place in places]]
    origins = impact.joint_origins[:, None, [number[place.number] for place in places]]
    return loads[..., :3] - cross(origins, loads[..., 3:])


def _force_length(impact: Impact, places: Places) -> Any:
    """The lengths (N, S, n) of the impulses through joints [N s]."""
    return norm(_force(impact, places))


def _moment_length(impact: Impact, places: Places) -> Any:
    """The lengths (N, S, n) of the impulsive moments through joints [N m s]."""
    return norm(_moment(impact, places))


def _along(impact: Impact, places: Places) -> Any:
    """The power (N, S, n) of the wrench in a unit rate of the joint [N m s, N s].

    It is what the joint's drive carries; NaN of a joint with more axes than one.
    """
    single = [columns.stop - columns.start == 1 for columns in _columns(impact, places)]
    power = impact.joint_power([(place.body, place.number) for place in places])
    return np.where(single, power, np.nan)


def _stop_impulse(impact: Impact, places: Places) -> Any:
    """Impulses (N, S, n) of end stops along the axes of joints [N m s, N s].

    They are in the direction of the joints' coordinates; NaN where they are not determined.
    """
    impulse = impact.along(impact.impulse)
    stops = [constraint.kind == "stop" for constraint in impact.constraints]
    if not impact.landing.scene.stops and not any(stops):
        return np.full((*impulse.shape[:2], len(places)), np.nan)
    names = [place.name for place in places]
    total = [0.0 * impulse[..., 0] for _ in places]
    slices = slices_of(impact.constraints)
    for constraint, rows, stop in zip(impact.constraints, slices, stops, strict=True):
        joint = constraint.frame.removeprefix(STOP)
        if not stop or joint not in names:
            continue
        along = side_of(impact.landing.robot, constraint) * impulse[..., rows.start]
        known = np.where(impact.unique[:, None, rows.start], along, np.nan)
        total[names.index(joint)] = total[names.index(joint)] + known
    return np.stack(total, axis=-1)


def _stop_acts(impact: Impact, places: Places) -> Array:
    """(N, S, n) 1 where an end stop of a joint acts, else 0."""
    stops = (constraint for constraint in impact.constraints if constraint.kind == "stop")
    acting = {constraint.frame.removeprefix(STOP) for constraint in stops}
    acts = np.array([float(place.name in acting) for place in places])
    shape = impact.along(impact.delta_qd).shape[:2]
    return np.broadcast_to(acts, (*shape, len(places)))


def _size(impact: Impact, values: Array) -> float:
    """The largest part of a wrench through a joint [N s, N m s]."""
    places = joint_places(impact.landing.robot)
    force = np.abs(_force(impact, places).astype(float))
    moment = np.abs(_moment(impact, places).astype(float))
    return float(max(force.max(initial=0.0), moment.max(initial=0.0)))


JOINTS = (
    Quantity(
        "force",
        "joint",
        "impulse on the body, world axes",
        "N s",
        "greater",
        _force,
        _size,
        form="vector",
        scope=Scope(REDUNDANT, shared=True),
    ),
    Quantity(
        "moment",
        "joint",
        f"moment about {ORIGIN}, world axes",
        "N m s",
        "greater",
        _moment,
        _size,
        form="vector",
        scope=Scope(REDUNDANT, shared=True),
    ),
    Quantity(
        "along",
        "joint",
        "impulse along the joint's axis",
        "N m s, N s",
        "greater",
        _along,
        _size,
        form="signed",
        scope=Scope(f"{MULTIAXIAL}; or {REDUNDANT}", shared=True),
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "delta_qd",
        "joint",
        "jump of the joint's rate",
        "rad/s, m/s",
        "greater",
        _delta_qd,
        _largest_jump,
        form="signed",
        scope=Scope(MULTIAXIAL),
        relations=Relations(also=("friction", "stiffness"), linear=True),
    ),
    Quantity(
        "joint_impulse",
        "joint",
        "impulse through the joint",
        "N s",
        "greater",
        _force_length,
        _size,
        scope=Scope(REDUNDANT, shared=True),
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "joint_moment",
        "joint",
        f"impulsive moment through the joint, about {ORIGIN}",
        "N m s",
        "greater",
        _moment_length,
        _size,
        scope=Scope(REDUNDANT, shared=True),
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "stop_impulse",
        "joint",
        "impulse of the joint's end stop along its axis",
        "N m s, N s",
        "greater",
        _stop_impulse,
        _size,
        form="signed",
        scope=Scope("the scene leaves end stops out; or contacts, loops or stops are redundant"),
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "stop_acts",
        "joint",
        "whether an end stop of the joint acts",
        "1",
        "greater",
        _stop_acts,
        form="flag",
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "rate_after",
        "joint",
        "joint's rate after the impact",
        "rad/s, m/s",
        "greater",
        _rate_after,
        _fastest,
        form="signed",
        scope=Scope(MULTIAXIAL),
        relations=Relations(also=("friction",)),
    ),
)
