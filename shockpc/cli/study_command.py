"""Commands that follow from the declarations of studies.

The signature gives the options, and the result is reported.
"""

import inspect
import pkgutil
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, get_args

import numpy as np

from shockpc.cli.declared import Command, Declared, Parser, argument, command, group
from shockpc.cli.options import (
    AT,
    EXPLAIN,
    PARSERS,
    ROBOT,
    STRICT,
    TARGET,
    OutputOptions,
    SceneOptions,
    in_output,
)
from shockpc.cli.output import emit, exit_code
from shockpc.cli.parse import (
    Span,
    Vector,
    box,
    numbers,
    pair_of,
    renaming,
    robot_name,
    setting,
    span,
    variable,
)
from shockpc.cli.progress import progress, shown_trace
from shockpc.cli.scenes import landings_from, one_scene, postures_from
from shockpc.evaluation.declare import StudyParameter, declaration
from shockpc.evaluation.designs import Design
from shockpc.evaluation.variations.kinds.contacts import OFFSETS
from shockpc.evaluation.variations.kinds.posture import ATTITUDES
from shockpc.evaluation.variations.variation import Variation
from shockpc.evaluation.variations.vary import Vary, variation
from shockpc.landing.scenes.scene import Point
from shockpc.landing.scenes.scene_file import point_at
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError, traces
from shockpc.text.trace import Trace
from shockpc.text.wings import from_wings

REPEATED: dict[Any, Parser | None] = {
    Sequence[str]: None,
    str | Sequence[str]: None,
    Sequence[tuple[str, str]]: pair_of,
    Mapping[str, float]: setting,
    Mapping[str, str]: renaming,
    Vary: variable,
}
"""Types whose options may be repeated, and what reads each."""

SINGLE: dict[Any, Parser] = {
    **PARSERS,
    Span: span,
    tuple[float, ...]: numbers,
    tuple[Vector, Vector]: box,
}


def help_of(study: Callable[..., Any]) -> dict[str, Any]:
    """The help of the command of a study, as arguments of `command`."""
    declared = declaration(study)
    return {"examples": declared.examples, "more": declared.more, "without": declared.without}


def study_options(study: Callable[..., Any]) -> Declared:
    """The options that the parameters of a study declare, by parameter of a command."""
    return Declared(
        {name: _declared(parameter) for name, parameter in declaration(study).parameters.items()}
    )


def given(study: Callable[..., Any], typed: Mapping[str, Any], robot: Any = None) -> dict[str, Any]:
    """The arguments of a study that were typed, in SI units.

    Those that were not typed keep their defaults.
    """
    parameters = declaration(study).parameters
    values = {name: value for name, value in typed.items() if value not in (None, ())}
    for name in values:
        if _kind(parameters[name]) in (Mapping[str, float], Mapping[str, str]):
            values[name] = dict(values[name])
        if parameters[name].option.unit == "deg":
            values[name] = np.radians(values[name]).tolist()
    return declaration(study).typed(robot, values)


class Input(NamedTuple):
    """The input of a study from files and the options of a landing.

    Attributes:
        typed: arguments of the command by name, with type and declaration; the options of a landing
            complete them.
        read: from what was typed for these, the options, new names of columns and a trace to the
            first robot and arguments of the study.
        file: whether the first argument is the path of a file, which the report takes before the
            result.
        check: refuses options that have no effect, by the options, the arguments of the study and
            its result.
    """

    typed: dict[str, tuple[Any, Any]]
    read: Callable[
        [Sequence[Any], SceneOptions, Mapping[str, str], Trace], tuple[Robot, dict[str, Any]]
    ]
    file: bool = False
    check: Callable[[SceneOptions, Mapping[str, Any], Any], None] | None = None


