"""What an analysis gives back: a landing and its proof; every other number is a quantity, computed when it is read."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from shockpc.core.directions import ExtremeDirections
from shockpc.core.impulse import RowChoice, solve_impact
from shockpc.core.percussion import shock_at
from shockpc.core.spatial import Array, Plane, freeze, jump_at, read_only
from shockpc.impact.exact.proof import Proof
from shockpc.impact.solve import solve_exactly
from shockpc.landing.closure import Assembly
from shockpc.landing.dynamics import dynamics
from shockpc.landing.joint_model import without_springs
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Kind, Place, body_places, point_place
from shockpc.landing.ratings import Strength, strength, torque_limits
from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import point_at
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
from shockpc.quantities.plausibility import gained, implausible, pulled, saturated, slipping
from shockpc.quantities.quantity import Quantity, evaluate
from shockpc.quantities.table import Selection, quantity
from shockpc.robot.geometry import body_outline
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import SceneError, SolveError
from shockpc.text.trace import Trace

if TYPE_CHECKING:
    from shockpc.impact.friction import FrictionResult
    from shockpc.impact.stiffness import CompliantLanding


R = TypeVar("R", bound="NamedTuple")

DIFFERS, LEAST_DIFFERENCE = 0.1, 1e-3
"""Share by which shock on contacts of finite stiffness differs from that of the impulse model, from which a warning says so; and
the least difference of which one does [1]."""


class PointShock(NamedTuple):
    """Shock at a sensor, or at a point that was asked for.

    Attributes:
        frame: its name.
        body: the body it is fixed to.
        position: (3,) world [m].
        delta_v: (3,) jump of its velocity, in the frame's own axes [m/s].
        shock: |Δv| / v_in [1].
        directions: the most and the least severe impact direction.
        peak_g: peak acceleration for the scene's pulse, in multiples of gravity; None without a pulse.
    """

    frame: str
    body: str
    position: Array
    delta_v: Array
    shock: float
    directions: ExtremeDirections
    peak_g: float | None


class PartMargin(NamedTuple):
    """How far a part is from what it withstands.

    Attributes:
        part: its name.
        body: the body it is fixed to.
        strength: its damage boundary.
        delta_v: (3,) jump of its velocity, in the axes of its frame [m/s].
        shock: |Δv| / v_in [1].
        velocity_margin: critical velocity change, of |Δv| [1].
        peak_g: peak acceleration, in multiples of gravity; None without a pulse or a contact stiffness.
        acceleration_margin: critical acceleration, of that peak [1]; None where one of the two is not known.
        part_margin: by how much the speed of the strike may rise before the part may be damaged [1].
        governed_by: which of the two margins that is.
    """

    part: str
    body: str
    strength: Strength
    delta_v: Array
    shock: float
    velocity_margin: float
    peak_g: float | None
    acceleration_margin: float | None
    part_margin: float
    governed_by: str


class ContactImpulse(NamedTuple):
    """What the ground does at a contact.

    Attributes:
        frame: its name.
        point: (3,) where it strikes, world [m].
        impulse: (3,) of the ground on the robot, world axes [N s]; None where only the sum over several contacts is determined.
        moment: (3,) about that point, of a flat contact, world axes [N m s]; None for a point, or without an impulse.
        friction_needed: tangential over normal impulse, the least coefficient of friction that makes it stick [1]; None without an
            impulse, or where the ground would have to pull.
        approach: (3,) velocity of the contact point before the impact, world axes [m/s].
        mass_sticking: effective mass along the ground's normal if the contact sticks [kg]; inf if it cannot give way.
        mass_frictionless: the same if it slides [kg].
        effective_mass: that of the two which the contact has.
        mitigation: impact mitigation factor if the contact sticks, in the directions in which joints can move it: 1 if they
            decouple the robot from the ground, 0 if none can move it [1]; None unless the base is free.
        mitigation_frictionless: the same if it slides, along the ground's normal [1].
        pull: by how much the ground would have to pull [N s]; None without an impulse.
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


class StanceImpulse(NamedTuple):
    """What the ground does at a foot that stands already; the attributes are as in `ContactImpulse`."""

    frame: str
    point: Array
    impulse: Array | None
    friction_needed: float | None
    pull: float | None


