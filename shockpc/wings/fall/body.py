"""A robot whose joints are held: one rigid body with points on its surface, as a fall sees it.

World axes, with the origin at the base of the robot in its posture.
"""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from shockpc.core.spatial import Array, quaternion_of
from shockpc.impact.landed import without_kinetic_energy
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.geometry import Outline, drawn_outline, outline
from shockpc.robot.shapes.mesh import hull
from shockpc.robot.usual_base import usual_base
from shockpc.text.errors import StudyError
from shockpc.wings.fall.cross_section import CrossSection

UP = np.array([0.0, 0.0, 1.0])

POINT = Contact(frame="", at="frame", kind="point")
"""The contact of a fall: a point where the geometry of the whole robot meets the ground."""

CORNERS = 720
"""Corners of a round shape in the plane of a fall.

The polygon is inside the shape by at most a part in 100 000 of its radius.
"""


class Spot(NamedTuple):
    """A point where a link meets the ground: the link's name, and the point (3,) [m].

    The point is in the posture.
    """

    link: str
    point: Array


@dataclass(frozen=True, eq=False)
class Rigid:
    """A robot with its joints held.

    Attributes:
        posture_scene: the scene of its posture.
        landing: that posture.
        mass: [kg]
        com: (3,) centre of mass [m].
        inertia: (3, 3) about it [kg m²].
        coms: (nb, 3) of the bodies [m].
        shapes: of all links, in the posture.
        visual: names of links whose visual geometry is used, because they have no collision
            geometry.
    """

    posture_scene: Scene
    landing: PosedLanding
    mass: float
    com: Array
    inertia: Array
    coms: Array
    shapes: tuple[Shape, ...] = field(repr=False)
    visual: tuple[str, ...]

    @classmethod
    def of(cls, scene: Scene, robot: Robot) -> "Rigid":
        """The robot in the posture of a scene.

        Raises:
            ShockError: the posture is not possible, or its inertia is not one of a mechanism.
            StudyError: the robot cannot fall, or has no geometry.
        """
        if not robot.free_base or (scene.base or usual_base(robot).base) != "free":
            raise StudyError(
                f'the base of robot "{robot.name}" does not move freely, so it does not fall; give '
                f"--base free"
            )
        landing = landing_of(
            replace(scene, contact=(replace(POINT, frame=robot.bodies[0].name),), stance=()), robot
        )
        if not np.isfinite(landing.equation(landing.state).H).all():
            raise without_kinetic_energy(landing, landing.state.H)
        rotation = landing.state.rotation[0]
        position = landing.state.position[0]
        mass = robot.masses.sum()
        coms = position + (rotation @ robot.coms[..., None])[..., 0]
        com = robot.masses @ coms / mass
        solid = _placed(outline(robot, "collision"), landing)
        links = {shape.link for shape in solid}
        visual = _placed(drawn_outline(robot), landing)
        drawn = [shape for shape in visual if shape.link not in links]
        if not solid and not drawn:
            raise StudyError(
                f'robot "{robot.name}" has neither collision nor visual geometry, so nothing of it '
                f"meets the ground"
            )
        return cls(
            posture_scene=scene,
            landing=landing,
            mass=float(mass),
            com=com,
            inertia=_inertia(robot, rotation, coms - com),
            coms=coms,
            shapes=tuple(_corners_only(shape) for shape in (*solid, *drawn)),
            visual=tuple(dict.fromkeys(shape.link for shape in drawn)),
        )

    def points(self, directions: Array) -> tuple[Array, np.ndarray]:
        """Points (n, 3) of the surface [m], and the link of each (n,).

        Those that reach farthest along the unit vectors (m, 3) are among them.
        """
        points, links = [], []
        for shape in self.shapes:
            surface = shape.points
            if shape.rounding.any():
                # An ellipsoid A u, |u| = 1, reaches farthest along d at u = Aᵀd / |Aᵀd|.
                along = directions @ shape.rounding
                length = np.linalg.norm(along, axis=1, keepdims=True)
                extends = length > 1e-6 * np.abs(shape.rounding).max()
                u = np.divide(along, length, out=np.zeros_like(along), where=extends)
                surface = (surface[:, None] + u @ shape.rounding.T).reshape(-1, 3)
            points.append(surface)
            links += [shape.link] * len(surface)
        return np.concatenate(points), np.array(links)

    def section(self, forward: Array) -> CrossSection:
        """The robot in the plane in which it tips. Args: forward, (3,) level unit vector."""
        angle = 2.0 * math.pi * np.arange(CORNERS) / CORNERS
        points, _ = self.points(np.outer(np.cos(angle), forward) + np.outer(np.sin(angle), UP))
        left = np.cross(UP, forward)
        return CrossSection.of(
            self.mass,
            float(left @ self.inertia @ left),
            (points - self.com) @ np.stack([forward, UP], axis=1),
        )

    def support(self, together: float) -> Array:
        """Corners (k, 2) of the support, anticlockwise; two for a line, or one.

        They are in world x and y from the centre of mass [m].

        Args:
            together: height up to which points are on the ground, and distance from a side up to
                which a corner is left out [m].
        """
        # Down, and tilted from it by 1 mrad all around: a round edge then has its points too.
        ring = 2.0 * math.pi * np.arange(64) / 64
        tilted = np.stack([1e-3 * np.cos(ring), 1e-3 * np.sin(ring), -np.ones(64)], axis=1)
        points, _ = self.points(np.vstack([-UP, tilted]))
        on_ground = points[:, 2] <= points[:, 2].min() + together
        low = points[on_ground][:, :2] - self.com[:2]

        # The extent along the longest direction of the points, and across it.
        centre = low.mean(axis=0)
        directions = np.linalg.svd(low - centre, full_matrices=False)[2]
        extent = np.ptp((low - centre) @ directions.T, axis=0)
        if extent[0] <= together:
            return np.asarray(centre[None])
        if len(low) < 3 or extent[1] <= together:
            along = (low - centre) @ directions[0]
            return np.asarray(low[[int(np.argmin(along)), int(np.argmax(along))]])
        return _without_flat_corners(low[ConvexHull(low).vertices], together)

    def edge(self, heading: float, together: float) -> tuple[Array, Array]:
        """The side of the support over which the robot tips along a heading.

        The heading is from forward to the left [rad].

        That is the side that the vertical plane through the centre of mass along the heading
        crosses. If the support is a point, or each side is turned from the heading by more than
        45 deg, it is the farthest corner along the heading: a side without length.

        Returns: (3,) level unit vector across it, away from the support; its ends (2,), to the left
        from the centre of mass [m].
        """
        wanted = np.array([math.cos(heading), math.sin(heading)])
        corners = self.support(together)
        farthest = corners[np.argmax(corners @ wanted)]
        normal, ends = wanted, np.array([farthest, farthest])
        nearest = math.inf
        sides = list(zip(corners, np.roll(corners, -1, axis=0), strict=True))
        if len(corners) == 1:
            sides = []
        for a, b in sides:
            along = (b - a) / np.linalg.norm(b - a)
            across = np.array([along[1], -along[0]])
            toward = float(wanted @ across)
            if toward <= math.cos(math.radians(45.0)):
                continue
            # The heading crosses the line of the side at distance · wanted:
            # a · across = distance (wanted · across).  It is 0 if the side is behind the centre.
            distance = max(float(a @ across), 0.0) / toward
            crossing = float(distance * wanted @ along)
            low, high = sorted((float(a @ along), float(b @ along)))
            outside = max(low - crossing, crossing - high, 0.0)
            if outside < nearest - together:
                nearest = outside
                normal, ends = across, np.array([a, b])
        x, y = normal
        return np.array([x, y, 0.0]), np.sort(ends @ [-y, x])

    def on_ground(self, rotation: Array, together: float) -> tuple[Array, np.ndarray]:
        """Points (n, 3) of the surface on the ground in an attitude, and their links (n,).

        The points are from the centre of mass, world axes [m].

        Args:
            rotation: (3, 3) from the posture.
            together: height above the lowest point up to which points are on the ground [m].
        """
        points, links = self.points(-rotation[2:])
        turned = (points - self.com) @ rotation.T
        near = turned[:, 2] <= turned[:, 2].min() + together
        return turned[near], links[near]

    def spots(self, rotation: Array, points: Array, links: np.ndarray) -> tuple[Spot, ...]:
        """The points where bodies meet the ground, one for each body.

        Each is the middle of its points, as `on_ground` gives them, on its lowest link.
        """
        frames, spots = self.landing.robot.frames, []
        bodies = np.array([frames[link].body for link in links.tolist()])
        for body in dict.fromkeys(bodies[np.argsort(points[:, 2], kind="stable")].tolist()):
            of_body = np.flatnonzero(bodies == body)
            lowest = of_body[np.argmin(points[of_body, 2])]
            middle = np.append(
                (points[of_body].min(axis=0) + points[of_body].max(axis=0))[:2] / 2.0,
                points[lowest, 2],
            )
            spots.append(Spot(str(links[lowest]), self.com + middle @ rotation))
        return tuple(spots)

    def scene(
        self,
        rotation: Array,
        velocity: Array,
        omega: Array,
        struck: tuple[Spot, ...],
        stands: tuple[Spot, ...],
        slides: bool = False,
    ) -> Scene:
        """The landing in an attitude, on what strikes and on what slides on the ground then.

        Args:
            rotation: (3, 3) from the posture.
            velocity: (3,) of the centre of mass [m/s].
            omega: (3,) angular velocity [rad/s], world axes.
            struck: what strikes.
            stands: what is on the ground already.
            slides: whether that slides.
        """
        scene = self.posture_scene
        base = rotation @ self.landing.state.rotation[0, 0]
        quaternion = quaternion_of(base @ self.landing.robot.bodies[0].rotation.T)
        ground = min(float(rotation[2] @ spot.point) for spot in (*struck, *stands))
        posture = replace(
            scene.posture,
            base_rpy_deg=None,
            base_quaternion=tuple(quaternion / np.linalg.norm(quaternion)),
            base_position=(0.0, 0.0, -ground),
        )
        at_base = velocity - np.cross(omega, rotation @ self.com)
        strike = replace(
            scene.strike,
            speed=None,
            strike_angle_deg=None,
            drop_height=None,
            forward_speed=None,
            velocity=tuple(at_base.tolist()),
            angular_velocity=tuple(omega.tolist()) if omega.any() else None,
        )
        contacts = [replace(POINT, frame=spot.link, offset=self._offset(spot)) for spot in struck]
        standing: list[str] = []
        for spot in stands:
            offset = self._offset(spot)
            if not slides:
                standing.append(f"{spot.link}:" + ",".join(map(repr, offset)))
                continue
            arm = rotation @ (spot.point - self.com)
            x, y, _ = (velocity + np.cross(omega, arm)).tolist()
            contacts.append(replace(POINT, frame=spot.link, offset=offset, velocity=(x, y, 0.0)))
        return replace(
            scene,
            posture=posture,
            strike=strike,
            contact=tuple(contacts),
            stance=tuple(standing),
        )

    def _offset(self, spot: Spot) -> tuple[float, float, float]:
        """A point in the frame of its link [m]."""
        frame = self.landing.robot.frames[spot.link]
        state = self.landing.state
        arm = spot.point - state.position[0, frame.body]
        r = state.rotation[0, frame.body].T @ arm
        x, y, z = (frame.rotation.T @ (r - frame.offset)).tolist()
        return x, y, z


