"""Tables as text: whole outputs, character for character."""

import csv
import io
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from robot_texts import joint, link, urdf
from trees import robot_from

from shockpc import Contact, Health, Point, Posture, Scene, Strike, shock_profile
from shockpc.core.directions import ExtremeDirections
from shockpc.result import ContactImpulse, StanceImpulse
from shockpc.show.tables.design import directions_sheet
from shockpc.show.tables.sheets import Sheet, contacts_sheet, fits
from shockpc.show.tables.text import as_csv, as_markdown, as_text, csv_report, markdown_report, text_report

HEALTH = Health(
    rank=3,
    rows=3,
    residual=2e-16,
    error_estimate=3e-15,
    body_errors=(3e-15,),
    method="by hand",
    warnings=("the ground is wet; feet may slip",),
)


def strikes(*shape):
    """Worst and least_severe strikes that every machine finds alike; a beam's are as good in one direction as in another."""
    worst, least_severe = np.broadcast_to([0.6, 0.0, -0.8], (*shape, 3)), np.broadcast_to([0.0, -1.0, 0.0], (*shape, 3))
    return ExtremeDirections(worst, np.full(shape, 1.25), least_severe, np.full(shape, 0.0625))


def landing(contact: str, **changes):
    """The paper's beam struck somewhere, judged in round numbers."""
    scene = Scene(robot="beam", contact=(Contact(frame=contact),), point=(Point(frame="tip", offset=(0, 0, 0.1)),), **changes)
    found = shock_profile(scene)
    points = tuple(replace(point, directions=strikes()) for point in found.points)
    return replace(found, health=HEALTH, directions=strikes(1), points=points)


@pytest.fixture(scope="module")
def landings():
    return [landing("pivot"), landing("center")]


