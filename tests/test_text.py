"""Tables as text: what the lines of a report say, and the laws of every cell."""

import csv
import io
import itertools
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from altered import Altered, health
from commands import good
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import joint, link, urdf
from trees import robot_from

from shockpc import Contact, Joints, Point, Posture, Rotor, Scene, Strike, shock_profile
from shockpc.core.most_severe import ExtremeDirections
from shockpc.judgement.drive_range import range_of
from shockpc.quantities.selection import select
from shockpc.show.header import header_lines, shared_warnings
from shockpc.show.tables import Lines, Sheet, as_csv, as_markdown, as_text, escaped, rounded
from shockpc.show.wording import vector_text
from shockpc.studies.analyze.closing import accuracy_line
from shockpc.studies.analyze.report import analyze_report, landing_report
from shockpc.studies.analyze.sheets import directions_sheet
from shockpc.studies.analyze.views import VIEWS
from shockpc.text.diagnostic import Diagnostic, by_cause
from shockpc.text.printed import cause_lines, causes, message, printable


def directions(*shape):
    """Impact directions that every machine finds alike; for a beam, many directions are equally
    severe.
    """
    most, least = (
        np.broadcast_to([0.6, 0.0, -0.8], (*shape, 3)),
        np.broadcast_to([0.0, -1.0, 0.0], (*shape, 3)),
    )
    return ExtremeDirections(most, np.full(shape, 1.25), least, np.full(shape, 0.0625))


def landing(contact: str, **changes):
    """The paper's beam struck somewhere, with the accuracy in round numbers."""
    scene = Scene(
        robot="beam", contact=contact, point=(Point(frame="tip", offset=(0, 0, 0.1)),), **changes
    )
    found = shock_profile(scene)
    points = tuple(Altered(point, directions=directions()) for point in found.points)
    warned = health(warnings=(Diagnostic("scene", "", None, "the ground is wet; feet may slip"),))
    return Altered(found, health=warned, directions=directions(1), points=points)


@pytest.fixture(scope="module")
def landings():
    return [landing("pivot"), landing("center")]


def text_of(profiles, format_):
    """The landings in a format."""
    return analyze_report(
        {str(k): profile for k, profile in enumerate(profiles)}, all_tables=True
    ).text(format_)


def header(**scene):
    """The header of a landing by the names of its lines."""
    return dict(header_lines(shock_profile(Scene(**scene))))


# Whole texts


def test_formats_hold_the_same(landings):
    """Every line and every cell of the text for a terminal is in the Markdown document too, for one
    landing and for several.
    """
    report = landing_report(landings[0], all_tables=True)
    text, markdown = report.text("table"), report.files()["report.md"]
    assert "![shock profile of beam](shock.svg)" in markdown
    body = list(report.body(True))
    for sheet in (block for block in body if isinstance(block, Sheet)):
        for column, cell in (
            pair for row in sheet.rows for pair in zip(sheet.headings, row, strict=True)
        ):
            assert f" {column.shown(cell)}" in text.replace("\n", " ")
            assert f"| {escaped(column.shown(cell))} |" in markdown
    named = [line for block in body if isinstance(block, Lines) for _, line in block.lines]
    for line in (*named, *report.closing, *report.warnings):
        assert line in text
        assert escaped(line) in markdown
    several = text_of(landings, "markdown")
    assert several.startswith(report.text("markdown"))
    assert several.endswith("| at tip:0,0,0.1 | 0.5220 | 1.000 |\n")
    assert "![" not in several


