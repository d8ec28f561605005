"""What an analysis gives back: a landing and its proof; every other number is a quantity, computed
when it is read.
"""

import pkgutil
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from shockpc.core.frozen import frozen
from shockpc.core.impulse import RowChoice
from shockpc.core.most_severe import ExtremeDirections
from shockpc.core.percussion import shock_at
from shockpc.core.spatial import Array, Plane, freeze, read_only
from shockpc.core.threads import one_thread
from shockpc.impact.companions import Companions, Other
from shockpc.impact.landed import LandingProof
from shockpc.landing.closure import Assembly
from shockpc.landing.landing import OfLanding, PosedLanding
from shockpc.landing.places import Place, PlaceKind, body_places
from shockpc.landing.posture import spelled_out
from shockpc.landing.ratings import strength, torque_strength
from shockpc.landing.scene import Scene
from shockpc.quantities.contact_mass import mass_of_contacts
from shockpc.quantities.of_parts import not_judged
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.records import (
    Bracket,
    ContactImpulse,
    Health,
    JointLoad,
    PartMargin,
    PointShock,
    StanceImpulse,
    Unknown,
    records,
)
from shockpc.quantities.renamed import renamed_attribute
from shockpc.quantities.selection import Selection, quantity
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.shown import show_page, shown_by
from shockpc.text.trace import Trace

if TYPE_CHECKING:
    from shockpc.impact.friction import FrictionResult
    from shockpc.impact.stiffness import CompliantLanding

T = TypeVar("T")


class _Of(cached_property[T]):
    """A property of a profile: what is made of the values of the quantity that has its name, at all
    places of a kind.
    """

    def __init__(self, kind: PlaceKind, made: Callable[[Array], T]) -> None:
        def read(profile: "ShockProfile") -> T:
            values = made(profile.value(str(self.attrname), kind))
            freeze(values)
            return values

        super().__init__(read)
        self.kind = kind

    def __set_name__(self, owner: type[Any], name: str) -> None:
        super().__set_name__(owner, name)
        self.__doc__ = (
            f"{quantity(self.kind, name).text} (of {'the' if self.kind == 'robot' else 'each'} "
            f"{self.kind})."
        )


def _each(values: Array) -> Array:
    """Values at several places."""
    return values


def _one(values: Array) -> float:
    """The number of the robot."""
    return float(values[0])


class Judge(NamedTuple):
    """Says of a profile how far to trust it; whoever makes the profile gives it.

    Attributes:
        health: the arithmetic, with the warnings.
        warnings: what is doubtful, without the rest of it, which takes longer.
        unknowns: what it takes for granted.
    """

    health: Callable[["ShockProfile"], Health]
    warnings: Callable[["ShockProfile"], tuple[Diagnostic, ...]]
    unknowns: Callable[["ShockProfile"], tuple[Unknown, ...]]


