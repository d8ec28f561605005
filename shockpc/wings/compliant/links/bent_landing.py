"""A landing whose links bend: the same scene on a robot with a body for each segment.

Hinges between the segments of a link swing on springs.

Joint model, posture and motion are those of the rigid robot, so that nothing that the scene says of
joints reaches a hinge.
"""

import functools
from dataclasses import fields, replace
from typing import Any

import numpy as np

from shockpc.core.frozen import frozen
from shockpc.core.spatial import Array
from shockpc.landing.feet.auto_contact import with_faces_of
from shockpc.landing.joint_model import JointModel
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, PlaceKind
from shockpc.method.constraints import Constraint, slices_of
from shockpc.method.dynamics import dynamics, geared_bodies
from shockpc.robot.bodies_and_joints import Loop
from shockpc.text.errors import SceneError
from shockpc.wings.compliant.links.bent_robot import LEAVE_OUT, FlexibleRobot, flexible_robot
from shockpc.wings.compliant.links.flexes import Flex, flexes_of
from shockpc.wings.compliant.links.segments import elastic_frequencies

OF_HINGES = {"drive_stiffness": np.inf, "torque": np.nan}
"""Values of a joint model for hinges; others are zero."""


@frozen(kw_only=True)
class FlexibleLanding(PosedLanding):
    """A landing in one posture, with straight links that bend.

    Attributes:
        rigid: the landing with rigid links.
        flexible: the robot and its segments.
    """

    rigid: PosedLanding
    flexible: FlexibleRobot

    @property
    def hinges(self) -> np.ndarray:
        """The velocities of the hinges."""
        return self.flexible.hinges

    def carried(self, place: Place) -> Place:
        """A place of the rigid landing in this one.

        It is a point on the segment that it moves with, or a joint with its velocities here.
        """
        joint = self._joints.get((place.name, place.body, place.number))
        if joint is not None:
            return joint
        return place._replace(body=self.flexible.body_at(place.body, place.r), centre=False)

    @functools.cached_property
    def points(self) -> tuple[Place, ...]:
        """Places of the rigid landing, carried to this one."""
        return tuple(map(self.carried, self.rigid.points))

    @functools.cached_property
    def parts(self) -> tuple[Place, ...]:
        """Places of the rigid landing, carried to this one."""
        parts = []
        for place in self.rigid.parts:
            parts.append(place if place.joint >= 0 else self.carried(place))
        return tuple(parts)

    @functools.cached_property
    def _joints(self) -> dict[tuple[str, int, int], Place]:
        """The joints of the rigid landing, by name, body and velocity."""
        velocities, segments = self.flexible.v.tolist(), self.flexible.segments
        joints = {}
        for place in self.rigid.places("joint"):
            body, number = segments[place.body][0], velocities[place.number]
            key = place.name, place.body, place.number
            joints[key] = place._replace(body=body, number=number)
        return joints

    def places(self, kind: PlaceKind) -> tuple[Place, ...]:
        """Places of the rigid landing: hinges are no joints, and segments no bodies."""
        if kind not in ("body", "joint"):
            return super().places(kind)
        return tuple(map(self.carried, self.rigid.places(kind)))

    def elastic_frequencies(self, held: bool = False) -> Array:
        """Frequencies of the robot on the springs of its hinges, from the lowest [Hz].

        Its joints are as in the impact: free, with the inertia of their rotors, or locked.

        Args:
            held: whether contacts and standing feet hold it; else it is free, but for its loops.
        """
        equation, hinges = self.equation(self.state), self.hinges
        acts = []
        for constraint in self.constraints:
            acts += [held or constraint.kind == "closure"] * constraint.size
        rows = np.eye(len(self.flexible.stiffness))[hinges]
        if equation.G is not None:
            rows = equation.G[0, hinges]
        # Motions that no row which acts stops.
        _, size, V = np.linalg.svd(equation.J_c[0, np.array(acts, dtype=bool)])
        rank = int(np.count_nonzero(size > 1e-9 * size.max(initial=0.0)))
        basis = V[rank:].T
        M = basis.T @ equation.H[0] @ basis
        return elastic_frequencies(M, rows @ basis, self.flexible.stiffness[hinges])