def study_command(name: str, package: str) -> Command:
    """The command of a study: the function `NAME` of the module `study` of its package.

    The result is reported by `NAME_report` of the module `report`.
    """
    study = pkgutil.resolve_name(f"{package}.study:{name}")
    declared = declaration(study)
    assert declared.reads is not None
    source = inputs_of(declared.reads)
    passed = declared.passed

    def run(**parsed: Any) -> int:
        trace = shown_trace()
        options = parsed["options"]
        # Options of the study itself, by parameter.
        values = parsed["typed"]
        # What the study reads, and what it takes besides.
        inputs = [parsed[key] for key in source.typed]
        robot, arguments = source.read(inputs, options, dict(values.get("rename") or ()), trace)
        if "target" in passed:
            arguments["target"] = _target(robot, parsed["at_"], parsed["quantity"])
        if "trace" in passed:
            arguments["trace"] = trace
        if "progress" in passed:
            arguments["progress"] = partial(progress, "landings computed")
        # What has no effect is refused before and after the study.
        refuse_varied(options, robot, _varied(study, values, robot))
        refuse_unasked(study, options, values, filter(None, [parsed.get("quantity")]))
        result = study(**arguments, **given(study, values, robot))
        if source.check is not None:
            source.check(options, arguments, result)
        with trace.stage("output"):
            # Imported here, because neither the help nor a refused study needs the report.
            report_of = pkgutil.resolve_name(f"{package}.report:{name}_report")
            report = report_of(inputs[0], result) if source.file else report_of(result)
            emit(report, parsed["output"])
        if parsed.get("explain"):
            sys.stderr.write(trace.text())
        # The landings of a study that may fail one by one decide the exit code.
        if not declared.fails:
            return 0
        failures = [failure for _, failure in result.failures]
        rows = len(failures) + len(result.landings)
        return exit_code(len(failures), rows, parsed.get("strict", False), traces(failures))

    # The parameters of the command in the order of its help.
    parameters: dict[str, tuple[Any, Any]] = dict(source.typed)
    if "target" in passed:
        parameters["at_"] = (str | None, AT)
        parameters["quantity"] = (str | None, TARGET)
    parameters["typed"] = (Any, study_options(study))
    parameters["options"] = (SceneOptions, inspect.Parameter.empty)
    if "progress" in passed:
        parameters["strict"] = (bool, in_output(STRICT))
    parameters["output"] = (OutputOptions, inspect.Parameter.empty)
    if "trace" in passed:
        parameters["explain"] = (bool, EXPLAIN)
    signature = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=default)
        for name, (kind, default) in parameters.items()
    ]
    vars(run)["__signature__"] = inspect.Signature(signature)
    return command(**help_of(study))(run)


SETTINGS = {"joint": "set", "armature": "armature", "joint-stiffness": "joint-stiffness"}
"""Options that give a value by joint, by the kind of what varies."""


def refuse_varied(options: SceneOptions, robot: Robot, varied: Iterable[Variation]) -> None:
    """Refuse options that have no effect.

    They have none because each landing of a study has a value of what they give.

    Of a glob of joints one that does not vary is enough to have an effect, and components of zero
    say nothing.

    Args:
        options: of the command.
        robot: the robot.
        varied: what has these values; factors are of what the options give.

    Raises:
        StudyError: an option has no effect.
    """
    targets: dict[str, list[str]] = {}
    for varying in varied:
        if not varying.factor:
            targets.setdefault(varying.kind.word, []).append(varying.target)
    ignored: list[str] = []
    # A rotor of which the inertia varies keeps the gear ratio and the spring that are given.
    for kind, option in SETTINGS.items():
        joints: set[str] = set()
        for target in targets.get(kind, ()):
            joints.update(robot.match_joints(target))
        for pattern, *_ in getattr(options, option.replace("-", "_")):
            if joints.issuperset(robot.match_joints(pattern)):
                ignored.append(f"--{option} {pattern}")
    # Of three numbers, one that varies.
    for option, kinds in (("base-rpy", ATTITUDES), ("offset", OFFSETS)):
        vector = options.given.get(option.replace("-", "_")) or (0.0, 0.0, 0.0)
        for of_axis in kinds:
            if vector[of_axis.axis] and of_axis.word in targets:
                ignored.append(f"--{option}")
    # Numbers of a scene, whose kinds have the names of the options.
    for kind in targets:
        if options.given.get(kind.replace("-", "_")) is not None:
            ignored.append(f"--{kind}")
    if options.contact and "contact" in targets:
        ignored.append("--contact")
    if ignored:
        raise StudyError(
            f"{', '.join(ignored)} has no effect, because the value varies from landing to "
            "landing; leave it out, or, of an option with three numbers, set the varied one to "
            "zero"
        )


def refuse_unasked(
    study: Callable[..., Any],
    options: SceneOptions,
    typed: Mapping[str, Any],
    quantities: Iterable[str] = (),
) -> None:
    """Refuse a pulse, a bandwidth, a range and parts on which no number of a study depends.

    In a scene's file they may stand: they are of the robot.

    Args:
        study: the study.
        options: of the command.
        typed: the arguments of the study, by parameter.
        quantities: further ones that are computed, KEY[@PLACE].

    Raises:
        UnknownName: there is no such quantity.
        StudyError: an option has no effect.
    """
    texts = list(quantities)
    for name, parameter in declaration(study).parameters.items():
        if parameter.option.holds == "quantity" and (value := typed.get(name)):
            texts += [value] if isinstance(value, str) else value
    entries = [select(re.split("@|<=|>=", text)[0].strip()).quantity for text in texts]
    of_sensors = any(entry.key.startswith(("filtered_peak", "range_share")) for entry in entries)
    wanted = {
        "imu-bandwidth": of_sensors,
        "pulse": any(
            entry.computation.exact == "rigid" or entry.key.startswith("peak_g")
            for entry in entries
        ),
        "range-g": any(entry.key == "range_share" for entry in entries),
        "part": any(entry.of == "part" or entry.key == "joint_torque_share" for entry in entries),
    }
    named = "pulse", "imu-bandwidth", "range-g"
    given = {name: options.given.get(name.replace("-", "_")) for name in named} | {
        "part": options.part
    }
    examples = {
        "pulse": "peak_g",
        "imu-bandwidth": "filtered_peak",
        "range-g": "range_share",
        "part": "part_margin",
    }
    for name, example in examples.items():
        if given[name] and not wanted[name] and name not in declaration(study).uses:
            raise StudyError(
                f"no number here depends on --{name}; leave it out, or add a quantity such as "
                f"{example}"
            )


