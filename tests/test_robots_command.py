"""`shockpc robots`: the robots known by name, and the contents of one."""

import json
import re

import pytest
from commands import ROBOTS, STICK, good, says
from robot_texts import body, mjcf

import shockpc.robot.catalogue
from shockpc.method.dynamics import PINOCCHIO
from shockpc.robot.catalogue import catalogue

DOG = (ROBOTS / "dog" / "dog.urdf.xacro", "--package", f"dog_description={ROBOTS / 'dog'}")

WHEEL = body(
    "wheel", '<geom size="0.05" mass="0.5"/>', '<joint name="axle" axis="0 1 0"/>', 'pos="0.2 0 0"'
)
SWING = '<joint name="swing" axis="0 1 0" range="-45 30" limited="true" armature="0.02"/>'
BOX = '<geom type="box" size="0.2 0.02 0.02" mass="1"/><site name="tip_imu" pos="0.2 0 0"/>'
ARM = mjcf(
    body("arm", BOX + WHEEL, SWING, ""), after='<keyframe><key name="up" qpos="0.1 0"/></keyframe>'
)


def table(text, title):
    """The rows of a table, cell by cell."""
    lines = text.partition(f"{title}\n")[2].partition("\n\n")[0].splitlines()
    rule = next(k for k, line in enumerate(lines) if line.startswith("─"))
    columns = [match.span() for match in re.finditer("─+", lines[rule])]
    return [
        tuple(line[a:b].strip() for a, b in columns)
        for line in lines[rule + 1 :]
        if not line.startswith("(")
    ]


def test_one_robot(capfd):
    """Head, bodies with all that is fixed to them, joints with their limits, check-up."""
    out = good(capfd, "robots", *DOG, "--xacro", "payload:=2")
    assert out.splitlines()[:6] == [
        "robot        dog, 8 kg, 5 moving bodies, 10 velocities",
        f"file         {ROBOTS}/dog/dog.urdf.xacro",
        "base         falls freely; --base planar or --base fixed restrains it",
        "feet         lf_foot, lh_foot, rf_foot, rh_foot",
        "sensors      trunk_imu",
        "postures     standing, crouched (from dog.srdf), neutral; standing by default",
    ]
    sides = ("lf", "lh", "rf", "rh")
    legs = (
        [(f"{s}_leg", "body", "trunk", "0.5000") for s in sides],
        [(f"{s}_foot", "link", f"{s}_leg", "–") for s in sides],
    )
    assert table(out, "bodies, and what is fixed to them") == [
        *(("trunk", "body", "world", "6.000"), ("trunk_imu", "link", "trunk", "–")),
        *(row for pair in zip(*legs, strict=True) for row in pair),
    ]
    assert table(out, f"joints (read by Pinocchio {PINOCCHIO})") == [
        ("root_joint", "free base", "–", "–", "–", "0"),
        *((f"{side}_hip", "revolute", "-85.94", "85.94", "deg", "0") for side in sides),
    ]
    notes = [line for line in out.splitlines() if line.startswith("note: ")]
    assert ["shapes but no <inertial>" in notes[0], "zero armature" in notes[1], len(notes)] == [
        True,
        True,
        2,
    ]
    assert says(out, "yourdfpy", "10 links, 9 joints")


def test_mjcf_with_a_fixed_base(capfd, tmp_path):
    """Sites stand beside links, joints without limits show none, armature is what the file gives."""
    (tmp_path / "arm.xml").write_text(ARM)
    out = good(capfd, "robots", tmp_path / "arm.xml")
    assert out.splitlines()[:6] == [
        "robot        m, 1.5 kg, 2 moving bodies, 2 velocities",
        f"file         {tmp_path}/arm.xml",
        "base         fixed in the file; --base free releases it",
        "feet         wheel",
        "sensors      tip_imu",
        "postures     up, neutral; up by default",
    ]
    assert table(out, "bodies, and what is fixed to them") == [
        ("arm", "body", "world", "1.000"),
        ("tip_imu", "site", "arm", "–"),
        ("wheel", "body", "arm", "0.5000"),
    ]
    swing, axle = table(out, f"joints (read by Pinocchio {PINOCCHIO})")
    assert swing == ("swing", "revolute", "-45.00", "30.00", "deg", "0.0200")
    assert (axle[0], axle[2:]) == ("axle", ("–", "–", "deg", "0"))
    assert out.endswith("\ncheck-up\nnothing found\n")


