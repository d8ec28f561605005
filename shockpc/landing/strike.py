"""The velocity with which a robot strikes the ground, as a scene states it."""

import math
from collections.abc import Collection, Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING

from shockpc.core.frozen import frozen
from shockpc.landing.record import STRIKE, Record, documented, option
from shockpc.text.errors import SceneError

if TYPE_CHECKING:
    from shockpc.core.spatial import Array, Plane

GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s²]: converts a drop height to a speed."""

SLOWEST, FASTEST = 1e-9, 1e9
"""Range of speeds [m/s]; outside it squares overflow or underflow."""


@documented
@frozen(kw_only=True)
class Strike(Record):
    """Velocity of the robot relative to the ground before the impact; 1 m/s straight down by
    default.

    The velocity of the base frame's origin is given as speed and angle, as a vector or by a drop
    height. The rotation of the base and the joint velocities are superposed.

    Attributes:
        joint_velocities: joint velocities by name or glob [rad/s; m/s for a prismatic joint].
    """

    speed: float | None = option(
        None,
        "Speed along --strike-angle.",
        STRIKE,
        "V",
        unit="m/s",
        above=0.0,
        varies=True,
        default="1",
    )
    strike_angle_deg: float | None = option(
        None,
        "Angle from vertical, positive forward; of the velocity, in the plane.",
        STRIKE,
        "DEG",
        unit="deg",
        varies=True,
    )
    velocity: tuple[float, float, float] | None = option(
        None, "Velocity of the robot, world axes.", STRIKE, "VX,VY,VZ", unit="m/s"
    )
    drop_height: float | None = option(
        None,
        "Height of a free fall before the impact. It gives the vertical velocity; --strike-angle "
        "or --forward-speed adds a horizontal one.",
        STRIKE,
        "H",
        unit="m",
        above=0.0,
    )
    forward_speed: float | None = option(
        None,
        "Horizontal speed in the plane after the fall from --drop-height.",
        STRIKE,
        "V",
        unit="m/s",
    )
    angular_velocity: tuple[float, float, float] | None = option(
        None, "Angular velocity of the base, world axes.", STRIKE, "WX,WY,WZ", unit="rad/s"
    )
    joint_velocities: Mapping[str, float] = field(default_factory=dict)

    def turned(self, angle: float, plane: "Plane") -> "Strike":
        """The same at another strike angle [deg].

        The part of the velocity that is in the plane turns, and the part out of the plane stays;
        after a fall from a drop height the vertical component stays, and the forward one changes.

        Raises:
            SceneError: as for `vector`.
        """
        if self.velocity is None:
            return replace(self, strike_angle_deg=angle, forward_speed=None)
        velocity, theta = self.vector(plane), math.radians(angle)
        within = velocity - (velocity @ plane.normal) * plane.normal
        turned = (
            velocity
            - within
            + math.hypot(*within) * (math.sin(theta) * plane.forward - [0.0, 0.0, math.cos(theta)])
        )
        return replace(self, velocity=tuple(turned.tolist()))

    def vector(self, plane: "Plane") -> "Array":
        """The velocity (3,) in world axes [m/s]: speed · (sin θ · forward − cos θ · z).

        Down is −z of the world for every plane. Forward is the horizontal direction in the plane
        with a positive x component, or a positive y component if the plane is perpendicular to x.

        Raises:
            SceneError: it is given in two ways at once, the speed is out of range, or an angle is
                given in a horizontal plane.
        """
        import numpy as np

        ways = [self.speed is not None, self.velocity is not None, self.drop_height is not None]
        angles = self.strike_angle_deg is not None, self.forward_speed is not None
        if sum(ways) > 1 or all(angles) or (self.velocity is not None and any(angles)):
            raise SceneError(
                "the contact velocity is given in two ways; keep one of: speed with strike angle, "
                "velocity, drop height with strike angle or forward speed"
            )
        if self.forward_speed is not None and self.drop_height is None:
            raise SceneError(
                "a forward speed is given without a drop height; give both, or the velocity"
            )
        theta = math.radians(self.strike_angle_deg or 0.0)
        if self.velocity is not None:
            speed = max(map(abs, self.velocity))
        else:
            what, unit, size = "strike speed", "m/s", 1.0 if self.speed is None else self.speed
            if self.drop_height is not None:
                what, unit, size = "drop height", "m", self.drop_height
            if not size > 0.0:
                raise SceneError(
                    f"a {what} of {size:g} {unit} gives no impact; it has to be above zero"
                )
            speed = size if self.drop_height is None else math.sqrt(2.0 * GRAVITY * size)
            if not abs(theta) <= math.pi:
                raise SceneError(
                    f"a strike angle of {self.strike_angle_deg:g} deg is not valid; it must lie in "
                    f"[-180, 180] deg"
                )
            if self.drop_height is not None:
                theta = math.atan2(self.forward_speed, speed) if self.forward_speed else theta
                if not abs(theta) < math.pi / 2.0 * (1.0 - 1e-9):
                    raise SceneError(
                        f"after a fall the strike angle has to lie between -90 and 90 deg, and it "
                        f"is {math.degrees(theta):g} deg"
                    )
                speed = speed / math.cos(theta)
            if theta and plane.level:
                raise SceneError(
                    "no strike angle is defined in a horizontal plane; give the strike's velocity"
                )
        if not (speed == 0.0 or SLOWEST <= speed <= FASTEST):
            raise SceneError(
                f"a strike at {speed:g} m/s cannot be computed; its speed has to lie between "
                f"{SLOWEST:g} and {FASTEST:g} m/s"
            )
        if self.velocity is not None:
            return np.array(self.velocity, dtype=float)
        return np.asarray(
            speed * (math.sin(theta) * plane.forward - math.cos(theta) * np.array([0.0, 0.0, 1.0]))
        )


def replaced_ways(given: Collection[str]) -> tuple[str, ...]:
    """The fields of a strike that others replace: one way of giving the velocity takes the place of
    another.

    A vector or a drop height says all of it, a speed keeps the angle, and an angle keeps the speed
    or the drop height.

    Args:
        given: names of the fields that replace others.
    """
    if "velocity" in given or "drop_height" in given:
        return "speed", "strike_angle_deg", "velocity", "drop_height", "forward_speed"
    if "speed" in given:
        return "velocity", "drop_height", "forward_speed"
    if "strike_angle_deg" in given or "forward_speed" in given:
        return "velocity", "strike_angle_deg", "forward_speed"
    return ()
