"""What a study reads from files and the options of a landing: scenes, landings or designs."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from shockpc.cli.declared import argument
from shockpc.cli.options import ROBOT, SceneOptions
from shockpc.cli.parse import typed_robot
from shockpc.cli.scenes import landings_from, one_scene, postures_from
from shockpc.evaluation.designs import Design
from shockpc.robot.robot import Robot
from shockpc.text.trace import Trace
from shockpc.text.wings import from_wings


class CommandLine(NamedTuple):
    """What was typed for a study.

    Attributes:
        inputs: values of the arguments of its `Input`.
        options: of a landing.
        study: values of the study's own options, by parameter.
        trace: collects what each stage cost.
    """

    inputs: Sequence[Any]
    options: SceneOptions
    study: Mapping[str, Any]
    trace: Trace


class Input(NamedTuple):
    """The input of a study from files and the options of a landing.

    Attributes:
        typed: arguments of the command by name, with type and declaration; the options of a landing
            complete them.
        read: makes the first robot, and arguments of the study, of what was typed.
        file: whether the first argument is the path of a file, which the report takes before the
            result.
        check: refuses options that have no effect, by the options, the arguments of the study and
            its result.
    """

    typed: dict[str, tuple[Any, Any]]
    read: Callable[[CommandLine], tuple[Robot, dict[str, Any]]]
    file: bool = False
    check: Callable[[SceneOptions, Mapping[str, Any], Any], None] | None = None


def _scene(line: CommandLine) -> tuple[Robot, dict[str, Any]]:
    robot, scene = one_scene(line.inputs[0], line.options, line.trace)
    return robot, {"scene": scene, "robot": robot}


def _landings(line: CommandLine) -> tuple[Robot, dict[str, Any]]:
    landings = landings_from(line.inputs[0], line.options, line.trace)
    first_robot, _ = next(iter(landings.values()))
    scenes = {name: scene for name, (_, scene) in landings.items()}
    return first_robot, {"landings": scenes}


def _postures(line: CommandLine) -> tuple[Robot, dict[str, Any]]:
    robot, postures = postures_from(line.inputs[0], line.options, line.trace)
    return robot, {"postures": postures, "robot": robot}


def _designs(line: CommandLine) -> tuple[Robot, dict[str, Any]]:
    """As many contacts as there are designs are one for each."""
    (names,), options = line.inputs, line.options
    options_of_each = [options] * len(names)
    if len(options.contact) == len(names) > 1:
        options_of_each = [options._replace(contact=(name,)) for name in options.contact]
    designs = []
    for name, options_of_design in zip(names, options_of_each, strict=True):
        robot, scene = one_scene(name, options_of_design)
        designs.append(Design(name, scene, robot))
    return designs[0].robot, {"designs": designs}


def _several(help_: str, form: str) -> tuple[Any, Any]:
    """Type and declaration of one or more names of robots, robot files or scenes."""
    return tuple[str, ...], argument(help_, form, typed_robot, default=...)


INPUTS: dict[str, Input] = {
    "scene": Input({"scene": (str, ROBOT)}, _scene),
    "landings": Input(
        {
            "landings": _several(
                "Scenes (TOML), or a robot: all level feet together, each edge of their support, "
                "and each foot.",
                "SCENE...",
            )
        },
        _landings,
    ),
    "postures": Input(
        {
            "postures": _several(
                "A robot, or scenes (TOML) of one robot in several postures.", "SCENE..."
            )
        },
        _postures,
    ),
    "designs": Input(
        {"designs": _several("Robot files, robots by name or scenes (TOML).", "DESIGN...")},
        _designs,
    ),
}
"""Inputs of a study, by the name of its parameter; wings add what their studies read.

They are one landing; landings by name, without contacts those of `default_landings`; postures of
one robot by name; one landing of each design.
"""


def inputs_of(reads: str) -> Input:
    """The input of a study that reads this."""
    known = dict(INPUTS)
    for inputs in from_wings("inputs", "INPUTS"):
        known |= inputs
    return known[reads]
