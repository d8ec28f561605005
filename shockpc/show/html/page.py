"""The page of a report: its tables and figures, and landings as data for `report.js`, which
computes every other strike.

All text is escaped here or set as `textContent` by the script; none reaches the drawing library as
markup.
"""

import base64
import html
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.landed import CONTRADICTION
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scene_file import scene_text
from shockpc.method.constraints import block_point
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.heights import levels, on_ground
from shockpc.quantities.of_bodies import ROUNDED
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.strike_matrices import (
    StrikeAxes,
    StrikeMatrices,
    contact_normals,
    peak_per_speed,
    strike_matrices,
)
from shockpc.show.figure.picture import letter
from shockpc.show.figure.style import BANDS, EDGES, SHOCK
from shockpc.show.figure.view import body_shapes, numbered
from shockpc.show.html.charts import CONFIG, STYLES, picture, placed
from shockpc.show.html.posture import Posture
from shockpc.show.html.surfaces import Surface, surfaces
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Cell, Column, Lines, Sheet, numeric
from shockpc.show.wording import BRACKETED, robot_name
from shockpc.text.printed import printable
from shockpc.text.wings import from_wings

MOST_TRIANGLES, MOST_BODIES = 90_000, 500
"""Limits of a page, which keep it below 8 MB."""

ON_SCREEN = ("damage_boundary", "spectrum")
"""Figures of a landing that the page has in no other form."""

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:"
)
"""What a page may load: nothing."""

VERDICTS = ("exceeded", "not computed", "undecided", "warning", "passed")
"""Results of a budget, which have colours."""

CONTROLS = (
    ("angle", "strike angle [deg]", "from the vertical, positive forward", -89, 89),
    ("heading", "heading [deg]", "of the horizontal part, from forward to the left", -180, 180),
    ("speed", "speed [m/s]", "of the base", 0.05, 10),
)


def page(
    report: Report, files: Mapping[str, str | bytes], library: Path | None, command: str
) -> str:
    """The page as text, complete in itself.

    Args:
        report: of landings; with more than `MOST_BODIES` in all the first are shown.
        files: of the report by path; its figures are part of the page.
        library: the script of Plotly; None for a report that shows no landing.
        command: the command line, or nothing.
    """
    most = MOST_BODIES // max(
        (len(profile.bodies) for profile in report.landings.values()), default=1
    )
    shown = {} if library is None else dict(list(report.landings.items())[: max(most, 1)])
    here = Path(__file__).parent
    title = _text(
        report.title
        or next(
            (f"Shock of {robot_name(profile.robot)}" for profile in shown.values()), report.name
        )
    )
    parts = [(name, report.parts[name]) for name in shown if name in report.parts]
    blocks: list[tuple[str, int | None, list[Section], Report]]
    blocks = [
        (f"{name}/", number, _body_of(part), part) for number, (name, part) in enumerate(parts)
    ]
    blocks.append(("", None, _body_of(report) if shown else list(report.body(True)), report))
    scripts = [f"<script>\n{(here / 'tables.js').read_text('utf-8')}</script>"]
    drawn = _surfaces(shown)
    postures: dict[str, Posture] = {}
    for posture_of in from_wings("sliders", "posture_of") if report.live is not None else ():
        for name, profile in shown.items():
            surfaces_of_robot = drawn[id(profile.robot)]
            postures[name] = posture_of(profile.landing, surfaces_of_robot, report.live)
    if library is not None:
        data = json.dumps(
            _data(shown, drawn, postures), allow_nan=False, separators=(",", ":")
        ).replace("<", "\\u003c")
        scripts += [
            f"<script>{library.read_text('utf-8')}</script>",
            f'<script type="application/json" id="data">{data}</script>',
            f"<script>const "
            f"postures=[{','.join(posture.code for posture in postures.values())}];</script>",
            f"<script>\n{(here / 'doubts.js').read_text('utf-8')}</script>",
            f"<script>\n{(here / 'posture.js').read_text('utf-8')}</script>",
            f"<script>\n{(here / 'report.js').read_text('utf-8')}</script>",
        ]
    return "\n".join(
        [
            '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{title}</title><style>\n{(here / 'report.css').read_text('utf-8')}</style></head><body>",
            f"<h1>{title}</h1>",
            *(
                _section(number, *_answer(folder, body, part, files))
                for folder, number, body, part in blocks
            ),
            _view(shown, len(report.landings), [posture.note for posture in postures.values()])
            if shown
            else "",
            *(
                _section(number, *_below(folder, body, part, files))
                for folder, number, body, part in blocks
            ),
            *(
                _section(number, *_histories_and_scene(number, profile))
                for number, profile in enumerate(shown.values())
            ),
            f"<h2>Command</h2><pre>{_text(command)}</pre>" if command else "",
            *scripts,
            "</body></html>\n",
        ]
    )


