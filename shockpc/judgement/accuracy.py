"""Accuracy of a result: the error of double precision, and the sensitivity to the data."""

import math
from collections.abc import Iterator
from itertools import compress
from typing import Any

import numpy as np

from shockpc.core.impulse import DATA_TOLERANCE
from shockpc.core.inertia import definite
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, velocity_at
from shockpc.impact.exact_impact import BallImpact
from shockpc.impact.landed import UNPHYSICAL, LandingProof, body_speeds, greatest_motion
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.method.constraints import slices_of
from shockpc.method.exact.arithmetic import SingularError
from shockpc.method.exact.balls import PrecisionError
from shockpc.method.exact.proof import motion
from shockpc.quantities.of_bodies import ROUNDED
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.selection import quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.diagnostic import Diagnostic

SENSITIVE = 1e-9
"""Largest share by which a change of the data in their last digits moves a result unwarned."""

PATTERNS = 2
"""Number of patterns of changes of the data, of which the largest effect counts.

A scalar may happen to stay as it is under one of them.
"""

ENLARGED = 10.0
"""Factor on its condition by which an impact may enlarge a change of the data [1].

In ten robots it is 0.1.
"""

RESTING_SHARE = 1e-13
"""Share of the fastest body's motion below which a body counts as at rest.

It is used where errors are compared with motion.
"""

STRAIN = 100.0
"""Impulse through a joint, relative to the largest of the contacts, that a warning names [1]."""

OVERSIZED = 100.0
"""Impulse or effective mass from which it is the first warning [1].

It is relative to what the mass and the speed of the robot allow.
"""

SHARE = 0.1
"""Part of a unit combination of rows from which a row takes part in it [1]."""

FASTEST_PLAUSIBLE = 100.0
"""Motion relative to the strike beyond which a warning names the body [1].

That of a robot is about 1.
"""


def double_error(landing: PosedLanding, proof: LandingProof, jumps: Array) -> float:
    """True error of jumps (nb, 6) in double precision [1].

    It is relative to each body's motion, and the largest over the bodies that move; inf if a jump
    is not finite.
    """
    if not np.isfinite(jumps).all():
        return np.inf
    length = landing.robot.rotation_lengths
    exact = proof.jumps[..., 3:]
    size = motion(exact, length)[:, 0]
    off = motion(jumps[..., None] - exact, length)[:, 0]
    return float(_of_motion(off, size).max(initial=0.0))


def _of_motion(change: Array, size: Array) -> Array:
    """Changes (nb,) relative to the motions (nb,) of bodies [1]; 0 of a body at rest."""
    share = change / np.where(size > 0.0, size, 1.0)
    at_rest = size <= RESTING_SHARE * size.max(initial=0.0)
    return np.where(at_rest, 0.0, share)