def test_the_result_comes_first():
    """The shock at the IMU with its range, what is assumed, the largest impulse through a joint,
    and warnings; then all else.
    """
    scene = Scene(robot="anymal_b", contact="LF_FOOT", posture=Posture(joints={"RH_KFE": 0.1}))
    profile = shock_profile(scene)
    lines = text_of([profile], "table").splitlines()
    shock, assumed, joint, warnings, ground, blank = lines[:6]
    found = range_of(profile, select("point.shock"), profile.landing.points[0])
    ends = f"{found.smallest:.4f} … {found.largest:.4f}"
    assert shock == (
        f"shock        LF_FOOT only: imu_link {profile.points[0].shock:.4f} ({ends}, drives "
        f"derived)"
    )
    assert assumed.startswith("assumed      drives of all 12 joints: derived, ")
    sizes = [np.linalg.norm(load.force) for load in profile.loads]
    load = profile.loads[int(np.argmax(sizes))]
    assert joint == (
        f"joint        largest impulse: {load.joint} {max(sizes):.3f} N s, 0 N m s along its axis"
    )
    found = [str(warning) for warning in profile.health.warnings]
    assert found
    assert warnings == f"warnings     {len(found)} warning{'s' * (len(found) > 1)}: {found[0]}"
    assert ground.startswith("ground       LF_FOOT: impulse ")
    assert blank == ""
    assert (
        text_of([profile], "markdown")
        .splitlines()[2]
        .startswith("- **shock**: LF_FOOT only: imu_link ")
    )
    beam = text_of([shock_profile(Scene(robot="beam", contact="pivot"))], "table").splitlines()
    assert beam[0] == "shock        pivot only: CoM of beam 0.2500"
    assert beam[1:4] == [
        'assumed      pivot: a point at the origin of its frame; posture "neutral"',
        "joint        largest impulse: none, because the robot has no joints",
        "warnings     no warnings",
    ]


def test_the_result_of_a_contact_that_slides_is_that_with_friction():
    """Of all contacts that stick, the same lines as without friction; feet that stand are in the
    header.
    """

    def answer(profile):
        return landing_report(profile).text("table")

    scene = Scene(
        robot="anymal_b",
        contact="LF_FOOT",
        pulse="half-sine:5ms",
        strike=Strike(strike_angle_deg=60.0),
    )
    sliding, sticking = (shock_profile(replace(scene, friction=mu)) for mu in (0.05, 5.0))
    lines = dict(line.split(maxsplit=1) for line in answer(sliding).splitlines()[:6])
    shock, peak = (sliding.value(f"{key}_friction", "point")[0] for key in ("shock", "peak_g"))
    sizes = sliding.numbers(select("joint_impulse_friction"), sliding.places("joint"))
    size = np.linalg.norm(sliding.value("impulse_friction", "contact")[0])
    assert sliding.friction.state == ("slides",)
    assert lines["shock"].startswith(f"LF_FOOT only: imu_link {shock:.4f} with friction 0.05 (")
    assert lines["shock"].endswith(
        f", sampled, drives derived), sticking {sliding.points[0].shock:.4f}"
    )
    assert (
        lines["peak"] == f"imu_link {rounded(peak)} g for a pulse half-sine:5ms with friction 0.05"
    )
    assert lines["joint"].startswith(
        f"largest impulse with friction 0.05: {sliding.loads[int(sizes.argmax())].joint} "
        f"{sizes.max():.4f} N s"
    )
    assert lines["ground"] == f"LF_FOOT: slides with friction 0.05, impulse {size:.4f} N s"
    plain = answer(shock_profile(scene)).splitlines()[:5]
    assert answer(sticking).splitlines()[:5] == plain
    standing = answer(shock_profile(replace(scene, stance=("RH_FOOT",))))
    assert "\nstance       RH_FOOT, which stands\n" in standing


