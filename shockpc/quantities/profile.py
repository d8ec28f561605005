"""What an analysis gives back: a landing and its proof; every other number is a quantity, computed when it is read."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from shockpc.core.directions import ExtremeDirections
from shockpc.core.impulse import RowChoice
from shockpc.core.percussion import shock_at
from shockpc.core.spatial import Array, Plane, freeze, read_only
from shockpc.impact.exact.proof import Proof
from shockpc.impact.solve import solve_exactly, solve_in_doubles
from shockpc.impact.stops import with_stops
from shockpc.landing.closure import Assembly
from shockpc.landing.dynamics import dynamics
from shockpc.landing.joint_model import without_springs
from shockpc.landing.landing import OfLanding, PosedLanding
from shockpc.landing.places import Place, PlaceKind, body_places
from shockpc.landing.ratings import Strength, TorqueStrength, strength, torque_strength
from shockpc.landing.stops import at_stops, driven_beyond, has_stops
from shockpc.quantities.accuracy import (
    AT_REST,
    Health,
    data_sensitivity,
    double_error,
    nearly_singular,
    oversized,
    redundant,
    strained,
)
from shockpc.quantities.parts import REMEDIES, MarginLost, margin_lost, not_judged
from shockpc.quantities.plausibility import gained, implausible, pulled, saturated, slipping
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.table import Selection, quantities_of, quantity
from shockpc.robot.geometry import body_outline
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import SceneError, SolveError
from shockpc.text.trace import Trace

if TYPE_CHECKING:
    from shockpc.impact.friction import FrictionResult
    from shockpc.impact.stiffness import CompliantLanding


R = TypeVar("R", bound="NamedTuple")
T = TypeVar("T")

CLEARLY_BEYOND = 1e-6
"""Share of the largest rate with which a joint moves beyond an end stop from which on that is no rounding of double precision."""

DIFFERS, LEAST_DIFFERENCE = 0.1, 1e-3
"""Share by which shock on contacts of finite stiffness differs from that of the impulse model, from which a warning says so; and
the least difference of which one does [1]."""


def _record_of(kind: PlaceKind) -> Callable[[type[R]], type[R]]:
    """A record of one place: its fields are quantities of a kind by key, None without a value, whose titles document them."""

    def described(record: type[R]) -> type[R]:
        own = [entry for entry in quantities_of(kind) if entry.key in record._fields]
        record.__doc__ = f"{record.__doc__}" + "".join(f"    {entry.key}: {entry.text}.\n    " for entry in own)
        return record

    return described


def _property(kind: PlaceKind, key: str, made: Callable[[Array], T]) -> "cached_property[T]":
    """A property of a profile: what is made of the values of a quantity at all places of its kind."""
    entry = quantity(kind, key)

    def read(profile: "ShockProfile") -> T:
        return made(profile.values(entry))

    read.__doc__ = f"{entry.text} (of {'the' if kind == 'robot' else 'each'} {kind})."
    return cached_property(read)


def _each(values: Array) -> Array:
    """Values at several places."""
    return values


def _flags(values: Array) -> np.ndarray:
    """Whether a flag is set, at several places."""
    flags = np.asarray(values > 0.0)
    freeze(flags)
    return flags


def _vector(values: Array) -> Array:
    """The vector of the robot."""
    return np.asarray(values[0])


def _one(values: Array) -> float:
    """The number of the robot."""
    return float(values[0])


def _known(values: Array) -> float | None:
    """The number of the robot, or None where there is none."""
    return None if np.isnan(values[0]) else float(values[0])


def _number(value: Any) -> Any:
    """A number or a vector, or None where there is none."""
    if np.isnan(value).all():
        return None
    return value if np.ndim(value) else float(value)


@_record_of("point")
class PointShock(NamedTuple):
    """Shock at a sensor, or at a point that was asked for.

    Attributes:
        frame: its name.
        body: the body it is fixed to.
        directions: the most and the least severe impact direction.
    """

    frame: str
    body: str
    position: Array
    delta_v: Array
    shock: float
    directions: ExtremeDirections
    peak_g: float | None


@_record_of("part")
class PartMargin(NamedTuple):
    """How far a part, at a point or of a joint, is from what it withstands.

    Attributes:
        part: its name.
        body: the body it is fixed to, or that its joint carries.
        joint: its joint; empty for a part at a point.
        strength: its damage boundary; of a part of a joint the torque.
        governed_by: which margin is that of the part: by "velocity change", "acceleration" or "torque"; empty if it has none.
        missing: why it has none; empty if it has one.
    """

    part: str
    body: str
    joint: str
    strength: Strength | TorqueStrength
    delta_v: Array | None
    shock: float | None
    velocity_margin: float | None
    peak_g: float | None
    acceleration_margin: float | None
    along: float | None
    torque: float | None
    part_margin: float | None
    governed_by: str
    missing: str

    @property
    def speed_change(self) -> float:
        """|Δv| [m/s]; NaN for a part of a joint."""
        return math.nan if self.delta_v is None else math.hypot(*self.delta_v)


@_record_of("contact")
class ContactImpulse(NamedTuple):
    """What the ground does at a contact; masses that cannot give way are infinite.

    Attributes:
        frame: its name.
    """

    frame: str
    point: Array
    impulse: Array | None
    moment: Array | None
    friction_needed: float | None
    approach: Array
    mass_sticking: float
    mass_frictionless: float
    effective_mass: float
    mitigation: float | None
    mitigation_frictionless: float | None
    pull: float | None


@_record_of("contact")
class StanceImpulse(NamedTuple):
    """What the ground does at a foot that stands already.

    Attributes:
        frame: its name.
    """

    frame: str
    point: Array
    impulse: Array | None
    friction_needed: float | None
    pull: float | None


@_record_of("joint")
class JointLoad(NamedTuple):
    """What a joint goes through.

    Attributes:
        joint: its name.
    """

    joint: str
    force: Array
    moment: Array
    along: float | None
    delta_qd: float | None


class Bracket(NamedTuple):
    """The same landing with other models of the joints; shock at one place [1].

    Attributes:
        place: a body (its centre of mass), or a sensor.
        free: no reflected inertia; None if massless bodies then make it unsolvable.
        as_modelled: as the scene says.
        locked: every joint holds; None if there is no verdict then, because the contact cannot move as the impact asks.
        springs_free: every joint holds but those with a spring, which yield; None without springs, or if there is no verdict.
    """

    place: str
    free: float | None
    as_modelled: float
    locked: float | None
    springs_free: float | None


@dataclass(frozen=True, eq=False)
class ShockProfile(OfLanding):
    """The shock of one landing; index i of an array over the bodies is body i of the robot. Its arrays cannot be written to.

    The reported numbers are those of the proof: midpoints of enclosures, rounded to doubles. All are computed when they are first
    read.

    Attributes:
        landing: the scene resolved on the robot.
        double_jumps: (nb, 6, 4) jump (Δω, Δv) of every body in double precision, body coordinates, as in `Proof`.
        proof: enclosures of the exact solution.
        trace: collects what each part cost.
    """

    landing: PosedLanding
    double_jumps: Array = field(repr=False)
    proof: Proof = field(repr=False)
    trace: Trace = field(repr=False)

    def places(self, kind: PlaceKind) -> tuple[Place, ...]:
        """The places of one kind, as those of the landing."""
        return self.landing.places(kind)

    def values(self, wanted: Quantity, places: Sequence[Place] | None = None) -> Array:
        """The values (n,) or (n, 3) of a quantity at some places, by default all of its kind; NaN where there is none.

        A point that is fixed to the world does not move.
        """
        where = self.places(wanted.of) if places is None else places
        key = (wanted.of, wanted.key, None if places is None else tuple((p.name, p.body, p.number, *p.r.tolist()) for p in places))
        if key not in self._cache:
            found = np.full((len(where), 3) if wanted.vector else len(where), np.nan)
            fixed = [k for k, place in enumerate(where) if wanted.of == "point" and place.body < 0]
            moving = [k for k in range(len(where)) if k not in fixed]
            with self.trace.stage(wanted.title):
                if fixed and not wanted.lacks(self.landing):
                    found[fixed] = [wanted.fixed(where[k]) for k in fixed]
                if moving and wanted.on == "health":
                    found[moving] = wanted.compute(self.health, [where[k] for k in moving])
                elif moving and (proof := self.proof if wanted.on == "scene" else self.proof_with(wanted.on)) is not None:
                    found[moving] = proof.read(wanted.compute, [where[k] for k in moving], size=wanted.size)[0, 0]
            self._cache[key] = read_only(found)
        return self._cache[key]

    def value(self, key: str, kind: PlaceKind) -> Array:
        """The values of a quantity at all places of its kind, as `values`."""
        return self.values(quantity(kind, key))

    def numbers(self, selection: Selection, places: Sequence[Place]) -> Array:
        """The numbers (n,) of a selection at some places; NaN where there is none, or redundant rows leave it undetermined."""
        numbers = selection.scalar(self.values(selection.quantity, places))
        return np.full(len(places), np.nan) if selection.quantity.shared and self.redundant else numbers

    @property
    def redundant(self) -> bool:
        """Whether contact or closure rows depend on one another, so that their impulses are one solution of many."""
        return len(self.choice.rows) < len(self.proof.impulse)

    @cached_property
    def _cache(self) -> dict[Any, Array]:
        return {}

    def proof_with(self, name: str) -> Proof | None:
        """The proof of the same landing with "free" or "locked" joints, or with "springs_free" and all other joints locked.

        Returns: None where that has no verdict, or the landing no springs.
        """
        proof = self._other_joints[name]
        return None if isinstance(proof, str) else proof

    @property
    def unsolved_joints(self) -> dict[str, str]:
        """Why there is no solution with "free" joints, "locked" ones or "springs_free", as in `proof_with`, by these names."""
        return {name: proof for name, proof in self._other_joints.items() if isinstance(proof, str)}

    @cached_property
    def _other_joints(self) -> dict[str, Proof | str | None]:
        joints, model = self.robot.actuated_dofs, self.landing.joint_model
        proofs: dict[str, Proof | str | None] = {"springs_free": None}
        models = {"free": np.zeros_like(joints), "locked": joints}
        for name, locked in (models | ({"springs_free": joints & ~model.springs} if model.springs.any() else {})).items():
            if model.name == name or not (locked.any() or name == "free"):
                proofs[name] = self.proof if model.name == name else proofs["free"]
                continue
            state = dynamics(self.robot, self.landing.q[None])
            bare = self.landing.without_stops
            changed = replace(bare, joint_model=without_springs(np.zeros(len(locked)), locked, name), state=state)
            try:
                changed = with_stops(changed) if self.scene.stops else changed
                equation = changed.equation(state)
                proofs[name] = solve_exactly(changed, equation, solve_in_doubles(changed, equation))
            except (SceneError, SolveError) as refusal:
                proofs[name] = str(refusal)
        return proofs

    @property
    def plane(self) -> Plane:
        """The plane in which CoPc and RoPc are given."""
        return self.landing.plane

    @property
    def q(self) -> Array:
        """(nq,) configuration in Pinocchio's layout."""
        return self.landing.q

    @property
    def joint_model(self) -> str:
        """The model: "free" (no reflected inertia), "geared" (every joint has some), "locked" (every joint holds) or "mixed"."""
        return self.landing.joint_model.name

    @property
    def assembly(self) -> Assembly | None:
        """What closing the loops changed; None without loops."""
        return self.landing.assembly

    @property
    def choice(self) -> RowChoice:
        """Which rows are independent."""
        return self.proof.choice

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return tuple(body.name for body in self.robot.bodies)

    v_in = _property("robot", "v_in", _one)
    position = _property("body", "position", _each)
    copc = _property("body", "copc", _each)
    copc_world = _property("body", "copc_world", _each)
    ropc = _property("body", "ropc", _each)
    translates = _property("body", "translates", _flags)
    pitch = _property("body", "pitch", _each)
    off_plane = _property("body", "off_plane", _each)
    shock_com = _property("body", "shock_com", _each)
    shock_min = _property("body", "shock_min", _each)
    shock_max = _property("body", "shock_max", _each)
    total_impulse = _property("robot", "total_impulse", _vector)
    total_moment = _property("robot", "total_moment", _vector)
    energy_lost = _property("robot", "energy_lost", _one)
    energy_share = _property("robot", "energy_share", _known)

    @property
    def reference_velocities(self) -> Array:
        """(k, 3) velocities before the impact of which the fastest has the speed `v_in`: contacts or centre of mass [m/s]."""
        return read_only(
            self.proof.read(lambda impact: impact.reference_velocities[0, 0], size=lambda *_: self.landing.fastest_approach)
        )

    @property
    def approach(self) -> Array:
        """(n, 3) velocity of every contact point before the impact, world axes [m/s]."""
        return self.value("approach", "contact")[: len(self.landing.contacts)]

    @property
    def strike(self) -> Array:
        """(3,) velocity of the fastest contact before the impact, world axes [m/s]."""
        return np.asarray(self.approach[np.argmax(np.linalg.norm(self.approach, axis=1))])

    @property
    def delta_qd(self) -> Array:
        """(nv,) jump of the joint velocities, Pinocchio's layout [rad/s, m/s]."""
        return self.proof.delta_qd[:, 3]

    @property
    def maps(self) -> Array:
        """(nb, 6, 3) jump (Δω, Δv) of every body for a strike of 1 m/s along world x, y and z, body axes."""
        return self.proof.jumps[..., :3]

    @property
    def delta_omega(self) -> Array:
        """(nb, 3) jump of angular velocity, body axes [rad/s] (Eqs. 8 and 9)."""
        return self.proof.jumps[:, :3, 3]

    @property
    def delta_v(self) -> Array:
        """(nb, 3) jump of velocity of the body frame's origin, body axes [m/s] (Eqs. 8 and 9)."""
        return self.proof.jumps[:, 3:, 3]

    @cached_property
    def moved(self) -> np.ndarray:
        """(nb,) whether the strike moves the body by more than 1e-12 of the fastest one."""
        motion = np.linalg.norm(self.delta_omega, axis=1) + np.linalg.norm(self.delta_v, axis=1)
        moved = motion > 1e-12 * motion.max()
        freeze(moved)
        return np.asarray(moved)

    @cached_property
    def rotation(self) -> Array:
        """(nb, 3, 3) of the body frames, body to world."""
        return read_only(self.proof.read(lambda impact: impact.state.rotation[0], size=lambda *_: 1.0))

    @cached_property
    def directions(self) -> ExtremeDirections:
        """Most and least severe impact directions of the bodies' centres of mass."""
        return self._directions("body")

    @cached_property
    def points(self) -> tuple[PointShock, ...]:
        """Shock at sensors and points."""
        directions = self._directions("point")
        each = [ExtremeDirections(*(part[k] for part in directions)) for k in range(len(self.landing.points))]
        named = [("world" if place.body < 0 else self.bodies[place.body]) for place in self.landing.points]
        return self._records(PointShock, "point", frame=[p.name for p in self.landing.points], body=named, directions=each)

    @cached_property
    def parts(self) -> tuple[PartMargin, ...]:
        """Margins of the scene's parts."""
        places, names = self.landing.parts, {place.number: place.name for place in self.places("joint")}
        joints = [names.get(place.joint, "") for place in places]
        given = [self.scene.part[place.number] for place in places]
        margins, by_velocity = self.value("part_margin", "part"), self.value("velocity_margin", "part")
        missing = [
            not_judged(self.landing, place, self.redundant) if np.isnan(margin) else ""
            for place, margin in zip(places, margins, strict=True)
        ]
        return self._records(
            PartMargin,
            "part",
            part=[place.name for place in places],
            body=[self.bodies[place.body] for place in places],
            joint=joints,
            strength=[torque_strength(self.robot, part, j) if j else strength(part) for part, j in zip(given, joints, strict=True)],
            governed_by=[
                ("" if np.isnan(margin) else "torque") if j else "velocity change" if margin == v else "acceleration"
                for margin, v, j in zip(margins, by_velocity, joints, strict=True)
            ],
            missing=missing,
        )

    @cached_property
    def margin_lost(self) -> MarginLost | None:
        """From which contact stiffness on a margin is lost; None without parts, or without limits and a contact stiffness."""
        return margin_lost(self.landing) if self.landing.parts or self.stiffness is not None else None

    @cached_property
    def contacts(self) -> tuple[ContactImpulse, ...]:
        """Impulses, friction and effective masses of the contacts."""
        frames = [block.frame for block in (*self.landing.contacts, *self.landing.stance)]
        return self._records(ContactImpulse, "contact", frame=frames)[: len(self.landing.contacts)]

    @cached_property
    def stance(self) -> tuple[StanceImpulse, ...]:
        """Impulses of the standing feet."""
        frames = [block.frame for block in (*self.landing.contacts, *self.landing.stance)]
        return self._records(StanceImpulse, "contact", frame=frames)[len(self.landing.contacts) :]

    @cached_property
    def loads(self) -> tuple[JointLoad, ...]:
        """Impulses through the joints between bodies, and jumps of their rates.

        Where rows depend on one another (redundant contacts, a planar loop closed in space) they are those of the contact impulses
        of least norm.
        """
        return self._records(JointLoad, "joint", joint=[place.name for place in self.places("joint")])

    @cached_property
    def bracket(self) -> tuple[Bracket, ...]:
        """Shock with other models of the joints: at the heaviest body's centre of mass and at every sensor and point."""
        return self._records(
            Bracket, "point", self.bracketed, place=[place.name for place in self.bracketed], free="shock_free",
            as_modelled="shock", locked="shock_locked", springs_free="shock_springs_free",
        )  # fmt: skip

    @cached_property
    def spring_time(self) -> float:
        """Time after the impact from which on the first spring counts, as `spring_times` [s]; infinite without springs."""
        if not self.landing.joint_model.springs.any():
            return math.inf
        from shockpc.impact.springs import spring_times

        return float(spring_times(self.landing).min())

    @property
    def friction(self) -> "FrictionResult | None":
        """The landing with the scene's friction; None if it gives none."""
        if self.scene.friction is None:
            return None
        from shockpc.impact.friction import friction_of

        return friction_of(self.landing)

    @property
    def stiffness(self) -> "CompliantLanding | None":
        """The landing on contacts of the scene's stiffness; None if it gives none."""
        if self.scene.contact_stiffness is None:
            return None
        from shockpc.impact.stiffness import compliant_landing

        return compliant_landing(self.landing)

    @cached_property
    def health(self) -> Health:
        """How far to trust the numbers, with the warnings."""
        landing, proof, robot = self.landing, self.proof, self.robot.name
        with self.trace.stage("accuracy and warnings"):
            sensitivity, data = data_sensitivity(proof, self._small_differences)
            joints = dict(
                zip([place.name for place in self.places("joint")], self.value("joint_impulse", "joint").tolist(), strict=True)
            )
            impulses = {
                (f'impulse of contact "{place.name}"', place.name): value
                for place, value in zip(self.places("contact"), self._contact_impulses.tolist(), strict=True)
            }
            impulses |= {(f'impulse through joint "{name}"', name): value for name, value in joints.items()}
            masses = {(f'effective mass of contact "{c.frame}"', c.frame): c.effective_mass for c in self.contacts}
            largest = tuple(oversized(landing, impulses, masses))
            stopped = any(block.kind == "stop" for block in landing.contacts)
            held = max(float(self._contact_impulses.max()), float(np.linalg.norm(self.total_impulse)))
            warnings = (
                *largest,
                *(Diagnostic("robot", robot, None, text) for text in self.robot.warnings),
                *self.robot.change_warnings,
                *landing.warnings,
                *implausible(landing, {contact.frame: contact.mitigation for contact in self.contacts}),
                *nearly_singular(landing, proof),
                *redundant(landing, self.choice),
                *(() if stopped or any(one.kind == "size" for one in largest) else strained(joints, held)),
                *data,
                *pulled(landing, self.value("pull", "contact"), None if self.friction is None else self.friction.state),
                *slipping(landing, self.value("friction_needed", "contact")),
                *gained(robot, self.energy_lost, self.v_in * float(np.linalg.norm(self.total_impulse))),
                *self._beyond_the_impulse(),
                *saturated(landing, {point.frame: point.peak_g for point in self.points}),
                *self._overloaded(),
                *self._beyond_stops(),
                *(Diagnostic("geometry", robot, None, text) for text in body_outline(self.robot).warnings),
            )
            return Health(
                rank=len(self.choice.rows),
                rows=len(proof.impulse),
                error_bound=float(np.max(proof.bounds)),
                body_error_bounds=tuple(map(float, proof.bounds)),
                double_error=double_error(landing, proof, self.double_jumps[..., 3]),
                data_sensitivity=sensitivity,
                bits=proof.bits,
                warnings=warnings,
            )

    def _beyond_the_impulse(self) -> Iterator[Diagnostic]:
        """Warnings where springs in joints, or a finite stiffness of the contacts, make another result than the impulse model."""
        if self.stiffness is not None:
            places = [*self.bracketed, *self.landing.mounted]
            impulse, finite = (self.values(quantity("point", key), places) for key in ("shock", "shock_separated"))
            differs, said = np.abs(finite - impulse), set[str]()
            for k in np.flatnonzero((differs > DIFFERS * np.minimum(impulse, finite)) & (differs > LEAST_DIFFERENCE)).tolist():
                name = places[k].name
                text = (
                    f"shock at {name} is {finite[k]:.3g} at the end of contact on {self.scene.contact_stiffness:g} N/m, and "
                    f"{impulse[k]:.3g} in the impulse model, which the other tables show: that model does not hold there"
                )
                if text not in said:  # a part may be at a sensor
                    yield Diagnostic("contact", name, float(differs[k]), text)
                said.add(text)
            yield from self.stiffness.warnings()
        if math.isfinite(self.spring_time):
            from shockpc.impact.springs import early_springs

            duration = None if self.stiffness is None else self.impact_length
            yield from early_springs(self.landing, self.spring_time, duration)

    def _beyond_stops(self) -> Iterator[Diagnostic]:
        """Warnings of joints at a limit that the impact drives beyond it, where their end stops are left out."""
        robot, rates = self.robot, self.landing.before.joint_rates + self.delta_qd
        sides = at_stops(robot, self.q[None], self.landing.joint_model, limits=True)[0]
        beyond, clearly = driven_beyond(sides, rates), driven_beyond(sides, rates, CLEARLY_BEYOND)
        for joint in robot.single_joints:
            counted = has_stops(robot, joint)
            if self.scene.stops and counted and clearly[joint.v].any():
                text = (
                    f"{joint.name} is driven beyond its end stop, because double precision, which decides which stops act, is off: "
                    "the posture is nearly singular; set another one"
                )
                yield Diagnostic("limits", joint.name, float(rates[joint.v.start]), text)
            elif beyond[joint.v].any() and not (self.scene.stops and counted):
                remedy = ": count it with stops = true (--stops)" if counted else ", because it shares its body with other joints"
                rate = abs(float(rates[joint.v.start]))
                text = (
                    f"{joint.name} is at its limit, and the impact drives it beyond at {rate:.3g} {joint.unit}/s; its end stop is "
                    f"left out{remedy}"
                )
                yield Diagnostic("limits", joint.name, rate, text)

    def _overloaded(self) -> Iterator[Diagnostic]:
        """Warnings of parts that are not judged, that have a margin below 1, or whose torque is rated for a shorter time."""
        length = self.impact_length
        for one in self.parts:
            if one.missing:
                yield Diagnostic(
                    "part", one.part, None, f"{one.part} is not judged: it {one.missing}{REMEDIES.get(one.missing, '')}"
                )
            if one.part_margin is not None and one.part_margin < 1.0:
                text = f"{one.part} may be damaged: its margin by {one.governed_by} is {one.part_margin:.3g}, below 1"
                if isinstance(one.strength, TorqueStrength):
                    limit = "its momentary torque" if one.strength.given else "its effort limit"
                    text = f"{one.joint} carries {1.0 / one.part_margin:.3g} times {limit}"
                yield Diagnostic("part", one.part, one.part_margin, text)
            if isinstance(one.strength, TorqueStrength) and length is not None and length > one.strength.duration:
                text = (
                    f"the impact lasts {1e3 * length:.3g} ms, and the momentary torque of {one.joint} is for "
                    f"{1e3 * one.strength.duration:.3g} ms; give the torque that it withstands for longer"
                )
                yield Diagnostic("part", one.part, length, text)

    @property
    def impact_length(self) -> float | None:
        """How long the impact lasts, by a contact stiffness or the pulse of the scene [s]; None where neither is given."""
        if self.stiffness is not None:
            return float(self.stiffness.duration.max())
        return None if self.landing.pulse is None else self.landing.pulse.length

    @property
    def bracketed(self) -> list[Place]:
        """The heaviest body's centre of mass, every sensor and every point."""
        heaviest = body_places(self.robot)[int(np.argmax(self.robot.masses))]
        return [heaviest, *(place for place in self.landing.points if place.body >= 0)]

    @cached_property
    def _contact_impulses(self) -> Array:
        """Sizes (n,) of the impulses of contacts and standing feet [N s]; 0 where there is none."""
        return read_only(np.nan_to_num(np.linalg.norm(self.value("impulse", "contact"), axis=1)))

    @property
    def _small_differences(self) -> list[tuple[Quantity, list[Place], Array]]:
        """Results that may be small differences of large numbers: speed, radii of percussion, impulses; with places and values."""
        impulse = self._contact_impulses
        chosen = [
            (quantity("robot", "v_in"), np.ones(1)),
            (quantity("body", "ropc"), ~self.translates),
            (quantity("contact", "impulse"), impulse > AT_REST * impulse.max(initial=0.0)),
        ]
        kept = [(entry, [p for p, keep in zip(self.places(entry.of), flags, strict=True) if keep]) for entry, flags in chosen]
        return [(entry, places, self.values(entry, places)) for entry, places in kept if places]

    def shock_at(self, frame: str, r: Array) -> Array:
        """Shock at points of a body, |Δv + Δω × r| / v_in [1].

        Args:
            frame: name of the body, or of a link, joint or site on it.
            r: (..., 3) from the origin of that frame, in its axes [m].

        Raises:
            UnknownName: the robot has no such frame.
        """
        place = self.robot.frame(frame)
        points = place.offset + np.asarray(r, dtype=float) @ place.rotation.T
        if place.body < 0:
            return np.zeros(points.shape[:-1])
        return np.asarray(shock_at(self.delta_omega[place.body], self.delta_v[place.body], points, self.v_in))

    def _directions(self, kind: PlaceKind) -> ExtremeDirections:
        keys = ("most_severe_direction", "most_severe", "least_severe_direction", "least_severe")
        return ExtremeDirections(*(self.value(key, kind) for key in keys))

    def _records(
        self, record: type[R], kind: PlaceKind, places: Sequence[Place] | None = None, **given: str | Sequence[Any]
    ) -> tuple[R, ...]:
        """A record for each place, as `values` takes them: its fields are given, or quantities, by their own keys or given ones."""
        columns: list[Iterable[Any]] = []
        for name in record._fields:
            column = given.get(name, name)
            columns.append(map(_number, self.values(quantity(kind, column), places)) if isinstance(column, str) else column)
        return tuple(map(record._make, zip(*columns, strict=True)))
