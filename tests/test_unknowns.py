"""What a landing takes for granted: a record for each cause, first in every report, and never
beside "no warnings".
"""

import json

import numpy as np
import pytest
from commands import good
from robot_texts import LIMIT, joint, link, urdf
from trees import robot_from

from shockpc import Contact, Joints, Part, Posture, Scene, Strike, shock_profile
from shockpc.method.constraints import NO_AXES, row_jacobian
from shockpc.quantities.contact_mass import normal_mass
from shockpc.show.tables import Sheet, as_text, rounded
from shockpc.studies.analyze.report import landing_report
from shockpc.text.diagnostic import ShockWarning

FIRST = Scene(robot="a1", contact="FL_foot")

LEG_BELOW = urdf(
    link("body", "2", '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/>'),
    link(
        "shin",
        "0.5",
        '<inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0002"/><origin xyz="0 0 '
        '-0.2"/>',
    ),
    joint("knee", "body", "shin", more=LIMIT),
)
"""A body whose centre of mass is on the axis of its joint, with a leg below."""


def kinds(profile, known=False):
    return [(one.kind, one.status) for one in profile.unknowns if one.known == known]


def test_unknown_drives_are_a_record_with_the_joints_that_decide():
    """The struck leg's joints decide; who says that there are no drives, or gives them, has no such
    record.
    """
    profile = shock_profile(FIRST)
    (drives,) = (one for one in profile.unknowns if not one.known)
    assert (drives.kind, drives.status, len(drives.subjects)) == ("drives", "unknown", 12)
    assert set(drives.deciding) <= {"FL_hip_joint", "FL_thigh_joint", "FL_calf_joint"}
    assert drives.effect > 500.0
    assert "--drives go1" in drives.remedy
    assert str(drives) in [str(one) for one in profile.health.warnings]
    for joints in (Joints(model="free"), Joints(armature={"*": 0.01}), Joints(model="locked")):
        assert kinds(shock_profile(Scene(robot="a1", contact="FL_foot", joints=joints))) == []


def test_drives_without_an_effect_are_not_called_given(capfd, tmp_path):
    """A strike on the base above a straight leg moves no joint, so its range has one number,
    whatever the drives are.
    """
    (tmp_path / "leg.urdf").write_text(LEG_BELOW)
    first = good(
        capfd, "analyze", str(tmp_path / "leg.urdf"), "--contact", "body", "--posture", "neutral"
    ).splitlines()[0]
    assert first == "shock        body only: CoM of body 1.000 (1.000 … 1.000, whatever the drives)"


def test_one_number_for_joints_of_different_effort_is_no_knowledge():
    scene = Scene(robot="talos", contact="left_sole_link", joints=Joints(drives="none"))
    (setting,) = (one for one in shock_profile(scene).unknowns if not one.known)
    assert (setting.status, len(setting.subjects)) == ("simulation model", 30)
    assert setting.effect > 10.0


def test_what_was_chosen_is_not_a_warning():
    """Contact and posture that are given are no assumptions; drives of the catalogue and springs
    are, with their status.
    """
    given = Contact(frame="FL_foot", at="frame", kind="point")
    open_ = shock_profile(Scene(robot="go2", contact="FL_foot"))
    closed = shock_profile(Scene(robot="go2", contact=given, posture=Posture(reference="standing")))
    assert kinds(open_, known=True)[1:] == [("contact", "chosen"), ("posture", "chosen")]
    assert [kind for kind, _ in kinds(closed, known=True)] == ["drives"]
    assert open_.health.warnings == ()
    sprung = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT", pulse="half-sine:5ms"))
    assert {("springs", "assumed"), ("duration", "assumed")} <= set(kinds(sprung, known=True))


def test_inertias_about_the_origins_are_said_by_every_landing():
    """Bars that hang from their links' origins: given about these, or about their centres."""

    def chain(about_origin):
        bars = [
            link(name, mass, bar(float(mass), about_origin))
            for name, mass in zip("bcd", ("1.0", "2.0", "3.0"), strict=True)
        ]
        joints = [
            joint(f"{a}{b}", a, b, more=LIMIT + '<origin xyz="0 0 -0.4"/>')
            for a, b in ("ab", "bc", "cd")
        ]
        return robot_from(urdf(link("a", "5"), *bars, *joints))

    def bar(mass, about_origin):
        moment = mass * 0.4**2 * (1.0 / 12.0 + about_origin / 4.0)
        numbers = f'ixx="{moment}" ixy="0" ixz="0" iyy="{moment}" iyz="0" izz="{1e-3 * mass}"'
        return f'<origin xyz="0 0 -0.2"/><inertia {numbers}/>'

    def found(about_origin):
        profile = shock_profile(
            Scene(robot="r", base="free", contact=Contact(frame="d", offset=(0.0, 0.0, -0.4))),
            chain(about_origin),
        )
        return [
            str(one) for one in profile.health.warnings if "about the links' origins" in str(one)
        ]

    assert len(found(True)) == 1
    assert found(False) == []


def test_reports_begin_with_what_is_not_known(capfd):
    """Terminal, Markdown, notebook, JSON and Python; none says that there are no warnings."""
    profile = shock_profile(FIRST)
    report, first = landing_report(profile), str(profile.unknowns[0])
    for text in (
        report.text("table"),
        report.text("markdown"),
        good(capfd, "analyze", "a1"),
        profile._repr_html_(),
    ):
        assert text.count(first.partition(";")[0]) == 1
        assert "no warnings" not in text
    assert report.text("table").splitlines()[1] == f"unknown      {first}"
    assert json.loads(report.text("json"))["unknowns"][0]["text"] == profile.unknowns[0].text
    assert first in repr(profile)
    with pytest.warns(ShockWarning, match="are not known"):
        shock_profile(FIRST)


