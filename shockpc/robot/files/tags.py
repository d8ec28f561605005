"""Content of URDF and SDFormat files that is not read although it may change a shock.

It follows from tables of tags and attributes.

A row of a table has a path of tags from the root, the names at that path, of which "(element)" is
the element itself, "(text)" its text and the others are its attributes, and a treatment: read; no
effect on a shock; note, which the check-up reports; warn; refuse. Braces list alternatives, "**" is
all below, and "*" all attributes. `when` is the key of a test in `_TESTS` that a value has to pass
to be reported. Of an element that may stand `once` the first copy counts; of several shapes in one
geometry the first.
"""

import csv
import functools
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias, cast
from xml.etree.ElementTree import Element

from shockpc.text.printed import few, listed, printable

Treatment: TypeAlias = Literal["read", "no effect", "note", "warn", "refuse"]

URDF = Path(__file__).parents[1] / "urdf" / "tags.csv"
"""The table of a <robot>."""

_CLOSE = 0.7
"""Similarity from which an unknown name is taken for a misspelt one where unknown names are
allowed, as `difflib` has it.
"""
_NEAREST = 0.6
"""Similarity from which a known name is offered for an unknown one."""
_MOST = 20
"""Largest number of kinds reported of one treatment; of more only the number."""
_TRIES = 500
"""Largest number of unknown names of one file that are compared with known ones where unknown names
are allowed.
"""
_STRICT = (
    "link",
    "joint",
    "loop_joint",
    "drake:ball_constraint",
    "frame",
    "drake:frame",
    "fixed_frame",
    "sensor",
)
"""Elements of the root in which every unknown name is reported."""
_ALL, _TEXT_OF = "*", "(text)"
_NAMELESS = ("collision", "visual", "parent", "child")


class Unread(NamedTuple):
    """One kind of thing in a file that is not read, or not as it may be meant.

    Attributes:
        treatment: note, warn or refuse.
        text: where it stands, how often, and what that means.
    """

    treatment: Treatment
    text: str


class _Rule(NamedTuple):
    """A treatment, the condition of a report, and its text.

    The text is empty where there is nothing to report.
    """

    treatment: Treatment
    when: str = ""
    consequence: str = ""


@dataclass(eq=False, repr=False)
class _Node:
    """A tag at its place in the table; unknown without a rule of its element."""

    path: str
    element: _Rule | None = None
    once: str = ""
    attributes: dict[str, _Rule] = field(default_factory=dict)
    below: "dict[str, _Node]" = field(default_factory=dict)
    deep: _Rule | None = None

    @property
    def tags(self) -> dict[str, _Rule]:
        """The known tags below."""
        return {tag: node.element for tag, node in self.below.items() if node.element is not None}


_NOWHERE = _Node("")
_TWICE = _Rule(
    "warn", "", "stands twice in one element, and the copies differ; the first one is used"
)
_TEXT = _Rule(
    "warn",
    "",
    "holds text and no attributes, which is not read: its numbers are written as attributes",
)


def unread(root: Element, *tables: Path) -> tuple[Unread, ...]:
    """The content of a file that is not read although it may change a shock.

    There is one record for each kind.

    Args:
        root: its <robot> or <model>.
        tables: those of its format.
    """
    walk = _Walk(
        frozenset(part.get("name", "") for part in root if part.tag in ("link", "joint")), {}, {}
    )
    walk.read(root, _table(*tables), root, strict=False)
    by_treatment: dict[Treatment, list[_Kind]] = {}
    for kind in walk.kinds:
        by_treatment.setdefault(kind.treatment, []).append(kind)
    records: list[Unread] = []
    for treatment, kinds in by_treatment.items():
        # Only those that are reported get their text, which takes time to find.
        for kind in kinds[:_MOST]:
            records.append(Unread(treatment, _report(kind, walk.kinds[kind])))
        if len(kinds) > _MOST:
            summary = f"{len(kinds) - _MOST} other kinds of tags and attributes are not read either"
            records.append(Unread(treatment, summary))
    return tuple(records)


