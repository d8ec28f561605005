"""Variations of links that bend, for studies."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from shockpc.evaluation.variations.variation import Factors, Kind, Options, Target, Variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.wings.compliant.links.flexes import Flex, flexes_by_body, flexes_of


@dataclass(frozen=True)
class BendingStiffness(Kind):
    """The bending stiffness of links [N m²]; factors multiply that of all links that bend.

    The option for links that bend gives their hinges and their other stiffnesses too.
    """

    of: Target = "LINK"
    factors: Factors = "also"
    log_factors: bool = True
    nonnegative: bool = True
    lasting: bool = True
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
        present = flexes_by_body(robot, flexes_of(scene.flex))
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
        flexes = flexes_by_body(landing.robot, flexes_of(landing.scene.flex))
        bodies = landing.robot.match_bodies(varied.target)
        return [flexes.get(body, Flex()).EI for body in bodies]

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        changed = [name for name, text in scene.flex.items() if base.flex.get(name) != text]
        return [("--flex", f"{name}={scene.flex[name]}") for name in changed]


KINDS = (BendingStiffness("flex", "N m²"),)
"""Kinds of quantities that vary."""
