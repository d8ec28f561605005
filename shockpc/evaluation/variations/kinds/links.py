"""Kinds of links: mass, centre of mass and inertia."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.row_arrays import RowInertias
from shockpc.evaluation.variations.variation import Factors, Kind, Scale, Target, Variation
from shockpc.landing.landing import PosedLanding
from shockpc.robot.changes import ENTRIES, Change, link_inertia, links_with_mass
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


@dataclass(frozen=True)
class LinkProperty(Kind):
    """A property of the inertia of links, as `Change` has them."""

    of: Target = "LINK"
    uncertain: bool = True
    of_robot: bool = True
    changes_designs: bool = True

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        """Refuse a link without mass, and a mass or an inertia that is not above zero."""
        links_with_mass(robot, varied.target)
        if not self.added and not smallest > 0.0:
            raise StudyError(
                f"{varied.subject}: {smallest:g} is not above zero, but a link has to keep some "
                f"{self.word}"
            )

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return links_with_mass(robot, varied.target)

    def robot_changes(self, varied: Variation, robot: Robot, value: Any) -> list[Change]:
        return [Change(self.word, varied.target, float(value), varied.factor)]

    def set_inertia(self, varied: Variation, rows: RowInertias, x: Array) -> None:
        rows.change_links(self.word, varied.target, x, varied.factor)

    def usual(self, landing: PosedLanding) -> Iterable[Variation]:
        names = links_with_mass(landing.robot, "*")
        return [Variation(self.subject(name), self, name, self.unit) for name in names]

    def scale(self, varied: Variation, landing: PosedLanding, value: float) -> Scale:
        if varied.factor:
            return super().scale(varied, landing, value)
        mass = link_inertia(landing.robot, varied.target).mass
        return Scale(mass, mass, value)


@dataclass(frozen=True)
class Mass(LinkProperty):
    """The mass of links; their inertias change in proportion."""

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return links_with_mass(landing.robot, varied.target).values()


@dataclass(frozen=True)
class PointMass(LinkProperty):
    """A mass that is added at the centre of mass of links."""

    added: bool = True

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        lightest = min(links_with_mass(robot, varied.target).values())
        if smallest <= -lightest:
            raise StudyError(
                f"{varied.subject}: {smallest:g} kg would leave no mass of a link of "
                f"{lightest:g} kg"
            )

    def lowest(self, varied: Variation, robot: Robot) -> float:
        return -float(link_inertia(robot, varied.target).mass)


@dataclass(frozen=True)
class CentreOfMass(LinkProperty):
    """The displacement of the centre of mass of links along an axis of their frames."""

    added: bool = True

    def scale(self, varied: Variation, landing: PosedLanding, value: float) -> Scale:
        """The radius of gyration of the body: that of all links that are fixed to one another."""
        robot = landing.robot
        size = float(robot.gyration[robot.frames[varied.target].body]) or landing.length
        com = link_inertia(robot, varied.target).lever
        return Scale(size, size, float(com["xyz".index(self.word[-1])]))


@dataclass(frozen=True)
class InertiaFactor(LinkProperty):
    """All entries of the inertia of links."""

    factors: Factors = "only"

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        if not varied.factor:
            raise StudyError(
                f"{varied.subject}: the moments of inertia are varied by factors; give them with "
                f"an x, such as 0.5x:2x:4"
            )
        super().check(robot, varied, smallest)

    def usual(self, landing: PosedLanding) -> Iterable[Variation]:
        """Nothing: its entries are among the usual quantities."""
        return ()


@dataclass(frozen=True)
class InertiaEntry(LinkProperty):
    """An increase of an entry of the inertia of links."""

    added: bool = True

    def scale(self, varied: Variation, landing: PosedLanding, value: float) -> Scale:
        """A third of the trace, of the body for differences, and of the link for shown steps."""
        robot = landing.robot
        of_body = robot.inertias[robot.frames[varied.target].body]
        of_link = link_inertia(robot, varied.target).inertia
        row, column = ("xyz".index(axis) for axis in self.word[-2:])
        size = float(np.trace(of_body)) / 3.0
        amount = float(np.trace(of_link)) / 3.0
        return Scale(size, amount, float(of_link[row, column]))


LINK_PROPERTIES = (
    Mass("mass", "kg", factors="also", nonnegative=True),
    PointMass("point-mass", "kg"),
    *(CentreOfMass(f"com-{axis}", "m", title=f"CoM {axis}") for axis in "xyz"),
    InertiaFactor("inertia", "-"),
    *(InertiaEntry(entry, "kg m²") for entry in ENTRIES),
)