class _Kind(NamedTuple):
    """A kind of content reported together, and the known names there.

    It is of one treatment, in one place of files, and with one consequence.
    """

    treatment: Treatment
    content: str
    consequence: str
    name: str = ""
    known: tuple[str, ...] = ()


class _Walk(NamedTuple):
    """A walk through a file along the table.

    Attributes:
        named: names of the links and joints.
        kinds: the elements that hold something of each kind, and its value there.
        near: by an unknown name and where it is, whether it is close to a known one that matters.
    """

    named: frozenset[str]
    kinds: dict[_Kind, list[tuple[str, str]]]
    near: dict[tuple[str, str], bool]

    def add(self, rule: _Rule, content: str, owner: Element, value: str = "") -> None:
        self._note(_Kind(rule.treatment, content, rule.consequence), owner, value)

    def add_unknown(
        self, content: str, name: str, known: Mapping[str, _Rule], holder: Element, owner: Element
    ) -> None:
        """Note a name that is in no row of the table.

        Args: holder, the element in which it is; known, the names there.
        """
        kind = "element" if content.startswith("<") else "attribute"
        consequence = f"is no {kind} of <{holder.tag}> that is known, so it is not read"
        names = tuple(key for key in known if key not in (_ALL, _TEXT_OF))
        self._note(_Kind("warn", content, consequence, name, names), owner)

    def _note(self, kind: _Kind, owner: Element, value: str = "") -> None:
        subject = ""
        if owner.tag not in ("robot", "model"):
            subject = f"{owner.tag} {owner.get('name') or owner.get('reference') or ''}"
        self.kinds.setdefault(kind, []).append((subject, value))

    def reported(self, name: str, known: Mapping[str, _Rule], path: str, strict: bool) -> bool:
        """True if an unknown name is reported.

        That is where every one is, or if it is close to a known one that matters.

        A name with a prefix is one of another program unless it is close to a known one with that
        prefix. Only the first unknown names of a file are compared.
        """
        prefix, colon, bare = name.rpartition(":")
        if strict and not colon:
            return True
        if (path, name) not in self.near and len(self.near) < _TRIES:
            start = f"{prefix}:" if colon else ""
            matter: list[str] = []
            for key, rule in known.items():
                if rule.treatment != "no effect" and key.startswith(start):
                    matter.append(key.removeprefix(start))
            self.near[path, name] = bool(_nearest(bare, tuple(matter), _CLOSE))
        return self.near.get((path, name), False)

    def read(self, element: Element, node: _Node, owner: Element, strict: bool) -> None:
        """Note what is to be reported of an element and all below.

        Args:
            element: it.
            node: what the table says of it.
            owner: the innermost element with a name that holds it, itself included.
            strict: whether unknown names are reported in any case.
        """
        self._read_attributes(element, node, owner, strict)
        # Elements that may stand only once are collected, and compared after the loop.
        copies: dict[str, list[Element]] = {}
        for part in element:
            inner = node.below.get(part.tag)
            # Names of shapes and references to links say less than the link that holds them.
            holder = owner
            if part.tag not in _NAMELESS and (part.get("name") or part.get("reference")):
                holder = part
            # Without a rule the tag is unknown here, and what is below it is not read.
            if inner is None or inner.element is None:
                self._read_unknown(part, node, element, holder, strict)
                continue
            if inner.once:
                group = part.tag if inner.once == "once" else inner.once
                copies.setdefault(group, []).append(part)
            self._read_part(part, inner, inner.element, holder, strict)
        # Copies that agree change nothing; only differences are reported.
        for first, *repeated in copies.values():
            inner = node.below.get(first.tag, _NOWHERE)
            differences: list[str] = []
            for part in repeated:
                differences += _differences(first, part, inner)
            if differences:
                self.add(_TWICE, f"{node.path} <{first.tag}>", owner, f"({few(differences, 6)})")

    def _read_attributes(self, element: Element, node: _Node, owner: Element, strict: bool) -> None:
        """Note attributes that are unknown, or are not read. Args: as of `read`."""
        known = node.attributes
        for key, value in element.items():
            rule = known.get(key)
            if rule is None:
                if self.reported(key, known, f"{node.path} ", strict and _ALL not in known):
                    attribute = f"{key} of {node.path or element.tag}"
                    self.add_unknown(attribute, key, known, element, owner)
            elif rule.consequence and _TESTS[rule.when](value, element, key):
                self.add(rule, f"{node.path} {key}".lstrip(), owner, f'"{printable(value, 60)}"')

    def _read_unknown(
        self, part: Element, node: _Node, element: Element, holder: Element, strict: bool
    ) -> None:
        """Note an unknown part of an element, if it is reported. Args: node, of the element."""
        tag, known = part.tag, node.tags
        reported = self.reported(tag, known, node.path, strict and node.deep is None)
        at_top = not node.path and ":" not in tag
        if reported or (at_top and self._names_one(part)):
            self.add_unknown(f"<{tag}>", tag, known, element, holder)

    def _read_part(
        self, part: Element, node: _Node, rule: _Rule, holder: Element, strict: bool
    ) -> None:
        """Note a known part of an element, or what it holds. Args: node and rule, of the part."""
        text = (part.text or "").strip()
        if rule.consequence:
            if _TESTS[rule.when](text, part, part.tag):
                self.add(rule, node.path, holder)
        elif node.deep is None or node.below:
            only_text = text and not part.attrib and len(part) == 0
            if strict and only_text and not node.attributes.keys() & {_ALL, _TEXT_OF}:
                self.add(_TEXT, f"<{part.tag}>", holder, f'"{printable(text, 60)}"')
            # The path of a part of the root is its tag.
            self.read(part, node, holder, strict or node.path in _STRICT)

    def _names_one(self, element: Element) -> bool:
        """True if an element holds a link, a joint or a mass, or names a link or joint.

        The name is an attribute or a text.
        """
        for part in element.iter():
            if part.tag in ("link", "joint", "inertial"):
                return True
            text = (part.text or "").strip()
            if text in self.named or any(value in self.named for value in part.attrib.values()):
                return True
        return False