TABLES = """\
robot        beam (beam, 1 kg, 1 moving body)
posture      neutral; base free
contact      pivot at (0.000, 0.000, 0.000) m, sticks
strike       1 m/s, 0 deg from the vertical: velocity (0, 0, -1) m/s
joint model  none (no joint that could be driven)
plane        xz (sagittal)

bodies (CoPc in body coordinates; shock relative to the strike)
body     |Δω|  CoPc x  CoPc y  CoPc z    RoPc  shock at CoM  least  greatest  off-plane
      [rad/s]     [m]     [m]     [m]     [m]           [-]    [-]       [-]        [%]
────  ───────  ──────  ──────  ──────  ──────  ────────────  ─────  ────────  ─────────
beam   1.5000  0.6667       0       0  0.6667        0.2500      0    1.0007          0

sensors and points (Δv in the frame's own axes)
point        on body    Δv x   Δv y     Δv z   shock
                       [m/s]  [m/s]    [m/s]     [-]
───────────  ───────  ──────  ─────  ───────  ──────
tip:0,0,0.1  beam     0.1500      0  -0.5000  0.5220

contacts (impulse of the ground on the robot, world axes)
contact  impulse x  impulse y  impulse z  friction to stick
             [N s]      [N s]      [N s]                [-]
───────  ─────────  ─────────  ─────────  ─────────────────
pivot            0          0     0.2500                  0

worst and least_severe strike (direction of the velocity, world axes)
place         worst  from x  y        z  least_severe  from x        y  z  way
                [-]                          [-]
───────────  ──────  ──────  ─  ───────  ───────  ──────  ───────  ─  ─────
CoM of beam  1.2500  0.6000  0  -0.8000   0.0625       0  -1.0000  0  level
tip:0,0,0.1  1.2500  0.6000  0  -0.8000   0.0625       0  -1.0000  0  level
(among all directions, towards the ground or along it: one that is level is no landing)

energy lost  0.125 J, 25 % of what there was
pivot: effective mass 0.25 kg sticking, 0.25 kg frictionless, impact mitigation factor 0.000
health: 3 of 3 contact rows independent, residual 2e-16, error estimate 3e-15 of each body's motion; by hand
warning: the ground is wet; feet may slip

robot        beam (beam, 1 kg, 1 moving body)
posture      neutral; base free
contact      center at (0.500, 0.000, 0.000) m, sticks
strike       1 m/s, 0 deg from the vertical: velocity (0, 0, -1) m/s
joint model  none (no joint that could be driven)
plane        xz (sagittal)

bodies (CoPc in body coordinates; shock relative to the strike)
body     |Δω|  CoPc x      CoPc y  CoPc z  RoPc  shock at CoM   least  greatest  off-plane
      [rad/s]  [m]         [m]     [m]      [m]           [-]     [-]       [-]        [%]
────  ───────  ──────────  ──────  ──────  ────  ────────────  ──────  ────────  ─────────
beam        0  translates  –       –        inf        1.0000  1.0000    1.0000          0

sensors and points (Δv in the frame's own axes)
point        on body   Δv x   Δv y    Δv z   shock
                      [m/s]  [m/s]   [m/s]     [-]
───────────  ───────  ─────  ─────  ──────  ──────
tip:0,0,0.1  beam         0      0  1.0000  1.0000

contacts (impulse of the ground on the robot, world axes)
contact  impulse x  impulse y  impulse z  friction to stick
             [N s]      [N s]      [N s]                [-]
───────  ─────────  ─────────  ─────────  ─────────────────
center           0          0     1.0000                  0

worst and least_severe strike (direction of the velocity, world axes)
place         worst  from x  y        z  least_severe  from x        y  z  way
                [-]                          [-]
───────────  ──────  ──────  ─  ───────  ───────  ──────  ───────  ─  ─────
CoM of beam  1.2500  0.6000  0  -0.8000   0.0625       0  -1.0000  0  level
tip:0,0,0.1  1.2500  0.6000  0  -0.8000   0.0625       0  -1.0000  0  level
(among all directions, towards the ground or along it: one that is level is no landing)

energy lost  0.5 J, 100 % of what there was
center: effective mass 1 kg sticking, 1 kg frictionless, impact mitigation factor 0.000
health: 3 of 3 contact rows independent, residual 2e-16, error estimate 3e-15 of each body's motion; by hand
warning: the ground is wet; feet may slip

summary: shock at each body's CoM and at each point [-], by contact
shock at         pivot  center
──────────────  ──────  ──────
beam            0.2500  1.0000
at tip:0,0,0.1  0.5220  1.0000
"""

MARKDOWN = """\
## Shock of beam landing on pivot

- **robot**: beam (beam, 1 kg, 1 moving body)
- **posture**: neutral; base free
- **contact**: pivot at (0.000, 0.000, 0.000) m, sticks
- **strike**: 1 m/s, 0 deg from the vertical: velocity (0, 0, -1) m/s
- **joint model**: none (no joint that could be driven)
- **plane**: xz (sagittal)

![shock profile of beam](shock.svg)

### Bodies (CoPc in body coordinates; shock relative to the strike)

| body | \\|Δω\\| [rad/s] | CoPc x [m] | CoPc y [m] | CoPc z [m] | RoPc [m] | shock at CoM [-] | least [-] | greatest [-] \
| off-plane [%] |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|
| beam | 1.5000 | 0.6667 | 0 | 0 | 0.6667 | 0.2500 | 0 | 1.0007 | 0 |

### Sensors and points (Δv in the frame's own axes)

| point | on body | Δv x [m/s] | Δv y [m/s] | Δv z [m/s] | shock [-] |
|---|---|---:|---:|---:|---:|
| tip:0,0,0.1 | beam | 0.1500 | 0 | -0.5000 | 0.5220 |

### Contacts (impulse of the ground on the robot, world axes)

| contact | impulse x [N s] | impulse y [N s] | impulse z [N s] | friction to stick [-] |
|---|---:|---:|---:|---:|
| pivot | 0 | 0 | 0.2500 | 0 |

### Worst and least_severe strike (direction of the velocity, world axes)

| place | worst [-] | from x | y | z | least_severe [-] | from x | y | z | way |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---|
| CoM of beam | 1.2500 | 0.6000 | 0 | -0.8000 | 0.0625 | 0 | -1.0000 | 0 | level |
| tip:0,0,0.1 | 1.2500 | 0.6000 | 0 | -0.8000 | 0.0625 | 0 | -1.0000 | 0 | level |

*Among all directions, towards the ground or along it: one that is level is no landing.*

- energy lost  0.125 J, 25 % of what there was
- pivot: effective mass 0.25 kg sticking, 0.25 kg frictionless, impact mitigation factor 0.000
- health: 3 of 3 contact rows independent, residual 2e-16, error estimate 3e-15 of each body's motion; by hand
- warning: the ground is wet; feet may slip
"""

