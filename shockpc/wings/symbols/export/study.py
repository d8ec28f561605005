"""A landing's numbers as code, compared with what is proven in random postures."""

import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import displaced, set_many
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.landing.scenes.scene_file import robot_of, scene_of
from shockpc.method.approach import Motion
from shockpc.profile import ILL_CONDITIONED, profile_of
from shockpc.robot.robot import Robot
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import SolveError, StudyError
from shockpc.wings.symbols.export.code import MOST_ERROR, Samples, code_files
from shockpc.wings.symbols.landing_programs import Before
from shockpc.wings.symbols.symbolic import ACCURACY, SymbolicLanding, identifiers

Language = Literal["c", "js", "casadi"]

RUNS = {
    "c": ("cc", ("make", "-s", "CC=cc", "test")),
    "js": ("node", ("node", "landing_test.mjs")),
    "casadi": ("CasADi", ()),
}
"""Programs that run the code, and the commands that run its test."""

TIME = 300.0
"""Largest time that compiling and running the test may take [s]."""

TURN = 0.5
"""Largest rotation of a base or ball joint in a random posture, about each axis [rad].

It counts from the posture of the scene.
"""


QUATERNION = ("quaternion x", "quaternion y", "quaternion z", "quaternion w")

COORDINATES = {
    "free": (("x", "y", "z", *QUATERNION), ("m", "m", "m", "1", "1", "1", "1")),
    "ball": (QUATERNION, ("1", "1", "1", "1")),
    "planar": (("x", "y", "cosine", "sine"), ("m", "m", "1", "1")),
    "continuous": (("cosine", "sine"), ("1", "1")),
}
"""Names and units of the coordinates of joints that have several, by kind."""


@dataclass(frozen=True, eq=False)
class Export:
    """Code of a landing, and how far it is from what is proven.

    Attributes:
        symbols: the landing in symbols.
        lang: the language.
        files: the code by file name, without the scene.
        samples: random postures with what is proven in them.
        singular: how many random postures were left out, because no landing is proven there or the
            condition is too large.
        error: maximum error of the program in these postures, run by NumPy, as `Samples.error`.
        tested: the same of the code itself; None where nothing on this computer runs it.
    """

    symbols: SymbolicLanding
    lang: Language
    files: Mapping[str, str]
    samples: Samples
    singular: int
    error: float
    tested: float | None

    _repr_html_ = shown_by("wings.symbols.export.report:export_report")

    def __repr__(self) -> str:
        return brief(self, self.lang, *self.files)

    @property
    def landing(self) -> PosedLanding:
        """The landing."""
        return self.symbols.landing

    @property
    def outputs(self) -> list[tuple[str, str, str]]:
        """Names of the outputs in code, one for each number, with titles and units."""
        return outputs_of(self.symbols)

    @property
    def joints(self) -> list[tuple[str, str, float, float]]:
        """Name, unit, and smallest and largest value of each entry of q."""
        return coordinates_of(self.landing.robot)