def test_report_of_a_robot_with_joints():
    """How the robot lands, in words; peaks of a pulse with their range, and what a base that is
    held leaves out.
    """
    scene = Scene(
        robot="leg",
        base="planar",
        contact=Contact(frame="heel", directions=("z",), restitution=0.3),
        posture=Posture(
            base_rpy_deg=(0.0, 15.0, 0.0), joints={"knee": -0.2}, joints_deg={"k*": -15.0}
        ),
        strike=Strike(speed=2.0, strike_angle_deg=30.0),
        point=(Point(frame="heel"),),
        pulse="half-sine:5ms",
        range_g=16.0,
    )
    profile = shock_profile(scene)
    report = landing_report(profile, all_tables=True)
    lines, tables = (
        report.text("table").splitlines(),
        [block for block in report.body(True) if isinstance(block, Sheet)],
    )
    for line in (
        "posture      standing, knee = -0.2 rad, k* = -15 deg, base at roll 0, pitch 15, yaw 0 deg",
        "base         moves in the plane only; --base free releases it",
        "contact      heel at (-0.304, 0.000, 0.048) m, slides, constrained along z, restitution "
        "0.3",
        "velocity     contact at 2 m/s, 30 deg from the vertical: (1, 0, -1.732) m/s",
        "energy lost: 4.076 J",
        "contact rows: 1 of 1 independent",
    ):
        assert line in lines
    (point,) = next(sheet.rows for sheet in tables if sheet.title.startswith("sensors"))
    size = profile.value("shock", "point")[0] * 2.0
    peak = np.pi / 2.0 * size / 5e-3 / 9.80665
    assert (*point[:2], *point[-3:]) == (
        "heel",
        "lower_leg",
        *map(pytest.approx, (size / 2.0, peak, profile.value("range_share", "point")[0])),
    )
    model = next(sheet for sheet in tables if sheet.title == "effect of the joint model")
    assert [row[0] for row in model.rows] == ["CoM of upper_leg", "heel"]
    assert any("no impact mitigation factor (it requires a free base" in line for line in lines)


def test_the_last_line_is_the_accuracy():
    """Proven bound, precision, error of double precision, and the sensitivity to the data where it
    was computed.
    """
    profile = shock_profile(Scene(robot="beam", contact="pivot"))
    proven = Altered(profile, health=health())
    line = (
        "accuracy: rounding error below 2e-16 of each body's motion, 128 bits; double precision "
        "was off by 6e-15; last-digit changes of the data move it by 3e-15"
    )
    assert text_of([proven], "table").splitlines()[-1] == line
    assert text_of([proven], "markdown").splitlines()[-1] == f"- {line}"
    assert "double precision finds no solution" in accuracy_line(
        Altered(profile, health=health(double_error=math.inf))
    )


def test_csv_has_every_digit(landings):
    """One row for each landing and body; a body that translates has empty cells and an infinite
    radius.
    """
    head, pivot, center, end = text_of(landings, "csv").split("\n")
    assert head.startswith(
        "contact,body,|Δω| [rad/s],CoPc x [m],CoPc y [m],CoPc z [m],RoPc [m],shock at CoM "
        "[-],minimum [-],"
    )
    assert (center[:44], center[-11:], end) == (
        "center,beam,0.0,,,,inf,1.0,1.0,1.0,0.0,0.0,0",
        ",translates",
        "",
    )
    name, body, *numbers = pivot.split(",")[:11]
    assert (name, body) == ("pivot", "beam")
    profile = landings[0]
    expected = [
        1.5,
        *profile.copc[0],
        profile.ropc[0],
        profile.shock_com[0],
        profile.shock_min[0],
        profile.shock_max[0],
        0.0,
    ]
    assert [float(number) for number in numbers] == pytest.approx(expected, abs=1e-15)
    assert "-0.0" not in numbers


# Cells


CELLS = {
    None: "–",
    "trunk": "trunk",
    math.inf: "inf",
    0.0: "0",
    -1e-13: "0",
    1e-12: "1.00e-12",
    -0.0009999: "-1.00e-03",
    0.001: "0.0010",
    0.99996: "1.000",
    1.0: "1.000",
    -12.34567: "-12.35",
    123.456: "123.5",
    9999.0: "9999",
    9999.6: "1.00e+04",
}


@pytest.mark.parametrize("cell", CELLS)
def test_cells(cell):
    """At most four digits and four decimals; powers of ten where those would hide a number."""
    assert as_text(Sheet("t", ("value",), [(cell,)])).splitlines()[-1].strip() == CELLS[cell]
    assert as_markdown(Sheet("t", ("value",), [(cell,)])).splitlines()[-1] == f"| {CELLS[cell]} |"


def test_alignment_and_notes():
    """Names to the left, numbers at their points, headers over both; the unit below the name, if
    there is one.
    """
    sheet = Sheet(
        "title",
        ("name", "long number [m]", "note"),
        [("a", 1.0, "x"), ("longer name", 0.5, "–"), ("neither", None, "–")],
        ("first", "second"),
    )
    assert as_text(sheet) == (
        "title\n"
        "name         long number  note\n"
        "                     [m]\n"
        "───────────  ───────────  ────\n"
        "a                 1.000   x\n"
        "longer name       0.5000  –\n"
        "neither                –  –\n"
        "(first)\n"
        "(second)\n"
    )
    assert as_text(Sheet("none", ("name", "value"), [])) == "none\nname  value\n────  ─────\n"


