"""A landing in symbols: its numbers and their gradients in many postures.

They are computed in NumPy, as a function of CasADi, or by exported code.
"""

import functools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column, selected
from shockpc.impact.impact import Impact
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import check_rotations
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import robot_of, scene_of
from shockpc.method.exact.arithmetic import NoValueError
from shockpc.quantities.maps import doubles
from shockpc.quantities.selection import Selection
from shockpc.robot.robot import Robot
from shockpc.text.arguments import checked
from shockpc.text.display import brief
from shockpc.text.errors import SceneError, StudyError
from shockpc.wings.symbols.landing_programs import (
    Before,
    Graph,
    functions_module,
    program_inputs,
    refuse,
)
from shockpc.wings.symbols.programs import Program

ACCURACY = ("condition", "pivot")
"""Quantities beside the numbers that say how far a posture is from a singular one."""


class SymbolicLanding:
    """Numbers of a landing as expressions of its posture and of what is before the impact.

    Near a singular posture double precision returns plausible wrong numbers. So `condition` and
    `pivot` belong to every value: where the condition is above `shockpc.profile.ILL_CONDITIONED`,
    rounding may show above 1e-9, and only `shock_profile` knows.

    Args:
        landing: the landing; its posture is not used.
        quantities: KEY@PLACE of what is computed, as `shockpc quantities` lists them; without
            places at all of its kind.
        before: the input for the motion before the impact: "strike", the velocity of the base
            (3,) in world axes, or "velocity", that of all joints (nv,) in Pinocchio's layout.

    Attributes:
        landing: the landing.
        before: as the argument.
        columns: the numbers; a vector is one.
        names: of all outputs: those of the columns, then "condition" and "pivot".

    Raises:
        SceneError, SolveError: the landing cannot be written in symbols.
        StudyError: a number cannot, there is none, or CasADi is not installed.
        UnknownName: there is no such quantity, or no such place of its kind.
    """

    def __init__(
        self, landing: PosedLanding, quantities: Sequence[str], before: Before = "strike"
    ) -> None:
        self.landing = landing
        self.before = before
        columns: dict[str, Column] = {}
        for text in quantities:
            columns |= {column.name: column for column in _columns(landing, text)}
        self.columns = tuple(columns.values())
        if not self.columns:
            raise StudyError(
                f"{', '.join(quantities) or 'nothing'} has no number in this landing; name one, "
                f"such as shock@PLACE"
            )
        self.names = (*(column.name for column in self.columns), *ACCURACY)
        refuse(landing)
        if before == "velocity" and any(
            contact.velocity is not None for contact in landing.contacts
        ):
            raise SceneError(
                "a contact has a velocity, which is no joint velocity; leave it out of the scene"
            )
        label = tuple((column.name, column.place) for column in self.columns)
        self._values = Graph(
            landing, before, lambda impact: [*self._numbers(impact), *_accuracy(impact)], label
        )
        self._slopes = Graph(landing, before, self._numbers, label)
        self._value, self._slope = self._values.values(), functools.cache(self._slopes.slopes)

    def __repr__(self) -> str:
        return brief(self, repr(self.landing), ", ".join(self.names))

    @property
    def program(self) -> Program:
        """The steps of `value`: of q and what is before the impact the outputs."""
        return self._value.program

    def value(
        self, Q: Array | Sequence[Sequence[float]], before: Array | Sequence[float] | None = None
    ) -> dict[str, Array]:
        """The numbers (N,), or vectors (N, 3), of N postures by name, with condition and pivot.

        Args:
            Q: (N, nq) configurations, Pinocchio's layout.
            before: ([N,] 3) strikes or ([N,] nv) velocities before the impact [m/s, rad/s]; the
                landing's by default. Where a velocity moves no contact, what is divided by their
                speed is NaN.

        Raises:
            SceneError: an argument has another shape, a rotation another length than 1, or a strike
                or velocity is zero.
        """
        return self._named(self._value(self._inputs(Q, before)), self.names)

    def gradient(
        self, Q: Array | Sequence[Sequence[float]], before: Array | Sequence[float] | None = None
    ) -> dict[str, Array]:
        """The derivatives (N, nv), of vectors (N, 3, nv), by the tangent of q.

        The tangent has Pinocchio's layout; the arguments are those of `value`.

        A follower, and a locked joint, has a column too, in which the others stay.
        """
        rows = self.slopes(Q, before)[1]
        nv = self.landing.robot.model.nv
        return {name: part[..., :nv] for name, part in rows.items()}

    def slopes(
        self, Q: Array | Sequence[Sequence[float]], before: Array | Sequence[float] | None = None
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """The numbers, and their derivatives (N, [3,] nv + 3 or nv + nv).

        They are by the tangent of q and by the motion before the impact.
        """
        rows = self._slope()(self._inputs(Q, before))
        m = sum(map(self._size, self.columns))
        names = self.names[: len(self.columns)]
        derivatives = rows[:, m:].reshape(len(rows), m, -1)
        return self._named(rows[:, :m], names), self._named(derivatives, names)

    def casadi(self) -> Any:
        """The function of CasADi: of q and what is before the impact, the outputs by name.

        Raises:
            StudyError: two outputs have the same name in code, or CasADi is not installed.
        """
        outputs: dict[str, slice] = {}
        start = 0
        sizes = [*map(self._size, self.columns), 1, 1]
        for name, size in zip(identifiers(self.names), sizes, strict=True):
            outputs[name] = slice(start, start + size)
            start += size
        inputs = {"q": self.landing.robot.model.nq, self.before: self._values.before_size}
        return functions_module().function_of(self._value.text, inputs, outputs)

    def _numbers(self, impact: Impact) -> list[Any]:
        numbers = []
        for column in self.columns:
            entry, axis = column.selection.quantity, column.selection.axis
            try:
                value = np.asarray(entry.compute(impact, (column.place,)), dtype=object)[0, 0, 0]
            except NoValueError:
                raise _refused(column.selection) from None
            if any(isinstance(part, float) and math.isnan(part) for part in np.ravel(value)):
                reason = f": {entry.scope.missing}" if entry.scope.missing else ""
                raise StudyError(f"{column.name} has no value in this landing{reason}")
            numbers.append(value if axis is None else value[axis])
        return numbers

    def _inputs(self, Q: Any, before: Any) -> Array:
        robot = self.landing.robot
        size = self._values.before_size
        Q = doubles("Q", Q)
        if Q.ndim != 2 or Q.shape[1] != robot.model.nq or not len(Q):
            raise SceneError(
                f'Q has shape {Q.shape}; configurations of robot "{robot.name}" have shape (N, '
                f"{robot.model.nq}), a single one q[None]"
            )
        check_rotations(robot, Q)
        v = self._motion() if before is None else doubles(self.before, before)
        if v.shape not in ((size,), (len(Q), size)):
            raise SceneError(
                f"{self.before} has shape {v.shape}; give ({size},), or ({len(Q)}, {size}) with "
                "a row for each posture"
            )
        if (still := np.flatnonzero(~(np.linalg.norm(np.atleast_2d(v), axis=1) > 0.0))).size:
            row = f"in row {still[0]} " if v.ndim == 2 else ""
            raise SceneError(
                f"{self.before} is zero {row}before the impact, so there is no impact; give a "
                "velocity above zero"
            )
        return program_inputs(self._values, Q, v)

    def _motion(self) -> Array:
        motion = self.landing.before
        if self.before == "strike":
            return motion.velocity
        raise SceneError("the velocity of the joints before the impact has no default; give it")

    def _size(self, column: Column) -> int:
        return 3 if column.selection.quantity.vector and column.selection.axis is None else 1

    def _named(self, rows: Array, names: Sequence[str]) -> dict[str, Array]:
        """Columns of rows (N, m, ...) by name."""
        named: dict[str, Array] = {}
        k = 0
        for name, size in zip(names, [*map(self._size, self.columns), 1, 1], strict=False):
            named[name] = rows[:, k] if size == 1 else rows[:, k : k + size]
            k += size
        return named


@checked
def symbolic(
    scene: Scene | str,
    quantities: Sequence[str] = ("shock", "shock_com"),
    before: Before = "strike",
    robot: Robot | None = None,
) -> SymbolicLanding:
    """A landing in symbols.

    It needs CasADi the first time: its programs are kept in the user's cache folder.

    Args:
        scene: the landing.
        quantities: as for `SymbolicLanding`.
        before: likewise.
        robot: the scene's robot, if it is loaded already.

    Raises:
        ShockError: as for `resolve` and `SymbolicLanding`.
    """
    scene = scene_of(scene)
    return SymbolicLanding(resolve(scene, robot or robot_of(scene)), quantities, before)


def _columns(landing: PosedLanding, text: str) -> list[Column]:
    """The numbers that a text means.

    Raises:
        ShockError: as for `selected`; or a number cannot be written in symbols.
    """
    selection, places = selected(landing, text)
    entry = selection.quantity
    if entry.computation.postures != "many" or entry.relations.role:
        raise _refused(selection)
    return [Column(selection, place) for place in places]


def _refused(selection: Selection) -> StudyError:
    return StudyError(
        f"{selection.name} ({selection.quantity.title}) cannot be written in symbols, because a "
        f"decision or a search in it "
        "depends on the posture; choose another quantity"
    )


def _accuracy(impact: Any) -> list[Any]:
    return [impact.condition, impact.pivot]


def identifiers(names: Sequence[str]) -> list[str]:
    """Names in code of ASCII letters, digits and underscores, as C and JavaScript take them.

    Other letters are spelled by their code point, such as u00b2 for ²; all else becomes an
    underscore.

    Raises:
        StudyError: two of them are the same then, or differ in capitals alone, which names of
            constants do not have.
    """
    codes, known = ["".join(map(_in_code, name)) for name in names], dict[str, str]()
    for name, code in zip(names, codes, strict=True):
        if (first := known.setdefault(code.upper(), name)) != name:
            raise StudyError(
                f"{first} and {name} have the same name in code; ask for one at a time"
            )
    return codes


def _in_code(letter: str) -> str:
    if not letter.isalnum():
        return "_"
    return letter if letter.isascii() else f"u{ord(letter):04x}"
