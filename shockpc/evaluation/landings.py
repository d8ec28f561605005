"""A source of landings for the engine: a grid, a sample, a recorded table or a list of scenes."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.method.dynamics import Inertias
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError

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
        extra_columns: (m,) other columns by heading.
    """

    postures: np.ndarray
    landing: PosedLanding
    Q: Array
    strikes: Array | None = None
    inertias: Inertias | None = None
    extra_columns: Mapping[str, Array] = {}


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
        """The headings of the labels of the chunks."""

    @property
    def extra_headings(self) -> tuple[str, ...]:
        """Headings of further columns of the groups."""

    @property
    def opens(self) -> bool:
        """True if a contact that would be pulled opens, because there is friction."""

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
        """The landing from which the rows differ; None if they have their own.

        Some number has to depend on its ground.
        """

    @property
    def description(self) -> dict[str, Any]:
        """The inputs on which the rows depend, besides scene and robot."""

    def compared(self, count: int) -> np.ndarray:
        """Numbers of rows that are compared with a proof, at most so many."""

    def data(self, k: int) -> Any:
        """The data of a chunk besides the pickled source: the rows of a recorded table."""

    def chunk(self, k: int, data: Any) -> Chunk:
        """The postures of a chunk. Args: data, as the method of that name gives it."""
