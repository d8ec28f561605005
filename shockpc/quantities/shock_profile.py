"""The result of an analysis: a landing and its proof; all other numbers are quantities."""

import pkgutil
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from shockpc.core.frozen import frozen
from shockpc.core.most_severe import ExtremeDirections
from shockpc.core.number import numbers_from
from shockpc.core.percussion import shock_at
from shockpc.core.spatial import Array, Plane, freeze, read_only
from shockpc.core.threads import one_thread
from shockpc.impact.landing_motion import LandingMotion, motion_of
from shockpc.landing.closure import Assembly
from shockpc.landing.places import Place, body_places
from shockpc.landing.posture import spelled_out
from shockpc.landing.scenes.scene import Scene
from shockpc.quantities.attribute import (
    OfQuantity,
    each_flag,
    each_value,
    only_number,
    only_number_or_none,
    only_vector,
)
from shockpc.quantities.contact_mass import mass_of_contacts
from shockpc.quantities.records import (
    Bracket,
    ContactImpulse,
    JointLoad,
    PartMargin,
    PointShock,
    StanceImpulse,
    brackets,
    contact_impulses,
    directions_of,
    joint_loads,
    part_margins,
    point_shocks,
    stance_impulses,
)
from shockpc.quantities.renamed import renamed_attribute
from shockpc.quantities.trust import Unknown
from shockpc.quantities.values import LandingValues
from shockpc.text.arguments import checked
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.display import brief, show_page, shown_by
from shockpc.text.errors import SceneError

if TYPE_CHECKING:
    from shockpc.impact.friction import FrictionResult


