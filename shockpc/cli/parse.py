"""Texts of the command line to values; every refusal says what would be valid."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import typer

from shockpc.paths import usable_path

__all__ = [
    "Definition",
    "Setting",
    "Span",
    "Variable",
    "Vector",
    "definition",
    "finite",
    "folder_definition",
    "limits",
    "path",
    "plane_or_normal",
    "positive_count",
    "robot_name",
    "setting",
    "span",
    "variable",
    "vector",
]


PLANES = ("xz", "yz", "xy")
"""The planes that have a name."""


class Vector(NamedTuple):
    """Three numbers typed with commas between them."""

    x: float
    y: float
    z: float


class Span(NamedTuple):
    """LOW:HIGH."""

    low: float
    high: float


class Setting(NamedTuple):
    """NAME=NUMBER."""

    name: str
    value: float


class Definition(NamedTuple):
    """NAME=TEXT, or NAME:=TEXT as xacro writes it."""

    name: str
    value: str


def positive_count(text: str) -> int:
    """A whole number above zero.

    Raises:
        typer.BadParameter: it is not one.
    """
    if not (text.isascii() and text.isdigit() and 0 < len(text.lstrip("0")) < 10):
        raise typer.BadParameter(f'"{text}" is not a whole number above zero')
    return int(text)


class Variable(NamedTuple):
    """NAME=VALUES; values are None where only a name is typed."""

    name: str
    values: str | None


def finite(text: str) -> float:
    """A finite number.

    Raises:
        typer.BadParameter: it is not one.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise typer.BadParameter(f'"{text}" is not a finite number')
    return value


def vector(example: str) -> Callable[[str], Vector]:
    """A parser of three numbers with commas between them; the example, such as "0,0,-0.02", is for its messages."""

    def parse(text: str) -> Vector:
        parts = text.split(",")
        if len(parts) != 3:
            raise typer.BadParameter(f'"{text}" is not three numbers with commas between them, such as {example}')
        return Vector(*map(finite, parts))

    return parse


def span(example: str) -> Callable[[str], Span]:
    """A parser of LOW:HIGH; the example, such as "-30:75", is for its messages."""

    def parse(text: str) -> Span:
        low, colon, high = text.partition(":")
        if not colon:
            raise typer.BadParameter(f'"{text}" is not LOW:HIGH, such as {example}')
        return Span(finite(low), finite(high))

    return parse


def plane_or_normal(text: str) -> str | Vector:
    """The name of a plane, or a normal.

    Raises:
        typer.BadParameter: it is neither.
    """
    if text in PLANES:
        return text
    if "," not in text:
        raise typer.BadParameter(f'"{text}" is not a plane; valid are {", ".join(PLANES)} or a normal such as 0,-1,0')
    return vector("0,-1,0")(text)


def setting(form: str, example: str) -> Callable[[str], Setting]:
    """A parser of NAME=NUMBER.

    Args:
        form: what the option takes, such as "JOINT=VALUE", for its messages.
        example: a valid value, for its messages.
    """

    def parse(text: str) -> Setting:
        name, value = definition(form, example)(text)
        try:
            return Setting(name, finite(value))
        except typer.BadParameter as refusal:
            raise typer.BadParameter(f"{name}: {refusal.message}") from None

    return parse


def definition(form: str, example: str) -> Callable[[str], Definition]:
    """A parser of NAME=TEXT or NAME:=TEXT; form and example are for its messages."""

    def parse(text: str) -> Definition:
        name, equals, value = text.partition("=")
        name = name.removesuffix(":").strip()
        if not (name and equals and value.strip()):
            raise typer.BadParameter(f'"{text}" is not {form}, such as {example}')
        return Definition(name, value.strip())

    return parse


def variable(text: str) -> Variable:
    """A quantity and its values, which the sweep interprets.

    Raises:
        typer.BadParameter: one of them is empty.
    """
    name, equals, values = (part.strip() for part in text.partition("="))
    if not name or (equals and not values):
        raise typer.BadParameter(f'"{text}" is not NAME=VALUES, such as "*_KFE=-120:-10:200" or strike-angle=0,15,30')
    return Variable(name, values if equals else None)


def folder_definition(text: str) -> Definition:
    """The package and its folder in NAME=DIR. A shell leaves a `~` after the equals sign as it is, so it is expanded here."""
    name, folder = definition("NAME=DIR", "dog_description=../dog")(text)
    return Definition(name, str(path(folder)))


def limits(text: str) -> tuple[Vector, Vector]:
    """The two corners of a box typed as X0:X1,Y0:Y1,Z0:Z1.

    Raises:
        typer.BadParameter: it is not a box.
    """
    sides = [side.split(":") for side in text.split(",")]
    if [len(side) for side in sides] != [2, 2, 2]:
        raise typer.BadParameter(f'"{text}" is not a box X0:X1,Y0:Y1,Z0:Z1, such as -0.1:0.1,-0.05:0.05,0:0.1')
    return Vector(*(finite(side[0]) for side in sides)), Vector(*(finite(side[1]) for side in sides))


def path(text: str) -> Path:
    """A path that a file or folder can have.

    Raises:
        typer.BadParameter: none can.
    """
    try:
        return usable_path(text)
    except ValueError as refusal:
        raise typer.BadParameter(str(refusal)) from None


def robot_name(text: str) -> str:
    """A robot's name or path as it was typed, because `./dog` is a path and `dog` a name.

    Raises:
        typer.BadParameter: it cannot be a path, so it is no name either.
    """
    path(text)
    return text