@frozen()
class ShockProfile(OfLanding):
    """The shock of one landing; index i of an array over the bodies is body i of the robot.

    Its arrays cannot be written to.

    The reported numbers are those of the proof: midpoints of enclosures, rounded to doubles. All
    are computed when they are first read.

    Attributes:
        landing: the scene resolved on the robot.
        double_jumps: (nb, 6, 4) jump (Δω, Δv) of every body in double precision, body coordinates,
            as in `LandingProof`.
        proof: enclosures of the exact solution.
        companions: the same landing with other joints.
        trace: collects what each part cost.
        judge: says how far to trust the numbers.
    """

    landing: PosedLanding
    double_jumps: Array
    proof: LandingProof
    companions: Companions
    trace: Trace
    judge: Judge

    def __repr__(self) -> str:
        known = "; ".join(f"unknown: {one}" for one in self.unknowns)
        return f"ShockProfile({self.landing!r}{'; ' if known else ''}{known})"

    _repr_html_ = shown_by("studies.analyze.report:landing_report")

    def show(self) -> None:
        """Show the landing in three dimensions, as in report.html: in the cell of a notebook, else
        in a browser.

        Raises:
            OutputError: Plotly is not installed, or no browser is found.
        """
        show_page("studies.analyze.report:landing_report", self)

    def figure(self, ax: Any = None) -> Any:
        """The figure of the landing in its plane, of matplotlib.

        It can be restyled, and saved as PDF, SVG or PNG: `profile.figure().savefig("go2.pdf")`.

        Args:
            ax: axes on which the robot, its velocities and its centres of percussion are drawn,
                without tables; a figure with tables by default.

        Returns: the figure, of the axes if they are given.
        """
        return pkgutil.resolve_name("shockpc.show.figure.plane:landing_figure")(self, ax)

    @cached_property
    def scene(self) -> Scene:
        """What lands, with every default filled in; in place of a posture that is computed the
        values of its joints.
        """
        return spelled_out(self.landing.scene, self.robot)

    def places(self, kind: PlaceKind) -> tuple[Place, ...]:
        """The places of one kind, as those of the landing."""
        return self.landing.places(kind)

    def values(self, wanted: Quantity, places: Sequence[Place] | None = None) -> Array:
        """The values (n,) or (n, 3) of a quantity at some places, by default all of its kind; NaN
        where there is none.

        A point that is fixed to the world does not move.
        """
        where = self.places(wanted.of) if places is None else places
        chosen = None
        if places is not None:
            chosen = tuple((p.name, p.body, p.number, *p.r.tolist()) for p in places)
        key = wanted.of, wanted.key, chosen
        if key not in self._cache:
            values = np.full((len(where), 3) if wanted.vector else len(where), np.nan)
            fixed = [k for k, place in enumerate(where) if wanted.of == "point" and place.body < 0]
            moving = [k for k in range(len(where)) if k not in fixed]
            with self.trace.stage(wanted.title):
                if fixed and not wanted.scope.lacks(self.landing):
                    values[fixed] = [wanted.scope.fixed(where[k]) for k in fixed]
                if moving:
                    values[moving] = self._computed(wanted, [where[k] for k in moving])
            self._cache[key] = read_only(values)
        return self._cache[key]

    def _computed(self, wanted: Quantity, places: list[Place]) -> Any:
        """The values of a quantity at places that move; NaN where a companion has no verdict."""
        if wanted.evaluation.on == "health":
            return wanted.compute(self.health, places)
        proof = (
            self.proof if wanted.evaluation.on == "scene" else self.proof_with(wanted.evaluation.on)
        )
        if proof is None:
            return np.nan
        return proof.read(wanted.compute, places, size=wanted.size)[0, 0]

    def value(self, key: str, kind: PlaceKind) -> Array:
        """The values of a quantity at all places of its kind, as `values`."""
        return self.values(quantity(kind, key))

    def numbers(self, selection: Selection, places: Sequence[Place]) -> Array:
        """The numbers (n,) of a selection at some places; NaN where there is none, or redundant
        rows leave it undetermined.
        """
        numbers = selection.scalar(self.values(selection.quantity, places))
        return (
            np.full(len(places), np.nan)
            if selection.quantity.scope.shared and self.redundant
            else numbers
        )

    @property
    def redundant(self) -> bool:
        """Whether contact or closure rows depend on one another, so that their impulses are one
        solution of many.
        """
        return len(self.choice.rows) < len(self.proof.impulse)

    @cached_property
    def _cache(self) -> dict[Any, Array]:
        return {}

    def proof_with(self, name: Other) -> LandingProof | None:
        """The proof of the same landing with "free" or "locked" joints, or with "springs_free" and
        all other joints locked.

        Returns: None where that has no verdict, or the landing no springs.
        """
        return self.companions.proof(name)

    @property
    def unsolved_joints(self) -> Mapping[str, str]:
        """Why there is no solution with "free" joints, "locked" ones or "springs_free", as in
        `proof_with`, by these names.
        """
        return self.companions.refused

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
        """The model: "free" (no reflected inertia), "geared" (every joint has some), "locked"
        (every joint holds) or "mixed".
        """
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

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """A quantity by its former key."""
            return renamed_attribute(self, name)

    v_in = _Of("robot", _one)
    position = _Of("body", _each)
    copc = _Of("body", _each)
    copc_world = _Of("body", _each)
    ropc = _Of("body", _each)
    translates = _Of("body", lambda values: np.asarray(values > 0.0))
    screw_pitch = _Of("body", _each)
    out_of_plane_share = _Of("body", _each)
    shock_com = _Of("body", _each)
    shock_min = _Of("body", _each)
    shock_max = _Of("body", _each)
    total_impulse = _Of("robot", lambda values: np.asarray(values[0]))
    total_moment = _Of("robot", lambda values: np.asarray(values[0]))
    energy_lost = _Of("robot", _one)
    energy_share = _Of("robot", lambda values: None if np.isnan(values[0]) else _one(values))

    @property
    def reference_velocities(self) -> Array:
        """(k, 3) velocities before the impact of which the fastest has the speed `v_in`: contacts
        or centre of mass [m/s].
        """
        return read_only(
            self.proof.read(
                lambda impact: impact.reference_velocities[0, 0],
                size=lambda *_: self.landing.fastest_approach,
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
        """(nb, 6, 3) jump (Δω, Δv) of every body for a strike of 1 m/s along world x, y and z, body
        axes.
        """
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
        return read_only(
            self.proof.read(lambda impact: impact.state.rotation[0], size=lambda *_: 1.0)
        )

    @cached_property
    def directions(self) -> ExtremeDirections:
        """Most and least severe impact directions of the bodies' centres of mass."""
        return self._directions("body")

    @cached_property
    def points(self) -> tuple[PointShock, ...]:
        """Shock at sensors and points."""
        places, directions = self.landing.points, self._directions("point")
        each = [ExtremeDirections(*(part[k] for part in directions)) for k in range(len(places))]
        carriers = ["world" if place.body < 0 else self.bodies[place.body] for place in places]
        return records(PointShock, self, "point", body=carriers, directions=each)

    @cached_property
    def parts(self) -> tuple[PartMargin, ...]:
        """Margins of the scene's parts."""
        places, names = (
            self.landing.parts,
            {place.number: place.name for place in self.places("joint")},
        )
        strengths, governed, missing, joints = (
            [],
            [],
            [],
            [names.get(place.joint, "") for place in places],
        )
        margins = zip(
            self.value("part_margin", "part"), self.value("velocity_margin", "part"), strict=True
        )
        for place, joint, (margin, by_velocity) in zip(places, joints, margins, strict=True):
            given, known = self.scene.part[place.number], not np.isnan(margin)
            strengths.append(
                torque_strength(self.robot, given, joint) if joint else strength(given)
            )
            by = (
                "torque"
                if joint
                else "velocity change"
                if margin == by_velocity
                else "acceleration"
            )
            governed.append(by if known else "")
            missing.append("" if known else not_judged(self.landing, place, self.redundant))
        carriers = [self.bodies[place.body] for place in places]
        return records(
            PartMargin,
            self,
            "part",
            body=carriers,
            joint=joints,
            strength=strengths,
            governed_by=governed,
            missing=missing,
        )

    @cached_property
    def contacts(self) -> tuple[ContactImpulse, ...]:
        """Impulses, friction and effective masses of the contacts."""
        return records(ContactImpulse, self, "contact", frame=self._feet)[
            : len(self.landing.contacts)
        ]

    @cached_property
    def effective_mass(self) -> float:
        """Effective mass of all contacts together along the ground's normal [kg]; NaN if they
        differ in normal or restitution.

        It is the impulse of the ground for an approach of 1 m/s along the normal, without rebound.
        """
        return mass_of_contacts(self.landing, self.proof.impulse)

    @cached_property
    def stance(self) -> tuple[StanceImpulse, ...]:
        """Impulses of the standing feet."""
        return records(StanceImpulse, self, "contact", frame=self._feet)[
            len(self.landing.contacts) :
        ]

    @property
    def _feet(self) -> list[str]:
        return [block.frame for block in (*self.landing.contacts, *self.landing.stance)]

    @cached_property
    def loads(self) -> tuple[JointLoad, ...]:
        """Impulses through the joints between bodies, and jumps of their rates.

        Where rows depend on one another (redundant contacts, a planar loop closed in space) they
        are those of the contact impulses of minimum norm.
        """
        return records(JointLoad, self, "joint")

    @cached_property
    def bracket(self) -> tuple[Bracket, ...]:
        """Shock with other models of the joints: at the heaviest body's centre of mass and at every
        sensor and point.
        """
        return records(
            Bracket,
            self,
            "point",
            self.bracketed,
            free="shock_free",
            as_modelled="shock",
            locked="shock_locked",
            springs_free="shock_springs_free",
        )

    @property
    def lasts(self) -> bool:
        """Whether the scene says how long the contact lasts, by a pulse or a contact stiffness."""
        return self.landing.pulse is not None or self.scene.yields

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
        if not self.scene.yields:
            return None
        from shockpc.impact.stiffness import compliant_landing

        return compliant_landing(self.landing)

    @cached_property
    def health(self) -> Health:
        """How far to trust the numbers, with the warnings."""
        with one_thread(self.robot.model.nv), self.trace.stage("accuracy and warnings"):
            return self.judge.health(self)

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """What the landing takes for granted: what is not known first, and of that what changes the
        answer most.
        """
        with self.trace.stage("what is taken for granted"):
            return self.judge.unknowns(self)

    @cached_property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What is doubtful of the landing and of its numbers, each with its consequence."""
        with one_thread(self.robot.model.nv):
            return self.judge.warnings(self)

    @property
    def impact_length(self) -> float | None:
        """How long the impact lasts, by a contact stiffness or the pulse of the scene [s]; None
        where neither is given.
        """
        if self.stiffness is not None:
            return float(self.stiffness.duration.max())
        return None if self.landing.pulse is None else self.landing.pulse.length

    @property
    def main_body(self) -> int:
        """The index of the body that an answer is about: the heaviest; with a fixed base the
        landing's `trunk`.
        """
        return (
            self.landing.trunk
            if self.landing.base == "fixed"
            else int(np.argmax(self.robot.masses))
        )

    @property
    def bracketed(self) -> list[Place]:
        """The main body's centre of mass, and every sensor and point that can move."""
        return [body_places(self.robot)[self.main_body], *self.moving_points]

    @property
    def moving_points(self) -> list[Place]:
        """The sensors and points that are fixed neither to the world nor to a fixed base."""
        first = self.robot.movable(self.landing.base).start
        return [place for place in self.landing.points if place.body >= first]

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
        return np.asarray(
            shock_at(self.delta_omega[place.body], self.delta_v[place.body], points, self.v_in)
        )

    def _directions(self, kind: PlaceKind) -> ExtremeDirections:
        keys = ("most_severe_direction", "most_severe", "least_severe_direction", "least_severe")
        return ExtremeDirections(*(self.value(key, kind) for key in keys))