def flexible_landing(
    landing: PosedLanding, flexes: tuple[tuple[str, Flex], ...] | None = None
) -> FlexibleLanding:
    """The landing with links that bend.

    Args:
        landing: with rigid links.
        flexes: how links bend, each with its name or a glob; as the scene says by default.

    Raises:
        SceneError: the scene says nothing of how a link bends, or the base is fixed to the world
            and bends.
        UnknownName: a pattern fits no link.
        RobotError: a link cannot bend.
    """
    robot = landing.robot
    if flexes is None:
        flexes = flexes_of(landing.scene.flex)
    ends = []
    for constraint in (*landing.contacts, *landing.stance):
        if constraint.kind != "stop":
            frame = robot.frame(constraint.frame)
            ends.append((frame.body, tuple(frame.offset.tolist())))
    joints = landing.joint_model
    rotors = []
    for v, body in geared_bodies(robot, joints.coupling):
        rotors.append((body, float(joints.coupling[v] * joints.per_turn[v])))
    flexible = flexible_robot(robot, flexes, tuple(ends), tuple(rotors))
    if landing.base == "fixed" and robot.free_base and 0 in flexible.divisions:
        name = robot.bodies[0].name
        raise SceneError(
            f'link "{name}" cannot bend, because it is fixed to the world; {LEAVE_OUT}',
            bodies=[name],
        )
    # The face of a sole that carries is that of the robot whose links bend.
    faced = with_faces_of(landing, lambda flat: _with_springs_as_inertia(_bent(flat, flexible)))
    return _bent(faced, flexible)


def _bent(landing: PosedLanding, flexible: FlexibleRobot) -> FlexibleLanding:
    """A landing on the robot whose links bend. Args: landing, with rigid links."""
    contacts, stance = len(landing.contacts), len(landing.stance)
    constraints = []
    for constraint in landing.without_stops.constraints[: contacts + stance]:
        constraints.append(_on_segments(flexible, constraint))
    model = _joint_model(landing.joint_model, flexible)
    q, rates = flexible.configuration(landing.q), np.zeros(landing.robot.model.nv)
    rates = flexible.velocities(landing.before.joint_rates + rates)
    values = {part.name: getattr(landing, part.name) for part in fields(PosedLanding)}
    values |= {
        "robot": flexible.robot,
        "contacts": tuple(constraints[:contacts]),
        "stance": tuple(constraints[contacts:]),
        "loops": tuple(_loop_on_segments(flexible, loop) for loop in landing.loops),
        "joint_model": model,
        "before": landing.before._replace(joint_rates=rates),
        "q": q,
        "state": dynamics(flexible.robot, q[None], model),
        "acting": (),
    }
    return FlexibleLanding(**values, rigid=landing, flexible=flexible)


def _joint_model(model: JointModel, flexible: FlexibleRobot) -> JointModel:
    """The joint model of a robot whose links bend, with the springs of its hinges."""
    values: dict[str, Any] = {}
    for name, value in model._asdict().items():
        if isinstance(value, np.ndarray):
            values[name] = flexible.velocities(value, OF_HINGES.get(name, 0.0))
    values["stiffness"] = values["stiffness"] + flexible.stiffness
    return model._replace(**values)


def _with_springs_as_inertia(landing: FlexibleLanding) -> FlexibleLanding:
    """The landing with the inertia k / ω² of each hinge.

    A hinge of stiffness k has it in a contact of frequency ω.

    What of a sole carries follows from it: links that are stiff against the contact are rigid then,
    and the hinges of soft ones are free. Of the energy that the rigid robot would lose, ω² = K Σ v²
    / (b · f), with the stiffness K of the contacts, their speeds v, all speeds b and impulses f.
    """
    stiffness = landing.scene.contact_stiffness
    if stiffness is None:
        return landing
    equation = landing.rigid.equation(landing.rigid.state)
    J, b = equation.J_c[0], equation.b[0, :, 3]
    # J H⁻¹ Jᵀ f = b
    delassus = J @ np.linalg.solve(equation.H[0], J.T)
    impulse = np.linalg.lstsq(delassus, b, rcond=1e-10)[0]
    squares = 0.0
    for rows, constraint in zip(slices_of(equation.constraints), landing.contacts, strict=False):
        squares += float(np.sum(b[rows][: len(constraint.forces)] ** 2))
    squared_frequency = stiffness * squares / float(b @ impulse)
    model, hinges = landing.joint_model, landing.hinges
    armature = model.armature.copy()
    armature[hinges] += landing.flexible.stiffness[hinges] / squared_frequency
    model = model._replace(armature=armature)
    return replace(
        landing, joint_model=model, state=dynamics(landing.robot, landing.q[None], model)
    )


def _on_segments(flexible: FlexibleRobot, constraint: Constraint) -> Constraint:
    """The rows of a contact or of an end stop on the segments that they act on.

    Each contact is where it is in this posture.
    """
    if constraint.kind == "stop":
        body = flexible.segments[constraint.body][0]
        return constraint._replace(
            body=body, other_body=flexible.robot.parents[body], axes_body=body
        )
    return constraint._replace(body=flexible.body_at(constraint.body, constraint.point), lowest=())


def _loop_on_segments(flexible: FlexibleRobot, loop: Loop) -> Loop:
    """A loop whose ends are on the segments that they are on."""
    first, second = (
        flexible.body_at(body, point) for body, point in zip(loop.bodies, loop.points, strict=True)
    )
    return loop._replace(bodies=(first, second))
