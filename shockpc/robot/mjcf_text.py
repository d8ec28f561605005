"""The text of an MJCF with all of its parts in it, so that MuJoCo opens no file."""

import math
import re
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.robot.files import OpenFolders, read_xml

__all__ = ["insert_includes", "without_files"]

# Sections and attributes that change no mass and no motion, some of which name files.
_UNUSED_SECTIONS = ("contact", "custom", "sensor", "statistic", "visual")
_UNUSED_ELEMENTS = ("hfield", "light", "material", "skin", "texture")
_UNUSED_ATTRIBUTES = ("material", "texture")
_LARGEST = 20_000  # elements; MuJoCo takes several seconds for so many, which grow with the square
_NOT_FINITE = re.compile(r"[+-]?(nan(\(\w*\))?|inf|infinity)", re.IGNORECASE)


def insert_includes(root: Element, folders: OpenFolders) -> str:
    """Replace every <include> of a <mujoco> element by the contents of its file, and return the text of the whole model.

    The path of every mesh is written relative to the main file. The element is changed in place.

    Raises:
        RobotError: an included file is missing, outside the open folders, or included twice.
    """
    _include(root, folders, [folders.file])
    meshdir, strip = "", False
    for compiler in root.findall("compiler"):
        meshdir = compiler.attrib.pop("meshdir", compiler.attrib.pop("assetdir", meshdir))
        strip = compiler.attrib.pop("strippath", str(strip).lower()) == "true"
    for mesh in root.findall("asset/mesh[@file]"):
        file = Path(mesh.get("file", ""))
        mesh.attrib.setdefault("name", file.stem)
        mesh.set("file", str(Path(meshdir) / (file.name if strip else file)))
    return ElementTree.tostring(root, encoding="unicode")


def _include(parent: Element, folders: OpenFolders, opened: list[Path]) -> None:
    """Insert included files below one element. MuJoCo finds all of them from the folder of the main file."""
    for child in list(parent):
        if child.tag != "include":
            _include(child, folders, opened)
            continue
        named = child.get("file", "")
        path = folders.resolve(folders.file.parent / named, named)
        if path in opened:
            raise RobotError(f'{folders.file.name} includes "{named}" twice; MuJoCo allows a file once, so save it under two names')
        if not path.is_file():
            raise RobotError(f'{folders.file.name} includes "{named}", which does not exist')
        opened.append(path)
        part = read_xml(path)
        _include(part, folders, opened)
        place = list(parent).index(child)
        parent[place : place + 1] = list(part)


def _size(element: Element) -> int:
    """The number of elements that MuJoCo makes of one."""
    count = math.prod(int(word[:9]) for word in element.get("count", "").split() if word.isdecimal())
    return max(count, 1) * (1 + sum(map(_size, element)))


def without_files(root: Element, folders: OpenFolders, parts: dict[str, bytes]) -> str:
    """Take out of a model what names files and changes neither mass nor motion: textures, materials, height fields, sensors.

    Args:
        root: its <mujoco> element, includes inserted; changed in place.
        folders: what the file may read.
        parts: receives the texts of the models that it attaches.

    Returns: the text of the model, in which meshes are named as before.

    Raises:
        RobotError: an attached model cannot be read, or a number is not finite.
    """
    size = _size(root)
    if size > _LARGEST:
        raise RobotError(
            f"{folders.file.name} has {size} elements after replication, and up to {_LARGEST} are read; lower the count of "
            "<replicate>, <composite> or <flexcomp>"
        )
    for section in [section for section in root if section.tag in _UNUSED_SECTIONS]:
        root.remove(section)
    for parent in list(root.iter()):
        for child in [child for child in parent if child.tag in _UNUSED_ELEMENTS]:
            parent.remove(child)
        for key in _UNUSED_ATTRIBUTES:
            parent.attrib.pop(key, None)
        for key, value in parent.attrib.items():
            if parent.tag != "key" and key not in ("name", "model") and any(_NOT_FINITE.fullmatch(word) for word in value.split()):
                called = f' "{parent.get("name")}"' if "name" in parent.attrib else ""
                raise RobotError(f'{folders.file.name}: {parent.tag}{called}: {key} is "{value}"; it has to be finite numbers')
    for element in root.iter():
        if "file" in element.attrib and element.tag not in ("mesh", "model"):
            raise RobotError(
                f'{folders.file.name}: <{element.tag}> names the file "{element.get("file")}", which is not read here; write out '
                "what it stands for"
            )
    for model in root.findall("asset/model[@file]"):
        named = model.get("file", "")
        path = folders.resolve(folders.file.parent / named, named)
        inner = OpenFolders(path, folders.packages, folders.allowed)
        part = read_xml(path)
        insert_includes(part, inner)
        for mesh in part.findall("asset/mesh[@file]"):
            mesh.set("file", str(path.parent / mesh.get("file", "")))
        model.attrib.setdefault("name", part.get("model", path.stem))
        key = f"part_{len(parts)}.xml"
        parts[key] = b""
        parts[key] = without_files(part, inner, parts).encode()
        model.set("file", key)
    return ElementTree.tostring(root, encoding="unicode")