# Names from files


@given(st.text())
def test_what_is_printed_cannot_control_a_terminal(text):
    """No control character, line break, mark that reverses text, or lone surrogate; ordinary text
    stays as it is.
    """
    found = printable(text)
    assert found.isprintable()
    assert found == text or not text.isprintable()
    assert printable(found) == found


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[31mred", r"\x1b[31mred"),
        ("a\nb", r"a\nb"),
        ("x\u202ey", r"x\u202ey"),
        ("Fuß_links", "Fuß_links"),
        ("a" * 80, "a" * 80),
        ("a" * 40 + "b" * 60, "a" * 40 + "…" + "b" * 39),
    ],
)
def test_escapes_and_long_names(text, shown):
    """These are cut in the middle."""
    assert printable(text, 80) == shown


def test_names_in_messages_are_shortened_and_nothing_between_them():
    between = " and ".join(["what the message says"] * 20)
    assert message(f'"a" {between} "{"b" * 161}"') == f'"a" {between} "{"b" * 40}…{"b" * 39}"'


def test_names_cannot_break_a_table():
    """Escapes in the terminal; in Markdown also no HTML, no cell, no link; in CSV no formula, and
    numbers stay numbers.
    """
    names = ["a|b", "<script>", "[x](http://y)", "*b*", "\x1b[2J", "=1+1", "@x", "-5", "+1"]
    sheet = Sheet("title", ("name", "m"), [(name, -1.5) for name in names])
    assert "\x1b" not in as_text(sheet) + as_markdown(sheet)
    assert [line.split(" | ")[0] for line in as_markdown(sheet).splitlines()[4:]] == [
        *(
            "| a\\|b",
            "| &lt;script&gt;",
            "| [x\\](http\\://y)",
            "| \\*b\\*",
            "| \\\\x1b[2J",
            "| \\=1+1",
            "| @x",
            "| -5",
            "| \\+1",
        )
    ]
    rows = list(csv.reader(io.StringIO(as_csv(sheet))))[1:]
    assert [row[0] for row in rows] == [*names[:4], "\\x1b[2J", "'=1+1", "'@x", "-5", "+1"]
    assert {row[1] for row in rows} == {"-1.5"}
    assert as_csv(Sheet("t", ("a", "b", "c"), [(None, -0.0, 1e-300)])) == "a,b,c\n,0.0,1e-300\n"


# The header


UP = "deg from the vertical"
HEADERS = [
    (
        "velocity",
        {"strike": Strike(speed=2.5, strike_angle_deg=30.0)},
        f"contact at 2.5 m/s, 30 {UP}: (1.25, 0, -2.165) m/s",
    ),
    (
        "velocity",
        {"strike": Strike(velocity=(0.0, 0.0, -2.0))},
        f"contact at 2 m/s, 0 {UP}: (0, 0, -2) m/s",
    ),
    (
        "velocity",
        {"strike": Strike(drop_height=0.5)},
        f"contact at 3.132 m/s, 0 {UP}, after a fall of 0.5 m: (0, 0, -3.132) m/s",
    ),
    (
        "velocity",
        {"strike": Strike(strike_angle_deg=-12.345)},
        f"contact at 1 m/s, -12.35 {UP}: (-0.2138, 0, -0.9769) m/s",
    ),
    (
        "velocity",
        {"strike": Strike(strike_angle_deg=30.0), "plane": (0, 1.0, 0)},
        f"contact at 1 m/s, 30 {UP}: (0.5, 0, -0.866) m/s",
    ),
    (
        "velocity",
        {"strike": Strike(angular_velocity=(0.0, 2.0, 0.0)), "v_in": "com"},
        f"contact at 1 m/s, 0 {UP}, robot rotates at (0, 2, 0) rad/s: (0, 0, -1) m/s; shock "
        "relative to 2 m/s of the centre of mass",
    ),
    # A point 1 m below the base moves back: speed and angle are those of the contact.
    (
        "velocity",
        {
            "strike": Strike(angular_velocity=(0.0, 1.0, 0.0)),
            "contact": Contact(frame="pivot", offset=(0.0, 0.0, -1.0)),
        },
        f"contact at 1.414 m/s, -45 {UP}, robot rotates at (0, 1, 0) rad/s: (-1, 0, -1) m/s",
    ),
    *(
        ("plane", {"plane": plane, "strike": Strike(velocity=(0.0, 0.0, -1.0))}, line)
        for plane, line in {
            "xz": "xz (sagittal)",
            "yz": "yz (frontal)",
            "xy": "xy (from above)",
            (0.0, -2.0, 2.0): "normal (0, -0.7071, 0.7071)",
        }.items()
    ),
    *(
        ("plane", {"strike": Strike(velocity=velocity), **changes}, line)
        for velocity, changes, line in (
            (
                (0.0, 0.8, -0.6),
                {},
                "yz (frontal); 80 % of the motion is out of the sagittal plane, which --plane xz "
                "selects",
            ),
            ((0.0, -0.49, -0.8717), {}, "xz (sagittal)"),
            (
                (0.0, 0.8, -0.6),
                {"plane": "xz"},
                "xz (sagittal); 80 % of the motion is out of the sagittal plane",
            ),
        )
    ),
]


