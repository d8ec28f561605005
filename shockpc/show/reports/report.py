"""What was found, described once: the text, the Markdown document, CSV, JSON and the files of a folder are made from that."""

import pkgutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from shockpc.printed import message
from shockpc.show.document import headed, json_text
from shockpc.show.tables import Sheet, as_csv, as_markdown, as_text, escaped, markdown_list

__all__ = ["Picture", "Report"]


class Picture(NamedTuple):
    """A figure, which is drawn, and matplotlib imported, only if its files are asked for.

    Attributes:
        name: of the files.
        caption: what it shows.
        drawn_by: "module:function" in `shockpc.show.figure`.
        arguments: of that function.
    """

    name: str
    caption: str
    drawn_by: str
    arguments: tuple[Any, ...]

    def draw(self) -> Any:
        """The figure of matplotlib."""
        return pkgutil.resolve_name(f"shockpc.show.figure.{self.drawn_by}")(*self.arguments)

    def files(self) -> dict[str, bytes]:
        """The figure as SVG and PNG, by file name."""
        from shockpc.show.figure.style import render

        return render(self.name, self.draw)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Report:
    """One result as people and as programs read it. What costs time is a function that is called if it is needed.

    Attributes:
        name: of the JSON file, and of its schema.
        title: heading of the Markdown document.
        summary: the result in a few lines, which come first: (name, text) of every line.
        header: what was computed, in the same form.
        tables: the tables for people; the argument is the number of rows of the longer ones, None for all.
        short: this number on a terminal.
        closing: lines under the tables.
        warnings: lines under those: what warns, and what could not be computed.
        details: lines that only the Markdown document has.
        sheets: the tables with all digits, by the name of their CSV file; the first one is what --format csv prints.
        document: the JSON document, with or without its head; `null` where a thing does not exist, positions in metres.
        picture: the figure, if there is one.
        parts: the reports of several results by the names of their folders. Their texts and documents are put together, and the
            tables of this report, which then has no document of its own, follow.
    """

    name: str
    title: str = ""
    summary: Sequence[tuple[str, str]] = ()
    header: Sequence[tuple[str, str]] = ()
    tables: Callable[[int | None], Sequence[Sheet]]
    short: int | None = None
    closing: Sequence[str] = ()
    warnings: Sequence[str] = ()
    details: Sequence[str] = ()
    sheets: Mapping[str, Callable[[], Sheet]]
    document: Callable[[], Any]
    picture: Picture | None = None
    parts: Mapping[str, "Report"] = field(default_factory=dict)

    def text(self, format_: str) -> str:
        """What goes to standard output. Args: format_, "table", "markdown", "csv" or "json"."""
        if format_ == "json":
            return json_text(self.json())
        if format_ == "csv":
            return as_csv(self._first_sheet())
        blocks = [part.text(format_) for part in self.parts.values()]
        return "\n".join([*blocks, self.markdown() if format_ == "markdown" else self._terminal()])

    def json(self) -> Any:
        """The document with its head, or a list of those of several results."""
        return [part.json() for part in self.parts.values()] if self.parts else headed(self.name, self.document())

    def markdown(self, figure: bool = False) -> str:
        """The Markdown document, of several results the part that is about all. Args: figure, whether its files are beside it."""
        shown = self.picture if figure else None
        blocks = [
            f"## {escaped(self.title)}\n" if self.title else "",
            *("".join(f"- **{name}**: {escaped(text)}\n" for name, text in lines) for lines in (self.summary, self.header)),
            f"![{escaped(shown.caption)}]({shown.name}.svg)\n" if shown else "",
            *map(as_markdown, self.tables(None)),
            markdown_list([*self.closing, *self.warnings, *self.details]),
        ]
        return "\n".join(filter(None, blocks))

    def files(self) -> dict[str, str | bytes]:
        """The files of a folder by name: figure, CSV, Markdown and JSON; several results have a folder each."""
        sheets = {f"{name}.csv": as_csv(sheet()) for name, sheet in self.sheets.items()}
        if self.parts:
            every = {f"{name}/{file}": text for name, part in self.parts.items() for file, text in part.files().items()}
            return {**every, **sheets, f"{self.name}.md": self.markdown()}
        return {
            **(self.picture.files() if self.picture else {}),
            **sheets,
            "report.md": self.markdown(figure=True),
            f"{self.name}.json": self.text("json"),
        }

    def _terminal(self) -> str:
        """The tables for a terminal, between the lines above and below them."""
        above = ["".join(f"{name:<12} {message(text)}\n" for name, text in lines) for lines in (self.summary, self.header)]
        below = "".join(f"{message(line)}\n" for line in (*self.closing, *self.warnings))
        return "\n".join(filter(None, [*above, *map(as_text, self.tables(self.short)), below]))

    def _first_sheet(self) -> Sheet:
        """What --format csv prints, of several results with the rows of all."""
        sheets = [part._first_sheet() for part in self.parts.values()] or [next(iter(self.sheets.values()))()]
        return sheets[0]._replace(rows=[row for sheet in sheets for row in sheet.rows])
