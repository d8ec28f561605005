"""Commands that follow from the declarations of studies.

The signature gives the options, and the result is reported.
"""

import inspect
import pkgutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from shockpc.cli.declared import Command, Declared, Parser, command, group, without_none
from shockpc.cli.options import (
    AT,
    EXPLAIN,
    PARSERS,
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
    corners,
    number_list,
    pair_of,
    renaming,
    setting,
    span,
    variable,
)
from shockpc.cli.progress import progress, shown_trace
from shockpc.cli.study_inputs import CommandLine, Input, inputs_of
from shockpc.cli.unused_options import refuse_unasked, refuse_varied
from shockpc.evaluation.declare import Study, StudyParameter, declaration
from shockpc.evaluation.variations.variation import Variation
from shockpc.evaluation.variations.vary import Vary, variation
from shockpc.landing.scenes.scene import Point
from shockpc.landing.scenes.scene_file import point_at
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError, traces
from shockpc.text.trace import Trace

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
    tuple[float, ...]: number_list,
    tuple[Vector, Vector]: corners,
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


def study_arguments(
    study: Callable[..., Any], typed: Mapping[str, Any], robot: Robot | None = None
) -> dict[str, Any]:
    """The arguments of a study that were typed, in SI units.

    Those that were not typed keep their defaults.
    """
    parameters = declaration(study).parameters
    values = {name: value for name, value in typed.items() if value not in (None, ())}
    for name in values:
        if without_none(parameters[name].kind) in (Mapping[str, float], Mapping[str, str]):
            values[name] = dict(values[name])
        if parameters[name].option.unit == "deg":
            values[name] = np.radians(values[name]).tolist()
    return declaration(study).typed(robot, values)


def study_command(name: str, package: str) -> Command:
    """The command of a study: the function `NAME` of the module `study` of its package.

    The result is reported by `NAME_report` of the module `report`.
    """
    study = pkgutil.resolve_name(f"{package}.study:{name}")
    declared = declaration(study)
    assert declared.reads is not None
    source = inputs_of(declared.reads)

    def run(**parsed: Any) -> int:
        inputs = [parsed[key] for key in source.typed]
        line = CommandLine(inputs, parsed["options"], parsed["typed"], shown_trace())
        robot, arguments = source.read(line)
        arguments |= _passed_to(declared, robot, parsed, line.trace)
        # What has no effect is refused before and after the study.
        refuse_varied(line.options, robot, _varied(study, line.study, robot))
        refuse_unasked(study, line.options, line.study, filter(None, [parsed.get("quantity")]))
        result = study(**arguments, **study_arguments(study, line.study, robot))
        if source.check is not None:
            source.check(line.options, arguments, result)
        with line.trace.stage("output"):
            # Imported here, because neither the help nor a refused study needs the report.
            report_of = pkgutil.resolve_name(f"{package}.report:{name}_report")
            report = report_of(inputs[0], result) if source.file else report_of(result)
            emit(report, parsed["output"])
        if parsed.get("explain"):
            sys.stderr.write(line.trace.text())
        return _exit_code(result, parsed.get("strict", False)) if declared.fails else 0

    vars(run)["__signature__"] = inspect.Signature(_parameters(study, source))
    return command(**help_of(study))(run)


def _parameters(study: Callable[..., Any], source: Input) -> list[inspect.Parameter]:
    """The parameters of the command of a study in the order of its help."""
    passed = declaration(study).passed
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
    return [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=default)
        for name, (kind, default) in parameters.items()
    ]


def _passed_to(
    declared: Study, robot: Robot, parsed: Mapping[str, Any], trace: Trace
) -> dict[str, Any]:
    """The arguments of a study that are neither its input nor its own options."""
    arguments: dict[str, Any] = {}
    if "target" in declared.passed:
        arguments["target"] = _target(robot, parsed["at_"], parsed["quantity"])
    if "trace" in declared.passed:
        arguments["trace"] = trace
    if "progress" in declared.passed:
        arguments["progress"] = partial(progress, "landings computed")
    return arguments


def _exit_code(result: Any, strict: bool) -> int:
    """The exit code of a study whose landings may fail one by one."""
    failures = [failure for _, failure in result.failures]
    rows = len(failures) + len(result.landings)
    return exit_code(len(failures), rows, strict, traces(failures))


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


def _declared(parameter: StudyParameter) -> tuple[Any, Any]:
    """Type and declaration of the option of a parameter."""
    kind = without_none(parameter.kind)
    option = parameter.option.stating(parameter.default)
    repeated = kind in REPEATED
    required = parameter.default is inspect.Parameter.empty
    parser = REPEATED[kind] if repeated else SINGLE.get(kind)
    declaration = group(option.heading)(
        option.text, option.form, parser, default=... if required else None, name=option.name
    )
    return tuple[str, ...] if repeated else kind if required else kind | None, declaration
