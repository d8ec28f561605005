"""Names that a typed name means: the exact one, else all that it matches as a glob, else an error.

Upper and lower case differ.
"""

import fnmatch
import itertools
import re
from collections.abc import Iterable, Sequence

from shockpc.text.errors import UnknownName
from shockpc.text.printed import listed


def matches(pattern: str, names: Iterable[str]) -> tuple[str, ...]:
    """The names that a pattern means, each once, in their order; none if it means nothing."""
    known = dict.fromkeys(names)
    return (
        (pattern,)
        if pattern in known
        else tuple(name for name in known if fnmatch.fnmatchcase(name, pattern))
    )


def glob_of(names: Sequence[str], every: Iterable[str]) -> str:
    """A name or glob that means some names of all and no more; empty if there is none.

    It is a glob where they differ in only one part.
    """
    if len(names) == 1:
        return names[0]
    glob = f"{_beginning(names)}*{_beginning([name[::-1] for name in names])[::-1]}"
    return glob if {*matches(glob, every)} == {*names} else ""


def _beginning(names: Sequence[str]) -> str:
    """The longest common beginning of all names."""
    return "".join(
        letters[0]
        for letters in itertools.takewhile(
            lambda letters: len({*letters}) == 1, zip(*names, strict=False)
        )
    )


def match(
    pattern: str,
    names: Iterable[str],
    kind: str,
    where: str,
    listing: str,
    known: Iterable[str] = (),
    hint: str = "",
) -> tuple[str, ...]:
    """The names that a pattern means, each once, in their order.

    Args:
        pattern: an exact name or a glob.
        names: those that it may mean.
        kind: what they name, such as "joint".
        where: where they are, such as 'robot "hyq"'; may be empty.
        listing: the command that lists them; may be empty.
        known: other names among which the nearest are sought too.
        hint: what else would be valid.

    Raises:
        UnknownName: it means none. Where it is a part of some names, the text says which glob
            matches them.
    """
    names = tuple(names)
    if matching := matches(pattern, names):
        return matching
    part = re.search(re.escape(pattern), "\n".join(names), re.IGNORECASE) if pattern else None
    glob = f"*{part.group()}*" if part else ""
    hints = (
        f'"{glob}" matches {listed(fitting, 4)}' if (fitting := matches(glob, names)) else "",
        hint,
    )
    raise UnknownName(
        kind,
        pattern,
        dict.fromkeys([*names, *known]),
        where,
        listing,
        "; ".join(filter(None, hints)),
    )
