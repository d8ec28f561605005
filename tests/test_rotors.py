"""Rotors that the links carry: against robots whose rotors are bodies of their own, geared to their
joints by mimics.
"""

from dataclasses import replace
from pathlib import Path

import dense
import numpy as np
import pytest
from robot_texts import BODY, HINGE, body, floating, joint, link, mjcf, refused, urdf
from test_sweep import table
from trees import known_robot, robot_from

import shockpc
from shockpc import (
    Contact,
    Joints,
    Posture,
    Rotor,
    Scene,
    SceneError,
    Strike,
    resolve,
    shock_profile,
    sweep,
)
from shockpc.cli.parse import rotor
from shockpc.evaluation.variations.vary import read_changes, variation
from shockpc.impact.drive_response import drive_response, with_inertias
from shockpc.impact.landed import solved
from shockpc.landing.joint_model import joint_model
from shockpc.method.dynamics import Inertias, dynamics
from shockpc.profile import profile_of
from shockpc.quantities.quantity import quantity_values
from shockpc.quantities.selection import quantity
from shockpc.robot.changes import changed

WIDE = '<limit lower="-999" upper="999" effort="1" velocity="1"/>'
ROTORS = {
    "hip": ("base", 0.02, 6.0, "planetary", (1.0, 0.0, 0.0)),
    "knee": ("thigh", 0.001, 30.0, "harmonic", (0.0, 0.6, 0.8)),
    "ankle": ("shank", 0.004, 1.5, "spur", (0.0, 1.0, 0.0)),
    "other_hip": ("base", 0.003, 9.0, "belt", (0.0, 1.0, 0.0)),
}
"""The link that carries each rotor, its inertia about its axis [kg m²], its ratio, its gear, and
the axis of its joint.
"""


