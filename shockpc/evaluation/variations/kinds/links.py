"""Kinds of links: mass, centre of mass and inertia."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, cast, get_args

from shockpc.evaluation.variations.variation import Kind, Target, Variation
from shockpc.landing.landing import PosedLanding
from shockpc.robot.changes import Change, Entry, Property, links_with_mass
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


@dataclass(frozen=True)
class LinkProperty(Kind):
    """A property of the inertia of links, as `Change` has them."""

    of: Target = "LINK"
    uncertain: bool = True
    inertial: bool = True
    of_robot: bool = True

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        if self.factors == "only" and not varied.factor:
            raise StudyError(
                f"{varied.subject}: the moments of inertia are varied by factors; give them with "
                f"an x, such as 0.5x:2x:4"
            )
        lightest = min(links_with_mass(robot, varied.target).values())
        if self.word == "point-mass" and smallest <= -lightest:
            raise StudyError(
                f"{varied.subject}: {smallest:g} kg would leave no mass of a link of "
                f"{lightest:g} kg"
            )
        if self.word in ("mass", "inertia") and not smallest > 0.0:
            raise StudyError(
                f"{varied.subject}: {smallest:g} is not above zero, but a link has to keep some "
                f"{self.word}"
            )

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return links_with_mass(robot, varied.target)

    def robot_changes(self, varied: Variation, robot: Robot, value: Any) -> list[Change]:
        return [Change(cast(Property, self.word), varied.target, float(value), varied.factor)]

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        if self.word != "mass":
            return ()
        return links_with_mass(landing.robot, varied.target).values()


MASS = LinkProperty("mass", "kg", factors="also", nonnegative=True)
POINT_MASS = LinkProperty("point-mass", "kg", added=True)
CENTRES = tuple(LinkProperty(f"com-{axis}", "m", title=f"CoM {axis}", added=True) for axis in "xyz")
INERTIA = LinkProperty("inertia", "-", factors="only")
ENTRIES = tuple(LinkProperty(entry, "kg m²", added=True) for entry in get_args(Entry))
LINK_PROPERTIES = (MASS, POINT_MASS, *CENTRES, INERTIA, *ENTRIES)
