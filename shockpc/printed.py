"""How names from files are printed: without characters that control a terminal or the direction of text, and not too many."""

import re
from collections.abc import Iterable, Sequence

__all__ = ["few", "listed", "message", "printable"]


def printable(text: str, most: int | None = None) -> str:
    r"""A text with control characters, line breaks and invisible marks as escapes such as `\x1b`.

    Args:
        text: any text.
        most: largest number of characters; a longer text is shortened in the middle.
    """
    if not text.isprintable():
        text = "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii") for sign in text)
    if most is None or len(text) <= most:
        return text
    return f"{text[: most // 2]}…{text[len(text) - (most - 1 - most // 2) :]}"


def message(text: str) -> str:
    """A message on one line of at most 2000 characters, in which quoted names of more than 160 are shortened to 80."""
    return printable(re.sub('"([^"]{161,})"', lambda name: f'"{printable(name[1], 80)}"', text), 2000)


def few(names: Sequence[str], most: int, separator: str = ", ", what: str = "") -> str:
    """The first names, and how many more there are."""
    return separator.join(names[:most]) + (f" and {len(names) - most} more{what}" if len(names) > most else "")


def listed(names: Iterable[object], most: int = 10**6) -> str:
    """The first names in quotation marks, with commas, and how many more there are."""
    return few([f'"{name}"' for name in names], most)
