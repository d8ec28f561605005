"""The files of a robot.

Here are the folders that may be read, the one function that opens a file, and the one XML parser.

A robot file may read its package, the folders given with it, and nothing else; that holds after
symbolic links are resolved. A file is read once, as a whole, and only if it is a regular one of at
most 64 MB. A DOCTYPE is refused, so no entity is ever defined, expanded or fetched. Prefixes are
kept as written ("xacro:if"), because robot files use them without declaring them.
"""

import codecs
import functools
import itertools
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, TypeAlias
from urllib.parse import unquote
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from shockpc.text.errors import RobotError
from shockpc.text.paths import inputs, read_file
from shockpc.text.printed import listed
from shockpc.text.wings import from_wings

# elements within elements; TinyXML-2, by which Pinocchio and MuJoCo read, stops at 500
_DEEPEST = 490
# with their attributes; 64 MB could hold sixteen million, which take gigabytes
_MOST_ELEMENTS = 500_000
_MARKS_AND_BLANKS = b"\xef\xbb\xbf \t\n\r\v\f"
MESHES = "*"
"""The package that stands for every other one: its files are found by their names only."""

FORMATS = {
    "robot": ("urdf", "URDF, xacro", "shockpc.robot.urdf.reader"),
    "mujoco": ("mjcf", "MJCF", "shockpc.robot.mjcf.reader"),
}
"""The formats of robot files by their root element: the kind of a source, the name of the format,
and the module that knows it.

A module has read(source, xacro), from a source with the bare text of the file to one with what is
read along with it; choose(source, frames), which of several robots in it is meant; and
build(source, chosen), that robot.
"""

for formats in from_wings("formats", "FORMATS"):
    FORMATS |= formats

ROOTS = " or ".join(f"<{tag}> ({name})" for tag, (_, name, _) in FORMATS.items())
"""With what robot files begin, for messages."""

_MARKS = {
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF32_LE: "utf-32-le",
    codecs.BOM_UTF32_BE: "utf-32-be",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}
"""Encodings by their byte-order marks; that of UTF-32 begins with that of UTF-16."""

_DECLARED = re.compile(r"""<\?xml[^>]*?encoding\s*=\s*["']([\w.:-]+)["']""")
_READ_BY = ("ascii", "cp037", "utf-16-le", "utf-16-be", "utf-32-le", "utf-32-be")
"""Encodings by one of which the XML declaration of any other can be read."""

_NO_CHARACTER_SETS = ("idna", "punycode", "raw_unicode_escape", "unicode_escape", "undefined")
"""Encodings of Python that are none of text files; decoding some takes time that grows with the
square of the size.
"""


_State: TypeAlias = tuple[int, int, int, int, bytes | None] | None
"""The state that tells a file from others and from a later version: device, inode, size, time of
change [ns], and its bytes if they are compared too; None if it does not exist.
"""


