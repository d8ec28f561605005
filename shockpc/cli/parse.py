"""Texts of the command line to values.

Every parser is given the text and the form of it that the help names, and raises typer.BadParameter with what would be valid.
"""

import math
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import typer

from shockpc.paths import usable_path

__all__ = [
    "PlaneName",
    "Setting",
    "Span",
    "Variable",
    "Vector",
    "box",
    "definition",
    "finite",
    "folder",
    "path",
    "plane_or_normal",
    "robot_name",
    "setting",
    "span",
    "variable",
    "vector",
]

Vector: TypeAlias = tuple[float, float, float]
Span: TypeAlias = tuple[float, float]
Setting: TypeAlias = tuple[str, float]
Variable: TypeAlias = tuple[str, str | None]
PlaneName: TypeAlias = Literal["xz", "yz", "xy"]


def finite(text: str, form: str = "") -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise typer.BadParameter(f'"{text}" is not a finite number')
    return value


def vector(text: str, form: str) -> Vector:
    """Three numbers with commas between them."""
    parts = text.split(",")
    if len(parts) != 3:
        raise typer.BadParameter(f'"{text}" is not {form}: three numbers with commas between them, such as 0,15,-0.5')
    return finite(parts[0]), finite(parts[1]), finite(parts[2])


def span(text: str, form: str) -> Span:
    """LOW:HIGH."""
    low, colon, high = text.partition(":")
    if not colon:
        raise typer.BadParameter(f'"{text}" is not {form}, such as -30:75')
    return finite(low), finite(high)


def box(text: str, form: str) -> tuple[Vector, Vector]:
    """The two corners of a box typed as X0:X1,Y0:Y1,Z0:Z1."""
    sides = text.split(",")
    if len(sides) != 3:
        raise typer.BadParameter(f'"{text}" is not {form}, such as -0.1:0.1,-0.05:0.05,0:0.1')
    x, y, z = (span(side, "LOW:HIGH") for side in sides)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1])


def plane_or_normal(text: str, form: str) -> PlaneName | Vector:
    """The name of a plane, or a normal."""
    names: tuple[PlaneName, ...] = get_args(PlaneName)
    for name in names:
        if text == name:
            return name
    if "," not in text:
        raise typer.BadParameter(f'"{text}" is not a plane; valid are {", ".join(names)} or a normal such as 0,-1,0')
    return vector(text, "NX,NY,NZ")


def setting(text: str, form: str) -> Setting:
    """NAME=NUMBER."""
    name, value = definition(text, form)
    try:
        return name, finite(value)
    except typer.BadParameter as refusal:
        raise typer.BadParameter(f"{name}: {refusal.message}") from None


def definition(text: str, form: str) -> tuple[str, str]:
    """NAME=TEXT, or NAME:=TEXT as xacro writes it."""
    name, equals, value = text.partition("=")
    name = name.removesuffix(":").strip()
    if not (name and equals and value.strip()):
        raise typer.BadParameter(f'"{text}" is not {form}: a name, an equals sign and a value')
    return name, value.strip()


def folder(text: str, form: str) -> tuple[str, str]:
    """NAME=DIR. A shell leaves a `~` after the equals sign as it is, so it is expanded here."""
    name, place = definition(text, form)
    return name, str(path(place))


def variable(text: str, form: str) -> Variable:
    """NAME=VALUES, which the sweep interprets; None where only a name is typed."""
    name, equals, values = (part.strip() for part in text.partition("="))
    if not name or (equals and not values):
        raise typer.BadParameter(f'"{text}" is not {form}, such as "*_KFE=-120:-10:200" or strike-angle=0,15,30')
    return name, values if equals else None


def path(text: str, form: str = "") -> Path:
    """A path that a file or folder can have."""
    try:
        return usable_path(text)
    except ValueError as refusal:
        raise typer.BadParameter(str(refusal)) from None


def robot_name(text: str, form: str = "") -> str:
    """A robot's name or path as it was typed, because `./dog` is a path and `dog` a name; what cannot be a path is neither."""
    path(text)
    return text
