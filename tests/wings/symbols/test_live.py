"""A landing that sliders move: its numbers in other postures are those that are proven there."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from commands import STICK
from test_derivatives import IN_SERIES, on
from trees import known_robot, robot_from

from shockpc import Contact, Posture, Scene, SceneError, Strike, resolve
from shockpc.profile import profile_of
from shockpc.robot.changes import Change, changed
from shockpc.wings.symbols.posture_formulas import live_landing

LANDINGS = {
    "geared leg": on("go2", "FL_foot"),
    "sliding, rebound along the normal": Scene(
        robot="anymal_b",
        contact=(
            Contact(
                frame="LF_FOOT",
                at="frame",
                directions=("x", "z"),
                restitution=0.4,
                restitution_along="normal",
            ),
            Contact(frame="RH_FOOT", at="frame", directions=("z",)),
        ),
    ),
    "flat foot": on("talos", "left_sole_link", kind="flat", at="frame", directions=("z",)),
    "base in the plane": on(
        "anymal_b", "LF_FOOT", at="frame", base="planar", directions=("x", "z"), stance=()
    ),
    "followers on a fixed base": on("panda", "panda_leftfinger", at="frame"),
    "several joints of one body": on(IN_SERIES, "shank", at="frame"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LANDINGS)
def test_other_postures_are_those_that_are_proven(name):
    scene = LANDINGS[name]
    robot = robot_from(IN_SERIES, ".xml") if scene.robot == IN_SERIES else known_robot(scene.robot)
    landing, rng = resolve(scene, robot), np.random.default_rng(2)
    nb = len(robot.bodies)
    live = live_landing(landing, boxes=np.tile([[[-0.1] * 3], [[0.1] * 3]], (nb, 1, 1, 1))[:, :, 0])
    assert (
        live.tilts == {"free": ("pitch", "roll"), "planar": ("pitch",), "fixed": ()}[landing.base]
    )
    x = np.array(
        [
            np.clip(one.value * rng.uniform(0.8, 1.2) + rng.uniform(-0.1, 0.1), one.low, one.high)
            for one in live.sliders
        ]
    )
    kinds = np.array([one.kind for one in live.sliders])
    pitch, roll = rng.uniform(-0.5, 0.5, 2) * [bool(live.tilts), len(live.tilts) > 1]
    about = landing.plane.normal, landing.plane.forward
    T = pin.exp3(pitch * about[0]) @ pin.exp3(roll * about[1])
    strike = np.array([0.2, 0.1 * (landing.base == "free"), -1.1])
    x[kinds == "mass"] = [one.value for one in live.sliders if one.kind == "mass"]
    (out,) = live.program(np.array([[*x, *(T.T @ strike), *T.ravel()]]))

    q = landing.q.copy()
    for one, value in zip(live.sliders, x, strict=True):
        if one.kind == "joint":
            robot.joint(one.name).set(value, q)
    robot.set_followers(q)
    if robot.free_base:
        q[3:7] = pin.Quaternion(T @ pin.Quaternion(q[3:7]).toRotationMatrix()).coeffs()
    first = landing.contacts[0]._replace(point=x[kinds == "contact"])
    there = replace(landing, contacts=(first, *landing.contacts[1:])).at(q)
    profile = profile_of(replace(there, before=landing.before._replace(velocity=strike)))

    size = np.abs(profile.proof.jumps[..., 3]).max()
    rotation, position, jumps = (
        out[: 9 * nb].reshape(nb, 3, 3),
        out[9 * nb : 12 * nb].reshape(nb, 3),
        out[12 * nb : 18 * nb],
    )
    np.testing.assert_allclose(T @ rotation, profile.rotation, atol=1e-12)
    np.testing.assert_allclose(position @ T.T + there.state.origin[0], profile.position, atol=1e-12)
    np.testing.assert_allclose(jumps.reshape(nb, 6), profile.proof.jumps[..., 3], atol=1e-10 * size)
    impulses = np.array([contact.impulse for contact in profile.contacts])
    found = out[18 * nb : 18 * nb + impulses.size].reshape(-1, 3) @ T.T
    np.testing.assert_allclose(found, impulses, atol=1e-10 * np.abs(impulses).max())
    loads = out[18 * nb + impulses.size : -1].reshape(-1, 7)
    for load, row in zip(profile.loads, loads, strict=True):
        wanted = [
            np.nan if load.along is None else load.along,
            np.linalg.norm(load.force),
            np.linalg.norm(load.moment),
        ]
        here = [
            row[0] if load.along is not None else np.nan,
            np.linalg.norm(row[1:4]),
            np.linalg.norm(row[4:]),
        ]
        np.testing.assert_allclose(here, wanted, atol=1e-9 * np.abs(impulses).max())
    assert 1.0 <= out[-1] < 1e6


def test_masses_are_those_of_a_changed_robot():
    robot, scene = robot_from(STICK), Scene(robot="stick", contact=Contact(frame="foot"))
    landing = resolve(scene, robot)
    live = live_landing(landing)
    assert [one.name for one in live.sliders] == ["knee", "body", "shin"]
    values = [0.3, 2.5, 0.9]
    (out,) = live.program(np.array([[*values, *landing.before.velocity, *np.eye(3).ravel()]]))
    heavier = changed(
        robot,
        [Change("mass", name, value, False) for name, value in (("body", 2.5), ("shin", 0.9))],
    )
    profile = profile_of(resolve(replace(scene, posture=Posture(joints={"knee": 0.3})), heavier))
    np.testing.assert_allclose(out[24:36].reshape(2, 6), profile.proof.jumps[..., 3], atol=1e-11)


def test_a_motion_of_its_own_is_refused():
    scene = replace(LANDINGS["geared leg"], strike=Strike(angular_velocity=(0.0, 1.0, 0.0)))
    with pytest.raises(SceneError, match="rotates"):
        live_landing(resolve(scene, known_robot("go2")))
