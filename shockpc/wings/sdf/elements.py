"""Texts, booleans and numbers in elements of SDFormat."""

from xml.etree.ElementTree import Element

from shockpc.core.spatial import Array
from shockpc.robot.urdf.numbers import finite_numbers
from shockpc.text.errors import RobotError


def text_of(element: Element, path: str, default: str = "") -> str:
    """The text of an element below another, or a default where there is none."""
    return element.findtext(path, default).strip() or default


def boolean(text: str, subject: str) -> bool:
    """A boolean of SDFormat, false where none is written; `subject` names it in messages."""
    words = {"1": True, "true": True, "0": False, "false": False, "": False}
    value = words.get(text.lower())
    if value is None:
        raise RobotError(f'{subject} is "{text}"; it has to be true, false, 1 or 0')
    return value


def numbers_of(
    element: Element, path: str, size: int, default: str = "", subject: str = ""
) -> Array:
    """The numbers (size,) in an element below another, or in itself.

    `subject` begins the message about other content.
    """
    text = text_of(element, path, default) if path else element.text
    values = finite_numbers(text, size)
    if values is None:
        tag = path.rpartition("/")[2] or element.tag
        wanted = "one finite number" if size == 1 else f"{size} finite numbers"
        raise RobotError(f'{subject}<{tag}> is "{text}"; it has to be {wanted}')
    return values
