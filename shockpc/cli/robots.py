"""`shockpc robots`: what is known by name, and what is in one robot."""

import sys
from typing import Annotated

import typer

__all__ = ["robots"]


def robots(
    robot: Annotated[str | None, typer.Argument(help="A name from the list, or a robot file.", show_default=False)] = None,
) -> None:
    """List every robot known by name, or show what is in one of them."""
    sys.stdout.write("")
