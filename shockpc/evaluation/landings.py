"""A source of landings: what the engine asks of a grid, a sample, a recorded table or a list of
scenes.
"""

import reprlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.contact import contact_name
from shockpc.landing.landing import PosedLanding
from shockpc.landing.level_feet import with_contacts
from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import robot_of, scene_of
from shockpc.method.dynamics import Inertias
from shockpc.quantities.selection import Selection
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError, StudyError

ROWS = 16384
"""Largest number of rows of a chunk."""

GROUP = 4096
"""Largest number of postures of a group that is made at once."""


class Group(NamedTuple):
    """Postures that share a landing, each with S strikes.

    Attributes:
        postures: (m,) their numbers in the chunk.
        landing: what they share.
        Q: (m, nq) configurations.
        strikes: (m, S, 3) velocities of the base before the impact, world axes [m/s]; None where
            the landing has a motion for each posture (S = 1).
        inertias: the inertias in each posture; the landing's by default.
        further: (m,) further columns by heading.
    """

    postures: np.ndarray
    landing: PosedLanding
    Q: Array
    strikes: Array | None = None
    inertias: Inertias | None = None
    further: Mapping[str, Array] = {}


class Refusal(NamedTuple):
    """Postures that are no landings.

    Attributes:
        postures: (m,) their numbers in the chunk.
        error: why.
    """

    postures: np.ndarray
    error: ShockError


class Chunk(NamedTuple):
    """Some postures of a source, ready to be solved.

    Attributes:
        labels: (n,) columns by heading that tell the rows apart; n is the number of postures times
            that of strikes.
        groups: the postures by what they share, made one after the other.
        profile: a row by its number in the chunk, with its proof; raises ShockError. It is asked of
            rows of groups made before.
        landing: the same without the proof, where the source has columns at times.
    """

    labels: Mapping[str, np.ndarray]
    groups: Iterable[Group | Refusal]
    profile: Callable[[int], ShockProfile]
    landing: Callable[[int], PosedLanding] | None = None


class Landings(Protocol):
    """A source of landings, in chunks that do not depend on who computes them; it can be pickled.

    Attributes:
        noun: of the files that hold the rows.
    """

    noun: str

    @property
    def strikes(self) -> int:
        """Number of strikes of each posture."""

    @property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """First and last posture of every chunk, the last one excluded."""

    @property
    def headings(self) -> tuple[str, ...]:
        """Of the labels of the chunks."""

    @property
    def further(self) -> tuple[str, ...]:
        """Headings of further columns of the groups."""

    @property
    def opens(self) -> bool:
        """Whether a contact that would be pulled opens, because there is friction."""

    @property
    def robot(self) -> Robot:
        """The robot that the landings have in common, or one of them."""

    @property
    def scene(self) -> Scene:
        """The landing that is varied, or one of them."""

    @property
    def rows(self) -> int:
        """Number of rows."""

    @property
    def base_scene(self) -> Scene | None:
        """The landing from which the rows differ, on whose ground some number has to depend; None
        where rows have their own.
        """

    @property
    def description(self) -> dict[str, Any]:
        """What the rows depend on, besides scene and robot."""

    def compared(self, count: int) -> np.ndarray:
        """Numbers of rows that are compared with a proof, at most so many."""

    def data(self, k: int) -> Any:
        """What a chunk needs besides the pickled source: the rows of a recorded table."""

    def chunk(self, k: int, data: Any) -> Chunk:
        """The postures of a chunk. Args: data, as the method of that name gives it."""


def named_scenes(landings: Scene | str | Mapping[str, Scene | str]) -> dict[str, Scene]:
    """One landing, or landings by name, as the latter, each as `scene_of`; the name of a single one
    is empty.

    Raises:
        StudyError: there is no landing, or something else.
    """
    scenes = {"": landings} if isinstance(landings, Scene | str) else landings
    if not isinstance(scenes, Mapping) or not all(
        isinstance(scene, Scene | str) for scene in scenes.values()
    ):
        raise StudyError(
            f"landings is {reprlib.repr(landings)}; give a scene or a robot, or several by name"
        )
    if not scenes:
        raise StudyError("no landing is given; give at least one scene")
    return {name: scene_of(scene) for name, scene in scenes.items()}


def with_default_landings(landings: Mapping[str, Scene], robot: Robot) -> dict[str, Scene]:
    """Landings by name, those of a scene without contacts by its name and what strikes.

    Raises:
        ShockError: as for `default_landings`.
    """
    return {
        name if scene.contact else f"{name} {contact_name(one)}".strip(): one
        for name, scene in landings.items()
        for one in with_contacts(scene, robot)
    }


NAME_ONE = "name a quantity that depends on it, such as shock_friction or peak_force"
"""What to do where none of the numbers of a study depends on the ground."""


def common_robot(landings: Mapping[str, Scene]) -> Robot:
    """The robot of all landings, which are given by name.

    Raises:
        StudyError: there is no landing, or they are of different robots.
    """
    robots = {name: robot_of(scene) for name, scene in named_scenes(landings).items()}
    (first, robot), *_ = robots.items()
    other = next((name for name, another in robots.items() if another is not robot), None)
    if other is not None:
        raise StudyError(
            f'the landings "{first}" and "{other}" are of different robots; give scenes that have '
            f"the file, xacro arguments, "
            "packages and SRDF in common, and in an MJCF the robot that has the contact"
        )
    return robot


def refuse_ground(scene: Scene, *, friction: bool = True, others: str = NAME_ONE) -> None:
    """Refuse what a study of contacts that stick and are rigid would ignore.

    Args:
        scene: a landing of the study.
        friction: whether a coefficient of friction has no effect either.
        others: what else can be done.

    Raises:
        StudyError: the scene gives a contact stiffness, or a friction.
    """
    given = {
        "contact stiffness": scene.contact_stiffness,
        "friction": scene.friction if friction else None,
    }
    ignored = [name for name, value in given.items() if value is not None]
    if ignored:
        raise StudyError(
            f"the scene gives a {' and a '.join(ignored)}, which would change nothing here: all "
            f"numbers are of the impulse of "
            f"contacts that stick; leave it out, or {others}"
        )


def refuse_unused_ground(scene: Scene, selections: Iterable[Selection]) -> None:
    """Refuse a friction or a contact stiffness on which nothing depends that a study computes.

    Args:
        scene: a landing of the study.
        selections: what is computed; whether flat ground allows the landing depends on the
            friction.

    Raises:
        StudyError: the scene gives one.
    """
    entries = tuple(selection.quantity for selection in selections)
    if not any(entry.of_ground(scene) for entry in entries):
        refuse_ground(scene, friction=not any(entry.decided_by_ground for entry in entries))