def moments(inertia, axis):
    """Inertia of a link: this about an axis, 0.03 kg m² about all others."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (
        0.03 * np.eye(3) + (inertia - 0.03) * np.outer(axis, axis)
    ).tolist()
    return f'<inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>'


def legs(geared):
    """A base with two legs.

    Rotors are links that turn with their joints by a mimic, or fixed to the links that carry them.
    """
    at = '<origin xyz="{}" rpy="0.2 -0.3 0.4"/>'
    parts = [
        link("base", "3"),
        link("thigh"),
        link("shank", "0.5"),
        link("foot", "0.2"),
        link("other", "0.8"),
    ]
    parents = {"hip": ("base", "thigh", "0 0.1 -0.05"), "knee": ("thigh", "shank", "0.05 0 -0.3")}
    parents |= {
        "ankle": ("shank", "foot", "0 0 -0.3"),
        "other_hip": ("base", "other", "0 -0.1 -0.05"),
    }
    for name, (parent, child, place) in parents.items():
        carrier, inertia, ratio, gear, axis = ROTORS[name]
        assert carrier == parent
        text = " ".join(map(repr, axis))
        sense = -1.0 if gear in ("harmonic", "spur") else 1.0
        mimic = f'<mimic joint="{name}" multiplier="{sense * ratio}"/>'
        kind, more = ("revolute", WIDE + mimic) if geared else ("fixed", "")
        parts += [
            link(f"{name}_rotor", "0.1", moments(inertia, axis)),
            joint(name, parent, child, axis=text, more=at.format(place) + WIDE),
            joint(f"{name}_gear", parent, f"{name}_rotor", kind, text, at.format(place) + more),
        ]
    return robot_from(urdf(*parts))


DRIVES = Joints(
    rotor={
        k: Rotor(inertia=inertia, gear_ratio=n, gear=gear)
        for k, (_, inertia, n, gear, _) in ROTORS.items()
    }
)
FOOT = Contact(frame="foot", at="frame", kind="point")
STRIKE = Strike(
    velocity=(0.3, 0.1, -1.0),
    angular_velocity=(0.4, -0.2, 0.7),
    joint_velocities={"hip": 1.2, "knee": -0.7, "ankle": 2.0, "other_hip": 0.4},
)
BENT = Posture(joints_deg={"hip": 20.0, "knee": -50.0, "ankle": 15.0, "other_hip": -10.0})
SCENES = {
    "free": {},
    "planar": {
        "base": "planar",
        "strike": Strike(velocity=(0.3, 0.0, -1.0), joint_velocities=STRIKE.joint_velocities),
    },
    "held joints": {"joints": ("hip", "ankle")},
    "held base": {
        "base": "fixed",
        "strike": Strike(velocity=(0.3, 0.1, -1.0), joint_velocities=STRIKE.joint_velocities),
        "contact": (Contact(frame="foot", at="frame", kind="point", directions=("z",)),),
    },
    "two feet, one slides": {
        "contact": (FOOT, Contact(frame="other", at="frame", kind="point", directions=("z",)))
    },
}


def both(strike=STRIKE, contact=(FOOT,), joints=(), **scene):
    """The landing of a robot whose rotors are bodies, and of one whose rotors are known from its
    drives.
    """
    scene = Scene(robot="legs", contact=contact, strike=strike, posture=BENT, **scene)
    # A mimic follows a joint that is held, too.
    bodies = shock_profile(
        replace(scene, joints=Joints(locked=(*joints, *(f"{name}_gear" for name in joints)))),
        legs(True),
    )
    rotors = {name: one for name, one in DRIVES.rotor.items() if name not in joints}
    return bodies, shock_profile(
        replace(scene, joints=Joints(locked=joints, rotor=rotors)), legs(False)
    )


@pytest.mark.parametrize("name", SCENES)
def test_rotors_are_bodies_that_turn_with_their_gears(name):
    """Jumps, impulses, energies and wrenches through joints are those of a robot whose rotors are
    bodies of their own.
    """
    bodies, rotors = both(**SCENES[name])
    kinds = {
        "delta_v": "body",
        "delta_omega": "body",
        "force": "joint",
        "moment": "joint",
        "along": "joint",
    }
    for key, kind in kinds.items():
        found, wanted = (
            dict(
                zip(
                    [place.name for place in profile.places(kind)],
                    profile.value(key, kind),
                    strict=True,
                )
            )
            for profile in (rotors, bodies)
        )
        size = max(np.abs(value).max() for value in wanted.values())
        for place, value in found.items():
            np.testing.assert_allclose(
                value, wanted[place], rtol=0, atol=1e-13 * size, err_msg=place
            )
    for key in ("energy_lost", "energy_share"):
        np.testing.assert_allclose(
            rotors.value(key, "robot"), bodies.value(key, "robot"), rtol=1e-12
        )
    np.testing.assert_allclose(rotors.proof.impulse, bodies.proof.impulse, rtol=1e-12, atol=1e-14)
    without = shock_profile(
        replace(rotors.scene, joints=replace(rotors.scene.joints, carried=False)), rotors.robot
    )
    assert np.abs(without.delta_qd - rotors.delta_qd).max() > 1e-2


@pytest.mark.parametrize("limit", ["", "WHOLE_ARRAYS", "LARGEST_DATA"])
def test_doubles_are_in_the_balls(limit, monkeypatch):
    """Inertia as a matrix, as momenta, and of a robot too large for Pinocchio's data gives the jump
    that is proven.
    """
    _, rotors = both(**SCENES["two feet, one slides"])
    if limit:
        monkeypatch.setattr(f"shockpc.method.dynamics.{limit}", 0)
    landing = rotors.landing
    for inertias in (None, Inertias.of(landing.robot, landing.joint_model)):
        state = dynamics(landing.robot, landing.q[None], landing.joint_model, inertias)
        equation, solution, _ = solved(landing, state)
        found = equation.full(solution.delta_qd)[0]
        np.testing.assert_allclose(found, rotors.proof.delta_qd, rtol=0, atol=1e-12)


def test_energy_is_that_of_the_momenta():
    """The energy before the impact is ½ q̇ᵀ H q̇, and so is what is left of it after: the impact's
    work is their difference.
    """
    _, rotors = both()
    H, before = rotors.landing.state.H[0], np.array(rotors.landing.before.joint_rates)
    before[:6] = np.linalg.solve(
        rotors.landing.state.J[0, :, :6], [*STRIKE.angular_velocity, *STRIKE.velocity]
    )
    after = before + rotors.delta_qd
    lost = 0.5 * (before @ H @ before - after @ H @ after)
    assert rotors.value("energy_lost", "robot")[0] == pytest.approx(lost, rel=1e-12)
    assert rotors.value("energy_share", "robot")[0] == pytest.approx(
        2.0 * lost / (before @ H @ before), rel=1e-12
    )


def test_gears_of_drives_are_those_of_scenes(tmp_path):
    """A file, an option and a scene say the same; without a gear, and on request, rotors add to the
    diagonal alone.
    """
    file, robot = tmp_path / "drives.toml", legs(False)
    text = '[[drive]]\njoint = ["{}"]\nrotor_inertia = {}\ngear_ratio = {}\ngear = "{}"\n'
    file.write_text("".join(text.format(name, *values[1:4]) for name, values in ROTORS.items()))
    coupling = joint_model(robot, DRIVES).coupling
    for name, (_, inertia, ratio, gear, _) in ROTORS.items():
        c = inertia * ratio * (1 if gear in ("planetary", "belt") else -1)
        assert coupling[robot.joint(name).v.start] == pytest.approx(c, rel=1e-15)
    np.testing.assert_allclose(
        joint_model(robot, Joints(drives=str(file))).coupling, coupling, rtol=1e-15
    )
    plain = joint_model(robot, replace(DRIVES, carried=False))
    assert not plain.coupling.any()
    np.testing.assert_array_equal(plain.armature, joint_model(robot, DRIVES).armature)
    no_gear = Joints(rotor={name: replace(one, gear=None) for name, one in DRIVES.rotor.items()})
    assert not joint_model(robot, no_gear).coupling.any()
    assert rotor("hip=0.02:6:planetary") == ("hip", (0.02, 6.0, None, "planetary"))
    assert rotor("hip=0.02:6:100:spur") == ("hip", (0.02, 6.0, 100.0, "spur"))
    file.write_text('[[drive]]\njoint = ["hip"]\narmature = 0.1\ngear = "spur"\n')
    refused(SceneError, ("hip", "gear_ratio"), joint_model, robot, Joints(drives=str(file)))


def test_a_rotor_behind_a_spring_couples_where_springs_are_rigid():
    """In an instant the spring gives no impulse, so that the rotor has no effect; a rigid spring
    joins it to its joint.
    """
    robot, behind = (
        legs(False),
        Rotor(inertia=0.02, gear_ratio=6.0, gear="planetary", stiffness=100.0),
    )
    assert not joint_model(robot, Joints(rotor={"hip": behind})).coupling.any()
    rigid = joint_model(robot, Joints(rotor={"hip": behind}, model="rigid"))
    np.testing.assert_array_equal(
        rigid.coupling, joint_model(robot, Joints(rotor={"hip": DRIVES.rotor["hip"]})).coupling
    )


def test_the_world_carries_rotors_that_do_not_couple():
    """A joint of a fixed base has only its reflected inertia: what carries its rotor does not turn."""
    robot = robot_from(
        mjcf(body("arm", BODY + body("tip", joints=HINGE.replace('"j"', '"k"')))), ".xml"
    )
    model = joint_model(
        robot, Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=10.0, gear="harmonic")})
    )
    np.testing.assert_allclose(model.coupling, [0.0, -1e-3])


@pytest.mark.parametrize("kind", ["slide", "hinge"])
def test_gears_need_an_axis_that_both_links_have(kind):
    """A joint that slides has no such axis, and of two joints of one body the first does not carry
    the other's rotor.
    """
    joints = f'<joint name="a" type="{kind}" axis="0 0 1"/>' + '<joint name="b" axis="0 1 0"/>' * (
        kind == "hinge"
    )
    robot = robot_from(mjcf(floating(body("leg", joints=joints))), ".xml")
    given = Joints(rotor={"a": Rotor(inertia=1e-4, gear_ratio=10.0, gear="belt")})
    refused(SceneError, ("gear", "a"), joint_model, robot, given)


def test_varied_reflected_inertia_keeps_its_gear():
    """Factors multiply the coupling too, of rows that are computed together, of one landing, and of
    a changed robot.
    """
    scene, robot = (
        Scene(robot="go2", contact=Contact(frame="FL_foot", at="frame")),
        known_robot("go2"),
    )
    made = sweep(
        scene, {"armature:FL_*": "0.5x,2x"}, robot=robot, quantities=["shock_com@base"], prove=0
    )
    for factor, found in zip((0.5, 2.0), table(made)[0]["shock_com@base"], strict=True):
        same = shock_profile(scene, changed(robot, read_changes(f"armature:FL_*={factor}x")))
        assert found == pytest.approx(same.shock_com[0], rel=1e-10)
        varied = variation(robot, "armature:FL_*", f"{factor}x")
        row, _ = varied.applied(scene, robot, factor)
        assert shock_profile(row, robot).shock_com[0] == pytest.approx(same.shock_com[0], rel=1e-12)


def test_a_range_changes_the_rotor_in_its_link_too():
    """A heavier rotor adds d to the reflected inertia, d/n to the coupling and d/n² to the link
    that contains it.

    The closed form is the full solution with these. Where the link keeps its inertia, as with other
    drives, the jump is the same to 1/n² of the change.
    """
    landing = resolve(
        Scene(robot="go2", contact=Contact(frame="FL_foot", at="frame")), known_robot("go2")
    )
    model, H, equation = landing.joint_model, landing.state.H[0], landing.equation(landing.state)
    columns, change = np.flatnonzero(model.coupling), np.zeros(len(H))
    change[columns] = model.armature[columns] * np.linspace(-0.4, 0.8, len(columns))
    plain = dynamics(
        landing.robot, landing.q[None], model._replace(per_turn=0.0 * model.per_turn)
    ).H[0]
    for v in columns:
        alone = np.where(np.arange(len(H)) == v, model.per_turn, 0.0)
        spin = (
            dynamics(landing.robot, landing.q[None], model._replace(per_turn=alone)).H[0] - plain
        )[v] / model.coupling[v]
        turns = np.eye(len(H))[v] + model.per_turn[v] * spin
        H = H + change[v] * np.outer(turns, turns)
    wanted, _ = dense.solve(H, equation.J_c[0], equation.b[0, :, 3])
    found = drive_response(landing).at(landing, [change])
    np.testing.assert_allclose(found.delta_qd[0, :, 0], wanted, atol=1e-11 * np.abs(wanted).max())
    other = profile_of(with_inertias(landing, change))
    np.testing.assert_allclose(wanted, other.delta_qd, atol=5e-3 * np.abs(wanted).max())
    along, joints = quantity("joint", "along"), landing.places("joint")
    loads = other.value("along", "joint")
    np.testing.assert_allclose(
        quantity_values(along, found, joints)[0, 0], loads, atol=2e-3 * np.abs(loads).max()
    )


def test_the_guide_says_by_how_much_carried_rotors_lower_the_shock():
    """The IMU of Go2 on a front foot, with and without the coupling."""
    scene = Scene(robot="go2", contact="FL_foot")
    carried, alone = (
        shock_profile(replace(scene, joints=Joints(carried=each))).points[0].shock
        for each in (True, False)
    )
    page = (Path(shockpc.__file__).parent / "guide" / "changes.md").read_text(encoding="utf-8")
    assert (
        f"Go2's shock on one front foot is {100.0 * (1.0 - carried / alone):.1f} % smaller" in page
    )
