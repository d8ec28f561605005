"""The protocol of a landing over time, which a wing implements."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from shockpc.core.low_pass import LowPass
from shockpc.core.spatial import Array
from shockpc.impact.impact import DoubleImpact
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.text.wings import from_wings


class LandingMotion(Protocol):
    """A landing over time; what is read from it is computed then.

    Attributes:
        landing: the landing.
    """

    landing: PosedLanding

    @property
    def duration(self) -> Array:
        """Duration (c,) of each contact [s]."""

    @property
    def stop_peaks(self) -> dict[str, float]:
        """Peak force or torque of the end stops of each joint that is at one [N, N m]."""

    def peaks(
        self,
        compute: Callable[[Any, Sequence[Place]], Any],
        places: Sequence[Place] = (),
        low_pass: LowPass | None = None,
    ) -> tuple[Array, Array]:
        """Largest lengths (n,) of the rates of a quantity of jumps, and their times (n,) [s].

        Args:
            compute: the quantity, n vectors linear in jumps and impulses.
            places: its places.
            low_pass: a filter that the rates go through.
        """

    def impact_at(self, time: float) -> DoubleImpact:
        """Changes of velocity from the first touch until a time [s]."""


def motion_of(landing: PosedLanding, until: float | None = None) -> LandingMotion | None:
    """The landing over time; None where it is an impact of no duration.

    Args:
        landing: the landing.
        until: end of the motion [s]; by default, when all contacts are open and stay so.

    Raises:
        SolveError: the motion cannot be followed.
    """
    if not landing.scene.yields:
        return None
    for motion_until in from_wings("landing", "landing_motion"):
        motion: LandingMotion | None = motion_until(landing, until)
        if motion is not None:
            return motion
    return None
