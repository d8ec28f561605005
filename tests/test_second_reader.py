"""The second reader of URDFs agrees on every robot of the catalogue, and names what differs."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from test_source import NOT_ROBOTS

from shockpc import load_robot
from shockpc.robot.catalogue import catalogue
from shockpc.robot.urdf.second_reader import TOLERANCE, second_reading


@pytest.mark.slow
# an MJCF
@pytest.mark.parametrize(
    "name", [entry.name for entry in catalogue() if entry.name not in {*NOT_ROBOTS, "cassie"}]
)
def test_yourdfpy_reads_the_same_robot(name: str):
    """Links, joints, limits, mimics, inertias, and placements at random configurations."""
    reading = second_reading(load_robot(name))
    assert reading.differences == ()
    assert reading.links > 0
    assert reading.largest <= TOLERANCE


def limit(model):
    model.upperPositionLimit[7] += 1e-9


def mass(model):
    model.frames[model.getFrameId("panda_link3", pin.FrameType.BODY)].inertia.mass *= 1.0 + 1e-9


def placement(model):
    model.jointPlacements[3].translation += np.array([0.0, 1e-9, 0.0])


def name(model):
    model.frames[model.getFrameId("panda_link3", pin.FrameType.BODY)].name = "other"


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        (limit, ['"panda_joint1"', "limits"]),
        (mass, ['"panda_link3"', "mass"]),
        (placement, ["e-10 elsewhere", '"panda_']),
        (name, ["links", '"other"', '"panda_link3"']),
    ],
)
def test_what_differs_is_named(change, parts):
    robot = load_robot("panda")
    model = pin.Model(robot.model)
    change(model)
    text = "; ".join(second_reading(replace(robot, model=model)).differences)
    assert all(part in text for part in parts), text


def test_another_mimic_is_named():
    robot = load_robot("panda")
    (mimic,) = robot.mimics
    for rule in ((), (mimic._replace(offset=1e-9),)):
        (text,) = second_reading(replace(robot, mimics=rule)).differences
        assert mimic.joint in text