def _body_of(report: Report) -> list[Section]:
    """The lines, tables and figures beside the view of landings."""
    return list(report.body(True) if report.page_body is None else report.page_body())


def fragment(report: Report) -> str:
    """A report without a page around it, for the cell of a notebook: its lines, tables and figures,
    and no script.
    """
    report, body = report._replace(landings={}), list(report.body(True))
    files = {
        name: content
        for block in body
        if isinstance(block, Picture)
        for name, content in block.files().items()
    }
    style = (Path(__file__).parent / "report.css").read_text("utf-8").replace(":root", "&")
    title = f"<h2>{_text(report.title)}</h2>" if report.title else ""
    parts = [*_answer("", body, report, files), *_below("", body, report, files)]
    style = (
        f"<style>.shockpc {{ {style} img.paper {{ display: block; }} th {{ cursor: auto; }} "
        f"}}</style>"
    )
    return f'<div class="shockpc">{style}{title}{_section(None, *parts)}</div>'


def _section(number: int | None, *parts: str) -> str:
    """Parts of the page. Args: number, of the only landing that they are about."""
    return (
        f"<section{'' if number is None else f' data-landing={number}'}>{''.join(parts)}</section>"
    )


def _above(body: Sequence[Section], report: Report) -> list[Section]:
    """What is before the view: the answer of the command, or the lines before the first figure or
    table.
    """
    return list(body[: report.lead]) or list(
        itertools.takewhile(lambda block: isinstance(block, Lines), body)
    )


def _answer(
    folder: str, body: Sequence[Section], report: Report, files: Mapping[str, str | bytes]
) -> list[str]:
    """The answer of the command, with the lines that it ends with.

    Args: folder, of the report's files.
    """
    parts = [_part(block, folder, report, files) for block in _above(body, report)]
    if report.landings and parts and not report.lead:
        parts.append(
            '<p class="note">These lines are for the contact velocity of the scene. Parts with a '
            "blue edge follow the controls.</p>"
        )
    return [*parts, *_closing(report)] if report.lead else parts


def _part(block: Section, folder: str, report: Report, files: Mapping[str, str | bytes]) -> str:
    """A figure, a table or lines."""
    if not isinstance(block, Picture):
        return _block(block)
    source = base64.b64encode(_encoded(files[f"{folder}{block.name}.svg"])).decode()
    # The picture in three dimensions takes the place of a landing's figure, which only paper shows.
    kind = "paper" if report.name == "profile" and block.name not in ON_SCREEN else "figure"
    return (
        f'<img class="{kind}" alt="{_text(block.caption)}" '
        f'src="data:image/svg+xml;base64,{source}">'
    )


def _closing(report: Report) -> list[str]:
    return [f"<p>{_text(line)}</p>" for line in report.closing]


def _below(
    folder: str, body: Sequence[Section], report: Report, files: Mapping[str, str | bytes]
) -> list[str]:
    """Figures, tables and lines. Args: folder, of the report's files."""
    parts = [
        f"<h2>Results{' for the contact velocity of the scene' if report.landings or folder else ''}</h2>"
    ]
    parts += [_part(block, folder, report, files) for block in body[len(_above(body, report)) :]]
    parts = parts if any(parts[1:]) else []
    warnings = "".join(f'<p class="warnings">{_text(line)}</p>' for line in report.warnings)
    return [*parts, *([] if report.lead else _closing(report)), warnings]


