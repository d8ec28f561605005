"""Programs of a landing in any posture, made by symbols and kept in a cache.

An error names what no program can compute.
"""

import functools
import hashlib
import importlib.util
import io
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from shockpc.core.frozen import frozen
from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.impact.landed import solved, without_inertia
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import displaced
from shockpc.method.dynamics import dynamics
from shockpc.method.exact.arithmetic import SingularError
from shockpc.method.exact.kinematics import data_of
from shockpc.text.cache import cached, version_of_code
from shockpc.text.errors import SceneError, StudyError
from shockpc.wings.symbols.programs import Program

Before: TypeAlias = Literal["strike", "velocity"]
"""Kind of the motion before the impact that a program takes.

It is the base's velocity (3,), world axes, or that of all joints (nv,).
"""

Formulas: TypeAlias = Callable[[Impact], list[Any]]
"""Function from an impact to its quantities, as arrays of numbers."""

FEW = 128
"""Rows up to which CasADi's virtual machine takes less time than NumPy.

NumPy runs each step for all rows.
"""

ROOMS = ("core", "method", "landing", "impact", "quantities", "wings/symbols")
"""Folders whose code decides what a program computes."""


def has_symbols() -> bool:
    """True if CasADi is installed, which makes programs."""
    return importlib.util.find_spec("casadi") is not None


@frozen()
class CompiledProgram:
    """A program, and the same as a function of CasADi, which is quicker where there are few rows.

    Attributes:
        program: the program.
        text: of the function, as CasADi serialises it: of one vector of inputs one of outputs.
    """

    program: Program
    text: str

    def __call__(self, X: Array) -> Array:
        """The results (N, m) of N rows of inputs (N, inputs)."""
        if len(X) > FEW or not has_symbols():
            return self.program(X)
        return np.asarray(self.function(X.T)).T

    @functools.cached_property
    def function(self) -> Any:
        """The function."""
        return functions_module().function_from(self.text)


class Graph(NamedTuple):
    """Quantities to compute of a landing in any posture.

    Attributes:
        landing: the landing; its posture is not used, and its motion only where no input gives it.
        before: the input for the motion before the impact.
        formulas: what is computed.
        label: what they depend on beside the landing, such as names and places.
    """

    landing: PosedLanding
    before: Before
    formulas: Formulas
    label: tuple[Any, ...]

    @property
    def before_size(self) -> int:
        """Number of inputs before the impact."""
        return 3 if self.before == "strike" else int(self.landing.robot.model.nv)

    def values(self) -> CompiledProgram:
        """Program from the configuration (nq,) and the motion before the impact to the numbers."""
        return self._program("values", lambda y, q, before, robot: y)

    def slopes(self) -> CompiledProgram:
        """Program of `values` with derivatives (m, nv + before).

        They are by the tangent of q, in Pinocchio's layout, and by the motion before the impact.
        """
        return self._program("slopes", lambda *args: functions_module().with_slopes(*args))

    def _program(self, name: str, outputs: Callable[..., Any]) -> CompiledProgram:
        def make() -> dict[str, np.ndarray]:
            try:
                traced = symbols_module().traced(self.landing, self.before_size, self.formulas)
            except SingularError as singular:
                raise singular_landing(self.landing, singular) from None
            q, before, y = traced
            results = outputs(y, q, before, self.landing.robot)
            program, text = functions_module().compiled_program((q, before), results)
            return {"text": np.frombuffer(text.encode(), dtype=np.uint8), **program.arrays()}

        arrays = cached_arrays(self.landing, (name, self.before, self.label), make)
        return CompiledProgram(Program.of(arrays), arrays["text"].tobytes().decode())


def cached_arrays(
    landing: PosedLanding, label: tuple[Any, ...], make: Callable[[], Mapping[str, Any]]
) -> dict[str, np.ndarray]:
    """Arrays that are made of a landing, or were in an earlier run.

    Args: label, all that they depend on beside the landing.
    """

    def content() -> bytes:
        file = io.BytesIO()
        np.savez_compressed(file, allow_pickle=False, **make())
        return file.getvalue()

    key = hashlib.sha256(
        b"\0".join(_parts((version_of_code(ROOMS), *label, *_of_landing(landing))))
    )
    with np.load(
        io.BytesIO(cached(f"{key.hexdigest()[:40]}.npz", content)), allow_pickle=False
    ) as arrays:
        return dict(arrays)


def singular_landing(landing: PosedLanding, singular: SingularError) -> Exception:
    """The error that says why a landing has no program."""
    if singular.of_inertia:
        return without_inertia(landing, landing.equation(landing.state))
    return _dependent(landing)


def symbols_module() -> Any:
    """The module of symbols.

    Raises:
        StudyError: CasADi is not installed.
    """
    _require_casadi()
    from shockpc.wings.symbols import symbols

    return symbols


