"""Texts of the command line to values.

Every parser raises typer.BadParameter with what would be valid.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias, get_args

import typer

from shockpc.core.interval import Interval
from shockpc.core.number import NUMBER, number_from, whole_from
from shockpc.landing.scenes.joint_options import JointModelName
from shockpc.landing.scenes.scene_fields import Option
from shockpc.robot.gear import SENSE, Gear
from shockpc.text.errors import OutputError
from shockpc.text.paths import is_path, usable_path

Vector: TypeAlias = tuple[float, float, float]
Span: TypeAlias = tuple[float, float]
Setting: TypeAlias = tuple[str, float]
Variable: TypeAlias = tuple[str, str | None]
Inertia: TypeAlias = tuple[str, Interval]
"""Joint, and its reflected inertia."""
Motor: TypeAlias = tuple[str, tuple[Interval, Interval | None, float | None, Gear | None]]
"""Joint; inertia, gear ratio and stiffness of a rotor, and the kind of its gear."""


def finite(text: str) -> float:
    """A finite number."""
    try:
        return number_from(str(text))  # a default is a number
    except ValueError:
        unit = (
            "; leave out the unit, which the help states"
            if re.match(rf"{NUMBER} *[a-zA-Z°µ\u03bc]", text)
            else ""
        )
        raise typer.BadParameter(f'"{text}" is not a finite number{unit}') from None


def whole_number(option: Option) -> Callable[[str], int]:
    """A parser of a whole number within the bounds of an option."""

    def read(text: str) -> int:
        try:
            value = whole_from(str(text))  # a default is a number
        except ValueError as refusal:
            raise typer.BadParameter(str(refusal)) from None
        if fault := option.fault(value):
            raise typer.BadParameter(fault)
        return value

    return read


def _split(text: str, separator: str, example: str) -> list[str]:
    """The parts of a text, as many as an example has."""
    parts = text.split(separator)
    if len(parts) != (count := example.count(separator) + 1):
        raise typer.BadParameter(
            f'"{text}" is not {count} values with "{separator}" between them, such as {example}'
        )
    return parts


def vector(text: str) -> Vector:
    """Three numbers with commas between them."""
    x, y, z = _split(text, ",", "0,15,-0.5")
    return finite(x), finite(y), finite(z)


def number_list(text: str) -> tuple[float, ...]:
    """Numbers with commas between them."""
    return tuple(map(finite, text.split(",")))


def directions(text: str) -> tuple[str | Vector, ...]:
    """Axes such as xz or x,z, or vectors X,Y,Z with semicolons between them."""
    axes = text.replace(",", "")
    different = len(set(axes)) == len(axes)
    if axes and different and set(axes) <= set("xyz"):
        return tuple(axes)
    if text.count(",") < 2:
        raise typer.BadParameter(
            f'"{text}" is neither axes, such as xz, nor vectors, such as "1,0,1;0,1,0"'
        )
    return tuple(vector(part) for part in text.split(";"))


def pair_of(text: str) -> tuple[str, str]:
    """A=B."""
    first, second = _split(text, "=", "FL_thigh=lf_upperleg")
    globs = first.count("*")
    if not (first and second) or globs != second.count("*") or globs > 1:
        raise typer.BadParameter(
            f'"{text}" is not a pair of names, or of names with one * each, such as FL_*=lf_*'
        )
    return first, second


def span(text: str) -> Span:
    """LOW:HIGH."""
    low, high = _split(text, ":", "-30:75")
    return finite(low), finite(high)


def stiffness(text: str) -> tuple[float, float | None]:
    """K, or KN:KT."""
    return span(text) if ":" in text else (finite(text), None)


def corners(text: str) -> tuple[Vector, Vector]:
    """The two corners of a box typed as X0:X1,Y0:Y1,Z0:Z1."""
    x, y, z = map(span, _split(text, ",", "-0.1:0.1,-0.05:0.05,0:0.1"))
    return (x[0], y[0], z[0]), (x[1], y[1], z[1])


def plane(text: str) -> str | Vector:
    """The name of a plane, which the scene checks, or a normal."""
    return vector(text) if "," in text else text


def setting(text: str) -> Setting:
    """NAME=NUMBER."""
    name, value = definition(text)
    return name, finite(value)


def armature(text: str) -> Inertia:
    """JOINT=INERTIA, or JOINT=LOW:HIGH."""
    name, value = definition(text)
    return name, span(value) if ":" in value else finite(value)


def rotor(text: str) -> Motor:
    """Rotor from JOINT=INERTIA[:RATIO[:STIFFNESS]][:GEAR].

    The inertia and the ratio may each be [LOW,HIGH].
    """
    name, values = definition(text)
    numbers = values.split(":")
    gear = next((kind for kind in SENSE if kind == numbers[-1]), None)
    if gear is not None:
        numbers.pop()
    no_gear = len(numbers) > 1 and numbers[-1].isalpha()
    if no_gear or not 1 <= len(numbers) <= 3:
        raise typer.BadParameter(
            f'"{text}" is not JOINT=INERTIA[:RATIO[:STIFFNESS]][:GEAR], such as '
            f'"*_knee=1.1e-4:9:planetary"; '
            f"gears are {', '.join(SENSE)}"
        )
    inertia = _interval(numbers[0])
    ratio = _interval(numbers[1]) if len(numbers) > 1 else None
    stiffness = finite(numbers[2]) if len(numbers) > 2 else None
    return name, (inertia, ratio, stiffness, gear)


def _interval(text: str) -> Interval:
    """A number, or [LOW,HIGH]."""
    if not (text.startswith("[") and text.endswith("]")):
        return finite(text)
    low, high = _split(text[1:-1], ",", "3e-5,1.2e-4")
    return finite(low), finite(high)


def drives(text: str) -> str:
    """The path of a file of drives, a robot's name, or none."""
    return str(path(text)) if is_path(text) else text