def test_with_drives_is_no_heading_where_no_drive_is_known():
    def columns(**options):
        return landing_report(shock_profile(Scene(**options))).text("table")

    assert "with drives" in columns(robot="go2", contact="FL_foot")
    unknown = columns(robot="a1", contact="FL_foot")
    assert "with drives" not in unknown
    assert all(
        heading in unknown
        for heading in (
            "joints free",
            "joints locked",
            "smallest found",
            "largest",
            "Neither is a bound",
        )
    )
    assert "as modelled" in columns(
        robot="talos", contact="left_sole_link", joints=Joints(drives="none")
    )


def test_the_first_line_has_the_imu_and_no_table_is_wider_than_a_terminal(capfd):
    """Before cameras, however many there are; where the shock is largest is said too, and nothing
    ends in "and 21 more".
    """
    text = good(capfd, "analyze", "anymal_c")
    shock = text.splitlines()[0]
    assert shock.startswith("shock        all four feet together: imu_link ")
    assert "_camera up to 0." in shock
    assert " more" not in shock
    tables = text.split("a line for each landing\n")[1].split("\n(")[0].splitlines()
    assert max(map(len, tables)) <= 100
    names = [line[:13].rstrip() for line in tables[3:]]
    assert names == [
        "all four feet",
        "LF + LH",
        "LF + RF",
        "LH + RH",
        "RF + RH",
        "LF",
        "LH",
        "RF",
        "RH",
    ]
    assert "imu_link" in tables[0]


def test_a_table_is_shortened_and_continued_until_it_has_room():
    columns = ["place", *(f"quantity {k} [m]" for k in range(9))]
    rows = [(f"{'long_' * 12}name_{n}", *(0.123 * k for k in range(9))) for n in range(2)]
    text = as_text(Sheet("table", columns, rows), 60)
    assert max(map(len, text.splitlines())) <= 60
    assert all(f"quantity {k}" in text for k in range(9))
    assert all(number in text for row in rows for number in (rounded(row[3]), rounded(row[9])))
    assert max(map(len, as_text(Sheet("table", columns, rows)).splitlines())) > 100


@pytest.mark.parametrize(
    ("directions", "words"),
    [("z", "slides without friction"), ("yz", "slides freely along one direction")],
)
def test_the_mass_of_a_contact_is_that_of_the_rows_that_act(capfd, directions, words):
    """By n A n of the point's mobility: the impulse of the ground for 1 m/s; that along the normal
    alone beside it.
    """
    line = next(
        line
        for line in good(
            capfd, "analyze", "go2", "--contact", "FL_foot", "--directions", directions
        ).splitlines()
        if line.startswith("ground")
    )
    profile = shock_profile(
        Scene(robot="go2", contact=Contact(frame="FL_foot", directions=tuple(directions)))
    )
    impulse = -float(profile.proof.impulse[-1, 2])
    assert f"effective mass {rounded(impulse)} kg" in line
    normal = profile.contacts[0].effective_mass_frictionless
    assert (f"{rounded(normal)} kg along the normal, without friction" in line) == (
        directions != "z"
    )
    assert words in line
    assert normal_mass(profile.landing) == pytest.approx(normal, rel=1e-12)


def test_the_normal_mass_of_several_contacts_is_that_of_all_of_them_without_friction():
    """1ᵀ (J_n H⁻¹ J_nᵀ)⁻¹ 1, with a row for each contact."""
    profile = shock_profile(
        Scene(robot="go2", contact=("FL_foot", "FR_foot", "RL_foot", "RR_foot"))
    )
    state, blocks = profile.landing.state, profile.landing.contacts
    rows = row_jacobian(
        state,
        [block._replace(forces=np.array([[0.0, 0.0, 1.0]]), moments=NO_AXES) for block in blocks],
    )[0]
    masses = np.linalg.inv(rows @ np.linalg.solve(state.inertia[0], rows.T))
    assert normal_mass(profile.landing) == pytest.approx(masses.sum(), rel=1e-10)


def test_the_smallest_margin_of_a_part_is_in_the_first_lines_of_several_landings(capfd):
    """With its landing and its range, and in a column; nobody gave a contact's duration, so none is
    named.
    """
    words = ("analyze", "go2", "--part", "imu=half-sine 50 g 11 ms", "--drop-height", "0.5")
    text = good(capfd, *words)
    margin = text.splitlines()[1]
    least = min(
        part.part_margin for part in shock_profile(scene_with_part(("FL", "FR", "RL", "RR"))).parts
    )
    assert margin.startswith(f"margin       imu {rounded(least)} (")
    assert margin.endswith(", drives derived) by velocity change, all four feet")
    assert "worst margin" in text
    alone = good(capfd, *words, "--contact", "FL_foot", "--all")
    assert alone.splitlines()[1].startswith("margin       imu ")
    assert not any(line.startswith(("rigid links", "links bend")) for line in alone.splitlines())


def scene_with_part(feet):
    part = Part(name="imu", at="imu", rating="half-sine 50 g 11 ms")
    return Scene(
        robot="go2",
        contact=tuple(f"{name}_foot" for name in feet),
        part=(part,),
        strike=Strike(drop_height=0.5),
    )


def test_a_profile_in_a_line_has_what_is_unknown_but_not_what_was_chosen():
    assert repr(shock_profile(Scene(robot="go2", contact="FL_foot"))) == (
        'ShockProfile(PosedLanding(go2: contact "FL_foot"))'
    )
