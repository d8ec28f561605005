"""Scene and robot of the rows of a study, and the landings that some of them need of their own."""

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from shockpc.evaluation.variations.variation import Variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import close_loops, resolve, with_definite_contacts
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.robot.changes import Change, changed
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError, StudyError

MOST_CLOSED = 4096
"""Largest number of postures whose closed loops are kept."""

MOVED = 1e-6
"""By how much closing loops may move a joint that varies [deg, m]."""


class RowScenes:
    """Scene and robot of each row, by the values of what varies.

    Args:
        scene: the landing that is varied.
        robot: its robot.
        axes: what varies, in the order of `VariedLandings.axes`.
        strikes: of each posture; empty for that of the scene.
    """

    def __init__(
        self, scene: Scene, robot: Robot, axes: Sequence[Variation], strikes: Sequence[Strike]
    ) -> None:
        self._scene = scene
        self._robot = robot
        self._axes = axes
        self._strikes = strikes
        self._closed: dict[str, Scene] = {}

    @functools.cached_property
    def first(self) -> PosedLanding:
        """The first of all landings."""
        values: dict[Variation, Any] = {}
        for varied in self._axes:
            if varied.stage == 0:
                values[varied] = (varied.values or varied.span or ())[0]
        return self.landing(values)

    @functools.cached_property
    def separate(self) -> bool:
        """True if loops have to be closed, so that each posture needs a landing of its own."""
        return bool(self.first.loops)

    @functools.cached_property
    def _contacts(self) -> dict[str, tuple[Contact, ...]]:
        """The contacts by the values of what varies, each resolved in the posture of the scene."""
        contacts = {}
        for varied in self._axes:
            if not varied.kind.names_contacts:
                continue
            for value in varied.values:
                scene, _ = varied.applied(self._scene, self._robot, value)
                contacts[str(value)] = definite_scene(scene, self._robot).contact
        return contacts

    def landing(self, values: Mapping[Variation, Any]) -> PosedLanding:
        """The landing with some values, resolved.

        Raises:
            ShockError: there is no such landing.
        """
        return resolve(*self.case(values))

    def case(self, values: Mapping[Variation, Any], strike: int = 0) -> tuple[Scene, Robot]:
        """Scene and robot with some values, of which NaN leaves a thing as it is.

        Args: values, by what varies; strike, number of that of the posture.

        Raises:
            ShockError: there is no such landing.
        """
        scene, robot = self._scene, self._robot
        if self._strikes:
            scene = replace(scene, strike=self._strikes[strike])
        values = {varied: value for varied, value in values.items() if not _is_nan(value)}
        # Contacts come first, because others change those that are struck.
        contacts_first = sorted(values, key=lambda varied: not varied.kind.names_contacts)
        changes: list[Change] = []
        for varied in contacts_first:
            value = values[varied]
            if varied.kind.names_contacts:
                scene = replace(scene, contact=self._contacts[str(value)])
            elif varied.kind.of_robot:
                changes += varied.kind.robot_changes(varied, robot, value)
            else:
                # `separate` asks for the first landing, and so for a case without motion.
                if varied.moves and self.separate:
                    scene = varied.kind.from_closed(varied, scene, robot, self.first.q)
                scene, robot = varied.applied(scene, robot, value)
        if changes:
            # All at once, because each changed robot reads the places of its frames anew.
            robot = changed(robot, changes)
        if any(varied.moves for varied in values) and self.separate:
            scene = self._with_closed_loops(scene)
            _refuse_moved(scene, robot, values)
        return scene, robot

    def _with_closed_loops(self, scene: Scene) -> Scene:
        """The scene with closed loops, from the first landing; the last results are kept."""
        key = repr((scene.posture, scene.assemble))
        if key not in self._closed:
            if len(self._closed) == MOST_CLOSED:
                self._closed.clear()
            self._closed[key] = close_loops(scene, self.first)
        closed = self._closed[key]
        return replace(scene, posture=closed.posture, assemble=closed.assemble)


def definite_scene(scene: Scene, robot: Robot) -> Scene:
    """A scene with definite contacts; as it is if its posture is no landing, as rows report."""
    try:
        return with_definite_contacts(scene, robot)
    except ShockError:
        return scene


def _is_nan(value: Any) -> bool:
    return not isinstance(value, str) and math.isnan(value)


def _refuse_moved(scene: Scene, robot: Robot, values: Mapping[Variation, Any]) -> None:
    """Refuse joints that closing the loops has moved away from their values.

    Raises:
        StudyError: there is one.
    """
    for varied, value in values.items():
        for joint in varied.kind.settable(robot, varied.target):
            closed = scene.posture.joints_deg.get(joint.name, value)
            if abs(closed - value) > MOVED:
                raise StudyError(
                    f'{varied.subject}: closing the loops moves "{joint.name}" away '
                    f"from {value:g} {varied.unit}; let other joints move with --assemble"
                )