CSV_HEADER = (
    "contact,body,|Δω| [rad/s],CoPc x [m],CoPc y [m],CoPc z [m],RoPc [m],shock at CoM [-],least [-],greatest [-],off-plane [%],"
    "no turn in the plane\n"
)


def test_tables(landings):
    assert text_report(landings) == TABLES


def test_markdown(landings):
    assert markdown_report(landings[:1], figure="shock.svg") == MARKDOWN


def test_markdown_without_figure(landings):
    assert "![" not in markdown_report(landings)
    assert markdown_report(landings).count("\n## ") == 1
    assert markdown_report(landings).endswith("| at tip:0,0,0.1 | 0.5220 | 1.0000 |\n")


def test_csv(landings):
    """Full precision, one row for each landing and body; a body that translates has empty cells and an infinite radius."""
    header, pivot, center, end = csv_report(landings).split("\n")
    assert (header + "\n", end) == (CSV_HEADER, "")
    assert center == "center,beam,0.0,,,,inf,1.0,1.0,1.0,0.0,yes"
    name, body, *numbers, still = pivot.split(",")
    assert (name, body, still) == ("pivot", "beam", "no")
    profile = landings[0]
    expected = [1.5, *profile.copc[0], profile.ropc[0], profile.shock_com[0], profile.shock_min[0], profile.shock_max[0], 0.0]
    assert [float(number) for number in numbers] == pytest.approx(expected, abs=1e-15)
    assert "-0.0" not in pivot.split(",")


@pytest.mark.parametrize(
    ("cell", "text"),
    [
        (None, "–"),
        ("trunk", "trunk"),
        (math.inf, "inf"),
        (0.0, "0"),
        (-1e-13, "0"),
        (1e-12, "1.00e-12"),
        (-0.0009999, "-1.00e-03"),
        (0.001, "0.0010"),
        (1.0, "1.0000"),
        (-12.34567, "-12.3457"),
        (99999.0, "99999.0000"),
        (100000.0, "1.00e+05"),
    ],
)
def test_cells(cell, text):
    """Four decimals, or powers of ten where those would hide a number."""
    assert as_text(Sheet("t", ("value",), [(cell,)])).splitlines()[-1].strip() == text
    assert as_markdown(Sheet("t", ("value",), [(cell,)])).splitlines()[-1] == f"| {text} |"


def test_alignment_and_notes():
    """Names to the left, numbers to the right, headers over both; the unit below the name, if there is one."""
    sheet = Sheet("title", ("name", "long number [m]", "note"), [("a", 1.0, "x"), ("longer name", None, "–")], ("first", "second"))
    assert as_text(sheet) == (
        "title\n"
        "name         long number  note\n"
        "                     [m]\n"
        "───────────  ───────────  ────\n"
        "a                 1.0000  x\n"
        "longer name            –  –\n"
        "(first)\n"
        "(second)\n"
    )
    assert as_text(Sheet("none", ("name", "value"), [])) == "none\nname  value\n────  ─────\n"


