"""How far to trust a result: the proven bound, the error of double precision, and the sensitivity
to the data.
"""

import math
from collections.abc import Iterator
from itertools import compress

import numpy as np

from shockpc.core.impulse import DATA_TOLERANCE
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
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
"""A result that a change of the data in their last digits moves by more than this share carries a
warning.
"""

PATTERNS = 2
"""Patterns of changes of the data, of which the largest effect counts: a scalar may happen to stay
as it is under one of them.
"""

ENLARGED = 10.0
"""By how much more than its condition says an impact may enlarge a change of the data; seen are 0.1
in ten robots [1].
"""

RESTING_SHARE = 1e-13
"""A body that moves by less than this share of the fastest one counts as at rest where errors are
compared with motion.
"""

STRAIN = 100.0
"""Impulse through a joint relative to the largest of the contacts beyond which a warning names the
joint [1].
"""

OVERSIZED = 100.0
"""Impulse or effective mass relative to what the mass and the speed of the robot allow, from which
it is the first warning [1].
"""

SHARE = 0.1
"""Part of a unit combination of rows from which a row takes part in it [1]."""

FASTEST_PLAUSIBLE = 100.0
"""Motion relative to the strike beyond which a warning names the body: that of a robot is about 1
[1].
"""


def double_error(landing: PosedLanding, proof: LandingProof, jumps: Array) -> float:
    """True error of jumps (nb, 6) in double precision, relative to each body's motion, the largest
    over the bodies that move.
    """
    length, exact = landing.robot.rotation_lengths, proof.jumps[..., 3:]
    size = motion(exact, length)[:, 0]
    if not np.isfinite(jumps).all():
        return np.inf
    off = motion(jumps[..., None] - exact, length)[:, 0]
    return float(
        np.max(
            (off / np.where(size > 0.0, size, 1.0))[size > RESTING_SHARE * size.max(initial=0.0)],
            initial=0.0,
        )
    )


