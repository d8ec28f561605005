"""A result, described once for all its formats.

The text, the Markdown document, CSV, JSON and the files of a folder are made from that.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.document import headed
from shockpc.show.tables import (
    Lines,
    Sheet,
    as_csv,
    as_markdown,
    as_records,
    as_text,
    escaped,
    joined,
    sheet_of,
    units_of,
)
from shockpc.text.printed import json_text

if TYPE_CHECKING:
    from shockpc.evaluation.evaluate import Evaluation
    from shockpc.evaluation.table import Table


class Picture(NamedTuple):
    """A figure, which is drawn, and matplotlib imported, only if its files are asked for.

    Attributes:
        name: of the files.
        caption: what it shows.
        drawn_by: "module:function", the module without `shockpc.`.
        arguments: of that function.
    """

    name: str
    caption: str
    drawn_by: str
    arguments: tuple[Any, ...]

    def draw(self) -> Any:
        """The figure of matplotlib."""
        import pkgutil

        import shockpc.show.figure  # noqa: F401 (refuses wrong settings of matplotlib)

        return pkgutil.resolve_name(f"shockpc.{self.drawn_by}")(*self.arguments)

    def files(self, pdf: bool = False) -> dict[str, bytes]:
        """The figure as SVG and PNG, and as PDF if that is asked for, by file name."""
        from shockpc.show.figure.style import render

        return render(self.name, self.draw, pdf)


ROWS = 20
"""Number of rows of a table in a notebook."""


def table_report(table: "Table", rows: int | None = None) -> "Report":
    """The first rows of a table, and why some of them could not be computed.

    Args: table; rows, number of all.
    """
    first = table.first_rows(ROWS)
    total = len(table) if rows is None else rows
    notes = []
    if len(first) < total:
        notes.append(f"the first {len(first)} of {total} rows")
    return Report(
        name="table",
        body=lambda _: [sheet_of(first, notes=notes)],
        sheets={"table": lambda: sheet_of(first)},
        document=dict,
        lead=1,
        warnings=[f"row {i}: {text}" for i, text in first.messages.items()],
    )


def evaluation_report(evaluation: "Evaluation[Any]") -> "Report":
    """The first landings, which are computed now."""
    return table_report(evaluation.chunk(0), evaluation.landings.rows)


Section = Sheet | Lines | Picture


class Report(NamedTuple):
    """One result as people and as programs read it.

    What costs time is a function that is called if it is needed.

    Attributes:
        name: of the JSON file, and of its schema.
        body: lines, tables and figures in the order of reading; the argument is whether all rows
            are wanted, as in the Markdown document, or on a terminal those of the largest values.
        sheets: the tables with all digits, by the name of their CSV file; the first one is what
            --format csv prints.
        document: the JSON document without its head and tables; `null` where a thing does not
            exist, positions in metres.
        title: heading of the Markdown document.
        page: name of the file of that document.
        page_body: what report.html has in place of the body beside landings in three dimensions,
            whose tables follow the controls; by default the body.
        lead: how many sections of the whole body are the answer of the command, which report.html
            has before the view, with the lines under the body; by default the lines that the body
            begins with.
        brief: what a terminal shows in place of the body and the lines under it; by default these.
        width: most characters of a line of a table on a terminal; None for any number.
        closing: lines under the body.
        warnings: lines under those: what warns, and what could not be computed.
        formats: texts in formats of other programs, by the name of the format.
        more: contents of further files by name, which may hold paths relative to the folder that
            they are written in.
        landings: those that report.html shows in three dimensions, by name.
        live: of the joints that have sliders in report.html, besides those that carry what strikes,
            names or globs; None for a page whose landings keep their postures.
        tables: whether the document holds the rows of the sheets, by name, and the units of their
            keys.
        parts: the reports of several results by the names of their folders. Their texts and
            documents are put together, and the body of this report follows, and its document if
            that has an entry.
    """

    name: str
    body: Callable[[bool], Iterable[Section]]
    sheets: Mapping[str, Callable[[], Sheet]]
    document: Callable[[], Any]
    title: str = ""
    page: str = "report"
    page_body: Callable[[], Iterable[Section]] | None = None
    lead: int = 0
    brief: Callable[[], Iterable[Section]] | None = None
    width: int | None = None
    closing: Sequence[str] = ()
    warnings: Sequence[str] = ()
    formats: Mapping[str, Callable[[], str]] = {}
    more: Callable[[Path], Mapping[str, str]] = lambda _: {}
    landings: Mapping[str, ShockProfile] = {}
    live: Sequence[str] | None = None
    tables: bool = False
    parts: Mapping[str, "Report"] = {}

    def text(self, format_: str) -> str:
        """The text for standard output.

        Args: format_, "table", "markdown", "csv", "json" or one of `formats`.
        """
        if format_ in self.formats:
            return self.formats[format_]()
        if format_ == "json":
            return json_text(self.json())
        if format_ == "csv":
            return as_csv(self._first_sheet())
        is_markdown = format_ == "markdown"
        texts = []
        if is_markdown or self.brief is None:
            texts += [part.text(format_) for part in self.parts.values()]
        texts.append(self._markdown(self.body(True)) if is_markdown else self._terminal())
        return "\n".join(texts)

    def json(self) -> Any:
        """The document with its head, or a list of those of several results."""
        document = self.document()
        if self.tables:
            sheets = {name: sheet() for name, sheet in self.sheets.items()}
            units = {name: units_of(sheet) for name, sheet in sheets.items()}
            return headed(
                self.name,
                {
                    **document,
                    "tables": {name: as_records(sheets[name]) for name in sheets},
                    "units": units,
                },
                2,
            )
        parts = [part.json() for part in self.parts.values()]
        return (
            [*parts, *([headed(self.name, document)] if document else [])]
            if parts
            else headed(self.name, document)
        )

    def files(self, folder: Path = Path(), pdf: bool = False) -> dict[str, str | bytes]:
        """The files of a folder by name, save the page: figures, CSV, Markdown and JSON.

        Several results have a folder each.

        Args:
            folder: in which they will be.
            pdf: whether figures are also written as PDF.
        """
        files: dict[str, str | bytes] = {}
        for name, part in self.parts.items():
            for file, text in part.files(folder / name, pdf).items():
                files[f"{name}/{file}"] = text
        body = list(self.body(True))
        for block in body:
            if isinstance(block, Picture):
                files |= block.files(pdf)
        for name, sheet in self.sheets.items():
            files[f"{name}.csv"] = as_csv(sheet())
        files[f"{self.page}.md"] = self._markdown(body, figures=True)
        if not self.parts:
            files[f"{self.name}.json"] = self.text("json")
        files.update(self.more(folder))
        return files

    def has_figures(self) -> bool:
        """True if figures are among the files."""
        if any(isinstance(section, Picture) for section in self.body(True)):
            return True
        return any(part.has_figures() for part in self.parts.values())

    def _markdown(self, body: Iterable[Section], figures: bool = False) -> str:
        """The Markdown document; of several results the part about all.

        Args: figures, whether their files are beside it.
        """
        blocks = [f"## {escaped(self.title)}\n" if self.title else ""]
        for block in (*body, self._end):
            if not isinstance(block, Picture):
                blocks.append(as_markdown(block))
            elif figures:
                blocks.append(f"![{escaped(block.caption)}]({block.name}.svg)\n")
        return "\n".join(filter(None, blocks))

    def _terminal(self) -> str:
        if self.brief is None:
            blocks = [*self.body(False), self._end]
        else:
            blocks = [*self.brief(), Lines(self.warnings)]
        texts = [as_text(block, self.width) for block in blocks if not isinstance(block, Picture)]
        return "\n".join(filter(None, texts))

    @property
    def _end(self) -> Lines:
        return Lines([*self.closing, *self.warnings])

    def _first_sheet(self) -> Sheet:
        """The table that --format csv prints, of several results with the rows of all."""
        if self.parts:
            return joined([part._first_sheet() for part in self.parts.values()])
        first, *_ = self.sheets.values()
        return joined([first()])