@study(
    "shockpc export anymal_b --contact LF_FOOT --quantity shock@imu_link --lang c --out code/",
    more="The code needs no library. It is compared with exact landings in random postures. It "
    "also returns the condition and the smallest pivot of the contacts, as measures of the "
    "distance to a singular posture.",
    reads="scene",
)
def export(
    scene: Scene | str,
    quantities: QuantityOption = ("shock", "shock_com"),
    *,
    robot: Robot | None = None,
    lang: Annotated[
        Language,
        Option(
            "Language: c (C99), js (a JavaScript module) or casadi (a function).", "Code", "LANG"
        ),
    ] = "c",
    before: Annotated[
        Before,
        Option(
            "Input of the code for the motion before the impact: the velocity of the base, or the "
            "velocity of all joints and the base.",
            "Code",
            "MOTION",
        ),
    ] = "strike",
    sample: Annotated[
        int,
        Option(
            "Number of random postures in which it is compared with exact landings.",
            "Code",
            "N",
            least=1.0,
            greatest=1e4,
        ),
    ] = 100,
) -> Export:
    """The numbers of a landing as code for any posture and motion before the impact.

    Args:
        scene: the landing.
        robot: the scene's robot, if it is loaded already.

    Raises:
        ShockError: as for `shockpc.symbolic`; or no random posture has a landing, or the code is
            wrong.
    """
    scene = scene_of(scene)
    landing = resolve(scene, robot or robot_of(scene))
    symbols = SymbolicLanding(landing, quantities, before)
    samples, singular = _samples(symbols, sample)
    nq, m = landing.robot.model.nq, samples.exact.shape[1]
    error, tested = samples.error(symbols.program(samples.inputs)[:, :m]), None
    if lang == "casadi":
        function = symbols.casadi()
        files = {"landing.casadi": function.serialize()}
        rows = type(function).deserialize(files["landing.casadi"])(
            samples.inputs[:, :nq].T, samples.inputs[:, nq:].T
        )
        tested = samples.error(np.concatenate([row.full() for row in rows]).T[:, :m])
    else:
        inputs = {"q": nq, before: samples.inputs.shape[1] - nq}
        names = [name for name, _, _ in outputs_of(symbols)]
        files = code_files(
            lang, symbols.program, inputs, names, _about(symbols), ILL_CONDITIONED, samples
        )
        tested = _tested(lang, files)
    worst = float(np.max([error, 0.0 if tested is None else tested]))  # NaN, if one is
    if not worst < MOST_ERROR:
        raise StudyError(
            f"the code is off by {worst:.2g} of a number in a posture whose condition is below "
            f"{ILL_CONDITIONED:g}, so it is not written. Please report this error in shockpc or "
            "in the compiler"
        )
    return Export(symbols, lang, files, samples, singular, error, tested)


def outputs_of(symbols: SymbolicLanding) -> list[tuple[str, str, str]]:
    """Outputs of a landing in symbols, as `Export.outputs`."""
    outputs: list[tuple[str, str, str]] = []
    for column in symbols.columns:
        selection = column.selection
        if selection.quantity.vector and selection.axis is None:
            for axis in "xyz":
                outputs.append((f"{column.name}.{axis}", f"{column.title} {axis}", column.unit))
        else:
            outputs.append((column.name, column.title, column.unit))
    titles = ("factor by which rounding is enlarged", "smallest pivot of the contact rows")
    outputs += [(name, title, "-") for name, title in zip(ACCURACY, titles, strict=True)]
    names = identifiers([name for name, _, _ in outputs])
    return [(name, title, unit) for name, (_, title, unit) in zip(names, outputs, strict=True)]


def coordinates_of(robot: Robot) -> list[tuple[str, str, float, float]]:
    """Coordinates of a robot, as `Export.joints`."""
    coordinates: list[tuple[str, str, float, float]] = []
    for joint in robot.single_joints:
        if joint.kind not in COORDINATES:
            coordinates.append((joint.name, joint.unit, *joint.limits))
            continue
        for name, unit in zip(*COORDINATES[joint.kind], strict=True):
            coordinates.append((f"{joint.name} {name}", unit, -np.inf, np.inf))
    return coordinates


def _about(symbols: SymbolicLanding) -> list[str]:
    """Lines that say what the code is of, and what its inputs and outputs mean."""
    import shockpc

    landing = symbols.landing
    contacts = ", ".join(contact.name for contact in (*landing.contacts, *landing.stance))
    lines = [
        f"shockpc {shockpc.__version__}: a landing of robot {landing.robot.name}, {contacts}, "
        f"base {landing.base}.",
        "The scene is in landing.toml.",
        "",
        "Inputs: q, the configuration in Pinocchio's layout",
    ]
    for k, (name, unit, low, high) in enumerate(coordinates_of(landing.robot)):
        line = f"  q[{k}] {name} [{unit}]"
        if np.isfinite([low, high]).all():
            line += f", {low:.6g} to {high:.6g}"
        lines.append(line)
    if symbols.before == "strike":
        lines.append("  strike[3] velocity of the base before the impact, world axes [m/s]")
    else:
        lines.append(
            "  velocity before the impact, Pinocchio's layout: a free base's in its own axes "
            "[m/s, rad/s]"
        )
    lines += ["", "Outputs:"]
    for k, (name, title, unit) in enumerate(outputs_of(symbols)):
        lines.append(f"  out[{k}] {name}: {title} [{unit}]")
    return list(map(_printable, lines))