class JointLoad(NamedTuple):
    """What a joint goes through.

    Attributes:
        joint: its name.
        force: (3,) impulse on the body from its parent, world axes [N s].
        moment: (3,) about the joint's origin (of a prismatic joint, where it has slid to), world axes [N m s].
        along: part of the moment (of the force, if prismatic) along the joint's axis: what the drive carries [N m s, N s]; None
            for a joint of more than one axis.
        delta_qd: jump of its rate [rad/s, m/s]; of a ball joint its length.
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


class ShockMaps(NamedTuple):
    """The shock of a landing in N postures: Δv is linear in the strike, so every strike angle and speed is a product.

    Attributes:
        robot: the robot.
        maps: (N, nb, 6, 3) jump (Δω, Δv at the body frame's origin) of every body for a strike of 1 m/s along world x, y and z;
            world axes, double precision [rad/s, m/s].
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) origins of the body frames, from the base [m].
        rank: (N,) number of independent contact and closure rows.
        condition: (N,) estimated factor by which rounding is enlarged [1]; inf where double precision has no solution.
        prove: (N,) whether the posture needs a proof: its rows depend on one another, or nearly, rounding may show above 1e-9, or
            joints move so fast that it may be singular, which `shock_profile` refuses.
    """

    robot: Robot
    maps: Array
    rotation: Array
    position: Array
    rank: np.ndarray
    condition: Array
    prove: np.ndarray

    def at(self, place: str | int, point: Array | None = None) -> Array:
        """Maps (N, 3, 3) from strike to jump of a point, world axes.

        Args:
            place: a frame, FRAME:x,y,z, or the index of a body.
            point: (3,) in the frame of the body, if that is an index [m]; by default its origin.

        Raises:
            UnknownName: the robot has no frame of that name.
        """
        if isinstance(place, str):
            where = point_place(self.robot, point_at(self.robot, place))
            place, point = where.body, where.r
        return np.asarray(jump_at(self.maps[:, place], self.rotation[:, place] @ (np.zeros(3) if point is None else point)))


@dataclass(frozen=True, eq=False)
class ShockProfile:
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

    def places(self, kind: Kind) -> tuple[Place, ...]:
        """The places of one kind, as those of the landing."""
        return self.landing.places(kind)

    def values(self, wanted: Quantity, places: Sequence[Place] | None = None) -> Array:
        """The values (n,) or (n, 3) of a quantity at some places, by default all of its kind; NaN where there is none.

        A point that is fixed to the world does not move.
        """
        where = self.places(wanted.of) if places is None else places
        key = (wanted.of, wanted.key, None if places is None else tuple((p.name, p.body, p.number, *p.r.tolist()) for p in places))
        cache = self._cache
        if key not in cache:
            with self.trace.stage(wanted.title):
                cache[key] = read_only(self._values(wanted, where))
        return cache[key]

    def value(self, key: str, kind: Kind) -> Array:
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

    def _values(self, wanted: Quantity, places: Sequence[Place]) -> Array:
        out = np.zeros((len(places), 3) if wanted.vector else len(places))
        moving = [k for k, place in enumerate(places) if wanted.of != "point" or place.body >= 0]
        if wanted.key == "position":
            out = np.array([place.r for place in places]).reshape(-1, 3)
        if wanted.key == "peak_g" and self.landing.pulse is None:
            out[:] = np.nan
        if not moving:
            return out
        where = [places[k] for k in moving]
        if wanted.key in ("shock_free", "shock_locked", "shock_springs_free"):
            other = self.proof_with(wanted.key.removeprefix("shock_"))
            shock = quantity("point", "shock")
            out[moving] = np.nan if other is None else other.read(lambda impact: evaluate(shock, impact, where))[0, 0]
        elif wanted.compute is None:
            bounds = self.health.body_error_bounds
            out[moving] = [bounds[place.body] for place in where] if wanted.of == "body" else getattr(self.health, wanted.key)
        else:
            out[moving] = self.proof.read(lambda impact: evaluate(wanted, impact, where))[0, 0]
        return out

    def proof_with(self, name: str) -> Proof | None:
        """The proof of the same landing with "free" or "locked" joints, or with "springs_free" and all other joints locked.

        Returns: None where that has no verdict, or the landing no springs.
        """
        return self._other_joints[name]

    @cached_property
    def _other_joints(self) -> dict[str, Proof | None]:
        joints, model = self.robot.actuated_dofs, self.landing.joint_model
        proofs: dict[str, Proof | None] = {"springs_free": None}
        models = {"free": np.zeros_like(joints), "locked": joints}
        for name, locked in (models | ({"springs_free": joints & ~model.springs} if model.springs.any() else {})).items():
            if model.name == name or not (locked.any() or name == "free"):
                proofs[name] = self.proof if model.name == name else proofs["free"]
                continue
            state = dynamics(self.robot, self.landing.q[None])
            changed = replace(self.landing, joint_model=without_springs(np.zeros(len(locked)), locked, name), state=state)
            try:
                equation = changed.equation(state)
                solution = solve_impact(
                    equation.inertia, equation.J_c, equation.b, equation.terms, equation.tolerance, changed.most_independent
                )
                proofs[name] = solve_exactly(changed, equation, solution)
            except (SceneError, SolveError):
                proofs[name] = None
        return proofs

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.landing.robot

    @property
    def scene(self) -> Scene:
        """What was computed, with every default filled in."""
        return self.landing.scene

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

    @property
    def v_in(self) -> float:
        """Speed by which shock is normalised, of the fastest contact or of the centre of mass [m/s]."""
        return float(self.value("v_in", "robot")[0])

    @property
    def reference_velocities(self) -> Array:
        """(k, 3) velocities before the impact of which the fastest has the speed `v_in`: contacts or centre of mass [m/s]."""
        return read_only(
            self.proof.read(
                lambda impact: impact.rounded(impact.reference_velocities[0, 0], lambda _: self.landing.fastest_approach)
            )
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

    @property
    def position(self) -> Array:
        """(nb, 3) origins of the body frames, world [m]."""
        return self.value("position", "body")

    @cached_property
    def rotation(self) -> Array:
        """(nb, 3, 3) of the body frames, body to world."""
        return read_only(self.proof.read(lambda impact: impact.rounded(impact.state.rotation[0], lambda entries: 1.0)))

    @property
    def copc(self) -> Array:
        """(nb, 3) centre of percussion, body coordinates [m]; NaN where the body does not rotate in the plane (Eq. 11)."""
        return self.value("copc", "body")

    @property
    def copc_world(self) -> Array:
        """(nb, 3) the same in the world [m]."""
        return self.value("copc_world", "body")

    @property
    def ropc(self) -> Array:
        """(nb,) radius of percussion [m]; inf where the body does not rotate in the plane (Eq. 12)."""
        return self.value("ropc", "body")

    @cached_property
    def translates(self) -> np.ndarray:
        """(nb,) whether the body does not rotate in the plane, by more than the rounding of files."""
        translates = self.value("translates", "body") > 0.0
        freeze(translates)
        return translates

    @property
    def pitch(self) -> Array:
        """(nb,) pitch of the spatial screw [m/rad]; NaN where the body does not rotate at all."""
        return self.value("pitch", "body")

    @property
    def off_plane(self) -> Array:
        """(nb,) share of the jump that the plane cannot show [1]."""
        return self.value("off_plane", "body")

    @property
    def shock_com(self) -> Array:
        """(nb,) shock at the centre of mass [1]."""
        return self.value("shock_com", "body")

    @property
    def shock_min(self) -> Array:
        """(nb,) least shock over the body's geometry [1]; NaN without geometry.

        Of a file without collision geometry the visual one is taken. Computed in double precision from the proven jumps: right to
        1e-15 of |Δv| + |Δω| |r| at the farthest point r of the body.
        """
        return self.value("shock_min", "body")

    @property
    def shock_max(self) -> Array:
        """(nb,) greatest shock over the body's geometry [1]; as `shock_min`."""
        return self.value("shock_max", "body")

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
        places = self.landing.parts
        by_velocity = self.value("part_margin", "part") == self.value("velocity_margin", "part")
        return self._records(
            PartMargin,
            "part",
            part=[place.name for place in places],
            body=[self.bodies[place.body] for place in places],
            strength=[strength(self.scene.part[place.number]) for place in places],
            governed_by=["velocity change" if flag else "acceleration" for flag in by_velocity],
        )

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

    @property
    def total_impulse(self) -> Array:
        """(3,) impulse of the ground on the robot, all contacts and standing feet together, world axes [N s]."""
        return np.asarray(self.value("total_impulse", "robot")[0])

    @property
    def total_moment(self) -> Array:
        """(3,) moment of the same about the robot's centre of mass, world axes [N m s]."""
        return np.asarray(self.value("total_moment", "robot")[0])

    @property
    def energy_lost(self) -> float:
        """Kinetic energy that the impact takes [J]."""
        return float(self.value("energy_lost", "robot")[0])

    @property
    def energy_share(self) -> float | None:
        """The same of the kinetic energy before it [1]; None where that is not determined (fixed base, standing feet)."""
        share = float(self.value("energy_share", "robot")[0])
        return None if np.isnan(share) else share

    @cached_property
    def bracket(self) -> tuple[Bracket, ...]:
        """Shock with other models of the joints: at the heaviest body's centre of mass and at every sensor and point."""
        places, keys = self.bracketed, ("shock_free", "shock", "shock_locked", "shock_springs_free")
        rows = zip(places, *(self.values(quantity("point", key), places).tolist() for key in keys), strict=True)
        return tuple(Bracket(place.name, _number(free), here, *map(_number, others)) for place, free, here, *others in rows)

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
            held = max(float(self._contact_impulses.max()), float(np.linalg.norm(self.total_impulse)))
            warnings = (
                *largest,
                *(Diagnostic("robot", robot, None, text) for text in self.robot.warnings),
                *self.robot.change_warnings,
                *landing.warnings,
                *implausible(landing, {contact.frame: contact.mitigation for contact in self.contacts}),
                *nearly_singular(landing, proof),
                *redundant(landing, self.choice),
                *(() if any(one.kind == "size" for one in largest) else strained(joints, held)),
                *data,
                *pulled(landing, self.value("pull", "contact"), None if self.friction is None else self.friction.state),
                *slipping(landing, self.value("friction_needed", "contact")),
                *gained(robot, self.energy_lost, self.v_in * float(np.linalg.norm(self.total_impulse))),
                *self._beyond_the_impulse(),
                *saturated(landing, {point.frame: point.peak_g for point in self.points}),
                *self._overloaded(),
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
            places = [*self.bracketed, *self.landing.parts]
            impulse, finite = (self.values(quantity("point", key), places) for key in ("shock", "shock_separated"))
            differs = np.abs(finite - impulse)
            for k in np.flatnonzero((differs > DIFFERS * np.minimum(impulse, finite)) & (differs > LEAST_DIFFERENCE)).tolist():
                name = places[k].name
                text = (
                    f"shock at {name} is {finite[k]:.3g} at the end of contact on {self.scene.contact_stiffness:g} N/m, and "
                    f"{impulse[k]:.3g} in the impulse model, which the other tables show: that model does not hold there"
                )
                yield Diagnostic("contact", name, float(differs[k]), text)
            yield from self.stiffness.warnings()
        if math.isfinite(self.spring_time):
            from shockpc.impact.springs import early_springs

            duration = None if self.stiffness is None else self.stiffness.motion.duration
            yield from early_springs(self.landing, self.spring_time, duration)

    def _overloaded(self) -> Iterator[Diagnostic]:
        """Warnings of parts with a margin below 1, and of rated joints beyond their torque or its duration."""
        for one in self.parts:
            if one.part_margin < 1.0:
                text = f"{one.part} may be damaged: its margin by {one.governed_by} is {one.part_margin:.3g}, below 1"
                yield Diagnostic("part", one.part, one.part_margin, text)
        rated = {name for part in self.scene.part if part.joint is not None for name in self.robot.match_joints(part.joint)}
        shares, durations = self.value("joint_torque_share", "joint").tolist(), torque_limits(self.robot, self.scene.part)[1]
        length = self.impact_length
        for place, share in zip(self.places("joint"), shares, strict=True):
            if place.name in rated and share > 1.0:
                text = f"{place.name} carries {share:.3g} times its momentary torque"
                yield Diagnostic("part", place.name, share, text)
            if length is not None and length > durations[place.number]:
                text = (
                    f"the impact lasts {1e3 * length:.3g} ms, and the momentary torque of {place.name} is for "
                    f"{1e3 * durations[place.number]:.3g} ms; give the torque that it withstands for longer"
                )
                yield Diagnostic("part", place.name, length, text)

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

    def _directions(self, kind: Kind) -> ExtremeDirections:
        keys = ("most_severe_direction", "most_severe", "least_severe_direction", "least_severe")
        return ExtremeDirections(*(self.value(key, kind) for key in keys))

    def _records(self, record: type[R], kind: Kind, **given: Sequence[Any]) -> tuple[R, ...]:
        """A record for each place of a kind, its fields quantities by key but those given; None where a value does not exist."""
        keys = record._fields
        columns = [given[key] if key in given else [_number(x) for x in self.value(key, kind)] for key in keys]
        return tuple(record(*row) for row in zip(*columns, strict=True))


def _number(value: Any) -> Any:
    """A number or a vector, or None where there is none."""
    if np.isnan(value).all():
        return None
    return value if np.ndim(value) else float(value)
