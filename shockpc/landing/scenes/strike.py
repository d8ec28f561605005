"""The velocity with which a robot strikes the ground, as a scene states it."""

import math
from collections.abc import Collection, Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING

from shockpc.core.frozen import frozen
from shockpc.landing.scenes.scene_fields import STRIKE, Record, documented, option
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
    """Velocity of the robot relative to the ground before the impact.

    By default it is 1 m/s straight down.

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
        "adds a horizontal one, as does forward_speed in a scene.",
        STRIKE,
        "H",
        unit="m",
        above=0.0,
    )
    forward_speed: float | None = option(
        None,
        "Horizontal speed in the plane after the fall from drop_height.",
        STRIKE,
        unit="m/s",
        on_command_line=False,
    )
    angular_velocity: tuple[float, float, float] | None = option(
        None, "Angular velocity of the base, world axes.", STRIKE, "WX,WY,WZ", unit="rad/s"
    )
    joint_velocities: Mapping[str, float] = field(default_factory=dict)

    def turned(self, angle: float, plane: "Plane") -> "Strike":
        """The motion at another strike angle [deg].

        The part of the velocity that is in the plane turns, and the part out of the plane stays;
        after a fall from a drop height the vertical component stays, and the forward one changes.

        Raises:
            SceneError: as for `vector`.
        """
        if self.velocity is None:
            return replace(self, strike_angle_deg=angle, forward_speed=None)
        _refuse_horizontal(plane)
        velocity = self.vector(plane)
        within = velocity - (velocity @ plane.normal) * plane.normal
        direction = _direction(math.radians(angle), plane)
        turned = velocity - within + math.hypot(*within) * direction
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

        self._refuse_two_ways()
        if self.velocity is not None:
            _refuse_out_of_range(max(map(abs, self.velocity)))
            return np.array(self.velocity, dtype=float)
        speed, theta = self._after_fall() if self.drop_height is not None else self._stated()
        if theta:
            _refuse_horizontal(plane)
        _refuse_out_of_range(speed)
        return np.asarray(speed * _direction(theta, plane))

    def _refuse_two_ways(self) -> None:
        """Refuse a velocity that is given in two ways, or in a part of one."""
        ways = [self.speed is not None, self.velocity is not None, self.drop_height is not None]
        angles = [self.strike_angle_deg is not None, self.forward_speed is not None]
        has_direction_twice = self.velocity is not None and any(angles)
        if sum(ways) > 1 or all(angles) or has_direction_twice:
            raise SceneError(
                "the contact velocity is given in two ways; keep one of: speed with strike angle, "
                "velocity, drop height with strike angle or forward speed"
            )
        if self.forward_speed is not None and self.drop_height is None:
            raise SceneError(
                "a forward speed is given without a drop height; give both, or the velocity"
            )

    def _stated(self) -> tuple[float, float]:
        """The speed [m/s] and the angle θ [rad] that are stated."""
        speed = 1.0 if self.speed is None else self.speed
        _refuse_no_impact("strike speed", speed, "m/s")
        return speed, self._angle()

    def _after_fall(self) -> tuple[float, float]:
        """The speed [m/s] and the angle θ [rad] after a fall, v = √(2 g h) / cos θ.

        θ is given, or follows from the forward speed.
        """
        height = self.drop_height or 0.0
        _refuse_no_impact("drop height", height, "m")
        vertical = math.sqrt(2.0 * GRAVITY * height)
        theta = self._angle()
        if self.forward_speed:
            theta = math.atan2(self.forward_speed, vertical)
        if not abs(theta) < math.pi / 2.0 * (1.0 - 1e-9):
            raise SceneError(
                f"after a fall the strike angle has to lie between -90 and 90 deg, and it "
                f"is {math.degrees(theta):g} deg"
            )
        return vertical / math.cos(theta), theta

    def _angle(self) -> float:
        """The strike angle [rad]; 0 by default."""
        theta = math.radians(self.strike_angle_deg or 0.0)
        if not abs(theta) <= math.pi:
            raise SceneError(
                f"a strike angle of {self.strike_angle_deg:g} deg is not valid; it must lie in "
                f"[-180, 180] deg"
            )
        return theta


def _refuse_horizontal(plane: "Plane") -> None:
    """Refuse a strike angle in a plane without a vertical from which it is measured."""
    if plane.level:
        raise SceneError(
            "no strike angle is defined in a horizontal plane; choose another plane, or give the "
            "velocity without an angle"
        )


def _direction(theta: float, plane: "Plane") -> "Array":
    """The unit vector sin θ · forward − cos θ · z (3,), world axes."""
    down = [0.0, 0.0, math.cos(theta)]
    return math.sin(theta) * plane.forward - down


def _refuse_no_impact(quantity: str, size: float, unit: str) -> None:
    if not size > 0.0:
        raise SceneError(
            f"a {quantity} of {size:g} {unit} gives no impact; it has to be above zero"
        )


def _refuse_out_of_range(speed: float) -> None:
    if not (speed == 0.0 or SLOWEST <= speed <= FASTEST):
        raise SceneError(
            f"a contact speed of {speed:g} m/s cannot be computed; it has to lie between "
            f"{SLOWEST:g} and {FASTEST:g} m/s"
        )


def replaced_ways(names: Collection[str]) -> tuple[str, ...]:
    """The fields of a strike that others replace.

    One way of giving the velocity takes the place of another.

    A vector or a drop height says all of it, a speed keeps the angle, and an angle keeps the speed
    or the drop height.

    Args:
        names: names of the fields that replace others.
    """
    if "velocity" in names or "drop_height" in names:
        return "speed", "strike_angle_deg", "velocity", "drop_height", "forward_speed"
    if "speed" in names:
        return "velocity", "drop_height", "forward_speed"
    if "strike_angle_deg" in names or "forward_speed" in names:
        return "velocity", "strike_angle_deg", "forward_speed"
    return ()