def _report(kind: _Kind, places: list[tuple[str, str]]) -> str:
    """The text about content of a kind. Args: places, owners and values, as of `_Walk`."""
    value = next((f" {value} " for _, value in places if value), " ")
    return f"{_subjects(places)}{kind.content}{value}{kind.consequence}{_hint(kind)}"


def _hint(kind: _Kind) -> str:
    """The known name that is nearest to an unknown one, or all that are known there."""
    form = "<{}>" if kind.content.startswith("<") else "{}"
    nearest = _nearest(kind.name, kind.known, _NEAREST) if kind.name else ""
    if nearest:
        return f"; nearest: {form.format(nearest)}"
    if kind.known:
        return f"; known are {few([form.format(name) for name in kind.known], 6)}"
    return ""


def _nearest(name: str, known: tuple[str, ...], cutoff: float) -> str:
    """The nearest known name; empty if none is close."""
    import difflib

    folded = {key.casefold(): key for key in reversed(known)}
    close = difflib.get_close_matches(name.casefold(), folded, 1, cutoff)
    return folded[close[0]] if close else ""


def _subjects(places: list[tuple[str, str]]) -> str:
    """The owners of the things of a kind, and their number, such as 'joints "a", "b": 2 × '."""
    by_tag: dict[str, list[str]] = {}
    for owner in dict.fromkeys(owner for owner, _ in places):
        tag, _, name = owner.partition(" ")
        by_tag.setdefault(tag, []).append(name)
    texts: list[str] = []
    for tag, names in by_tag.items():
        if tag:
            plural = "s" if len(names) > 1 else ""
            texts.append(f"{tag}{plural} {listed(names, 3)}")
    owners = f"{', '.join(texts)}: " if texts else ""
    number = f"{len(places)} × " if len(places) > 1 else ""
    return owners + number