@pytest.mark.parametrize(("name", "changes", "line"), HEADERS)
def test_header_names_strike_and_plane(name, changes, line):
    assert header(**({"robot": "beam", "contact": "pivot"} | changes))[name] == line


def test_header_shows_what_was_set_with_units():
    """Posture, contact and drives; the base with the option that changes it."""
    found = header(
        robot="leg",
        base="planar",
        contact=(
            Contact(
                frame="heel", offset=(0.01, 0, 0), directions=("z", (0, 1, 0)), restitution=0.3
            ),
        ),
        posture=Posture(
            reference="standing_on_ball",
            base_rpy_deg=(0.0, 15.0, 0.0),
            joints={"knee": -0.2},
            joints_deg={"k*": -1.4},
        ),
        joints=Joints(armature={"knee": 0.01}),
    )
    assert (
        found["posture"]
        == "standing_on_ball, knee = -0.2 rad, k* = -1.4 deg, base at roll 0, pitch 15, yaw 0 deg"
    )
    assert found["base"] == "moves in the plane only; --base free releases it"
    assert re.fullmatch(
        r"heel at \(.*\) m, slides, constrained along z \(0 1 0\), restitution 0\.3",
        found["contact"],
    )
    geared = "geared (every joint has the reflected inertia of its drive)"
    assert found["joint model"] == f"{geared}; reflected inertia knee = 0.01 kg m²"
    rotor = Joints(rotor={"*": Rotor(inertia=1e-5, gear_ratio=9.0)})
    assert (
        header(robot="leg", contact="heel", joints=rotor)["joint model"]
        == f"{geared}; rotor of *: 1e-05 kg m², gear ratio 9"
    )
    assert "1 moving body" in header(robot="beam", contact="pivot")["robot"]


# Tables


@pytest.mark.parametrize(
    ("slides", "ways"),
    [(("z",), ["parallel", "parallel"]), (("x", "y", "z"), ["parallel", "towards"])],
    ids=["slides", "sticks"],
)
def test_a_least_severe_direction_along_the_ground_is_called_parallel(slides, ways):
    """A contact that slides transmits nothing of an impact along the ground, which is no landing."""
    scene = Scene(
        robot="leg",
        contact=Contact(frame="heel", directions=slides),
        posture=Posture(joints_deg={"knee": -15.0}),
    )
    assert [row[-1] for row in directions_sheet(shock_profile(scene)).rows] == ways


def test_parallel_is_along_the_ground_that_is_struck():
    """In a plane seen from above, struck within it, the ground is vertical, so an impact along
    world z is parallel to it.
    """
    scene = Scene(robot="beam", contact="tip", strike=Strike(velocity=(0.0, -1.0, 0.0)), plane="xy")
    found = shock_profile(scene)
    for least, way in (((0.0, -1.0, 0.0), "towards"), ((0.0, 0.0, -1.0), "parallel")):
        chosen = found.directions._replace(least_severe=np.array([least]))
        assert directions_sheet(Altered(found, directions=chosen)).rows[0][-1] == way


