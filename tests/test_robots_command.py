"""`shockpc robots`: every robot known by name, and all that is in one."""

import json
import re

import pytest
from commands import ROBOTS, STICK, Outcome, good, run

import shockpc.robot.catalogue
from shockpc.model.dynamics import PINOCCHIO
from shockpc.robot.catalogue import catalogue

DOG = (ROBOTS / "dog" / "dog.urdf.xacro", "--package", f"dog_description={ROBOTS / 'dog'}")

ARM = """<mujoco model="arm">
  <worldbody>
    <body name="arm">
      <joint name="swing" axis="0 1 0" range="-45 30" limited="true" armature="0.02"/>
      <geom type="box" size="0.2 0.02 0.02" mass="1"/>
      <site name="tip_imu" pos="0.2 0 0"/>
      <body name="wheel" pos="0.2 0 0">
        <joint name="axle" axis="0 1 0"/>
        <geom type="sphere" size="0.05" mass="0.5"/>
      </body>
    </body>
  </worldbody>
  <keyframe><key name="up" qpos="0.1 0"/></keyframe>
</mujoco>
"""


def table(text, title):
    """The rows of a table, cell by cell."""
    lines = text.partition(f"{title}\n")[2].partition("\n\n")[0].splitlines()
    rule = next(k for k, line in enumerate(lines) if line.startswith("─"))
    columns = [match.span() for match in re.finditer("─+", lines[rule])]
    return [tuple(line[a:b].strip() for a, b in columns) for line in lines[rule + 1 :] if not line.startswith("(")]


def test_one_robot(capfd):
    """Head, bodies with all that is fixed to them, joints with their limits, check-up: the whole text."""
    assert good(capfd, "robots", *DOG, "--xacro", "payload:=2") == (
        f"""\
robot        dog, 8 kg, 5 moving bodies, 10 velocities
file         {ROBOTS}/dog/dog.urdf.xacro
base         free by default; planar or fixed on demand
feet         lf_foot, lh_foot, rf_foot, rh_foot
sensors      trunk_imu
postures     standing, crouched (from dog.srdf), neutral; standing by default

bodies, and the links and sites fixed to them
name       what  hangs on, or is fixed to  mass of the body
                                                       [kg]
─────────  ────  ────────────────────────  ────────────────
trunk      body  world                               6.0000
trunk_imu  link  trunk                                    –
lf_leg     body  trunk                               0.5000
lf_foot    link  lf_leg                                   –
lh_leg     body  trunk                               0.5000
lh_foot    link  lh_leg                                   –
rf_leg     body  trunk                               0.5000
rf_foot    link  rf_leg                                   –
rh_leg     body  trunk                               0.5000
rh_foot    link  rh_leg                                   –

joints (read by Pinocchio {PINOCCHIO})
joint       kind          lower    upper  unit     armature
                                                [kg m², kg]
──────────  ─────────  ────────  ───────  ────  ───────────
root_joint  free base         –        –  –               0
lf_hip      revolute   -85.9437  85.9437  deg             0
lh_hip      revolute   -85.9437  85.9437  deg             0
rf_hip      revolute   -85.9437  85.9437  deg             0
rh_hip      revolute   -85.9437  85.9437  deg             0

check-up
note: links "lf_foot", "rf_foot", "lh_foot" and 1 more: have shapes and no <inertial>; they count as without mass
note: every joint: zero armature (URDF has no place for it): joints are computed without the inertia of their motors; \
with geared or locked joints the shock is different
"""
    )


def test_mjcf_with_a_fixed_base(capfd, tmp_path):
    """Sites stand beside links, joints without limits show none, armature is what the file gives."""
    (tmp_path / "arm.xml").write_text(ARM)
    out = good(capfd, "robots", tmp_path / "arm.xml")
    assert out.splitlines()[:6] == [
        "robot        arm, 1.5 kg, 2 moving bodies, 2 velocities",
        f"file         {tmp_path}/arm.xml",
        "base         fixed in the file",
        "feet         wheel",
        "sensors      tip_imu",
        "postures     up, neutral; neutral by default",
    ]
    assert table(out, "bodies, and the links and sites fixed to them") == [
        ("arm", "body", "world", "1.0000"),
        ("tip_imu", "site", "arm", "–"),
        ("wheel", "body", "arm", "0.5000"),
    ]
    swing, axle = table(out, f"joints (read by Pinocchio {PINOCCHIO})")
    assert swing == ("swing", "revolute", "-45.0000", "30.0000", "deg", "0.0200")
    assert (axle[0], axle[2:]) == ("axle", ("–", "–", "deg", "0"))
    assert out.endswith("\ncheck-up\nnothing to find fault with\n")