def test_names_cannot_break_a_table():
    """A bar in a name splits no Markdown cell, and commas and quotes no CSV cell."""
    sheet = Sheet("title", ("name", "m"), [('a|b, "c"', 1.5)])
    assert as_markdown(sheet) == '### Title\n\n| name | m |\n|---|---:|\n| a\\|b, "c" | 1.5000 |\n'
    assert as_csv(sheet) == 'name,m\n"a|b, ""c""",1.5\n'
    assert as_csv(Sheet("t", ("a", "b", "c"), [(None, -0.0, 1e-300)])) == "a,b,c\n,0.0,1e-300\n"


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"strike": Strike(speed=2.5, strike_angle_deg=30.0)}, "2.5 m/s, 30 deg from the vertical: velocity (1.25, 0, -2.165) m/s"),
        ({"strike": Strike(velocity=(0.0, 0.0, -2.0))}, "2 m/s, as given: velocity (0, 0, -2) m/s"),
        ({"strike": Strike(drop_height=0.5)}, "3.132 m/s, after a fall of 0.5 m: velocity (0, 0, -3.132) m/s"),
        ({"strike": Strike(strike_angle_deg=-12.345)}, "1 m/s, -12.35 deg from the vertical: velocity (-0.2138, 0, -0.9769) m/s"),
        (
            {"strike": Strike(strike_angle_deg=30.0), "plane": (0.0, 1.0, 0.0)},
            "1 m/s, 30 deg from the vertical: velocity (0.5, 0, -0.866) m/s",
        ),
    ],
)
def test_header_tells_the_strike(changes, line):
    assert f"\nstrike       {line}\n" in text_report([landing("pivot", **changes)])


@pytest.mark.parametrize(
    ("strike", "line"),
    [
        (Strike(), "1.414 m/s, -45 deg from the vertical: velocity (-1, 0, -1) m/s"),
        (Strike(strike_angle_deg=0.0, speed=3.0), "3.162 m/s, -18.43 deg from the vertical: velocity (-1, 0, -3) m/s"),
        (Strike(velocity=(1.0, 1.0, -1.0)), "1.414 m/s, 45 deg from the vertical: velocity (0, 1, -1) m/s"),
        (Strike(drop_height=0.5), "3.287 m/s, after a fall of 0.5 m, -17.71 deg from the vertical: velocity (-1, 0, -3.132) m/s"),
    ],
)
def test_the_strike_told_is_that_of_the_contact(strike, line):
    """Turning at 1 rad/s about y, a point 1 m below the base goes back at 1 m/s; speed and angle are those of what is printed."""
    contact = Contact(frame="pivot", offset=(0.0, 0.0, -1.0))
    scene = Scene(robot="beam", contact=(contact,), strike=replace(strike, angular_velocity=(0.0, 1.0, 0.0)))
    line += "; turning at (0, 1, 0) rad/s"
    assert f"\nstrike       {line}\n" in text_report([shock_profile(scene)])
    assert f"- **strike**: {line}\n" in markdown_report([shock_profile(scene)])


def test_a_strike_relative_to_the_centre_of_mass_says_so():
    """The speed printed is that of the contact beside it; by what shock is divided stands after it."""
    strike = Strike(angular_velocity=(0.0, 2.0, 0.0))
    scene = Scene(robot="beam", contact=(Contact(frame="pivot"),), strike=strike, v_in="com")
    assert (
        "\nstrike       1 m/s, 0 deg from the vertical: velocity (0, 0, -1) m/s; turning at (0, 2, 0) rad/s; "
        "shock relative to the centre of mass's 2 m/s\n" in text_report([shock_profile(scene)])
    )


@pytest.mark.parametrize(
    ("directions", "ways"), [(("z",), ["level", "level"]), (("x", "y", "z"), ["level", "down"])], ids=["slides", "sticks"]
)
def test_a_kindest_strike_along_the_ground_is_called_level(directions, ways):
    """What slides feels nothing of a strike along the ground, which is no landing; the one that the lower leg likes comes down."""
    scene = Scene(robot="leg", contact=(Contact(frame="heel", directions=directions),), posture=Posture(joints_deg={"knee": -15.0}))
    report = text_report([shock_profile(scene)])
    assert re.findall(r"^CoM of .* (\w+)$", report, re.MULTILINE) == ways
    assert "(among all directions, towards the ground or along it: one that is level is no landing)\n" in report