def test_what_a_robot_lacks_is_stated(capfd, tmp_path):
    """A robot without sensors, postures or faults."""
    (tmp_path / "stick.urdf").write_text(STICK)
    out = good(capfd, "robots", tmp_path / "stick.urdf")
    assert (
        "\nsensors      no link or site is named like an IMU, gyro, accelerometer or camera\n"
        in out
    )
    assert "\npostures     neutral; neutral by default\n" in out
    assert "\nfeet         foot\n" in out


def test_mimic_joints_are_shown(capfd):
    """Joints that follow others are listed in the head, with the joint that they follow."""
    out = good(capfd, "robots", "panda")
    assert "\nmimic        panda_finger_joint2 = 1 panda_finger_joint1 + 0\n" in out
    assert "\npanda_finger_joint1: nothing is known\n" in out


def test_every_link_is_listed(capfd):
    """Messages refer to this list for all names: it has them all, even the 65 links of ANYmal's
    base.
    """
    listed = {
        row[0]
        for row in table(good(capfd, "robots", "anymal_c"), "bodies, and what is fixed to them")
    }
    profile = json.loads(
        good(capfd, "analyze", "anymal_c", "--contact", "LF_FOOT", "--format", "json")
    )
    assert {link for body in profile["bodies"] for link in body["links"]} == listed


@pytest.mark.slow
def test_list_of_all(capfd):
    """Every robot that the catalogue knows, in 120 columns; one that cannot be loaded is a row with
    the command that says why.
    """
    out = good(capfd, "robots")
    assert max(map(len, out.splitlines())) <= 120
    rows = table(out, "robots known by name")
    assert [row[0] for row in rows] == [entry.name for entry in catalogue()]
    found = {row[0]: row[1:] for row in rows}
    assert found["leg"][:3] == ("2", "10.50", "heel")
    assert found["leg"][3].startswith("standing, ")
    assert found["hyq"] == (
        "13",
        "86.77",
        "lf_foot, lh_foot, rf_foot, rh_foot",
        "standing, straight_standing",
    )
    assert found["laikago"][3] == "neutral_bent"
    assert found["romeo_laas_small"][2] == "l_sole, r_sole"
    assert len(found["alex_psyonic_hands"][2]) == 38
    lost = [name for name, row in found.items() if row[1] == "–"]
    assert lost == ["hector_macro", "hector_xacro", "ur3_empty"]
    assert f"(cannot be loaded, which shockpc robots NAME says why: {', '.join(lost)})" in out
    assert "shockpc analyze NAME --contact FOOT" in out


def test_list_without_any_robot(capfd, monkeypatch):
    """The list is there even if there is nothing to list."""
    monkeypatch.setattr(shockpc.robot.catalogue, "catalogue", lambda: ())
    assert table(good(capfd, "robots"), "robots known by name") == []


def test_names_in_the_check_up_cannot_control_a_terminal(tmp_path, capfd):
    shape = '<visual><geometry><mesh filename="\u202e.stl"/></geometry></visual>'
    (tmp_path / "r.urdf").write_text(STICK.replace("</link>", f"{shape}</link>", 1))
    assert '"\\u202e.stl"' in good(capfd, "robots", tmp_path / "r.urdf")


def test_a_link_inside_another_element_is_no_link(tmp_path, capfd):
    (tmp_path / "r.urdf").write_text(
        STICK.replace(
            "</inertial>",
            '<link><inertial><mass value="?"/><inertia/></inertial></link></inertial>',
            1,
        )
    )
    good(capfd, "robots", tmp_path / "r.urdf")