def tilt(forward: Array, angle: float) -> Array:
    """The rotation (3, 3) of a robot that tips by an angle [rad] along a level unit vector."""
    return np.asarray(Rotation.from_rotvec(angle * np.cross(UP, forward)).as_matrix())


def _placed(of_robot: Outline, landing: PosedLanding) -> list[Shape]:
    """The shapes of a robot in the posture of a landing."""
    shapes = []
    for i, carried in enumerate(of_robot.shapes):
        for shape in carried:
            placed = shape.placed(landing.state.rotation[0, i], landing.state.position[0, i])
            shapes.append(placed)
    return shapes


def _without_flat_corners(corners: Array, least: float) -> Array:
    """A convex polygon (k, 2) without corners nearer than `least` to the line past them [m].

    That line joins the corners before and after. At least three corners remain.
    """
    while len(corners) > 3:
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        chord, arm = after - before, corners - before
        # |chord × arm| / |chord|
        area = np.abs(chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0])
        distance = area / np.linalg.norm(chord, axis=1)
        if distance.min() > least:
            break
        corners = np.delete(corners, int(np.argmin(distance)), axis=0)
    return np.asarray(corners)


def _corners_only(shape: Shape) -> Shape:
    """A mesh as the corners of its hull; as it is if all lie in a plane.

    A body would pivot about vertices that rounding puts above a side of its hull, too.
    """
    if shape.mesh is None or len(shape.points) <= 4:
        return shape
    convex = hull(shape.points)
    return shape if convex is None else shape._replace(points=shape.points[convex.vertices])


def _inertia(robot: Robot, rotation: Array, arms: Array) -> Array:
    """Inertia (3, 3) about the centre of mass [kg m²]: Σ R I Rᵀ + Σ m (|r|² 1 − r rᵀ).

    Args:
        robot: the robot.
        rotation: R (nb, 3, 3) of the bodies.
        arms: r (nb, 3) from the centre of mass to theirs [m].
    """
    squares = np.einsum("i,ij,ij->", robot.masses, arms, arms)
    spread = squares * np.eye(3) - np.einsum("i,ij,ik->jk", robot.masses, arms, arms)
    of_bodies = rotation @ robot.inertias @ rotation.transpose(0, 2, 1)
    return np.asarray(np.sum(of_bodies, axis=0) + spread)