SPINNING = urdf(
    link("base", inertia='<inertia ixx="0.4" ixy="0" ixz="0" iyy="0.6" iyz="0" izz="0.9"/>'),
    link("wheel"),
    joint("j", "base", "wheel", axis="1 0 0"),
)


@pytest.mark.parametrize(
    ("plane", "base"), [("xz", ("–", "–", "–", "inf")), ("yz", ("0", "-0.4000", "0", "0.9000"))]
)
def test_a_body_that_rotates_out_of_the_plane(plane, base):
    """Struck beside its centre, seen along the axis and across it: a word, or a point; in CSV no
    word among numbers.
    """
    contact = Contact(frame="base", offset=(0.0, 0.5, 0.0))
    profile = shock_profile(Scene(robot="r", contact=(contact,), plane=plane), robot_from(SPINNING))
    rows = [
        line.strip("| ").split(" | ")
        for line in text_of([profile], "markdown").split("---|\n")[1].splitlines()
    ]
    # A wheel on a bearing along the axis of the turn keeps its orientation and is only carried: I /
    # (m d) = 0.4 / (2 · 0.5).
    assert [(row[0], *row[2:6]) for row in rows[:2]] == [
        ("base", *base),
        ("wheel", "–", "–", "–", "inf"),
    ]
    motion = ["out of plane" if plane == "xz" else "–", "translates"]
    assert [row[-2:] for row in rows[:2]] == [
        ["100.0" if plane == "xz" else "0", motion[0]],
        ["0", motion[1]],
    ]
    table = list(csv.reader(io.StringIO(text_of([profile], "csv"))))
    assert [row[-1] for row in table[1:]] == [motion[0].strip("–"), motion[1]]
    assert table[2][3:7] == ["", "", "", "inf"]
    assert (table[1][3:6] == ["", "", ""]) == (plane == "xz")


def test_stance_feet_are_listed_with_the_total():
    """A row for each stance foot, one for the total, and the total moment; contacts without an
    impulse of their own say so.
    """
    profile = shock_profile(
        Scene(robot="hyq", contact=Contact(frame="lf_foot"), stance=("rh_foot",))
    )
    *rows, moment = [
        re.split(r" {2,}", line)
        for line in as_text(VIEWS["contacts"].of(profile)).strip().split("─\n")[1].splitlines()
    ]
    assert [row[0] for row in rows] == ["lf_foot", "rh_foot", "total"]
    assert rows[1][-1].startswith("stance")
    np.testing.assert_allclose(
        sum(np.array(row[1:4], float) for row in rows[:2]), np.array(rows[2][1:4], float), atol=2e-4
    )
    assert moment == [
        f"(total moment ({vector_text(profile.total_moment)}) N m s about the centre of mass of "
        f"the robot)"
    ]
    assert len(VIEWS["contacts"].of(shock_profile(Scene(robot="leg", contact="heel"))).rows) == 1
    feet = tuple(Contact(frame=f"{leg}_foot") for leg in ("lf", "rf", "lh", "rh"))
    text = as_text(
        VIEWS["contacts"].of(
            shock_profile(Scene(robot="hyq", contact=feet, joints=Joints(model="locked")))
        )
    )
    assert re.search(r"\nlf_foot +not unique\n", text) or re.search(
        r"\nlf_foot +– .*not unique\n", text
    )
    assert "redundant" in text


def test_bodies_that_do_not_move_become_one_line():
    """On a fixed base most bodies of a quadruped stay as they are; CSV has them all."""
    profile = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT", base="fixed"))
    report = text_of([profile], "table")
    rows = [line.split("  ")[0] for line in report.split("─\n")[1].splitlines()]
    assert rows[:3] == ["LF_HIP", "LF_THIGH", "LF_SHANK"]
    listed = "base, LH_HIP, LH_THIGH, LH_SHANK, RF_HIP, RF_THIGH and 4 more"
    assert f"\n(10 bodies not shown, not moved by the impact: {listed})\n" in report
    assert text_of([profile], "csv").count("\n") == 14


