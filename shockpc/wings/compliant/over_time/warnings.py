"""Warnings of a landing on finite stiffness, where what the model leaves out counts."""

from collections.abc import Iterator

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.method.constraints import constraint_point
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import few
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

MANY_EVENTS = 100
"""Number of times that contacts change their state, above which durations are not reliable."""

GRAVITY_SHARE, DEEPEST_SHARE = 0.05, 0.1
"""Shares from which on a landing without gravity, or with frozen geometry, is doubtful.

The first is that of the approach speed that gravity adds during the contact; the second is that of
the robot's size by which a contact is compressed.
"""

DAMPED_SHARE = 0.01
"""Share of the change of velocities from which on the damping of joints counts."""


def warnings_of(compliant: CompliantLanding) -> Iterator[Diagnostic]:
    """Warnings where what the model leaves out counts.

    That is gravity, the change of geometry, and contacts that open often.
    """
    if not compliant.landing.scene.gravity:
        yield from _weightless(compliant)
    yield from _sinks(compliant)
    yield from _damped(compliant)
    yield from _compressed_far(compliant)
    events = len(compliant.motion.events)
    if events > MANY_EVENTS:
        text = (
            f"contacts change {events} times between loading, unloading, slipping and open: "
            f"tiny changes of the landing change their order, so durations are not reliable; "
            f"take restitution above 0, or fewer contacts"
        )
        yield Diagnostic("contact", "", float(events), text)


def _weightless(compliant: CompliantLanding) -> Iterator[Diagnostic]:
    """A warning where gravity, which is left out, counts."""
    rows = compliant.motion.elements.rows[compliant.normal]
    duration = float(compliant.duration.max())
    approach = float(-(rows @ compliant.system.velocity).min())
    gained = GRAVITY * duration
    if gained > GRAVITY_SHARE * approach:
        text = (
            f"gravity is left out, and in the {1e3 * duration:.3g} ms of contact it adds "
            f"{gained:.3g} m/s to an approach of {approach:.3g} m/s "
            f"({100.0 * gained / approach:.2g} %): real peak forces are larger; leave out "
            f"--no-gravity"
        )
        yield Diagnostic("contact", "", gained / approach, text)


def _sinks(compliant: CompliantLanding) -> Iterator[Diagnostic]:
    """A warning where dampers in series give way faster than a contact strikes.

    They do so under constant forces.
    """
    motion, normal = compliant.motion, compliant.normal
    rows = motion.elements.rows[normal]
    strikes = -rows @ compliant.system.velocity
    # Of the motion along springs only that of dampers in series does not oscillate.
    sinks = -rows @ (motion.to_velocity @ motion.segments[0].drift)
    in_series = motion.elements.relaxation[normal] > 0.0
    pressed = in_series & (strikes > 0.0) & (strikes < sinks)
    for k in np.flatnonzero(pressed).tolist():
        name = compliant.landing.contacts[k].name
        text = (
            f"{name} hits the ground at {strikes[k]:.3g} m/s, and the weight presses the "
            f"damper of its contact down at {sinks[k]:.3g} m/s: the force rises to the "
            "weight, and the impact has little effect; take a stiffer contact"
        )
        yield Diagnostic("contact", name, float(sinks[k] / strikes[k]), text)


def _damped(compliant: CompliantLanding) -> Iterator[Diagnostic]:
    """A warning where the damping of joints, which is left out, counts.

    Its impulses p = −d Δq, of the deflections Δq until the end, change velocities v by M⁻¹ p, or
    less where contacts hold the robot. Compared are the lengths √(vᵀ M v) of this change and of
    that by the impact.
    """
    system, moving, duration = compliant.system, compliant.moving, compliant.motion.duration
    M, robot = system.rows.M, moving.robot
    beyond_fall = compliant.changes[1].jump[-1] - duration * system.fall
    jump = beyond_fall[: len(M)]
    deflection = compliant.displacements(np.array([duration]))[0]
    impulse = np.where(moving.joint_model.locked, 0.0, -robot.model.damping * deflection)
    p = system.free.T @ impulse
    share = float(np.sqrt(p @ np.linalg.solve(M, p) / (jump @ M @ jump)))
    if share > DAMPED_SHARE:
        damped = [joint.name for joint in robot.single_joints if impulse[joint.v].any()]
        names = few(damped, 2, noun=" joints")
        text = (
            f"the damping of {names} in the robot's file is left out; in the "
            f"{1e3 * duration:.3g} ms of the motion it may change velocities by up to "
            f"{100.0 * share:.2g} % of their jumps, and late forces by about as much. If it "
            "is there for simulation only, set it to zero in the file"
        )
        yield Diagnostic("contact", "damping", share, text)


def _compressed_far(compliant: CompliantLanding) -> Iterator[Diagnostic]:
    """Warnings of contacts that are compressed so far that the geometry changes."""
    landing = compliant.landing
    state, robot = landing.state, landing.robot
    coms = state.position[0] + (state.rotation[0] @ robot.coms[..., None])[..., 0]
    compressions = _compressions(compliant).tolist()
    for contact, compression in zip(landing.contacts, compressions, strict=True):
        if contact.kind == "stop":
            continue
        distances = np.linalg.norm(coms - constraint_point(state, contact)[0], axis=1)
        size = float((distances + robot.gyration).max())
        if compression > DEEPEST_SHARE * size:
            text = (
                f"{contact.name} is compressed by {compression:.3g} m, on a robot that reaches "
                f"{size:.3g} m from there: the geometry does not stay as at impact, which this "
                f"model assumes; take a stiffer contact or a lower speed"
            )
            yield Diagnostic("contact", contact.name, compression, text)


def _compressions(compliant: CompliantLanding) -> Array:
    """Largest compression (c,) of each contact along its normal [m].

    It includes what dampers in series give way, and is largest where the normal is unloaded, or at
    the end.
    """
    elements, normal = compliant.motion.elements, compliant.normal
    _, then = compliant.changes
    speeds = (compliant.system.velocity + then.jump) @ elements.rows.T
    of_springs = then.force + elements.damping * speeds
    largest = np.where(then.force > 0.0, of_springs, 0.0).max(axis=0)
    pressed = largest[normal] / elements.stiffness[normal]
    way = -(then.displacement @ elements.rows[normal].T).min(axis=0)
    return np.asarray(np.where(elements.relaxation[normal] > 0.0, way, pressed))
