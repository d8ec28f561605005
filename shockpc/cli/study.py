"""Commands that follow from the declarations of studies: the signature gives the options, the result is reported.

What the command passes for a parameter that is no option follows from the parameter's name:

    scene        one landing, of ROBOT and the options of a scene
    landings     landings by name: SCENE..., or a robot's on each of its feet alone
    target       the number that the study is about, --at or --quantity
    trace        measures stages, for --explain
    progress     a function that makes one which counts, of the number of landings

A result with `failures` is that of landings some of which could not be computed, which decides on the exit code.
"""

import inspect
import pkgutil
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, get_args

import numpy as np

import shockpc
from shockpc.cli.declare import Command, Declared, Parser, argument, command, group
from shockpc.cli.options import AT, EXPLAIN, PARSERS, ROBOT, STRICT, TARGET, OutputOptions, SceneOptions, in_run, target_of
from shockpc.cli.output import emit, exit_code
from shockpc.cli.parse import Span, Vector, box, pair_of, robot_name, setting, span, variable
from shockpc.cli.progress import ShownTrace, progress
from shockpc.cli.scenes import landings_from, one_scene
from shockpc.evaluation.variation import Vary
from shockpc.studies.declare import Parameter, declaration
from shockpc.text.errors import DefectError

REPEATED: dict[Any, Parser | None] = {
    Sequence[str]: None,
    Sequence[tuple[str, str]]: pair_of,
    Mapping[str, float]: setting,
    Vary: variable,
}
"""Types whose options may be repeated, and what reads each."""

SINGLE: dict[Any, Parser] = {**PARSERS, Span: span, tuple[Vector, Vector]: box}


def asked(study: Callable[..., Any]) -> Declared:
    """The options that the parameters of a study declare, by parameter of a command."""
    return Declared({name: _declared(parameter) for name, parameter in declaration(study).parameters.items()})


def given(study: Callable[..., Any], typed: Mapping[str, Any], robot: Any = None) -> dict[str, Any]:
    """The arguments of a study that were typed, in SI units; those that were not keep their defaults."""
    parameters, values = declaration(study).parameters, {name: value for name, value in typed.items() if value not in (None, ())}
    for name in values:
        if _kind(parameters[name]) == Mapping[str, float]:
            values[name] = dict(values[name])
        if parameters[name].option.unit == "deg":
            values[name] = np.radians(values[name]).tolist()
    return declaration(study).typed(robot, values)


def study_command(name: str) -> Command:
    """The command of a study: `shockpc.NAME`, reported by `NAME_report` of `shockpc.show.reports.NAME`."""
    study = getattr(shockpc, name)
    needs, declared = inspect.signature(study).parameters, declaration(study)
    several = "landings" in needs

    def run(**typed: Any) -> int:
        trace = ShownTrace()
        arguments: dict[str, Any] = {"target": target_of(typed["at_"], typed["quantity"])} if "target" in needs else {}
        if several:
            found = landings_from(typed["scenes"], typed["options"], trace)
            robot = next((robot for robot, _ in found.values()), None)
            arguments["landings"] = {name: scene for name, (_, scene) in found.items()}
        else:
            robot, arguments["scene"] = one_scene(typed["robot"], typed["options"], trace)
        arguments |= {"trace": trace, "robot": robot, "progress": partial(progress, "landings computed")}
        used = {name: value for name, value in arguments.items() if name in needs and not (several and name == "robot")}
        result = study(**used, **given(study, typed["asked"], robot))
        with trace.stage("output"):
            emit(pkgutil.resolve_name(f"shockpc.show.reports.{name}:{name}_report")(result), typed["output"])
        if typed.get("explain"):
            sys.stderr.write(trace.text())
        failures = [failure for _, failure in getattr(result, "failures", ())]
        defects = [failure.trace for failure in failures if isinstance(failure, DefectError)]
        return exit_code(len(failures), len(failures) + len(getattr(result, "landings", ())), typed.get("strict", False), defects)

    scenes = argument("Scenes (TOML), or a robot, which lands on each foot alone.", "SCENE...", robot_name, default=...)
    target = {"at_": (str | None, AT), "quantity": (str | None, TARGET)}
    parameters: dict[str, tuple[Any, Any]] = {
        **({"scenes": (tuple[str, ...], scenes)} if several else {"robot": (str, ROBOT)}),
        **(target if "target" in needs else {}),
        "asked": (Any, asked(study)),
        "options": (SceneOptions, inspect.Parameter.empty),
        **({"strict": (bool, in_run(STRICT))} if several and "target" not in needs else {}),
        "output": (OutputOptions, inspect.Parameter.empty),
        **({"explain": (bool, EXPLAIN)} if "trace" in needs else {}),
    }
    signature = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=default)
        for name, (kind, default) in parameters.items()
    ]
    vars(run)["__signature__"] = inspect.Signature(signature)
    return command(*declared.examples, more=declared.more)(run)


def _kind(parameter: Parameter) -> Any:
    """The type without None."""
    kinds = get_args(parameter.kind)
    given = [kind for kind in kinds if kind is not type(None)]
    return given[0] if len(given) == 1 and type(None) in kinds else parameter.kind


def _declared(parameter: Parameter) -> tuple[Any, Any]:
    """Type and declaration of the option of a parameter."""
    kind, option = _kind(parameter), parameter.option.stating(parameter.default)
    several = kind in REPEATED
    required = parameter.default is inspect.Parameter.empty
    parser = REPEATED[kind] if several else SINGLE.get(kind)
    declaration = group(option.heading)(option.text, option.form, parser, default=... if required else None, name=option.name)
    return tuple[str, ...] if several else kind if required else kind | None, declaration