def _differences(first: Element, second: Element, node: _Node, within: str = "") -> Iterator[str]:
    """The differences between two elements, with both values.

    A number that is not written counts as zero.

    Args:
        first: the element that counts.
        second: the other.
        node: what the table says of them; what has no effect may differ.
        within: the tags from the first elements to these, for messages.
    """
    if first.tag != second.tag:
        yield f"<{first.tag}> and <{second.tag}>"
        return
    pairs: list[tuple[str, str, str]] = []
    for key in dict.fromkeys((*first.attrib, *second.attrib)):
        if node.attributes.get(key, _TWICE).treatment != "no effect":
            pairs.append((f"{key} ", first.get(key, ""), second.get(key, "")))
    pairs.append(("", (first.text or "").strip(), (second.text or "").strip()))
    for key, of_first, of_second in pairs:
        numbers = _numbers(of_first)
        if of_first != of_second and (numbers is None or numbers != _numbers(of_second)):
            yield f"{within}{key}{of_first or 'not given'} and {of_second or 'not given'}"
    # of elements that repeat a tag the first counts
    in_first = {part.tag: part for part in reversed(first)}
    in_second = {part.tag: part for part in reversed(second)}
    for tag in dict.fromkeys((*in_first, *in_second)):
        inner = node.below.get(tag, _NOWHERE)
        if inner.element is not None and inner.element.treatment == "no effect":
            continue
        if tag not in in_first or tag not in in_second:
            yield f"<{tag}> in one of them"
        else:
            yield from _differences(in_first[tag], in_second[tag], inner, f"{within}{tag} ")


def _numbers(text: str) -> list[float] | None:
    """The numbers of an attribute without zeros at the end; None for text."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return None
    while values and values[-1] == 0.0:
        values.pop()
    return values


def _largest(text: str) -> float:
    return max((abs(value) for value in _numbers(text) or ()), default=0.0)


_TRANSPOSED = {"iyx": "ixy", "izx": "ixz", "izy": "iyz"}
_TESTS: dict[str, Callable[[str, Element, str], bool]] = {
    "": lambda value, element, key: True,
    "true": lambda value, element, key: value.casefold() in ("true", "1"),
    "positive": lambda value, element, key: any(number > 0.0 for number in _numbers(value) or ()),
    "not zero": lambda value, element, key: _numbers(value) != [],
    "not symmetric": lambda value, element, key: (
        _numbers(value) != _numbers(element.get(_TRANSPOSED[key], ""))
    ),
    # files round 2 pi
    "beyond a turn": lambda value, element, key: _largest(value) > 2.0 * math.pi + 1e-3,
    "not 1.0 1.1 or 1.2": lambda value, element, key: value not in ("1.0", "1.1", "1.2"),
}
"""Tests that report a value, by the condition of its row.

Args: the value of an attribute, its element, and its key.
"""


@functools.cache
def _table(*tables: Path) -> _Node:
    """Tables as one tree of tags, from the root."""
    top = _Node("")
    for table in tables:
        for row in csv.DictReader(table.read_text(encoding="utf-8").splitlines()):
            rule = _Rule(cast(Treatment, row["treatment"]), row["when"], row["consequence"])
            choices: list[list[str]] = []
            for k, part in enumerate(re.split(r"[{}]", row["path"])):
                in_braces = k % 2 == 1
                choices.append(part.split(",") if in_braces else [part])
            for path in map("".join, itertools.product(*choices)):
                tags = path.removesuffix("/**").split("/")[1:]
                node = top
                for tag in tags:
                    node = node.below.setdefault(tag, _Node(f"{node.path}/{tag}".lstrip("/")))
                node.once = node.once or row["once"]
                for name in row["names"].split(" "):
                    if name == "(element)":
                        node.element = node.element or rule
                    else:
                        node.attributes.setdefault(name, rule)
                if path.endswith("/**"):
                    node.deep = node.deep or rule
    return top
