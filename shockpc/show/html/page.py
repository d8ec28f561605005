"""The page of a report: its tables and figures, and landings as data for `report.js`.

The script computes every other strike. All text is escaped in Python or set as `textContent` by the
script; none reaches the drawing library as markup.
"""

import base64
import itertools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from shockpc.landing.scenes.scene_file import scene_text
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.html.blocks import html_text, lines_html, table_html
from shockpc.show.html.landing_data import SurfacesOf, page_data, surfaces_of
from shockpc.show.html.posture import PostureSliders
from shockpc.show.html.view import view_html
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines, Sheet
from shockpc.show.wording import robot_name
from shockpc.text.wings import from_wings

MOST_BODIES = 500
"""Limit of the landings of a page, which keeps it below 8 MB."""

ON_SCREEN = ("damage_boundary", "spectrum")
"""Figures of a landing that the page has in no other form."""

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:"
)
"""The policy of a page on what it may load: nothing."""

Files = Mapping[str, str | bytes]
"""Files of a report by path."""


class _Chapter(NamedTuple):
    """A report on a page.

    Attributes:
        report: the report.
        body: its lines, tables and figures on this page.
        files: of the page's report.
        folder: of the report's own files among these.
        landing: number of the only landing that it is about; None for any number of landings.
    """

    report: Report
    body: list[Section]
    files: Files
    folder: str = ""
    landing: int | None = None

    def above(self) -> list[str]:
        """The blocks before the view.

        They are the answer of the command with the lines that it ends with, or the lines before the
        first figure or table.
        """
        parts = [self._html(section) for section in self.body[: self._lead]]
        if self.report.lead:
            parts += self._closing()
        elif self.report.landings and parts:
            parts.append(
                '<p class="note">These lines are for the contact velocity of the scene. Parts with '
                "a blue edge follow the controls.</p>"
            )
        return parts

    def below(self) -> list[str]:
        """The blocks after the view: figures, tables, lines and warnings."""
        results = [self._html(section) for section in self.body[self._lead :]]
        parts = []
        if any(results):
            of_landing = self.report.landings or self.folder
            heading = " for the contact velocity of the scene" if of_landing else ""
            parts = [f"<h2>Results{heading}</h2>", *results]
        if not self.report.lead:
            parts += self._closing()
        parts += [f'<p class="warnings">{html_text(line)}</p>' for line in self.report.warnings]
        return parts

    @property
    def _lead(self) -> int:
        """Number of the sections before the view."""
        if self.report.lead:
            return self.report.lead
        lines = itertools.takewhile(lambda section: isinstance(section, Lines), self.body)
        return len(list(lines))

    def _closing(self) -> list[str]:
        return [f"<p>{html_text(line)}</p>" for line in self.report.closing]

    def _html(self, section: Section) -> str:
        if isinstance(section, Sheet):
            return table_html(section)
        if isinstance(section, Lines):
            return lines_html(section)
        return self._figure(section)

    def _figure(self, picture: Picture) -> str:
        content = self.files[f"{self.folder}{picture.name}.svg"]
        data = content if isinstance(content, bytes) else content.encode()
        source = base64.b64encode(data).decode()
        kind = "figure"
        if self.report.name == "profile" and picture.name not in ON_SCREEN:
            kind = "paper"  # on the screen the picture in three dimensions takes its place
        return (
            f'<img class="{kind}" alt="{html_text(picture.caption)}" '
            f'src="data:image/svg+xml;base64,{source}">'
        )


def page(report: Report, files: Files, library: Path | None, command: str) -> str:
    """The page as text, complete in itself.

    Args:
        report: of landings; with more than `MOST_BODIES` in all the first are shown.
        files: of the report by path; its figures are part of the page.
        library: the script of Plotly; None for a report that shows no landing.
        command: the command line, or nothing.
    """
    landings = {} if library is None else _shown(report)
    drawn = surfaces_of(landings)
    postures = _postures(report, landings, drawn)
    chapters = _chapters(report, landings, files)
    title = html_text(report.title or _title(report, landings))
    view = ""
    if landings:
        notes = [posture.note for posture in postures.values()]
        view = view_html(landings, len(report.landings), notes)
    scenes = [_scene(number, profile) for number, profile in enumerate(landings.values())]
    scripts = [f"<script>\n{_file('tables.js')}</script>"]
    if library is not None:
        scripts += _scripts(landings, drawn, postures, library)
    return "\n".join(
        [
            '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{title}</title><style>\n{_file('report.css')}</style></head><body>",
            f"<h1>{title}</h1>",
            *(_section(chapter.above(), chapter.landing) for chapter in chapters),
            view,
            *(_section(chapter.below(), chapter.landing) for chapter in chapters),
            *scenes,
            f"<h2>Command</h2><pre>{html_text(command)}</pre>" if command else "",
            *scripts,
            "</body></html>\n",
        ]
    )