def functions_module() -> Any:
    """The module of functions of CasADi.

    Raises:
        StudyError: CasADi is not installed.
    """
    _require_casadi()
    from shockpc.wings.symbols import casadi_functions

    return casadi_functions


def _require_casadi() -> None:
    if not has_symbols():
        raise StudyError('symbols need the package "casadi"; install it with: pip install casadi')


def refuse(landing: PosedLanding) -> None:
    """Refuse a landing that no program can say: where a decision depends on the posture.

    Raises:
        SceneError: what it is; the text says what to change.
        SolveError: no inertia resists a motion.
    """
    scene = landing.scene
    # A program is one sequence of operations: what decides, iterates or integrates has none.
    for applies, property_, change in (
        (
            landing.loops,
            "is closed by a loop, whose postures come from an assembly,",
            "take a model without the loop",
        ),
        (
            scene.stops,
            "has end stops that act, found by a complementarity problem,",
            "leave stops out",
        ),
        (
            scene.friction is not None,
            "has friction, so that contacts stick or slide,",
            "leave it out, or give the contact the directions in which it stops",
        ),
        (
            scene.yields,
            "has a contact stiffness, with which forces are integrals over time,",
            "leave it out",
        ),
        (
            landing.robot.negative_moments,
            "has negative principal moments of inertia",
            "correct them in the file",
        ),
    ):
        if applies:
            raise SceneError(
                f'a landing of robot "{landing.robot.name}" that {property_} cannot be written in '
                f"symbols; {change}"
            )
    for constraint, posed in zip(
        landing.contacts + landing.stance, landing.constraints, strict=True
    ):
        if constraint.kind == "stop":
            raise SceneError(
                f"{constraint.name} cannot be written in symbols; name a frame as the contact",
                constraints=[constraint.frame],
            )
        # The text gives the point of this posture as an offset, which leaves the landing as it is
        # here.
        if constraint.lowest:
            frame = landing.robot.frames[constraint.frame]
            offset = ",".join(
                f"{x:.6g}" for x in frame.rotation.T @ (posed.point - frame.offset) + 0.0
            )
            raise SceneError(
                f"{constraint.name} touches with its lowest point, which jumps as postures change, "
                "so it has no symbols; take the frame's origin (--contact-point frame), or the "
                f"point of this posture: --offset {offset}"
                + (" --contact-kind flat" if len(constraint.moments) >= 2 else ""),
                constraints=[constraint.frame],
            )
    # Rows that depend on one another in three random postures do so in all.
    steps = np.random.default_rng(0).uniform(-0.5, 0.5, (3, landing.robot.model.nv))
    Q = displaced(landing.robot, np.tile(landing.q, (3, 1)), steps)
    for q in Q:
        landing.robot.set_followers(q)
    solution = solved(landing, dynamics(landing.robot, Q, landing.joint_model)).solution
    # Where no posture has a solution, the motion that nothing resists is named.
    if not np.isfinite(solution.condition).any():
        raise without_inertia(landing, landing.equation(landing.state))
    if solution.rank.max() < sum(constraint.size for constraint in landing.constraints):
        raise _dependent(landing)


def _dependent(landing: PosedLanding) -> SceneError:
    names = [constraint.name for constraint in landing.constraints]
    return SceneError(
        f"the rows of {', '.join(names)} are dependent in every posture, so they cannot be "
        "written in symbols; leave a direction or a contact out",
        constraints=[constraint.frame for constraint in landing.constraints],
    )


def _of_landing(landing: PosedLanding) -> tuple[Any, ...]:
    """All that a program depends on: numbers and tree of the robot, and how it lands."""
    robot = landing.robot
    return (
        data_of(robot),
        robot.joints,
        robot.mimics,
        robot.bodies,
        repr(landing.scene),
        landing.plane,
        landing.up,
        landing.constraints,
        tuple(landing.joint_model),
        landing.before,
        repr(landing.pulse),
    )


def _parts(value: Any) -> Iterator[bytes]:
    """A value as bytes, the same in every process.

    Arrays are written by their numbers, collections by their entries.
    """
    if isinstance(value, np.ndarray):
        yield f"{value.dtype}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, Mapping):
        yield from _parts(tuple(value.items()))
    elif isinstance(value, tuple):
        yield f"({len(value)}".encode()
        for part in value:
            yield from _parts(part)
    else:
        yield repr(value).encode()


def program_inputs(graph: Graph, Q: Array, before: Array) -> Array:
    """Inputs (N, nq + before) of a graph's programs.

    Args: Q (N, nq) configurations, before ([N,] before).
    """
    return np.concatenate([Q, np.broadcast_to(before, (len(Q), graph.before_size))], axis=1)