def test_nothing_to_say_is_said(capfd, tmp_path):
    """A robot without sensors, postures or faults."""
    (tmp_path / "stick.urdf").write_text(STICK)
    out = good(capfd, "robots", tmp_path / "stick.urdf")
    assert "\nsensors      no link or site is named like an IMU, gyro, accelerometer or camera\n" in out
    assert "\npostures     neutral; neutral by default\n" in out
    assert "\nfeet         foot\n" in out


def test_mimic_joints_are_shown(capfd):
    """Followers stand in the head, with the joint that they follow."""
    out = good(capfd, "robots", "panda")
    assert "\nmimic        panda_finger_joint2 = 1 panda_finger_joint1 + 0\n" in out


def test_every_link_is_listed(capfd):
    """Where a message sends people to see all names, all names are: even the 65 that ANYmal's base carries."""
    listed = {row[0] for row in table(good(capfd, "robots", "anymal_c"), "bodies, and the links and sites fixed to them")}
    profile = json.loads(good(capfd, "analyze", "anymal_c", "--contact", "LF_FOOT", "--format", "json"))
    assert {link for body in profile["bodies"] for link in body["links"]} == listed


def test_list_of_all(capfd):
    """Every robot that the catalogue knows, the project's own first; one that cannot be loaded is a row with its reason."""
    out = good(capfd, "robots")
    assert out.startswith("robots known by name\nrobot  ")
    rows = table(out, "robots known by name")
    assert [row[:2] for row in rows] == [(entry.name, entry.source) for entry in catalogue()]
    found = {row[0]: row[2:] for row in rows}
    assert found["leg"][:3] == ("2", "10.5000", "heel")
    assert found["leg"][3].startswith("standing, ")
    assert found["hyq"] == ("13", "86.7740", "lf_foot, lh_foot, rf_foot, rh_foot", "standing, straight_standing")
    assert found["laikago"][3] == "neutral only"
    lost = [name for name, row in found.items() if row[2] == "cannot be loaded"]
    assert lost == ["hector_macro", "hector_xacro", "ur3_empty"]
    assert [found[name] for name in lost] == [("–", "–", "cannot be loaded", "")] * 3
    assert (
        "\n(ur3_empty: ur3.urdf has no <link>, so there is no robot in it; "
        "if it only defines macros, give the file that uses them)\n" in out
    )
    assert out.endswith(
        "\n(analyse one with: shockpc analyze NAME --contact FOOT)\n(see what is in one with: shockpc robots NAME)\n"
    )


def test_list_without_any_robot(capfd, monkeypatch):
    """The list is there even if there is nothing to list."""
    monkeypatch.setattr(shockpc.robot.catalogue, "catalogue", lambda: ())
    assert table(good(capfd, "robots"), "robots known by name") == []


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("dgo",), 'no robot "dgo"; nearest: "go2", "go1", "tiago". To list them: shockpc robots'),
        (
            ("leg", "--xacro", "mas:=3"),
            'leg.urdf.xacro has no xacro argument "mas"; nearest: "mass". It has ',
        ),
        (("leg", "--xacro", "mass"), '--xacro: "mass" is not NAME:=VALUE, such as payload:=1.5'),
        (("leg", "--package", "dog"), '--package: "dog" is not NAME=DIR, such as dog_description=../dog'),
        (("leg", "--package", "dog=/nowhere"), 'package "dog": there is no folder "/nowhere"; correct --package dog=DIR'),
    ],
    ids=lambda words: " ".join(words) if isinstance(words, tuple) else "",
)
def test_bad_words(capfd, words, text):
    outcome = run(capfd, "robots", *words)
    whole = f"shockpc: {text}\n"
    # What arguments a robot has is its own business: the list of them may grow.
    shown = outcome.err[: len(whole) - 1] + "\n" if text.endswith("It has ") else outcome.err
    assert outcome._replace(err=shown) == Outcome(2, "", whole)