def fragment(report: Report) -> str:
    """A report without a page around it, for the cell of a notebook.

    It has the lines, tables and figures, and no script.
    """
    body = list(report.body(True))
    files: dict[str, bytes] = {}
    for section in body:
        if isinstance(section, Picture):
            files |= section.files()
    chapter = _Chapter(report._replace(landings={}), body, files)
    rules = _file("report.css").replace(":root", "&")
    style = (
        f"<style>.shockpc {{ {rules} img.paper {{ display: block; }} th {{ cursor: auto; }} "
        f"}}</style>"
    )
    title = f"<h2>{html_text(report.title)}</h2>" if report.title else ""
    content = _section([*chapter.above(), *chapter.below()], None)
    return f'<div class="shockpc">{style}{title}{content}</div>'


def _section(parts: list[str], landing: int | None) -> str:
    """Parts of the page. Args: parts; landing, number of the only one that they are about."""
    attribute = "" if landing is None else f" data-landing={landing}"
    return f"<section{attribute}>{''.join(parts)}</section>"


def _file(name: str) -> str:
    return (Path(__file__).parent / name).read_text("utf-8")


def _shown(report: Report) -> dict[str, ShockProfile]:
    """The landings that the page shows."""
    largest = max((len(profile.bodies) for profile in report.landings.values()), default=1)
    most = max(MOST_BODIES // largest, 1)
    return dict(list(report.landings.items())[:most])


def _title(report: Report, landings: Mapping[str, ShockProfile]) -> str:
    """The title of a page whose report has none."""
    for profile in landings.values():
        return f"Shock of {robot_name(profile.robot)}"
    return report.name


def _chapters(report: Report, landings: Mapping[str, ShockProfile], files: Files) -> list[_Chapter]:
    """The reports of landings, then that of all."""
    chapters = []
    parts = [name for name in landings if name in report.parts]
    for number, name in enumerate(parts):
        part = report.parts[name]
        chapters.append(_Chapter(part, _body_beside_view(part), files, f"{name}/", number))
    body = _body_beside_view(report) if landings else list(report.body(True))
    chapters.append(_Chapter(report, body, files))
    return chapters


def _body_beside_view(report: Report) -> list[Section]:
    """The lines, tables and figures beside the view of landings."""
    return list(report.body(True) if report.page_body is None else report.page_body())


def _postures(
    report: Report, landings: Mapping[str, ShockProfile], drawn: SurfacesOf
) -> dict[str, PostureSliders]:
    """The sliders of each landing; none without a wing that has them."""
    postures: dict[str, PostureSliders] = {}
    if report.live is None:
        return postures
    for posture_of in from_wings("sliders", "posture_of"):
        for name, profile in landings.items():
            surfaces = drawn[id(profile.robot)]
            postures[name] = posture_of(profile.landing, surfaces, report.live)
    return postures


def _scripts(
    landings: Mapping[str, ShockProfile],
    drawn: SurfacesOf,
    postures: Mapping[str, PostureSliders],
    library: Path,
) -> list[str]:
    """Plotly, the data of the landings, and what draws them."""
    data = page_data(landings, drawn, postures)
    text = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    code = ",".join(posture.code for posture in postures.values())
    return [
        f"<script>{library.read_text('utf-8')}</script>",
        f'<script type="application/json" id="data">{text}</script>',
        f"<script>const postures=[{code}];</script>",
        f"<script>\n{_file('warnings.js')}</script>",
        f"<script>\n{_file('posture.js')}</script>",
        f"<script>\n{_file('report.js')}</script>",
    ]


def _scene(number: int, profile: ShockProfile) -> str:
    """Room for the histories of a landing, if it lasts, and its scene with relative paths."""
    parts = []
    if profile.scene.yields:
        parts.append('<h2 class="screen">Histories for the contact velocity of the scene</h2>')
        parts += [f'<div class="screen" id="history-{number}-{k}"></div>' for k in range(2)]
    # `html_text` is of one line.
    lines = [html_text(line) for line in scene_text(profile.scene, Path()).splitlines()]
    parts.append("<h2>Scene</h2><pre>{}</pre>".format("\n".join(lines)))
    return _section(parts, number)
