"""The project's models: the proportions that the paper prints, and the postures of its figures."""

import math

import numpy as np
import pinocchio as pin
import pytest

from shockpc import Robot, load_robot
from shockpc.robot.bodies_and_joints import Body


def bodies(name: str, **arguments: str) -> dict[str, Body]:
    """The moving bodies of a model."""
    return {body.name: body for body in load_robot(name, xacro=arguments).bodies}


def places(robot: Robot, posture: str) -> dict[str, np.ndarray]:
    """Where every frame is in a posture of the robot's SRDF."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.postures[posture])
    return {
        frame.name: data.oMf[k].translation.copy() for k, frame in enumerate(robot.model.frames)
    }


def angle(vector: np.ndarray) -> float:
    """The angle of a direction on the page, counter-clockwise from straight down, x to the right
    and z up [deg].
    """
    return math.degrees(math.atan2(vector[0], -vector[2]))


@pytest.mark.parametrize(
    ("name", "arguments"),
    [("beam", {}), ("leg", {"torso": "true", "foot": "true"}), ("quadruped", {})],
)
def test_beams_are_slender_and_physical(name: str, arguments: dict[str, str]):
    """Every body: CoM half way, moments across exactly m l²/12, a tensor that a real body has, for
    any section.
    """
    lengths = {
        "beam": 1.0,
        "upper_leg": 0.4,
        "lower_leg": 0.4,
        "foot": 0.2,
        "torso": 0.6 if name == "leg" else 0.8,
        **{
            f"{which}_{part}_leg": 0.4 for which in ("hind", "front") for part in ("upper", "lower")
        },
    }
    for side in (None, "0.1"):
        for body in bodies(name, **arguments, **({"side": side} if side else {})).values():
            length, mass = lengths[body.name], body.mass
            across = mass * length**2 / 12
            along = mass * (float(side) if side else {"beam": 0.05}.get(name, 0.02)) ** 2 / 6
            # about y, as in the paper
            assert body.inertia[1, 1] == pytest.approx(across, rel=1e-15)
            moments = np.sort(np.linalg.eigvalsh(body.inertia))
            np.testing.assert_allclose(moments, [along, across, across], rtol=1e-12)
            assert moments[0] > 0
            assert moments[0] + moments[1] > moments[2]


def test_beam():
    """Figure 1: c = l/2, p = 2l/3 from the pivot, and its arguments."""
    robot = load_robot("beam", xacro={"length": "0.6", "mass": "3"})
    assert robot.mass == 3.0
    np.testing.assert_allclose(robot.coms, [[0.3, 0, 0]], atol=1e-16)
    assert [
        robot.frame(name).offset[0] for name in ("pivot", "center", "percussion", "tip")
    ] == pytest.approx([0, 0.3, 0.4, 0.6])


def test_leg_postures(capfd: pytest.CaptureFixture[str]):
    """Figure 2: upper leg +15°, torso −5°, and case F with the foot 105° from a vertical shank; the
    contact is on the ground.
    """
    robot = load_robot("leg", xacro={"torso": "true", "foot": "true"})
    for name, shank, contact in (("standing", -10.0, "heel"), ("standing_on_ball", 0.0, "ball")):
        at = places(robot, name)
        assert angle(at["knee"] - at["hip"]) == pytest.approx(15.0)
        assert angle(at["heel"] - at["knee"]) == pytest.approx(shank, abs=1e-12)
        assert angle(at["hip"] - at["head"]) == pytest.approx(-5.0)
        assert angle(at["ball"] - at["heel"]) == pytest.approx(105.0 + shank)
        assert at[contact][2] == pytest.approx(0.0, abs=1e-15)
    straight = places(robot, "straight")
    assert angle(straight["heel"] - straight["hip"]) == pytest.approx(0.0, abs=1e-12)
    # A variant that lacks joints of the posture stands alike.
    np.testing.assert_allclose(
        places(load_robot("leg"), "standing")["heel"], places(robot, "standing")["heel"], atol=1e-16
    )
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("name", "leg"), [("standing", 30), ("legs_20", 20), ("legs_10", 10), ("legs_0", 0)]
)
def test_quadruped_postures(name: str, leg: int):
    """Figure 5: nose up by 15°, hind knee forward and front knee backward by the leg's angle, hind
    foot on the ground.
    """
    at = places(load_robot("quadruped"), name)
    assert angle(at["front_hip"] - at["hind_hip"]) == pytest.approx(90 + 15)
    for which, knee in (("hind", leg), ("front", -leg)):
        assert angle(at[f"{which}_knee"] - at[f"{which}_hip"]) == pytest.approx(knee, abs=1e-12)
        assert angle(at[f"{which}_foot"] - at[f"{which}_knee"]) == pytest.approx(-knee, abs=1e-12)
    assert at["hind_foot"][2] == pytest.approx(0.0, abs=1e-15)
    assert at["front_foot"][2] > 0.2
    np.testing.assert_allclose(at["imu_link"], (at["front_hip"] + at["hind_hip"]) / 2, atol=1e-15)