def test_level_is_along_the_ground_that_is_struck():
    """In a plane seen from above, struck within it, the ground stands upright, and a strike along world z goes along it."""
    scene = Scene(robot="beam", contact=(Contact(frame="tip"),), strike=Strike(velocity=(0.0, -1.0, 0.0)), plane="xy")
    found = shock_profile(scene)
    for least_severe, way in (((0.0, -1.0, 0.0), "down"), ((0.0, 0.0, -1.0), "level")):
        chosen = found.directions._replace(least_severe=np.array([least_severe]))
        assert directions_sheet(replace(found, directions=chosen)).rows[0][-1] == way


def test_only_a_robot_with_joints_has_a_bracket_of_drives():
    """One body has nothing to drive, so three equal columns would say that a choice matters where there is none."""
    beam, leg = (shock_profile(Scene(robot=name, contact=(Contact(frame=at),))) for name, at in (("beam", "tip"), ("leg", "heel")))
    for report in (text_report, markdown_report):
        assert "drives" not in report([beam])
        assert "hat the drives make of it" in report([leg])
    assert beam.bracket


@pytest.mark.parametrize(
    ("plane", "line"),
    [("xz", "xz (sagittal)"), ("yz", "yz (frontal)"), ("xy", "xy (from above)"), ((0.0, -2.0, 2.0), "normal (0, -0.7071, 0.7071)")],
)
def test_header_tells_the_plane(plane, line):
    strike = Strike(velocity=(0.0, 0.0, -1.0))
    assert f"\nplane        {line}\n" in text_report([landing("pivot", plane=plane, strike=strike)])


def test_header_tells_posture_and_contact():
    contact = Contact(frame="heel", offset=(0.01, 0, 0), directions=("z", (0, 1, 0)), restitution=0.3)
    posture = Posture(reference="standing_on_ball", base_rpy_deg=(0.0, 15.0, 0.0), joints={"knee": -0.2}, joints_deg={"k*": -15.0})
    scene = Scene(robot="leg", base="planar", contact=(contact,), posture=posture)
    report = text_report([shock_profile(scene)])
    assert report.splitlines()[1:3] == [
        "posture      standing_on_ball, with knee, k* set, base turned by roll 0, pitch 15, yaw 0 deg; "
        "base moves in the plane only",
        "contact      heel at (-0.295, 0.000, -0.003) m, slides, kept along z (0 1 0), restitution 0.3",
    ]


@pytest.mark.parametrize(
    ("pattern", "names"),
    [("leg", ["LF_leg", "leg"]), ("LEG", ["LF_leg", "leg"]), ("*leg", ["LF_leg", "leg"]), ("l?g", ["leg"]), ("[t]runk", ["trunk"])],
)
def test_patterns(pattern, names):
    """A glob fits the whole name, plain text a part of it, whatever the case."""
    assert [name for name in ("LF_leg", "leg", "trunk") if fits(name, pattern)] == names


SPINNING = urdf(
    link("base", inertia='<inertia ixx="0.4" ixy="0" ixz="0" iyy="0.6" iyz="0" izz="0.9"/>'),
    link("wheel"),
    joint("j", "base", "wheel", axis="1 0 0"),
)


