"""Kinds of links: mass, centre of mass and inertia, and bending stiffness."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, cast, get_args

from shockpc.core.segments import Flex
from shockpc.evaluation.variation import Factors, Kind, Options, Target, Variation
from shockpc.landing.flexes import flexes_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scene import Scene
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


@dataclass(frozen=True)
class BendingStiffness(Kind):
    """The bending stiffness of links [N m²]; factors multiply all stiffnesses of links that bend."""

    of: Target = "LINK"
    factors: Factors = "also"
    log_factors: bool = True
    nonnegative: bool = True
    uncertain: bool = True

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        robot.match_bodies(varied.target)
        if not smallest > 0.0:
            raise StudyError(
                f"{varied.subject}: a bending stiffness of {smallest:g} is not above zero"
            )

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return [robot.bodies[k].name for k in robot.match_bodies(varied.target)]

    def check_landing(self, varied: Variation, scene: Scene, robot: Robot) -> None:
        """Refuse factors where no link bends."""
        self.scene_with(varied, scene, robot, 1.0)

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        """The scene with the bending stiffness of some links replaced or multiplied.

        Raises:
            ShockError: factors are given, and none of the links bends.
        """
        present = _flexes(scene, robot)
        bodies = robot.match_bodies(varied.target)
        if varied.factor:
            bodies = tuple(body for body in bodies if body in present)
        if not bodies:
            raise StudyError(
                f"{varied.subject}: these links do not bend, so nothing is multiplied; give values "
                f"in N m², such as 100:1000"
            )
        texts: dict[str, str] = {}
        for body in bodies:
            if varied.factor:
                flex = present[body].scaled(float(value))
            else:
                flex = present.get(body, Flex())._replace(EI=float(value), frequency=None)
            texts[robot.bodies[body].name] = str(flex)
        # Later entries go over earlier ones.
        kept = {name: text for name, text in scene.flex.items() if name not in texts}
        return replace(scene, flex=kept | texts)

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        flexes = _flexes(landing.scene, landing.robot)
        bodies = landing.robot.match_bodies(varied.target)
        return [flexes.get(body, Flex()).EI for body in bodies]

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        changed = [name for name, text in scene.flex.items() if base.flex.get(name) != text]
        return [("--flex", f"{name}={scene.flex[name]}") for name in changed]


def _flexes(scene: Scene, robot: Robot) -> dict[int, Flex]:
    """How the bodies bend that do."""
    flexes: dict[int, Flex] = {}
    for pattern, flex in flexes_of(scene.flex):
        flexes |= dict.fromkeys(robot.match_bodies(pattern), flex)
    return flexes


MASS = LinkProperty("mass", "kg", factors="also", nonnegative=True)
POINT_MASS = LinkProperty("point-mass", "kg", added=True)
CENTRES = tuple(LinkProperty(f"com-{axis}", "m", title=f"CoM {axis}", added=True) for axis in "xyz")
INERTIA = LinkProperty("inertia", "-", factors="only")
ENTRIES = tuple(LinkProperty(entry, "kg m²", added=True) for entry in get_args(Entry))
LINK_PROPERTIES = (MASS, POINT_MASS, *CENTRES, INERTIA, *ENTRIES)
FLEX = BendingStiffness("flex", "N m²")
