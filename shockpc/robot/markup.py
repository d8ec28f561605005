"""XML from a file that nobody vouches for: read as UTF-8, parsed in one pass, nothing in it followed.

A DOCTYPE is refused, so no entity is ever defined, expanded or fetched. Prefixes are kept as written ("xacro:if"), because
robot files use them without declaring them.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from shockpc.errors import RobotError

__all__ = ["Markup", "is_xacro", "parse_markup", "read_markup", "read_text"]

_DEEPEST = 800  # elements within elements; Python's own limit is 1000 calls


@dataclass(frozen=True)
class Markup:
    """An XML file as read.

    Attributes:
        text: the whole file.
        root: its root element; tags and attributes carry their prefixes as written.
    """

    text: str
    root: Element


def read_markup(path: Path) -> Markup:
    """Read an XML file.

    Args:
        path: the file.

    Raises:
        RobotError: it is missing, not a file, not readable, empty, not UTF-8, not well-formed, or has a DOCTYPE.
    """
    text = read_text(path)
    return Markup(text, parse_markup(text, path.name))


def read_text(path: Path) -> str:
    """Read a text file.

    Raises:
        RobotError: it is missing, not a file, not readable, empty or not UTF-8.
    """
    if os.path.isdir(path):
        raise RobotError(f'"{path}" is a folder; give the robot file in it')
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise RobotError(f'no file "{path}"') from None
    except OSError as error:
        raise RobotError(f'"{path}" cannot be read: {error.strerror}; check its permissions') from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise RobotError(
            f"{path.name}: line {line}: byte 0x{data[error.start]:02x} is not UTF-8; save the file as UTF-8 text"
        ) from None
    if not text.strip():
        raise RobotError(f"{path.name} is empty; a robot file begins with <robot> (URDF, xacro) or <mujoco> (MJCF)")
    return text


def parse_markup(text: str, name: str) -> Element:
    """Parse XML text without following anything in it.

    Args:
        text: the document.
        name: what to call it in a message.

    Returns:
        The root element.

    Raises:
        RobotError: the text is not well-formed, has a DOCTYPE, or is nested beyond reason.
    """
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    builder = TreeBuilder()
    depth = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise RobotError(f"{name}: line {parser.CurrentLineNumber}: elements are nested more than {_DEEPEST} deep")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def doctype(*_: object) -> None:
        raise RobotError(
            f"{name}: line {parser.CurrentLineNumber}: a DOCTYPE can define entities, and those are never expanded here; "
            "delete the DOCTYPE and write out what its entities stand for"
        )

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        raise RobotError(
            f"{name}: line {error.lineno}, column {error.offset + 1}: {expat.ErrorString(error.code)}; "
            "the file is not well-formed XML, so nothing of it is used"
        ) from None
    return builder.close()


def is_xacro(root: Element) -> bool:
    """Whether a document uses xacro, not merely declares its namespace as many expanded files still do."""
    return any(
        element.tag.startswith("xacro:") or any(name.startswith("xacro:") for name in element.attrib) for element in root.iter()
    )