def _printable(line: str) -> str:
    """A line with a question mark for each character that cannot be printed."""
    return "".join(letter if letter.isprintable() else "?" for letter in line)


def _samples(symbols: SymbolicLanding, n: int) -> tuple[Samples, int]:
    """Random postures with what is proven there; and how many were left out."""
    landing = symbols.landing
    rng = np.random.default_rng(0)
    tried = 0
    inputs: list[Array] = []
    exact: list[Array] = []
    while len(inputs) < n and tried < 3 * n + 20:
        tried += 1
        q, motion, before = _random(landing, symbols.before, rng)
        x = np.concatenate([q, before])
        if not symbols.program(x[None])[0, -2] < ILL_CONDITIONED:
            continue
        try:
            profile = profile_of(replace(landing.at(q), before=motion))
        except SolveError:
            continue
        numbers = []
        for column in symbols.columns:
            wanted = column.selection.quantity
            values = profile.value(wanted.key, wanted.of, (column.place,))
            numbers.append(_number(column, values[0]))
        inputs.append(x)
        exact.append(np.concatenate(numbers))
    if not inputs:
        raise StudyError(
            f'no random posture of robot "{landing.robot.name}" has a landing to compare the code '
            "with"
        )
    size = np.median(np.abs(exact), axis=0)
    size = np.where(size > 0.0, size, 1.0)
    return Samples(np.array(inputs), np.array(exact), size), tried - len(inputs)


def _number(column: Column, value: Array) -> Array:
    return np.atleast_1d(value if column.selection.axis is None else value[column.selection.axis])


def _random(
    landing: PosedLanding, before: Before, rng: np.random.Generator
) -> tuple[Array, Motion, Array]:
    """A configuration, a motion before the impact, and what the code is given of that."""
    robot, nv = landing.robot, landing.robot.model.nv
    steps, values = np.zeros(nv), []
    for joint in robot.independent_joints:
        low, high = np.clip(joint.limits, -np.pi, np.pi)
        values.append((joint, rng.uniform(low, high, 1)))
    for joint in robot.single_joints:
        if joint.kind in ("free", "ball"):
            steps[joint.v.stop - 3 : joint.v.stop] = rng.uniform(-TURN, TURN, 3)
    Q = displaced(robot, landing.q[None], steps[None])
    set_many(robot, values, Q)
    # The code is given the velocity of the strike, or all joint velocities.
    if before == "strike":
        velocity = landing.before.velocity + 0.3 * np.linalg.norm(
            landing.before.velocity
        ) * rng.uniform(-1.0, 1.0, 3)
        return Q[0], landing.before._replace(velocity=velocity), velocity
    qd = rng.uniform(-1.0, 1.0, nv)
    if not robot.free_base:
        return Q[0], Motion(np.zeros(3), np.zeros(3), qd), qd
    # A free base has its joint velocities in the axes of its joint, and its motion in the world's.
    turn = landing.at(Q[0]).state.rotation[0, 0] @ robot.bodies[0].rotation.T
    return Q[0], Motion(turn @ qd[:3], turn @ qd[3:6], np.concatenate([np.zeros(6), qd[6:]])), qd


def _tested(lang: Literal["c", "js"], files: Mapping[str, str]) -> float | None:
    """The maximum error that the test of a code prints, where this computer can run it."""
    if not all(map(shutil.which, {RUNS[lang][0], RUNS[lang][1][0]})):
        return None
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        try:
            run = subprocess.run(
                RUNS[lang][1], cwd=folder, capture_output=True, text=True, timeout=TIME, check=False
            )
        except subprocess.TimeoutExpired:
            raise StudyError(
                f"the test of the code takes more than {TIME:g} s; ask for fewer quantities"
            ) from None
    try:
        return float(run.stdout)
    except ValueError:
        raise StudyError(f"the test of the code does not run: {run.stderr[:400]}") from None
