"""What was found, described once: the text, the Markdown document, CSV, JSON and the files of a folder are made from that."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from shockpc.printed import message
from shockpc.show.document import json_text
from shockpc.show.tables.sheets import Sheet
from shockpc.show.tables.text import as_csv, as_markdown, as_text, escaped, markdown_list

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Report"]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Report:
    """One result as people and as programs read it. What costs time is a function that is called if it is needed.

    Attributes:
        name: of the JSON file.
        title: heading of the Markdown document.
        header: what was computed: (name, text) of every line.
        tables: the tables for people; the argument is the number of rows of the longer ones, None for all.
        short: this number on a terminal.
        closing: lines under the tables.
        details: lines that only the Markdown document has.
        sheets: the tables with all digits, by the name of their CSV file; the first one is what --format csv prints.
        document: the JSON document; `null` where a thing does not exist, positions in metres.
        picture: name of the files of the figure; empty if there is none.
        caption: what the figure shows.
        draw: makes the figure.
    """

    name: str
    title: str
    header: Sequence[tuple[str, str]] = ()
    tables: Callable[[int | None], Sequence[Sheet]]
    short: int | None = None
    closing: Sequence[str] = ()
    details: Sequence[str] = ()
    sheets: Mapping[str, Callable[[], Sheet]]
    document: Callable[[], dict[str, Any]]
    picture: str = ""
    caption: str = ""
    draw: "Callable[[], Figure]"

    @property
    def warnings(self) -> list[str]:
        """The closing lines that warn, or that name what could not be computed."""
        return [line for line in self.closing if line.startswith(("warning", "not computed"))]

    def text(self, format_: str) -> str:
        """What goes to standard output. Args: format_, "table", "markdown", "csv" or "json"."""
        if format_ == "json":
            return json_text(self.document())
        if format_ == "csv":
            return as_csv(next(iter(self.sheets.values()))())
        if format_ == "markdown":
            return self.markdown()
        header = "".join(f"{name:<12} {message(text)}\n" for name, text in self.header)
        closing = "".join(f"{message(line)}\n" for line in self.closing)
        return "\n".join(filter(None, [header, *map(as_text, self.tables(self.short)), closing]))

    def markdown(self, picture: str = "") -> str:
        """The Markdown document. Args: picture, path of the figure relative to it, if it shows one."""
        blocks = [
            f"## {escaped(self.title)}\n",
            "".join(f"- **{name}**: {escaped(text)}\n" for name, text in self.header),
            f"![{escaped(self.caption)}]({picture})\n" if picture else "",
            *map(as_markdown, self.tables(None)),
            markdown_list([*self.closing, *self.details]),
        ]
        return "\n".join(filter(None, blocks))

    def files(self) -> dict[str, str | bytes]:
        """The files of a folder by name: figure, CSV, Markdown and JSON."""
        figure: dict[str, bytes] = {}
        if self.picture:
            from shockpc.show.figure.style import render

            figure = render(self.picture, self.draw)
        return {
            **figure,
            **{f"{name}.csv": as_csv(sheet()) for name, sheet in self.sheets.items()},
            "report.md": self.markdown(f"{self.picture}.svg" if self.picture else ""),
            f"{self.name}.json": json_text(self.document()),
        }
