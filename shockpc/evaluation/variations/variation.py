"""One quantity that a study varies: its kind, its values or range, and how these are drawn."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.row_arrays import RowInertias, RowPostures, RowStrikes
from shockpc.evaluation.variations.typed_values import CUT, FORM, Law, Values, values_from
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.changes import Change, changed
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

Target = Literal["", "LINK", "JOINT"]
"""The parts that the name or glob of a kind means; empty for a kind of the landing."""

Factors = Literal["never", "also", "only"]
"""Values as factors of what the landing has: never, also, or only."""

Options: TypeAlias = list[tuple[str, str]] | None
"""Options of `shockpc analyze` with their texts; None where no option sets a value."""

RADIAN = math.degrees(1.0)


class Scale(NamedTuple):
    """The values with which changes of a quantity are compared.

    Attributes:
        size: that of a difference [its unit].
        amount: of which 1 % is the step that is shown, unless that is an angle or a length [its
            unit].
        away: a number with the sign of the direction away from zero.
    """

    size: float
    amount: float
    away: float


@dataclass(frozen=True)
class Kind:
    """A kind of quantity that varies; each is an instance of a subclass, listed in `KINDS`.

    The subclass says how a value changes the scene or the robot, and what a landing has.

    Attributes:
        word: names it, alone or before ":LINK" or ":JOINT".
        unit: of its values; empty where it follows from the joints, and for names.
        of: what a name or glob after the word means.
        title: in words; empty for the word itself.
        factors: whether values can be factors.
        log_factors: whether a range of factors is drawn from uniformly in the logarithm.
        added: whether a value is added to what the landing has.
        nonnegative: whether no value is below zero.
        uncertain: whether it is of the robot or of the ground, not of how the robot lands.
        scales: whether it only scales the velocity before the impact, so that no shock depends on
            it.
        lasting: whether it has an effect only on a landing that lasts.
        of_robot: whether it changes the robot itself, so that no scene contains it.
        changes_lengths: whether it changes lengths of links, and so how loops close.
        of_drives: whether it is of the drives of joints.
        of_rotors: whether it is the inertia of rotors, before or after the gear.
        of_ground: whether it is of the ground.
        names_contacts: whether its values are names of contacts, and no numbers.
        changes_designs: whether a design of a comparison can differ in it, as in `Change`.
        option: the option of commands that gives the value; of `of` "JOINT" by joint. Empty where
            none does, or where it gives more than that.
        axis: which of the three numbers of the option it is; -1 if the option is one number.
    """

    word: str
    unit: str = ""
    of: Target = ""
    title: str = ""
    factors: Factors = "never"
    log_factors: bool = False
    added: bool = False
    nonnegative: bool = False
    uncertain: bool = False
    scales: bool = False
    lasting: bool = False
    of_robot: bool = False
    changes_lengths: bool = False
    of_drives: bool = False
    of_rotors: bool = False
    of_ground: bool = False
    names_contacts: bool = False
    changes_designs: bool = False
    option: str = ""
    axis: int = -1

    @property
    def form(self) -> str:
        """The kind as it is typed, such as "speed" or "mass:LINK"."""
        return f"{self.word}:{self.of}" if self.of else self.word

    def subject(self, target: str) -> str:
        """The subject of the kind with a target, as it is typed."""
        return f"{self.word}:{target}" if self.of else self.word

    def in_words(self, target: str, unit: str) -> str:
        """The quantity in words. Args: unit, of its values."""
        words = self.title or self.word.replace("-", " ")
        return f"{words} of {target}" if target else words

    @property
    def moves(self) -> bool:
        """True if it changes the posture: if its class sets that of rows."""
        return type(self).set_posture is not Kind.set_posture

    @property
    def inertial(self) -> bool:
        """True if it changes only what `RowInertias` holds: if its class sets that of rows."""
        return type(self).set_inertia is not Kind.set_inertia

    def stage(self, factor: bool) -> int:
        """The stage at which a change is computed.

        It is 0 for another landing, 1 for another posture or inertia, 2 for only another product
        with the maps.

        Args: factor, whether values are factors.
        """
        if type(self).set_strike is not Kind.set_strike:
            return 2
        return 1 if self.moves or self.inertial else 0

    def read(self, robot: Robot, subject: str, target: str, values: Any) -> "Variation":
        """The quantity with its values.

        Args:
            robot: the robot.
            subject: as it is typed.
            target: the part of it after the colon.
            values: as in `vary.variation`.

        Raises:
            UnknownName: the robot has no such joint or link.
            StudyError: the values do not fit.
        """
        if values is None:
            raise StudyError(f"{subject}: no values are given; valid are {FORM}")
        read = values_from(subject, values)
        if read.factor and self.factors == "never":
            raise StudyError(
                f"{subject}: a factor such as 0.8x or ±5% does not apply to it; give values in "
                f"{self.unit or 'SI units'}"
            )
        if not (read.mean or read.factor or self.added):
            raise StudyError(f"{subject}: {values} has no mean; give it too, such as 1{values}")
        unit = self.unit_of(robot, subject, target)
        if read.factor:
            unit = "-"
        varied = Variation(
            subject, self, target, unit, read.numbers, read.span, read.law, read.factor
        )
        self.check(robot, varied, read.smallest)
        return varied.with_law(read)

    def unit_of(self, robot: Robot, subject: str, target: str) -> str:
        """The unit of values that are not factors."""
        return self.unit

    def check_robot(self, robot: Robot, subject: str) -> None:
        """Refuse a robot on which the kind has no meaning.

        Raises:
            StudyError: it has none.
        """

    def check(self, robot: Robot, varied: "Variation", smallest: float) -> None:
        """Refuse names that mean nothing, and values that are not possible.

        Args: smallest, of the values.

        Raises:
            UnknownName: the robot has no such joint or link.
            StudyError: a value is not possible.
        """

    def names(self, robot: Robot, varied: "Variation") -> Iterable[str]:
        """The links or joints that vary together."""
        return ()

    def each(self, robot: Robot, varied: "Variation") -> tuple["Variation", ...]:
        """A quantity for each link or joint that matches; itself if it is of the landing."""
        if not self.of:
            return (varied,)
        return tuple(
            replace(varied, subject=self.subject(name), target=name)
            for name in self.names(robot, varied)
        )

    def settable(self, robot: Robot, target: str) -> tuple[Joint, ...]:
        """The joints whose position is the value; none unless the kind is that of positions.

        Raises:
            UnknownName: the robot has no such joint.
            StudyError: one of the joints has no position that could be set.
        """
        return ()

    def sets(self, robot: Robot, varied: "Variation") -> Iterable[str]:
        """Names of what has the value, which no other quantity may vary too."""
        return (varied.subject,)

    def prepared(self, scene: Scene) -> Scene:
        """The scene in which the quantity varies."""
        return scene

    def refuse_scene(self, scene: Scene) -> None:
        """Refuse a scene that gives the same in another way.

        Raises:
            StudyError: it does.
        """

    def check_landing(self, varied: "Variation", scene: Scene, robot: Robot) -> None:
        """Refuse values that are not possible in a landing, or have no effect there.

        Raises:
            ShockError: one is not possible, or has no effect.
        """

    def scene_with(self, varied: "Variation", scene: Scene, robot: Robot, value: Any) -> Scene:
        """The scene with a value; as it is for a kind that changes the robot itself.

        Args: value, in the unit of the quantity, or the name of a contact.

        Raises:
            ShockError: the value is not possible.
        """
        return scene

    def from_closed(self, varied: "Variation", scene: Scene, robot: Robot, q: Array) -> Scene:
        """The scene from which a change begins, where closing loops has given a configuration q."""
        return scene

    def robot_changes(self, varied: "Variation", robot: Robot, value: Any) -> list[Change]:
        """The changes of the robot itself; none if the value is one of the scene."""
        return []

    def overridden(self, robot: Robot, target: str, scene: Scene) -> str:
        """Words for how a scene sets what a change of the robot would; empty if it does not."""
        return ""

    def present(self, varied: "Variation", landing: PosedLanding) -> Iterable[float | None]:
        """The values that a landing has [its unit]; None and NaN where it has none."""
        return ()

    def set_posture(self, varied: "Variation", rows: RowPostures, x: Array) -> None:
        """Change the postures of rows; only a kind whose class has this method moves.

        Args: x (n,), values [m, rad]; NaN leaves a row as it is.
        """

    def set_inertia(self, varied: "Variation", rows: RowInertias, x: Array) -> None:
        """Change the inertias of rows; only a kind whose class has this method is inertial.

        Args: x (n,), values; NaN leaves a row as it is.
        """

    def set_strike(self, rows: RowStrikes, x: Array) -> None:
        """Change the strikes of rows; only a kind whose class has this method is of stage 2.

        Args: x (...), values [m/s, rad]; NaN leaves a row as it is.
        """

    def has_derivatives(self, scene: Scene) -> bool:
        """True if there are formulas for derivatives by it in a landing."""
        return self.moves

    def usual(self, landing: PosedLanding) -> Iterable["Variation"]:
        """The quantities of this kind by which a sensitivity is computed if none is named."""
        return ()

    def lowest(self, varied: "Variation", robot: Robot) -> float:
        """The value below which none is possible."""
        return 0.0 if self.nonnegative or varied.factor else -math.inf

    def scale(self, varied: "Variation", landing: PosedLanding, value: float) -> Scale:
        """The values with which changes of a present value are compared."""
        size = abs(value) or 1.0
        if varied.unit == "m":
            size = landing.length
        elif varied.unit == "deg":
            size = RADIAN
        return Scale(size, size, value)

    def options(self, varied: "Variation", value: Any, scene: Scene, base: Scene) -> Options:
        """Options of `shockpc analyze` that set a value.

        Args:
            varied: the quantity.
            value: its value.
            scene: the scene with it.
            base: the scene that varies.
        """
        return None


@dataclass(frozen=True, eq=False)
class Variation:
    """One quantity that a study varies.

    Attributes:
        subject: as it is typed, such as "*_KFE", "strike-angle" or "mass:base_link".
        kind: what it is.
        target: a pattern of links or of joints; empty if the quantity is of the landing.
        unit: of the values.
        values: to be computed, or drawn from; numbers, or names of contacts.
        span: smallest and largest value between which numbers are drawn; None if values are given.
        law: distribution of these numbers, as in `Values`.
        factor: whether the values are factors of what the landing has.
    """

    subject: str
    kind: Kind
    target: str
    unit: str
    values: tuple[float | str, ...] = ()
    span: tuple[float, float] | None = None
    law: Law = "uniform"
    factor: bool = False

    def with_law(self, read: Values) -> "Variation":
        """The quantity with the distribution of its range: of factors by default log-uniform.

        Raises:
            StudyError: a number has no logarithm.
        """
        law = read.law
        is_uniform = law == "uniform" and self.span is not None
        if is_uniform and self.factor and self.kind.log_factors:
            law = "log-uniform"
        if law == "log-uniform" and not read.smallest > 0.0:
            raise StudyError(
                f"{self.subject}: {read.smallest:g} has no logarithm; give a range above zero, or "
                f"leave :log out"
            )
        return replace(self, law=law)

    def drawn(self, u: Array) -> np.ndarray:
        """Values (n,) of the distribution. Args: u (n,) uniform in [0, 1)."""
        if self.span is None:
            index = np.minimum((u * len(self.values)).astype(int), len(self.values) - 1)
            return np.asarray(np.asarray(self.values)[index])
        low, high = self.span
        if self.law == "log-uniform":
            # x = a (b/a)ᵘ; rounding may leave the range.
            x = low * np.exp(u * math.log(high / low))
            return np.asarray(np.clip(x, low, high))
        if self.law == "normal":
            from scipy.special import ndtr, ndtri

            # Φ is the normal distribution: z = Φ⁻¹(u) of one that is cut off at ±CUT.
            tail = ndtr(-CUT)
            z = ndtri(tail + u * (1.0 - 2.0 * tail))
            mean = 0.5 * (low + high)
            deviation = (high - low) / (2.0 * CUT)
            return np.asarray(mean + deviation * z)
        return np.asarray(low + (high - low) * u)

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value.

        Raises:
            StudyError: there is no range between them.
        """
        values = self.span or tuple(value for value in self.values if isinstance(value, float))
        if not values or not min(values) < max(values):
            raise StudyError(f"{self.subject} has no range; give it as {self.subject}=LOW:HIGH")
        return min(values), max(values)

    @property
    def per_unit(self) -> float:
        """Factor from a value in radians or SI units to the unit in which it is typed."""
        return RADIAN if self.unit == "deg" else 1.0

    def in_radians(self, values: Array) -> Array:
        """Values as typed (n,), angles in radians."""
        return np.radians(values) if self.unit == "deg" else values

    @property
    def column(self) -> str:
        """Heading of its column in tables, with the unit."""
        return f"{self.subject} [{self.unit}]" if self.unit else self.subject

    @property
    def moves(self) -> bool:
        """True if it changes the posture."""
        return self.kind.moves

    @property
    def stage(self) -> int:
        """The stage at which a change of it is computed, as in `Kind.stage`."""
        return self.kind.stage(self.factor)

    @property
    def uncertain(self) -> bool:
        """True if it is of the robot or of the ground, rather than of how the robot lands."""
        return self.kind.uncertain

    def applied(self, scene: Scene, robot: Robot, value: Any) -> tuple[Scene, Robot]:
        """A scene and its robot with a value.

        Args:
            scene: the landing.
            robot: its robot.
            value: a number in the unit, or the name of a contact.

        Raises:
            ShockError: the value is not possible.
        """
        self.kind.refuse_scene(scene)
        changes = self.kind.robot_changes(self, robot, value)
        if changes:
            robot = changed(robot, changes)
        return self.kind.scene_with(self, scene, robot, value), robot

    def present(self, landing: PosedLanding) -> float:
        """The value that a landing has [the unit]; NaN if it has not one number.

        It is 1 for a factor, and 0 for what is added.
        """
        if self.factor:
            return 1.0
        if self.kind.added:
            return 0.0
        values = set(self.kind.present(self, landing))
        value = values.pop() if len(values) == 1 else None
        return math.nan if value is None else value


def prepared(scene: Scene, variations: Iterable[Variation]) -> Scene:
    """The scene in which some quantities vary."""
    for varied in variations:
        scene = varied.kind.prepared(scene)
    return scene