@pytest.mark.parametrize(("plane", "base"), [("xz", ("turns across", "–", "–", "inf")), ("yz", ("0", "-0.4000", "0", "0.9000"))])
def test_a_body_that_spins_across_the_plane(plane, base):
    """Struck beside its centre, seen along the turn and across it: a word, or a point; and in CSV no word among numbers."""
    contact = Contact(frame="base", offset=(0.0, 0.5, 0.0))
    profile = shock_profile(Scene(robot="r", contact=(contact,), plane=plane), robot_from(SPINNING))
    report = text_report([profile])
    rows = [re.split(r" {2,}", line) for line in report.split("─\n")[1].splitlines()]
    # A wheel on a bearing along the axis of the turn keeps its orientation and is only carried: I / (m d) = 0.4 / (2 · 0.5).
    assert [(row[0], *row[2:6]) for row in rows[:2]] == [("base", *base), ("wheel", "translates", "–", "–", "inf")]
    assert [row[-1] for row in rows[:2]] == (["100.0000" if plane == "xz" else "0", "0"])
    table = list(csv.reader(io.StringIO(csv_report([profile]))))
    assert [row[-1] for row in table] == ["no turn in the plane", "yes" if plane == "xz" else "no", "yes"]
    cells = ["", "", "", "inf"]
    if plane == "yz":
        cells = [repr(float(x) + 0.0) for x in (*profile.copc[0], profile.ropc[0])]
    assert [row[3:7] for row in table[1:]] == [cells, ["", "", "", "inf"]]


STANDING = """\
contacts (impulse of the ground on the robot, world axes)
contact        impulse x  impulse y  impulse z  friction to stick
                   [N s]      [N s]      [N s]                [-]
─────────────  ─────────  ─────────  ─────────  ─────────────────
box                    0          0     1.5000                  0
flap (stands)          0          0    -0.5000              pulls
together               0          0     1.0000                  –
(together they turn the robot by (0, 0.25, 0) N m s about its centre of mass)
"""


def test_feet_that_stand_are_told_with_the_sum():
    """A row for each foot that stands, one for all together, and what they turn the robot by."""
    contacts = (ContactImpulse("box", np.zeros(3), np.array([0.0, 0.0, 1.5]), None, 0.0, np.zeros(3), 1.0, 1.0, None),)
    stance = (StanceImpulse("flap", np.zeros(3), np.array([0.0, 0.0, -0.5]), None),)
    found = replace(
        landing("pivot"),
        contacts=contacts,
        stance=stance,
        total_impulse=np.array([0.0, 0.0, 1.0]),
        total_moment=np.array([-1e-17, 0.25, 0.0]),
    )
    assert as_text(contacts_sheet(found)) == STANDING
    alone = replace(found, stance=())
    assert as_text(contacts_sheet(alone)).splitlines()[4:] == ["box              0          0     1.5000                  0"]
    unknown = replace(contacts[0], impulse=None, friction_needed=None)
    repeated = as_text(contacts_sheet(replace(found, contacts=(unknown,)))).splitlines()
    assert repeated[4].split() == ["box", "not", "unique", "–", "–", "–"]
    assert repeated[6:] == [
        "together                0          0     1.0000  –",
        "(where contacts repeat one another only the sum of their impulses is determined)",
        "(together they turn the robot by (0, 0.25, 0) N m s about its centre of mass)",
    ]


def test_the_health_line_says_how_it_was_computed():
    """The last line of a report: the method, not only its error."""
    profile = shock_profile(Scene(robot="beam", contact=(Contact(frame="pivot"),)))
    line = text_report([profile]).splitlines()[-1]
    assert re.fullmatch(
        r"health: 3 of 3 contact rows independent, residual \de-\d\d, error estimate \de-\d\d of each body's motion; "
        r"joint space \(Eq\. 4\), checked in maximal coordinates",
        line,
    )


def test_bodies_that_do_not_move_become_one_line(landings):
    """On a fixed base most bodies of a quadruped stay as they are."""
    scene = Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),), base="fixed")
    report = text_report([shock_profile(scene)])
    rows = [line.split("  ")[0] for line in report.split("─\n")[1].splitlines()]
    assert rows[:3] == ["LF_HIP", "LF_THIGH", "LF_SHANK"]
    assert (
        "(10 bodies not shown, the strike does not move them: base, LH_HIP, LH_THIGH, LH_SHANK, RF_HIP, RF_THIGH and 4 more)\n"
        in report
    )
    assert csv_report([shock_profile(scene)]).count("\n") == 14