def test_messages_that_differ_only_in_a_gap_are_counted_together():
    text = (
        'closure "a–b" cannot be closed: its ends stay {} mm apart and {} deg turned if only "{}" '
        "may move"
    )
    gaps = (("1.2", "3", "other"), ("1.2", "3", "k"), ("4e-05", "-0.5", "k"))
    found = causes(enumerate(text.format(*given) for given in gaps))
    assert [(one.rows, one.first) for one in found] == [(2, 1), (1, 0)]
    same = text.format("some", "some", "k")
    assert list(cause_lines(found, "rows", 1)) == [
        f"2 rows: {same} (first: 1)",
        "and 1 other cause",
    ]


HYQ = ("hyq", "--contact", "lf_foot")
TABLES = {
    "analyze": (*HYQ, "--strike-angle", "12.345"),
    "batch": HYQ,
    "compare": (*HYQ, "--change", "mass:trunk=1.2345x"),
    "place": (*HYQ, "--vary", "strike-angle=0:30:3"),
    "limits": (
        *HYQ,
        "--joint",
        "lf_kfe_joint",
        "--at",
        "trunk_imu",
        "--max",
        "0.01",
        "--step",
        "5",
    ),
    "sensitivity": (*HYQ, "--at", "trunk_imu"),
    "sweep": (*HYQ, "--vary", "armature:*_kfe_joint=0:0.12345", "--sample", "20", "--rows", "csv"),
    "paper": ("1", "2"),
}


@pytest.mark.parametrize("command", TABLES)
def test_tables_have_at_most_four_digits(capfd, tmp_path, command):
    """Significant ones, of every number with decimals in every table on a terminal."""
    out = ("--out", tmp_path) if command == "sweep" else ()
    lines, rows = iter(good(capfd, command, *TABLES[command], *out).splitlines()), []
    for line in lines:
        if line.startswith("──"):
            rows += itertools.takewhile(lambda row: row and not row.startswith("("), lines)
    numbers = [number for row in rows for number in re.findall(r"(?<![\w.:=])\d+\.\d+", row)]
    assert numbers
    assert [number for number in numbers if len(number.replace(".", "").lstrip("0")) > 4] == []


def test_warnings_of_several_landings_are_one_for_each_cause():
    """The worst of them, with where else it is, in the order of their effect; those of one landing
    with the number of places.
    """
    stop, pull = (
        "{} is driven beyond its end stop at {} rad/s",
        '"{}" would have to be pulled by {} N s',
    )
    found = {
        "a": [
            Diagnostic("limits", f"j{k}", 0.1 * k, stop.format(f"j{k}", 0.1 * k))
            for k in range(1, 6)
        ],
        "b": [
            Diagnostic("limits", "j1", 2.0, stop.format("j1", 2.0)),
            Diagnostic("contact", "b", -1.0, pull.format("b", 1.0)),
        ],
        "c": [Diagnostic("contact", "c", -3.0, pull.format("c", 3.0))],
    }
    (merged,) = by_cause(found["a"])
    assert str(merged) == f"{found['a'][4]} (5 alike: j5, j4, j3, j2 and 1 more)"
    assert (merged.subject, merged.value) == ("j5+j4+j3+j2+j1", 0.5)
    landings = {
        name: SimpleNamespace(health=SimpleNamespace(warnings=by_cause(every)), unknowns=())
        for name, every in found.items()
    }
    first, second = shared_warnings(landings)
    assert first == f"warning: {found['c'][0]} (in c, less in 1 more)"
    assert second == f"warning: {found['b'][0]} (in b, less in 1 more)"


def test_a_number_is_no_formula():
    """A spreadsheet computes texts that begin like a formula; a number that a text holds stays one."""
    cells = ["-30.5", "+1e-3", "-30 … 5", "=1+2", "-1-2"]
    rows = list(csv.reader(io.StringIO(as_csv(Sheet("", ("a",), [(cell,) for cell in cells])))))[1:]
    assert [row[0] for row in rows] == ["-30.5", "+1e-3", "'-30 … 5", "'=1+2", "'-1-2"]