class OpenFolders(NamedTuple):
    """The folders that a robot file may read, and the packages that it can name.

    Attributes:
        file: the robot file, absolute.
        packages: folders given by name.
        allowed: the only folders that may be read, absolute, symbolic links resolved.
        seen: the state of every file that was asked for, just before that; it grows with each one.
    """

    file: Path
    packages: Mapping[str, Path]
    allowed: tuple[Path, ...]
    seen: "dict[Path, _State]"

    def note(self, path: Path, with_bytes: bool = False) -> None:
        """Remember the state of a file or folder that is about to be read, for `unchanged`."""
        self.seen.setdefault(path, _state(path, with_bytes))

    def unchanged(self) -> bool:
        """True if all that was read is still as it was."""
        for path, state in tuple(self.seen.items()):
            with_bytes = state is not None and state[-1] is not None
            if state != _state(path, with_bytes):
                return False
        return True

    def remember(self) -> None:
        """Note what was read as an input of this command, too.

        The robot of an earlier command may be used again.
        """
        for state in self.seen.copy().values():
            if state is not None:
                inputs.setdefault(state[:2], "file of the robot")

    def contain(self, path: Path) -> bool:
        """True if a path, after following `..` and symbolic links, lies inside the folders."""
        target = Path(os.path.realpath(path))
        return any(target.is_relative_to(folder) for folder in self.allowed)

    def resolve(self, path: Path, named: str) -> Path:
        """Return a path with links resolved, which the robot file calls `named`.

        Raises:
            RobotError: it lies outside the folders.
        """
        self.note(path)
        target = Path(os.path.realpath(path))
        if not self.contain(target):
            package = re.match("(?:package|model):/+([^/]+)(/.+)", named)
            folder = str(target).removesuffix(package[2]) if package else str(target)
            definition = "NAME=DIR"
            if package and folder != str(target):
                definition = f"{package[1]}={folder}"
            raise RobotError(
                f'{self.file.name}: "{named}" leads to "{target}", outside the folders that may be '
                f"read ({listed(self.allowed)}). "
                f"If it belongs to the robot, name the folder that holds it: --package {definition}"
            )
        return target

    def package(self, name: str, named: str) -> Path:
        """Find a package as given, then in ROS_PACKAGE_PATH, then above the file.

        Raises:
            RobotError: there is none; the text calls what needs it `named`.
        """
        if name in self.packages:
            return self.packages[name]
        # What cannot be the name of a package might lead anywhere as a path.
        if len(name) <= 255 and re.fullmatch(r"[\w.-]*\w[\w.-]*", name):
            among: list[Path] = []
            for entry in _ros_package_path():
                among += [entry, entry / name, *entry.glob(f"*/{name}")]
            for folder in (*among, *self.file.parents):
                if os.path.isdir(folder) and name in (folder.name, self._package_name(folder)):
                    return folder
        raise RobotError(
            f'{self.file.name}: {named}: no package "{name}" among those given, in '
            f"ROS_PACKAGE_PATH or above the file. Give its folder with --package {name}=DIR, or "
            "the folder of its meshes with --meshes DIR"
        )

    def asset(self, uri: str) -> Path:
        """Find the file that a robot file names.

        It is an existing one inside the folders, symbolic links resolved.

        What is not where it is named is looked for by its name in the folder of the package "*", if
        that is given: of several files of one name it is the one whose path ends like the one that
        is named.

        Raises:
            RobotError: as `_as_named`; it is not in that folder either, or as much of two paths
                ends alike.
        """
        try:
            return self._as_named(uri)
        except RobotError as refusal:
            if MESHES not in self.packages:
                raise
            return self._by_name(uri, refusal)

    def _by_name(self, uri: str, refusal: RobotError) -> Path:
        """A file of the folder of meshes with the name of the one that is missing."""
        folder, wanted = self.packages[MESHES], [part for part in unquote(uri).split("/") if part]
        self.note(folder)
        alike: dict[int, list[Path]] = {}
        for directory, _, files in os.walk(folder):
            if not wanted or wanted[-1] not in files:
                continue
            path = Path(directory, wanted[-1])
            same = (a == b for a, b in zip(reversed(wanted), reversed(path.parts), strict=False))
            alike.setdefault(sum(1 for _ in itertools.takewhile(bool, same)), []).append(path)
        if not alike:
            raise RobotError(f'{refusal}; nor is a file of this name in "{folder}" (--meshes)')
        likest = sorted(alike[max(alike)])
        if len(likest) > 1:
            raise RobotError(
                f'{self.file.name}: "{uri}" may be "{likest[0]}" or "{likest[1]}"; name a folder '
                f"with one of them, or the package"
            )
        return self.resolve(likest[0], uri)

    def _as_named(self, uri: str) -> Path:
        """Find a file where the robot file says that it is.

        It names it by `package://name/rest` (more slashes are accepted, `model://` is read alike;
        an empty name is the folder of the robot file), by `file:///path`, by an absolute path, or
        by one relative to the robot file.

        Raises:
            RobotError: it is missing, its package is unknown, or it lies outside the folders.
        """
        scheme, separator, location = uri.partition("://")
        if not separator:
            path = self.file.parent / uri
        elif scheme == "file":
            path = self.file.parent / unquote(location.removeprefix("localhost"))
        elif scheme in ("package", "model"):
            name, _, inside = location.lstrip("/").partition("/")
            beside = self.file.parent / location.lstrip("/")  # what no package is named for
            nameless = location.startswith("/") and (not inside or os.path.isfile(beside))
            path = beside if nameless else self.package(name, f'"{uri}"') / inside
        else:
            raise RobotError(
                f'{self.file.name}: "{uri}" is not on this machine; only package:// and file:// '
                f"are followed"
            )
        target = self.resolve(path, uri)
        if not os.path.isfile(target):
            raise RobotError(f'{self.file.name}: "{uri}" is missing: no file "{target}"')
        return target

    def _package_name(self, folder: Path) -> str | None:
        """The name that a folder's package.xml gives to the package.

        None without a package.xml, or outside the open folders.
        """
        path = folder / "package.xml"
        readable = os.path.isfile(path) and self.contain(path)
        self.note(path)
        match = (
            re.search(rb"<name>([^<]*)</name>", read_file(path, "file", RobotError))
            if readable
            else None
        )
        return match[1].strip().decode(errors="replace") if match else None


