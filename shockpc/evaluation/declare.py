"""Declaration of a study: once, as a function.

Its command, options, help and documentation follow from that.

    @study("shockpc limits hyq --joint lf_kfe_joint --at trunk_imu --max 0.1")
    def limits(scene: Scene, joint: Annotated[str, Option("The joint.", "Question", "JOINT")], …) ->
    JointLimits: …

A parameter whose annotation has an `Option` is an option of the command; what the command passes
for others is declared by `reads` and `passed`. An argument that is not of the type of its
parameter, or beyond the bounds of its option, is a StudyError.
"""

import functools
import inspect
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias, TypeVar, cast, get_args

from shockpc.landing.scenes.scene_fields import Option, describe
from shockpc.quantities.renamed import current_name
from shockpc.text.arguments import checked, is_numeric

F = TypeVar("F", bound=Callable[..., Any])

Reads: TypeAlias = str
"""Name of the parameter for which a command reads an input.

`shockpc.cli.study_inputs.INPUTS` describes what it reads.
"""

Passed: TypeAlias = Literal["target", "trace", "progress"]
"""Further arguments that a command passes to a study.

They are the number that the study is about, by --at or --quantity; what measures stages, for
--explain; and a function that makes one which counts, of the number of landings.
"""


QuantityOption: TypeAlias = Annotated[
    Sequence[str],
    Option(
        "Another quantity, as shockpc quantities lists them: at all places of its kind, or at "
        "PLACE, a name or glob.",
        "What is computed",
        "KEY[@PLACE]",
        "quantity",
        holds="quantity",
    ),
]
"""Further columns of a table, as `shockpc.evaluation.column.selected` takes them."""


class StudyParameter(NamedTuple):
    """A parameter of a study that is an option.

    Attributes:
        kind: its type.
        option: its declaration.
        default: as in the signature, `inspect.Parameter.empty` if it is required.
    """

    kind: Any
    option: Option
    default: Any


class Study(NamedTuple):
    """The declaration of a study.

    Attributes:
        parameters: those that are options, by name.
        examples: command lines.
        more: a paragraph for the help of its command, or nothing.
        typed: makes arguments in SI units of what was typed, where a robot's joints decide on the
            units.
        without: options of a landing that the study refuses, which its command does not take: by
            their names with underscores, or by their headings.
        uses: "pulse", "imu-bandwidth", "range-g" or "part", if its numbers depend on these whatever
            quantities are asked for.
        reads: the parameter for what is read; None for a study whose command is written out.
        passed: further parameters that the command passes.
        fails: whether the result has `landings`, and `failures` of those that could not be
            computed, which decide on the exit code.
    """

    parameters: dict[str, StudyParameter]
    examples: tuple[str, ...]
    more: str
    typed: Callable[[Any, dict[str, Any]], dict[str, Any]]
    without: tuple[str, ...]
    uses: tuple[str, ...]
    reads: Reads | None
    passed: tuple[Passed, ...]
    fails: bool


def study(
    *examples: str,
    more: str = "",
    typed: Callable[[Any, dict[str, Any]], dict[str, Any]] = lambda robot, given: given,
    without: tuple[str, ...] = (),
    uses: tuple[str, ...] = (),
    reads: Reads | None = None,
    passed: tuple[Passed, ...] = (),
    fails: bool = False,
) -> Callable[[F], F]:
    """Declare a function as a study, and list its options in its docstring.

    Arguments are those of `Study`. Options whose unit is deg are typed in degrees, and are
    arguments in radians.
    """

    def declare(function: F) -> F:
        signature = inspect.signature(function)
        parameters = _options_of(signature)
        # Python's help prints annotations whole, so the options are left out of them.
        plain = []
        for name, parameter in signature.parameters.items():
            if name in parameters:
                parameter = parameter.replace(annotation=parameters[name].kind)
            plain.append(parameter)
        in_si: dict[str, Option] = {}
        for name, declared in parameters.items():
            unit = declared.option.unit.replace("deg", "rad")
            in_si[name] = declared.option._replace(unit=unit)
        describe(function, in_si)
        faults = {
            name: in_si[name].fault
            for name, declared in parameters.items()
            if is_numeric(declared.kind)
        }
        quantities = [
            name for name, declared in parameters.items() if declared.option.holds == "quantity"
        ]
        run = _with_current_names(function, quantities) if quantities else function
        call = checked(run, signature.replace(parameters=plain), faults)
        vars(call)["study"] = Study(
            parameters, examples, more, typed, without, uses, reads, passed, fails
        )
        return call

    return declare


def _options_of(signature: inspect.Signature) -> dict[str, StudyParameter]:
    """The parameters whose annotation is Annotated[kind, Option(...)], each named as an option."""
    parameters: dict[str, StudyParameter] = {}
    for name, parameter in signature.parameters.items():
        kind, *annotations = get_args(parameter.annotation) or (None,)
        for annotation in annotations:
            if isinstance(annotation, Option):
                option = annotation._replace(name=annotation.name or name.replace("_", "-"))
                parameters[name] = StudyParameter(kind, option, parameter.default)
    return parameters


def _with_current_names(function: F, names: Sequence[str]) -> F:
    """The function, with the current keys of quantities in the arguments that name some.

    Args:
        function: a study.
        names: of its parameters that hold a text, or several, each of which names a quantity.
    """
    signature = inspect.signature(function)

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        bound = signature.bind(*args, **kwargs)
        for name in names:
            value = bound.arguments.get(name)
            if isinstance(value, str):
                bound.arguments[name] = current_name(value)
            elif value is not None:
                bound.arguments[name] = tuple(map(current_name, value))
        return function(*bound.args, **bound.kwargs)

    return cast(F, call)


def declaration(function: Callable[..., Any]) -> Study:
    """The declaration of a study."""
    declared: Study = vars(function)["study"]
    return declared