def _encoded(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode()


def _histories_and_scene(number: int, profile: ShockProfile) -> Iterator[str]:
    """Room for the histories of a landing, if its contacts are of finite stiffness, and its scene
    with relative paths.
    """
    if profile.scene.yields:
        yield '<h2 class="screen">Histories for the contact velocity of the scene</h2>'
        yield from (f'<div class="screen" id="history-{number}-{k}"></div>' for k in range(2))
    lines = map(_text, scene_text(profile.scene, Path()).splitlines())
    yield "<h2>Scene</h2><pre>{}</pre>".format("\n".join(lines))


def _text(text: str) -> str:
    return html.escape(printable(text))


def _breakable(text: str) -> str:
    """A text whose long names may be broken after an underscore."""
    return _text(text).replace("_", "_<wbr>")


def _block(block: Section) -> str:
    if isinstance(block, Sheet):
        return _table(block) if block.rows or block.notes else ""
    assert isinstance(block, Lines)
    title = f"<h3>{_text(block.title)}</h3>" if block.title else ""
    parts = []
    for unnamed, lines in itertools.groupby(block.lines, lambda line: isinstance(line, str)):
        parts += [
            "" if unnamed else "<dl>",
            *(
                f"<p>{_text(one)}</p>"
                if isinstance(one, str)
                else f"<dt>{_text(one[0])}</dt><dd>{_text(one[1])}</dd>"
                for one in lines
            ),
            "" if unnamed else "</dl>",
        ]
    return title + "".join(parts)


def _table(sheet: Sheet) -> str:
    """A table that a click on a heading sorts; numbers with all digits are in an attribute."""
    right, columns = numeric(sheet), sheet.columns
    notes = "".join(f'<p class="note">{_text(note)}</p>' for note in sheet.notes)
    rows = "".join(f"<tr>{''.join(map(_cell, columns, row, right))}</tr>" for row in sheet.rows)
    head = _head(columns, right)
    return f'<div class="scroll"><table><caption>{_text(sheet.title)}</caption>{head}<tbody>{rows}</tbody></table></div>{notes}'


def _head(columns: Sequence[Column], to_the_right: Sequence[bool]) -> str:
    cells = []
    for column, right in zip(columns, to_the_right, strict=True):
        unit = f"[{_text(column.unit)}]" if column.unit else ""
        cells.append(
            f"<th{'' if right else ' class=name'}>{_breakable(column.title)}<small>{unit}</small></th>"
        )
    return f"<thead><tr>{''.join(cells)}</tr></thead>"


def _cell(column: Column, cell: Cell, right: bool) -> str:
    """A cell; a verdict has a colour, as its words have a class in `report.css`."""
    # The representation of a number of NumPy has the name of its type, which no script reads.
    value = ""
    if isinstance(cell, float | int) and math.isfinite(cell):
        value = f' data-v="{float(cell)!r}"'
    look = "" if right else " class=name"
    if column.key == "result" and cell in VERDICTS:
        look = f' class="name {str(cell).replace(" ", "-")}"'
    return f"<td{value}{look}>{_breakable(column.shown(cell))}</td>"


def _view(shown: Mapping[str, ShockProfile], every: int, notes: Sequence[str]) -> str:
    """The picture, the controls, and the tables that follow them.

    Args:
        shown: the landings.
        every: number of landings with those that are not shown.
        notes: on the posture of each; none where it has no sliders.
    """
    peak = any(profile.landing.pulse for profile in shown.values())
    options = "".join(
        f'<option value="{number}">{_text(name)}</option>' for number, name in enumerate(shown)
    )
    left = (
        f'<p class="note">The first {len(shown)} of {every} landings.</p>'
        if len(shown) < every
        else ""
    )
    ranges = "".join(
        f'<label for="{key}-range" title="{_text(what)}">{_text(title)}</label>'
        f'<input type="range" id="{key}-range" min="{low}" max="{high}" step="any">'
        f'<input type="number" id="{key}" step="any">'
        for key, title, what, low, high in CONTROLS
    )
    models = "".join(f"<option>{name}</option>" for name in ("free", "with drives", "locked"))
    switches = "".join(
        f'<label><input type="checkbox" id="{key}"{" checked" if on else ""}> {text}</label>'
        for key, text, on in (
            ("bodies", "bodies", True),
            ("through", "transparent", False),
            ("marks", "contacts, contact velocity, sensors", True),
            ("axes", "CoPc and screw axes", False),
        )
    )
    edges = ["" if math.isinf(edge) else f"{edge:g}" for edge in EDGES[1:]]
    bands = "".join(
        f'<span style="background:{colour}"><i>{edge}</i></span>'
        for colour, edge in zip(BANDS, edges, strict=True)
    )
    points = [
        "",
        "sensor or point",
        "shock [-]",
        "Δv x [m/s]",
        "Δv y [m/s]",
        "Δv z [m/s]",
        *(["peak [g]"] if peak else []),
    ]
    bodies = [
        "",
        "body",
        "shock at CoM [-]",
        "minimum drawn [-]",
        "maximum drawn [-]",
        "|Δω| [rad/s]",
    ]
    bodies += ["CoPc x [m]", "CoPc y [m]", "CoPc z [m]", "RoPc [m]", "motion"]
    contacts = [
        "",
        "contact or standing foot",
        "x [N s]",
        "y [N s]",
        "z [N s]",
        "friction to stick [-]",
    ]
    joints = ["", "joint", "along the axis [N m s, N s]", "force [N s]", "moment [N m s]"]
    doubtful = f"; mostly out of plane: over {100.0 * BRACKETED:.0f} % of the motion"
    live = [
        f'<div class="scroll live"><table id="{key}"><caption>{title}</caption>'
        f"{_head([*map(Column.of, header)], [k > 1 and head != 'motion' for k, head in enumerate(header)])}"
        "<tbody></tbody></table></div>"
        for key, title, header in (
            (
                "point-rows",
                "sensors and points, for this contact velocity (Δv in the frame's axes)",
                points,
            ),
            (
                "body-rows",
                f"bodies, for this contact velocity (CoPc in body coordinates{doubtful})",
                bodies,
            ),
            (
                "contact-rows",
                "impulses of the ground on the robot, for this contact velocity (world axes)",
                contacts,
            ),
            ("joint-rows", "impulses through the joints, for this contact velocity", joints),
        )
    ]
    nonlinear = any(profile.scene.friction is not None for profile in shown.values())
    note = (
        '<p class="note">The picture is without friction: contacts stick, or slide as the scene '
        "says.</p>"
        if nonlinear
        else ""
    )
    of_posture = "".join(
        f'<p class="note" data-landing={number}>{_text(text)}</p>'
        for number, text in enumerate(notes)
    )
    return (
        '<main><div><div id="stage"><div id="view"></div><div id="pointer">point at a body to read '
        "the shock there</div>"
        f'<div id="bands"><b>{_text(SHOCK)}</b>{bands}</div></div></div><div><div id="controls">'
        f'<label for="landing"{" hidden" * (len(shown) == 1)}>landing</label>'
        f'<select id="landing" '
        f'class="wide"{" hidden" * (len(shown) == 1)}>{options}</select>{ranges}'
        f'<label for="model">joints</label><select id="model" class="wide">{models}</select>'
        f'<span>show</span><span class="wide">{switches}</span>'
        '<span></span><button id="reset" class="wide" type="button">back to the '
        "scene</button></div>"
        f'<div id="posture"></div>{of_posture}'
        '<p id="state" class="live"></p><p id="doubts"></p>'
        f'{note}{left}{live[0]}</div><div class="wide">{"".join(live[1:])}</div></main>'
    )


def _surfaces(shown: Mapping[str, ShockProfile]) -> dict[int, list[Surface]]:
    """What is drawn of the bodies, in their frames, by the identity of the robot."""
    robots = {id(profile.robot): profile.robot for profile in shown.values()}
    return {
        key: surfaces([shapes for shapes, _ in body_shapes(one)], MOST_TRIANGLES // len(robots))
        for key, one in robots.items()
    }


def _data(
    shown: Mapping[str, ShockProfile],
    drawn: Mapping[int, Sequence[Surface]],
    postures: Mapping[str, Posture],
) -> dict[str, Any]:
    """What the script needs."""
    geometries = {key: _geometry(parts) for key, parts in drawn.items()}
    different = [
        one for k, one in enumerate(geometries.values()) if one not in list(geometries.values())[:k]
    ]
    return {
        "geometries": different,
        "landings": [
            {
                **_landing(
                    name,
                    profile,
                    drawn[id(profile.robot)],
                    different.index(geometries[id(profile.robot)]),
                ),
                "sliders": postures[name].sliders if name in postures else None,
            }
            for name, profile in shown.items()
        ],
        "contradiction": CONTRADICTION,
        "singular": ILL_CONDITIONED,
        "bracketed": BRACKETED,
        "styles": STYLES,
        "config": CONFIG,
    }


def _geometry(parts: Sequence[Surface]) -> dict[str, Any]:
    """The surfaces of the bodies, in their frames: single precision and whole numbers,
    little-endian, in base 64.
    """
    starts = np.concatenate([[0], np.cumsum([len(part.vertices) for part in parts])])
    triangles = np.concatenate(
        [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    )
    wide = bool(starts[-1] > 2**16)
    return {
        "vertices": base64.b64encode(
            np.concatenate([part.vertices for part in parts]).astype("<f4").tobytes()
        ).decode(),
        "triangles": base64.b64encode(
            triangles.astype("<u4" if wide else "<u2").tobytes()
        ).decode(),
        "wide": wide,
        "starts": starts[:-1].tolist(),
    }


def _landing(
    name: str, profile: ShockProfile, drawn: Sequence[Surface], geometry: int
) -> dict[str, Any]:
    """One landing: placements, what follows from the velocity of the base, and what shock is
    relative to.
    """
    landing, robot, plane, axes = (
        profile.landing,
        profile.robot,
        profile.plane,
        StrikeAxes.of(profile),
    )
    strike_velocity = landing.before.velocity
    proofs = {
        "free": profile.proof_with("free"),
        "with drives": profile.proof,
        "locked": profile.proof_with("locked"),
    }
    # A foot that only one of them lifts leaves the tables of contacts without a common row.
    proofs = {
        name: proof and (proof if proof.landing.lifted == landing.lifted else None)
        for name, proof in proofs.items()
    }
    angle, heading, speed = axes.polar(strike_velocity)
    blocks = landing.blocks[: len(profile.contacts)]
    contacts = [
        {
            "name": printable(contact.frame),
            "body": block.body,
            "r": block.point.tolist(),
            # The page takes a contact that approaches along its normal as one that strikes, which
            # an end stop does.
            "normal": normal.tolist(),
            **_motion(
                contact.approach,
                None if block.velocity is not None or block.kind == "stop" else strike_velocity,
            ),
        }
        for contact, block, normal in zip(
            profile.contacts, blocks, contact_normals(profile), strict=True
        )
    ]
    centre = profile.scene.v_in == "com"
    points = [
        {
            "letter": letter(k),
            "name": printable(place.name),
            "body": place.body,
            "r": place.r.tolist(),
            "axes": place.axes.T.tolist(),
            "position": point.position.tolist(),
        }
        for k, (place, point) in enumerate(zip(landing.points, profile.points, strict=True))
    ]
    return {
        "geometry": geometry,
        **picture(
            name,
            placed(drawn, profile.rotation, profile.position),
            profile.contacts[0].point,
            (plane.normal, plane.e1, plane.e2),
        ),
        "bodies": list(map(printable, profile.bodies)),
        "numbered": list(numbered(profile)),
        "com": robot.coms.tolist(),
        "gyration": robot.gyration.tolist(),
        "rotation": profile.rotation.tolist(),
        "position": profile.position.tolist(),
        "origin": landing.state.origin[0].tolist(),
        "models": {
            key: proof and _matrices(strike_matrices(proof)) for key, proof in proofs.items()
        },
        "joints": [printable(place.name) for place in profile.places("joint")],
        "grounds": [
            {"name": printable(place.name), "normal": landing.blocks[place.number].normal.tolist()}
            for place in profile.places("contact")
        ],
        "strike": [round(math.degrees(angle), 9), round(math.degrees(heading), 9), round(speed, 9)],
        "reference": [
            _motion(velocity, strike_velocity) for velocity in profile.reference_velocities
        ]
        if centre
        else contacts,
        **{key: axis.tolist() for key, axis in axes._asdict().items()},
        "normal": plane.normal.tolist(),
        "contacts": contacts,
        "points": points,
        "peak": peak_per_speed(landing),
        "ground": _ground(landing),
        "length": landing.length,
        "rounded": ROUNDED,
        "histories": [
            chart for charts in from_wings("report", "charts") for chart in charts(profile)
        ],
    }


def _ground(landing: PosedLanding) -> dict[str, Any] | None:
    """What flat ground has to touch first: contacts and standing feet, each with how far its shapes
    reach below its point [m].

    None where nothing lands on flat ground, or the robot does not come down as a whole.
    """
    level = on_ground(landing)
    if landing.base == "fixed" or not level:
        return None
    state, blocks = landing.state, (*landing.contacts, *landing.stance)
    points = np.stack([block_point(state, blocks[k]) for k in level], axis=1)
    here = levels(landing, state.rotation, state.position, points)
    depths = (points[0] @ landing.up - here.contacts[0]).tolist()
    contacts = [
        {
            "body": blocks[k].body,
            "r": blocks[k].point.tolist(),
            "depth": depth,
            "number": k if k < len(landing.contacts) else -1,
        }
        for k, depth in zip(level, depths, strict=True)
    ]
    return {"up": landing.up.tolist(), "tolerance": here.tolerance, "contacts": contacts}


def _matrices(strikes: StrikeMatrices) -> dict[str, Any]:
    """The matrices for the script; of impulses with ten digits, which keep the page small, and null
    where one is not determined.
    """
    matrices = {key: matrix.tolist() for key, matrix in strikes._asdict().items()}
    for key in ("contacts", "loads"):
        matrices[key] = [
            [None if math.isnan(sum(row)) else [float(f"{x:.10g}") for x in row] for row in matrix]
            for matrix in matrices[key]
        ]
    return matrices


def _motion(velocity: Array, base: Array | None) -> dict[str, Any]:
    """A velocity as that of the base and a constant; None for one that does not follow the base."""
    return {
        "follows": base is not None,
        "extra": (velocity - (0.0 if base is None else base)).tolist(),
    }