def definition(text: str) -> tuple[str, str]:
    """NAME=TEXT, or NAME:=TEXT as xacro writes it."""
    name, value = variable(text)
    name = name.removesuffix(":").strip()
    if not name or value is None:
        raise typer.BadParameter(f'"{text}" is not NAME=VALUE: a name, an equals sign and a value')
    return name, value


def renaming(text: str) -> tuple[str, str]:
    """NAME=NAME, or NAME= with nothing after it."""
    name, equals, new = (part.strip() for part in text.partition("="))
    globs = name.count("*")
    if not name or not equals or new.count("*") > globs or globs > 1:
        raise typer.BadParameter(
            f'"{text}" is not NAME=NAME, a column of the table and its other name, with at most '
            f"one * in each"
        )
    return name, new


def joint_models(text: str) -> tuple[JointModelName, ...]:
    """Joint models with commas between them."""
    known: dict[str, JointModelName] = {name: name for name in get_args(JointModelName)}
    models = [part.strip() for part in text.split(",")]
    if unknown := [model for model in models if model not in known]:
        raise typer.BadParameter(
            f'"{unknown[0]}" is not a joint model; valid are {", ".join(known)}'
        )
    return tuple(dict.fromkeys(known[model] for model in models))


def folder(text: str) -> tuple[str, str]:
    """NAME=DIR. A shell leaves a `~` after the equals sign as it is, so it is expanded here."""
    name, place = definition(text)
    return name, str(path(place))


def variable(text: str) -> Variable:
    """NAME=VALUES, which the sweep interprets; None where only a name is typed."""
    name, equals, values = (part.strip() for part in text.partition("="))
    if not name or (equals and not values):
        raise typer.BadParameter(f'"{text}" is not NAME=VALUE: a name, an equals sign and a value')
    return name, values if equals else None


def path(text: str) -> Path:
    """A path that a file or folder can have."""
    try:
        return usable_path(text)
    except ValueError as refusal:
        raise typer.BadParameter(str(refusal)) from None


def typed_robot(text: str) -> str:
    """A robot's name or path as it was typed.

    It is kept because `./dog` is a path and `dog` a name; what cannot be a path is neither.
    """
    path(text)
    return text


def out_folder(text: str) -> Path:
    """A folder in which results can be written, which is found out before anything is computed."""
    from shockpc.show.files import check_folder

    folder = path(text)
    if folder.suffix.casefold() == ".pdf":
        raise typer.BadParameter(
            f'"{text}" would be a folder, not a PDF file; for figures as PDF write --format pdf '
            "--out DIR"
        )
    check_folder(folder, "--out")
    return folder


def scene_file(text: str) -> Path:
    """The file of a scene that can be written."""
    if not text.casefold().endswith(".toml"):
        raise typer.BadParameter(f'"{text}" would not be read as a scene, whose name ends in .toml')
    return writable(path(text), "--save-scene")


def writable(file: Path, option: str) -> Path:
    """The file of an option, if it can be written, which is found out before anything is computed.

    Raises:
        OutputError: it cannot.
    """
    from shockpc.show.files import check_folder, destination

    folder = destination(file).parent
    if not folder.exists():
        raise OutputError(
            f'there is no folder "{folder}" for {option}; make it, or name another file'
        )
    check_folder(folder, option)
    return file