def nearly_singular(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings where the strike moves a body implausibly fast, or strikes in other directions have
    no verdict in its posture.
    """
    landing, proof, gyration = profile.landing, profile.proof, profile.robot.gyration
    # A body of almost no inertia may turn at any rate; its size is then taken to be like the
    # others'. (np.median imports numpy.ma.)
    times, body = greatest_motion(
        landing, proof.jumps[..., 3], np.fmax(gyration, np.sort(gyration)[len(gyration) // 2])
    )
    if times > FASTEST_PLAUSIBLE:
        name = landing.robot.bodies[body].name
        text = (
            f'body "{name}" would move or turn {times:.0e} times as fast as the contact: the '
            "posture is nearly singular, or almost no inertia resists this motion. This is not "
            "physically plausible: set another posture, or lock the joint with --lock"
        )
        yield Diagnostic("posture", name, times, text)
    most = max(
        float(body_speeds(landing.robot, proof.jumps[..., k], gyration).max()) for k in range(3)
    )
    if most > UNPHYSICAL:
        text = (
            f"in other impact directions a body would move up to {most:.0e} times as fast as the "
            "contact, because the posture is singular or nearly so; the most severe directions "
            "are not physically plausible"
        )
        yield Diagnostic("posture", "", most, text)


def redundant(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where rows of loops count as dependent, although more than rounding sets them
    apart.
    """
    row_space, blocks = profile.row_space, profile.landing.blocks
    loops = np.concatenate([np.full(block.size, block.kind == "closure") for block in blocks])
    if (
        row_space.discarded
        and loops.any()
        and (
            not len(row_space.infeasible) or np.any(np.abs(row_space.infeasible[:, loops]) > SHARE)
        )
    ):
        limit = (
            "as much as rounding of the file leaves"
            if len(row_space.infeasible)
            else f"below {DATA_TOLERANCE:.0e}"
        )
        text = (
            f"rows of the loops differ by {row_space.discarded:.0e} of their size, {limit}, so "
            "they are taken as the same (bars that are parallel to the last digits of the file). "
            "If all of them are meant to hold, give the file more digits"
        )
        yield Diagnostic("posture", profile.robot.name, row_space.discarded, text)


def contact_impulses(profile: ShockProfile) -> Array:
    """Sizes (n,) of the impulses of contacts and standing feet [N s]; 0 where there is none."""
    return np.asarray(np.nan_to_num(np.linalg.norm(profile.value("impulse", "contact"), axis=1)))


def oversized(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning of the number furthest above what the robot's mass and speed allow, whatever its
    cause.
    """
    landing, scene, inertia = profile.landing, profile.scene, profile.landing.joint_model.armature
    turning = np.any(landing.state.J[0, :3], axis=0)
    mass = float(landing.robot.mass + np.sum(inertia / np.where(turning, landing.length**2, 1.0)))
    most = (
        mass
        * landing.fastest_approach
        * (1.0 + max(contact.restitution for contact in scene.contact))
    )
    contacts = profile.places("contact")
    numbers = [
        ("size", "impulse of contact", most, "N s", contacts, contact_impulses(profile)),
        (
            "size",
            "impulse through joint",
            most,
            "N s",
            profile.places("joint"),
            profile.value("joint_impulse", "joint"),
        ),
        (
            "contact",
            "effective mass of contact",
            mass,
            "kg",
            contacts,
            profile.value("effective_mass", "contact"),
        ),
    ]
    shares = [
        (value / bound, f'{what} "{place.name}" {value:.3g} {unit}', kind, place.name)
        for kind, what, bound, unit, places, values in numbers
        for place, value in zip(places, values.tolist(), strict=True)
        if math.isfinite(value)
    ]
    times, what, kind, subject = max(shares, default=(0.0, "", "", ""))
    if times > OVERSIZED:
        text = (
            f"{what} is {times:.2g} times what the robot's mass and speed allow ({mass:.3g} kg, "
            f"{most:.3g} N s): the "
            "mechanism is singular, redundant or rounded here. Set another posture, or leave out "
            "the loop or the "
            "direction of the contact that takes it"
        )
        yield Diagnostic(kind, subject, times, text)


def strained(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning of the largest impulse through a joint, where neither that of the contacts nor an
    end stop explains it.
    """
    names, sizes = (
        [place.name for place in profile.places("joint")],
        profile.value("joint_impulse", "joint").tolist(),
    )
    name, most = max(zip(names, sizes, strict=True), key=lambda item: item[1], default=("", 0.0))
    contact = max(
        float(contact_impulses(profile).max()), float(np.linalg.norm(profile.total_impulse))
    )
    stopped = any(block.kind == "stop" for block in profile.landing.contacts)
    if (
        most > STRAIN * contact
        and not stopped
        and not any(one.kind == "size" for one in oversized(profile))
    ):
        text = (
            f'joint "{name}" would carry {most:.3g} N s, {most / contact:.2g} times the impulse of '
            f"the contact, which is "
            "not physically plausible. The mechanism is nearly singular or redundant here: set "
            "another posture, or open "
            "a loop"
        )
        yield Diagnostic("size", name, most, text)


def _small_differences(profile: ShockProfile) -> Iterator[tuple[Quantity, list[Place], Array]]:
    """Results that may be small differences of large numbers: speed, radii of percussion, impulses;
    with places and values.
    """
    impulse = contact_impulses(profile)
    pressed = impulse > RESTING_SHARE * impulse.max(initial=0.0)
    turning, speed = (
        (quantity("body", "ropc"), ~profile.translates),
        (quantity("robot", "v_in"), [True]),
    )
    for entry, chosen in (speed, turning, (quantity("contact", "impulse"), pressed)):
        if places := list(compress(profile.places(entry.of), chosen)):
            yield entry, places, profile.values(entry, places)


def sensitive(profile: ShockProfile) -> tuple[Diagnostic, ...]:
    """Warnings of results that the last digits of the data move by more than `SENSITIVE`.

    Two more impacts in balls decide, which take as long as all numbers together, where doubles
    cannot exclude a warning.
    """
    return () if hardly_sensitive(profile) else data_sensitivity(profile)[1]


def hardly_sensitive(profile: ShockProfile) -> bool:
    """Whether the last digits of the data clearly move every result by less than `SENSITIVE`.

    A change of the data by a share u changes a motion by about κ u of the fastest one, with the
    condition κ of inertia and rows (first order). Of a result that is a share s of the fastest it
    is κ u / s.
    """
    landing, proof = profile.landing, profile.proof
    if landing.base != "free" or not landing.translates or landing.loops or profile.redundant:
        return False
    length = landing.robot.rotation_lengths
    size = motion(proof.jumps[..., 3:], length)[:, 0]
    normals = landing.plane.normal @ landing.state.rotation[0]
    turning = np.abs(np.sum(proof.jumps[:, :3, 3] * normals, axis=1)) * landing.length
    impulse = np.array(
        [np.linalg.norm(proof.impulse[rows, 3]) for rows in slices_of(landing.blocks)]
    )
    velocity = landing.before.velocity
    approach = max(abs(float(block.normal @ velocity)) for block in landing.contacts)
    speeds = np.array([profile.v_in, approach, float(np.linalg.norm(velocity))])
    shares = []
    for values in (size, turning[turning > ROUNDED * profile.v_in], impulse, speeds):
        most = values.max(initial=0.0)
        shares.append((values[values > RESTING_SHARE * most] / (most or 1.0)).min(initial=1.0))
    # The largest motion of a body that does not only translate, for its rotation.
    shares[1] *= turning.max(initial=0.0) / (size.max(initial=0.0) or 1.0)
    return bool(ENLARGED * proof.condition * np.finfo(float).eps < SENSITIVE * min(shares))


@memoized()
def data_sensitivity(profile: ShockProfile) -> tuple[float, tuple[Diagnostic, ...]]:
    """How far a change of every datum in its last digit moves the jumps of the bodies [1], and
    warnings above `SENSITIVE`.
    """
    proof, others = profile.proof, list(_small_differences(profile))
    length, bodies = proof.landing.robot.rotation_lengths, proof.landing.robot.bodies

    def changed(impact: BallImpact) -> list[Array]:
        # No other precision than that of the result is needed, so balls are rounded as they are.
        values = [entry.compute(impact, places)[0, 0] for entry, places, _ in others]
        return [
            impact.jumps[0].astype(float),
            *(np.asarray(value, dtype=object).astype(float) for value in values),
        ]

    try:
        patterns = [proof.with_last_digits_changed(changed, pattern) for pattern in range(PATTERNS)]
    except (PrecisionError, SingularError):
        return np.inf, tuple(_sensitive("the result", "", np.inf))
    size = motion(proof.jumps[..., 3:], length)[:, 0]
    off = np.max(
        [motion(jumps[..., 3:] - proof.jumps[..., 3:], length)[:, 0] for jumps, *_ in patterns],
        axis=0,
    )
    moves = off / np.where(size > 0.0, size, 1.0)
    moves[size <= RESTING_SHARE * size.max(initial=0.0)] = 0.0
    worst = int(np.argmax(moves))
    warnings = [
        *_sensitive(
            f'the result of body "{bodies[worst].name}"', bodies[worst].name, float(moves[worst])
        )
    ]
    for k, (entry, places, before) in enumerate(others):
        whole, *changes = (
            np.linalg.norm(part.reshape(len(places), -1), axis=1)
            for part in (before, *(after[k + 1] - before for after in patterns))
        )
        off = np.max(changes, axis=0)
        share = off / np.where(whole > 0.0, whole, np.inf)
        place = places[int(np.argmax(share))].name
        warnings += _sensitive(f'{entry.title} of {entry.of} "{place}"', place, float(share.max()))
    return float(moves.max(initial=0.0)), tuple(warnings)


def _sensitive(what: str, subject: str, share: float) -> Iterator[Diagnostic]:
    """A warning where the data's last digits count."""
    if not share <= SENSITIVE:
        text = (
            f"a change of the data in their last digits moves {what} by {share:.0e} of its size; "
            f"digits beyond "
            "that depend on the rounding in this file"
        )
        yield Diagnostic("data", subject, share, text)