@frozen()
class ShockProfile(LandingValues):
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

    def __repr__(self) -> str:
        texts = [f"unknown: {unknown}" for unknown in self.unknowns if not unknown.known]
        return brief(self, repr(self.landing), *texts)

    _repr_html_ = shown_by("studies.analyze.report:landing_report")

    def show(self) -> None:
        """Show the landing in three dimensions, as in report.html.

        It is shown in the cell of a notebook, else in a browser.

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
        """The scene that lands, with every default filled in.

        In place of a posture that is computed it has the values of its joints.
        """
        return spelled_out(self.landing.scene, self.robot)

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
        """The model of the joints: "free", "geared", "locked" or "mixed".

        "free" has no reflected inertia; "geared" has some at every joint; of "locked" every
        joint holds.
        """
        return self.landing.joint_model.name

    @property
    def assembly(self) -> Assembly | None:
        """Changes by closing the loops; None without loops."""
        return self.landing.assembly

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return tuple(body.name for body in self.robot.bodies)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """A quantity by its former key."""
            return renamed_attribute(self, name)

    v_in = OfQuantity("robot", only_number)
    position = OfQuantity("body", each_value)
    copc = OfQuantity("body", each_value)
    copc_world = OfQuantity("body", each_value)
    ropc = OfQuantity("body", each_value)
    translates = OfQuantity("body", each_flag)
    screw_pitch = OfQuantity("body", each_value)
    out_of_plane_share = OfQuantity("body", each_value)
    shock_com = OfQuantity("body", each_value)
    shock_min = OfQuantity("body", each_value)
    shock_max = OfQuantity("body", each_value)
    total_impulse = OfQuantity("robot", only_vector)
    total_moment = OfQuantity("robot", only_vector)
    energy_lost = OfQuantity("robot", only_number)
    energy_share = OfQuantity("robot", only_number_or_none)

    @property
    def reference_velocities(self) -> Array:
        """(k, 3) velocities before the impact of which the fastest has the speed `v_in` [m/s].

        They are those of the contacts, or of the centre of mass.
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
        """Jumps (nb, 6, 3) of bodies, (Δω, Δv) in their axes, for unit strikes along world axes."""
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
        return directions_of(self, "body")

    @cached_property
    def points(self) -> tuple[PointShock, ...]:
        """Shock at sensors and points."""
        return point_shocks(self)

    @cached_property
    def parts(self) -> tuple[PartMargin, ...]:
        """Margins of the scene's parts."""
        return part_margins(self)

    @cached_property
    def contacts(self) -> tuple[ContactImpulse, ...]:
        """Impulses, friction and effective masses of the contacts."""
        return contact_impulses(self)

    @cached_property
    def stance(self) -> tuple[StanceImpulse, ...]:
        """Impulses of the standing feet."""
        return stance_impulses(self)

    @cached_property
    def loads(self) -> tuple[JointLoad, ...]:
        """Impulses through the joints between bodies, and jumps of their rates.

        Where rows depend on one another (redundant contacts, a planar loop closed in space) they
        are those of the contact impulses of minimum norm.
        """
        return joint_loads(self)

    @cached_property
    def bracket(self) -> tuple[Bracket, ...]:
        """Shock with other models of the joints.

        The places are the heaviest body's centre of mass, and every sensor and point.
        """
        return brackets(self, self.bracketed)

    @cached_property
    def effective_mass(self) -> float:
        """Effective mass of all contacts together along the ground's normal [kg].

        It is the impulse of the ground for an approach of 1 m/s along the normal, without rebound;
        NaN if the contacts differ in normal or restitution.
        """
        return mass_of_contacts(self.landing, self.proof.impulse)

    @property
    def lasts(self) -> bool:
        """True if the scene says how long the contact lasts, by a pulse or a contact stiffness."""
        return self.landing.pulse is not None or self.scene.yields

    @property
    def friction(self) -> "FrictionResult | None":
        """The landing with the scene's friction; None if it gives none."""
        if self.scene.friction is None:
            return None
        from shockpc.impact.friction import friction_of

        return friction_of(self.landing)

    @property
    def stiffness(self) -> LandingMotion | None:
        """The landing over time; None where the scene gives no stiffness of the contacts."""
        return motion_of(self.landing)

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Assumptions of the landing: first those that nobody knows.

        Of these, what changes the answer most comes first.
        """
        with self.trace.stage("what is taken for granted"):
            return self.judge.unknowns(self)

    @cached_property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Warnings of the landing and of its numbers, each with its consequence."""
        with one_thread(self.robot.model.nv):
            return self.judge.warnings(self)

    @property
    def impact_length(self) -> float | None:
        """Duration of the impact, by a contact stiffness or the pulse of the scene [s].

        It is None where neither is given.
        """
        if self.stiffness is not None:
            return float(self.stiffness.duration.max())
        return None if self.landing.pulse is None else self.landing.pulse.length

    @property
    def main_body(self) -> int:
        """Index of the body that an answer is about.

        It is the heaviest; with a fixed base the landing's `trunk`.
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

    @checked
    def shock_at(self, frame: str, r: Array | Sequence[Any]) -> Array:
        """Shock at points of a body, |Δv + Δω × r| / v_in [1].

        Args:
            frame: name of the body, or of a link, joint or site on it.
            r: (..., 3) from the origin of that frame, in its axes [m].

        Raises:
            UnknownName: the robot has no such frame.
            SceneError: r is not made of points of three numbers.
            StudyError: an argument is of another type.
        """
        place = self.robot.frame(frame)
        points = place.offset + _points(r) @ place.rotation.T
        if place.body < 0:
            return np.zeros(points.shape[:-1])
        return np.asarray(
            shock_at(self.delta_omega[place.body], self.delta_v[place.body], points, self.v_in)
        )


def _points(r: Any) -> Array:
    """Points (..., 3) as they are given.

    Raises:
        SceneError: they are not of three numbers each.
    """
    try:
        points = numbers_from(r)
    except (TypeError, ValueError):
        points = np.array(np.nan)
    if points.shape[-1:] != (3,):
        raise SceneError(
            f"r has shape {points.shape} or no numbers; give points of three numbers, (..., 3)"
        )
    return np.asarray(points)