def open_folders(file: Path, packages: Mapping[str, str]) -> OpenFolders:
    """Work out what a robot file may read.

    It is its folder, the packages, folders given by name, and ROS_PACKAGE_PATH.

    Its folder is the nearest one above it with a `package.xml`; else the parent of the folder that
    holds it, as meshes often lie beside that, unless the home folder lies in there.

    Raises:
        RobotError: a given package folder does not exist.
    """
    by_name: dict[str, Path] = {}
    for name, folder in packages.items():
        named_folder = Path(os.path.expanduser(folder))
        if not os.path.isdir(named_folder):
            option = "--meshes DIR" if name == MESHES else f"--package {name}=DIR"
            raise RobotError(f'package "{name}": there is no folder "{folder}"; correct {option}')
        by_name[name] = named_folder.resolve()
    above = file.parent.parent
    home = Path(os.path.realpath(os.path.expanduser("~")))
    packages_above = (folder for folder in file.parents if os.path.isfile(folder / "package.xml"))
    opened = next(packages_above, file.parent if home.is_relative_to(above) else above)
    allowed = [opened.resolve(), *by_name.values()]
    for entry in _ros_package_path():
        allowed.append(Path(os.path.realpath(entry)))
    return OpenFolders(file, by_name, tuple(dict.fromkeys(allowed)), {})


def _state(path: Path, with_bytes: bool) -> _State:
    """The state of a file or folder, with its bytes if they are to be compared as a whole."""
    try:
        status = os.stat(path)
        return (
            status.st_dev,
            status.st_ino,
            status.st_size,
            status.st_mtime_ns,
            read_file(path, "file", RobotError) if with_bytes else None,
        )
    except (OSError, RobotError):
        return None


def _ros_package_path() -> list[Path]:
    """The folders that ROS_PACKAGE_PATH lists and that exist."""
    entries = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    return [Path(entry) for entry in entries if entry.strip() and os.path.isdir(entry)]


def decoded(data: bytes) -> str:
    """The text of XML data.

    It is in the encoding of its byte-order mark or of its declaration, any that Python knows; else
    in UTF-8.

    Raises:
        UnicodeDecodeError: it is in neither.
    """
    for mark, encoding in _MARKS.items():
        if data.startswith(mark):
            return data.removeprefix(mark).decode(encoding)
    # What begins as ASCII is in none of the others; to load these takes a hundredth of a short run.
    begins_as_ascii = data[:1] == b"<" and data[1:2] != b"\0"
    for reading in _READ_BY[:1] if begins_as_ascii else _READ_BY:
        if declared := _DECLARED.match(data[:400].decode(reading, "replace")):
            with suppress(LookupError, UnicodeError):
                encoding = codecs.lookup(reading if reading.startswith("utf") else declared[1]).name
                # Bytes that are not in the encoding that they name, as those of UTF-8 called
                # UTF-16, may still be decoded.
                if encoding in _NO_CHARACTER_SETS:
                    continue
                text = data.decode(encoding)
                if text.startswith(declared[0]):
                    return text
    return data.decode()


