"""The view of a page as HTML: the picture of a landing, the controls, and tables that follow them.

`report.js` fills these.
"""

import math
from collections.abc import Mapping, Sequence

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.style import BANDS, EDGES, SHOCK
from shockpc.show.html.blocks import head_html, html_text
from shockpc.show.tables import Heading
from shockpc.show.wording import BRACKETED

CONTROLS = (
    ("angle", "strike angle [deg]", "from the vertical, positive forward", -89, 89),
    ("heading", "heading [deg]", "of the horizontal part, from forward to the left", -180, 180),
    ("speed", "speed [m/s]", "of the base", 0.05, 10),
)
"""Key, title, help, and limits of each control."""

MODELS = ("free", "with drives", "locked")
"""Joint models."""

SWITCHES = (
    ("bodies", "bodies", True),
    ("through", "transparent", False),
    ("marks", "contacts, velocity, sensors", True),
    ("axes", "CoPc and screw axes", False),
)
"""Key and text of each switch, and whether it is on."""

POINTS = ("", "sensor or point", "shock [-]", "Δv x [m/s]", "Δv y [m/s]", "Δv z [m/s]")
BODIES = (
    "",
    "body",
    "shock at CoM [-]",
    "minimum drawn [-]",
    "maximum drawn [-]",
    "|Δω| [rad/s]",
    "CoPc x [m]",
    "CoPc y [m]",
    "CoPc z [m]",
    "RoPc [m]",
    "motion",
)
CONTACTS = (
    "",
    "contact or standing foot",
    "x [N s]",
    "y [N s]",
    "z [N s]",
    "friction to stick [-]",
)
JOINTS = ("", "joint", "along the axis [N m s, N s]", "force [N s]", "moment [N m s]")
"""Headings of the tables; the first column has marks of the picture."""


def view_html(landings: Mapping[str, ShockProfile], total: int, notes: Sequence[str]) -> str:
    """The picture, the controls, and the tables that follow them.

    Args:
        landings: those that are shown.
        total: number of landings with those that are not shown.
        notes: on the posture of each; none where it has no sliders.
    """
    points, *wide = _tables(landings)
    return (
        '<main><div><div id="stage"><div id="view"></div><div id="pointer">point at a body to read '
        "the shock there</div>"
        f'<div id="bands"><b>{html_text(SHOCK)}</b>{_bands()}</div></div></div>'
        f'<div><div id="controls">{_controls(landings)}</div>'
        f'<div id="posture"></div>{_posture_notes(notes)}'
        '<p id="state" class="live"></p><p id="warnings"></p>'
        f"{_notes(landings, total)}{points}</div>"
        f'<div class="wide">{"".join(wide)}</div></main>'
    )


def _bands() -> str:
    """The scale of colours, with the shock at the end of each."""
    bands = []
    for colour, edge in zip(BANDS, EDGES[1:], strict=True):
        text = "" if math.isinf(edge) else f"{edge:g}"
        bands.append(f'<span style="background:{colour}"><i>{text}</i></span>')
    return "".join(bands)


def _controls(landings: Mapping[str, ShockProfile]) -> str:
    """The choice of a landing, the velocity, the joint model, and the switches."""
    hidden = " hidden" if len(landings) == 1 else ""
    options = "".join(
        f'<option value="{number}">{html_text(name)}</option>'
        for number, name in enumerate(landings)
    )
    ranges = "".join(
        f'<label for="{key}-range" title="{html_text(help_)}">{html_text(title)}</label>'
        f'<input type="range" id="{key}-range" min="{low}" max="{high}" step="any">'
        f'<input type="number" id="{key}" step="any">'
        for key, title, help_, low, high in CONTROLS
    )
    models = "".join(f"<option>{name}</option>" for name in MODELS)
    switches = []
    for key, text, on in SWITCHES:
        checked = " checked" if on else ""
        switches.append(f'<label><input type="checkbox" id="{key}"{checked}> {text}</label>')
    return (
        f'<label for="landing"{hidden}>landing</label>'
        f'<select id="landing" class="wide"{hidden}>{options}</select>{ranges}'
        f'<label for="model">joints</label><select id="model" class="wide">{models}</select>'
        f'<span>show</span><span class="wide">{"".join(switches)}</span>'
        '<span></span><button id="reset" class="wide" type="button">back to the scene</button>'
    )


def _posture_notes(notes: Sequence[str]) -> str:
    return "".join(
        f'<p class="note" data-landing={number}>{html_text(text)}</p>'
        for number, text in enumerate(notes)
    )


def _notes(landings: Mapping[str, ShockProfile], total: int) -> str:
    """Notes on what the picture leaves out."""
    notes = ""
    if any(profile.scene.friction is not None for profile in landings.values()):
        notes += (
            '<p class="note">The picture is without friction: contacts stick, or slide as the '
            "scene says.</p>"
        )
    if len(landings) < total:
        notes += f'<p class="note">The first {len(landings)} of {total} landings.</p>'
    return notes


def _tables(landings: Mapping[str, ShockProfile]) -> list[str]:
    """The tables of points, bodies, contacts and joints, without rows."""
    points = [*POINTS]
    if any(profile.landing.pulse for profile in landings.values()):
        points.append("peak [g]")
    doubtful = f"mostly out of plane: over {100.0 * BRACKETED:.0f} % of the motion"
    velocity = "for this contact velocity"
    return [
        _table("point-rows", f"sensors and points, {velocity} (Δv in the frame's axes)", points),
        _table("body-rows", f"bodies, {velocity} (CoPc in body coordinates; {doubtful})", BODIES),
        _table(
            "contact-rows",
            f"impulses of the ground on the robot, {velocity} (world axes)",
            CONTACTS,
        ),
        _table("joint-rows", f"impulses through the joints, {velocity}", JOINTS),
    ]


def _table(key: str, title: str, headings: Sequence[str]) -> str:
    """A table without rows; its first two columns have names, the others but `motion` numbers."""
    right = [k > 1 and heading != "motion" for k, heading in enumerate(headings)]
    shown = [Heading.of(heading) for heading in headings]
    return (
        f'<div class="scroll live"><table id="{key}"><caption>{title}</caption>'
        f"{head_html(shown, right)}<tbody></tbody></table></div>"
    )