def nearly_singular(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings where a strike moves a body implausibly fast.

    One is of the strike of the scene, the other of strikes in other directions.
    """
    robot, proof = profile.robot, profile.proof
    # A body of almost no inertia may turn at any rate; its size is then taken to be like the
    # others'. (np.median imports numpy.ma.)
    usual = np.sort(robot.gyration)[len(robot.gyration) // 2]
    gyration = np.fmax(robot.gyration, usual)
    times, body = greatest_motion(profile.landing, proof.jumps[..., 3], gyration)
    if times > FASTEST_PLAUSIBLE:
        name = robot.bodies[body].name
        text = (
            f'body "{name}" would move or turn {times:.0e} times as fast as the contact: the '
            "posture is nearly singular, or almost no inertia resists this motion. This is not "
            "physically plausible: set another posture, or lock the joint with --lock"
        )
        yield Diagnostic("posture", name, times, text)
    speeds = [body_speeds(robot, proof.jumps[..., k], robot.gyration) for k in range(3)]
    most = float(np.max(speeds))
    if most > UNPHYSICAL:
        text = (
            f"in other impact directions a body would move up to {most:.0e} times as fast as the "
            "contact, because the posture is singular or nearly so; the most severe directions "
            "are not physically plausible"
        )
        yield Diagnostic("posture", "", most, text)


def redundant(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where rows of loops count as dependent, but differ by more than rounding."""
    row_space = profile.row_space
    if not row_space.discarded:
        return
    constraints = profile.landing.constraints
    loops = np.concatenate([np.full(held.size, held.kind == "closure") for held in constraints])
    of_loops = bool(loops.any())
    limit = f"below {DATA_TOLERANCE:.0e}"
    if len(row_space.infeasible):
        of_loops = bool(np.any(np.abs(row_space.infeasible[:, loops]) > SHARE))
        limit = "as much as rounding of the file leaves"
    if of_loops:
        text = (
            f"rows of the loops differ by {row_space.discarded:.0e} of their size, {limit}, so "
            "they are taken as the same (bars that are parallel to the last digits of the file). "
            "If all of them are meant to hold, give the file more digits"
        )
        yield Diagnostic("posture", profile.robot.name, row_space.discarded, text)


def impulse_sizes(profile: ShockProfile) -> Array:
    """Sizes (n,) of the impulses of contacts and standing feet [N s]; 0 where there is none."""
    return np.asarray(np.nan_to_num(np.linalg.norm(profile.value("impulse", "contact"), axis=1)))


@memoized()
def impulse_bound(profile: ShockProfile) -> float:
    """A bound on the impulse through each joint, and on that of each contact [N s].

    It is Σ_i m_i |Δv_i| + Σ_k |λ_k| over all bodies, with Δv_i of their centres of mass, and all
    contact and closure rows: through joint i goes F_i = m_i Δv_i − f_i + Σ F_child, from leaf to
    root. It takes no balls, in which impulses through joints take as long as the proof.
    """
    robot = profile.robot
    of_centres = velocity_at(profile.delta_omega, profile.delta_v, robot.coms)
    momenta = robot.masses * np.linalg.norm(of_centres, axis=1)
    return float(momenta.sum() + np.abs(profile.proof.impulse[:, 3]).sum())


def oversized(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning of the number furthest above what the robot's mass and speed allow."""
    landing = profile.landing
    mass, impulse = _allowed(profile)
    # A floating robot can yield to a contact by its translation, so that its effective mass is at
    # most its mass; but not where a motion has a negative inertia, as with a rotor of more inertia
    # than the link that carries it.
    strikes_stop = any(contact.kind == "stop" for contact in landing.contacts)
    is_definite = bool(np.isfinite(definite(landing.state.inertia)).all())
    yields = landing.floating and not strikes_stop and is_definite
    if yields and impulse_bound(profile) <= OVERSIZED * impulse:
        return

    through = profile.value("joint_impulse", "joint")
    masses = profile.value("effective_mass", "contact")
    contacts, joints = profile.places("contact"), profile.places("joint")
    numbers = (
        ("size", "impulse of contact", "N s", impulse, contacts, impulse_sizes(profile)),
        ("size", "impulse through joint", "N s", impulse, joints, through),
        ("contact", "effective mass of contact", "kg", mass, contacts, masses),
    )
    shares = []
    for kind, title, unit, allowed, places, values in numbers:
        for place, value in zip(places, values.tolist(), strict=True):
            if math.isfinite(value):
                number = f'{title} "{place.name}" {value:.3g} {unit}'
                shares.append((value / allowed, number, kind, place.name))
    times, number, kind, subject = max(shares, default=(0.0, "", "", ""))
    if times > OVERSIZED:
        text = (
            f"{number} is {times:.2g} times what the robot's mass and speed allow ({mass:.3g} kg, "
            f"{impulse:.3g} N s): the mechanism is singular, redundant or rounded here. Set "
            "another posture, or leave out the loop or the direction of the contact that takes it"
        )
        yield Diagnostic(kind, subject, times, text)


def _allowed(profile: ShockProfile) -> tuple[float, float]:
    """The mass of the robot with its rotors [kg], and the impulse that its speed allows [N s].

    That is m v (1 + e), which stops all of the mass at the contact's speed and throws it back.
    """
    landing = profile.landing
    # Of a joint that turns, the reflected inertia counts as a mass at the robot's length.
    turning = np.any(landing.state.J[0, :3], axis=0)
    reflected = landing.joint_model.armature / np.where(turning, landing.length**2, 1.0)
    mass = float(landing.robot.mass + np.sum(reflected))
    restitution = max(contact.restitution for contact in profile.scene.contact)
    return mass, mass * landing.fastest_approach * (1.0 + restitution)


def strained(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning of the largest impulse through a joint, where nothing explains it.

    That of the contacts, or an end stop, may.
    """
    if any(constraint.kind == "stop" for constraint in profile.landing.contacts):
        return
    largest = float(impulse_sizes(profile).max())
    if impulse_bound(profile) <= STRAIN * largest:
        return
    impulses = profile.value("joint_impulse", "joint").tolist()
    names = [place.name for place in profile.places("joint")]
    loads = zip(names, impulses, strict=True)
    name, most = max(loads, key=lambda load: load[1], default=("", 0.0))
    contact = max(largest, float(np.linalg.norm(profile.total_impulse)))
    if not most > STRAIN * contact:
        return
    if not any(warning.kind == "size" for warning in oversized(profile)):
        text = (
            f'joint "{name}" would carry {most:.3g} N s, {most / contact:.2g} times the impulse of '
            "the contact, which is not physically plausible. The mechanism is nearly singular or "
            "redundant here: set another posture, or open a loop"
        )
        yield Diagnostic("size", name, most, text)


def _small_differences(profile: ShockProfile) -> Iterator[tuple[Quantity, list[Place], Array]]:
    """Results that may be small differences of large numbers, with places and values.

    They are the speed, radii of percussion, and impulses.
    """
    impulse = impulse_sizes(profile)
    pressed = impulse > RESTING_SHARE * impulse.max(initial=0.0)
    results = (
        (quantity("robot", "v_in"), np.array([True])),
        (quantity("body", "ropc"), ~profile.translates),
        (quantity("contact", "impulse"), pressed),
    )
    for entry, has_value in results:
        places = list(compress(profile.places(entry.of), has_value.tolist()))
        if places:
            yield entry, places, profile.value(entry.key, entry.of, places)


def sensitive(profile: ShockProfile) -> tuple[Diagnostic, ...]:
    """Warnings of results that the last digits of the data move by more than `SENSITIVE`.

    Two more impacts in balls decide, which take as long as all numbers together, where doubles
    cannot exclude a warning.
    """
    return () if clearly_insensitive(profile) else data_sensitivity(profile)[1]


def clearly_insensitive(profile: ShockProfile) -> bool:
    """True if the last digits of the data clearly move every result by less than `SENSITIVE`.

    A change of the data by a share u changes a motion by about κ u of the fastest one, with the
    condition κ of inertia and rows (first order). Of a result that is a share s of the fastest it
    is κ u / s.
    """
    landing, proof = profile.landing, profile.proof
    if landing.base != "free" or not landing.translates:
        return False
    if landing.loops or profile.redundant:
        return False
    size = motion(proof.jumps[..., 3:], landing.robot.rotation_lengths)[:, 0]
    normals = landing.plane.normal @ landing.state.rotation[0]
    in_plane = np.abs(np.sum(proof.jumps[:, :3, 3] * normals, axis=1))
    turning = in_plane * landing.length
    turns = turning[turning > ROUNDED * profile.v_in]
    slices = slices_of(landing.constraints)
    impulse = np.array([np.linalg.norm(proof.impulse[rows, 3]) for rows in slices])
    velocity = landing.before.velocity
    approach = max(abs(float(contact.normal @ velocity)) for contact in landing.contacts)
    speeds = np.array([profile.v_in, approach, float(np.linalg.norm(velocity))])

    # Of a rotation the largest motion of a body counts, which may translate besides.
    fastest = size.max(initial=0.0) or 1.0
    of_fastest = turning.max(initial=0.0) / fastest
    smallest = min(
        _smallest_share(size),
        _smallest_share(turns) * of_fastest,
        _smallest_share(impulse),
        _smallest_share(speeds),
    )
    change = ENLARGED * proof.condition * np.finfo(float).eps
    return bool(change < SENSITIVE * smallest)


def _smallest_share(values: Array) -> float:
    """The smallest of some sizes that is not zero, of the largest [1]; 1 without any."""
    most = values.max(initial=0.0)
    moving = values[values > RESTING_SHARE * most]
    return float((moving / (most or 1.0)).min(initial=1.0))


@memoized()
def data_sensitivity(profile: ShockProfile) -> tuple[float, tuple[Diagnostic, ...]]:
    """Largest change of a body's jump by changes of every datum in its last digit [1].

    Returns: that, and warnings of results that change by more than `SENSITIVE`.
    """
    proof = profile.proof
    results = list(_small_differences(profile))

    def changed(impact: BallImpact) -> list[Array]:
        """The jumps, and the results; balls are rounded as they are, as they need no precision."""
        values: list[Any] = [impact.jumps[0]]
        values += [entry.compute(impact, places)[0, 0] for entry, places, _ in results]
        return [np.asarray(value, dtype=object).astype(float) for value in values]

    try:
        patterns = [proof.with_last_digits_changed(changed, pattern) for pattern in range(PATTERNS)]
    except (PrecisionError, SingularError):
        # A landing without a solution for other last digits depends on them entirely.
        return np.inf, tuple(_sensitive("the result", "", np.inf))

    # The jumps of the bodies: the largest change of the patterns, of the motion of each body.
    length = profile.robot.rotation_lengths
    exact = proof.jumps[..., 3:]
    changes = [motion(jumps[..., 3:] - exact, length)[:, 0] for jumps, *_ in patterns]
    moves = _of_motion(np.max(changes, axis=0), motion(exact, length)[:, 0])
    worst = int(np.argmax(moves))
    body = profile.robot.bodies[worst].name
    warnings = [*_sensitive(f'the result of body "{body}"', body, float(moves[worst]))]

    # The results: the same of each place, of the size of the result there.
    for k, (entry, places, before) in enumerate(results, start=1):
        changes = [_lengths(after[k] - before) for after in patterns]
        size = _lengths(before)
        shares = np.max(changes, axis=0) / np.where(size > 0.0, size, np.inf)
        place = places[int(np.argmax(shares))].name
        result = f'{entry.title} of {entry.of} "{place}"'
        warnings += _sensitive(result, place, float(shares.max()))
    return float(moves.max(initial=0.0)), tuple(warnings)


def _lengths(values: Array) -> Array:
    """The magnitudes (n,) of numbers (n,) or vectors (n, 3)."""
    return np.asarray(np.linalg.norm(values.reshape(len(values), -1), axis=1))


def _sensitive(result: str, subject: str, share: float) -> Iterator[Diagnostic]:
    """A warning where the data's last digits count."""
    if not share <= SENSITIVE:
        text = (
            f"a change of the data in their last digits moves {result} by {share:.0e} of its size; "
            f"digits beyond "
            "that depend on the rounding in this file"
        )
        yield Diagnostic("data", subject, share, text)