def read_text(path: Path, kind: str = "robot file") -> str:
    """Read an XML file, as `decoded`; byte-order marks and blanks before it are left out.

    Raises:
        RobotError: as `read_file`; or it is empty, or no text.
    """
    data = read_file(path, kind, RobotError)
    start = data.lstrip(_MARKS_AND_BLANKS)
    if not start:
        raise RobotError(f"{path.name} is empty; a robot file begins with {ROOTS}")
    try:
        text = decoded(start).lstrip()
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, len(data) - len(start) + error.start) + 1
        byte = f"byte 0x{error.object[error.start]:02x}"
        raise RobotError(
            f"{path.name}: line {line}: {byte} is not {error.encoding.upper()}; save the file as "
            f"UTF-8 text"
        ) from None
    if "\0" in text:
        raise RobotError(
            f"{path.name} holds NUL characters, as text in UTF-16 does; save the file as UTF-8 text"
        )
    return text


def read_xml(path: Path, kind: str = "robot file") -> Element:
    """Read an XML file and return its root element.

    Raises:
        RobotError: as `read_text` and `parse_xml`.
    """
    return parse_xml(read_text(path, kind), path.name)


@functools.lru_cache(maxsize=2)
def shared_xml(text: str, name: str) -> Element:
    """As `parse_xml`, but parsed once for all who ask again.

    None of them may change the elements.
    """
    return parse_xml(text, name)


def parse_xml(text: str, name: str) -> Element:
    """Parse XML text without following anything in it, and return its root element.

    Messages call the text by a name.

    Tags and attributes carry their prefixes as written; values are without blanks around them.

    Raises:
        RobotError: the text is not well-formed, has a DOCTYPE, more than 490 levels, or more than
            500 000 elements and attributes.
    """
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    builder = TreeBuilder()
    depth, count, ended = 0, 0, None

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth, count = depth + 1, count + 1 + len(attributes)
        if depth > _DEEPEST:
            raise RobotError(
                f"{name}: line {parser.CurrentLineNumber}: elements are nested more than "
                f"{_DEEPEST} deep"
            )
        if count > _MOST_ELEMENTS:
            limit = f"up to {_MOST_ELEMENTS} elements and attributes are read"
            raise RobotError(
                f"{name}: line {parser.CurrentLineNumber}: {limit}, and there are more; leave out "
                f"what is not used"
            )
        builder.start(tag, {key: value.strip() for key, value in attributes.items()})

    def end(tag: str) -> None:
        nonlocal depth, ended
        depth -= 1
        ended = builder.end(tag)

    def doctype(*_: object) -> None:
        remedy = (
            "a DOCTYPE can define entities, and those are never expanded here; delete it and write "
            "out what they stand for"
        )
        raise RobotError(f"{name}: line {parser.CurrentLineNumber}: {remedy}")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = builder.data, doctype
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        # Closing tags left over after the root element are not read by other parsers either.
        if (
            depth
            or ended is None
            or not re.fullmatch(
                rb"/[^<>]*>\s*(</[^<>]*>\s*)*+", text.encode()[parser.ErrorByteIndex :]
            )
        ):
            raise RobotError(
                f"{name}: line {error.lineno}, column {error.offset + 1}: "
                f"{expat.ErrorString(error.code)}; "
                "the file is not well-formed XML, so nothing of it is used"
            ) from None
    return builder.close()