def _varied(
    study: Callable[..., Any], typed: Mapping[str, Any], robot: Robot
) -> Iterator[Variation]:
    """The variations from landing to landing of a study."""
    for name, parameter in declaration(study).parameters.items():
        if parameter.option.holds == "varied":
            for subject, values in typed[name]:
                yield variation(robot, subject, values)


def _target(robot: Robot, at: str | None, quantity: str | None) -> str | Point:
    """The number that a command is about: that of a point, or a quantity.

    Raises:
        StudyError: not one of the two is given.
        ShockError: the point is not one of the robot's.
    """
    if at is not None and quantity is None:
        return point_at(robot, at)
    if quantity is None or at is not None:
        raise StudyError(
            "one number is needed: give a point with --at, or a quantity with --quantity, such as "
            "shock@imu_link"
        )
    return quantity


def _scene(
    inputs: Sequence[Any], options: SceneOptions, rename: Mapping[str, str], trace: Trace
) -> tuple[Robot, dict[str, Any]]:
    robot, scene = one_scene(inputs[0], options, trace)
    return robot, {"scene": scene, "robot": robot}


def _landings(
    inputs: Sequence[Any], options: SceneOptions, rename: Mapping[str, str], trace: Trace
) -> tuple[Robot, dict[str, Any]]:
    landings = landings_from(inputs[0], options, trace)
    first_robot, _ = next(iter(landings.values()))
    scenes = {name: scene for name, (_, scene) in landings.items()}
    return first_robot, {"landings": scenes}


def _postures(
    inputs: Sequence[Any], options: SceneOptions, rename: Mapping[str, str], trace: Trace
) -> tuple[Robot, dict[str, Any]]:
    robot, postures = postures_from(inputs[0], options, trace)
    return robot, {"postures": postures, "robot": robot}


def _designs(
    inputs: Sequence[Any], options: SceneOptions, rename: Mapping[str, str], trace: Trace
) -> tuple[Robot, dict[str, Any]]:
    """As many contacts as there are designs are one for each."""
    names = inputs[0]
    options_of_each = [options] * len(names)
    if len(options.contact) == len(names) > 1:
        options_of_each = [options._replace(contact=(name,)) for name in options.contact]
    designs = []
    for name, options_of_design in zip(names, options_of_each, strict=True):
        robot, scene = one_scene(name, options_of_design)
        designs.append(Design(name, scene, robot))
    return designs[0].robot, {"designs": designs}


_SCENES = (
    "Scenes (TOML), or a robot: all level feet together, each edge of their support, and each foot."
)
_POSTURES = "A robot, or scenes (TOML) of one robot in several postures."
_DESIGNS = "Robot files, robots by name or scenes (TOML)."

INPUTS: dict[str, Input] = {
    "scene": Input({"scene": (str, ROBOT)}, _scene),
    "landings": Input(
        {"landings": (tuple[str, ...], argument(_SCENES, "SCENE...", robot_name, default=...))},
        _landings,
    ),
    "postures": Input(
        {"postures": (tuple[str, ...], argument(_POSTURES, "SCENE...", robot_name, default=...))},
        _postures,
    ),
    "designs": Input(
        {"designs": (tuple[str, ...], argument(_DESIGNS, "DESIGN...", robot_name, default=...))},
        _designs,
    ),
}
"""Inputs of a study, by the name of its parameter: one landing; landings by name, without contacts
those of `default_landings`;
postures of one robot by name; one landing of each design. Wings add what their studies read."""


def inputs_of(reads: str) -> Input:
    """The input of a study that reads this."""
    known = dict(INPUTS)
    for inputs in from_wings("inputs", "INPUTS"):
        known |= inputs
    return known[reads]


def _kind(parameter: StudyParameter) -> Any:
    """The type without None."""
    kinds = get_args(parameter.kind)
    others = [kind for kind in kinds if kind is not type(None)]
    if type(None) in kinds and len(others) == 1:
        return others[0]
    return parameter.kind


def _declared(parameter: StudyParameter) -> tuple[Any, Any]:
    """Type and declaration of the option of a parameter."""
    kind, option = _kind(parameter), parameter.option.stating(parameter.default)
    repeated = kind in REPEATED
    required = parameter.default is inspect.Parameter.empty
    parser = REPEATED[kind] if repeated else SINGLE.get(kind)
    declaration = group(option.heading)(
        option.text, option.form, parser, default=... if required else None, name=option.name
    )
    return tuple[str, ...] if repeated else kind if required else kind | None, declaration
