"""Recorded landings that flat ground does not allow."""

import numpy as np
from trees import known_robot

from shockpc import Contact, Posture, Scene
from shockpc.wings.recordings.recorded.report import recorded_report
from shockpc.wings.recordings.recorded.study import recorded


def test_impacts_that_make_energy_are_counted():
    """Restitution along the normal and an approach along the ground: two of four make energy."""
    robot = known_robot("anymal_b")
    tilted = Posture(base_rpy_deg=(-3.0, 3.0, 0.0))  # no other foot is level
    contact = (Contact(frame="LF_FOOT", restitution=1.0),)
    scene = Scene(robot="anymal_b", posture=tilted, contact=contact)
    angles = np.radians([-20.0, -5.0, 0.0, 20.0])
    columns = {"vx": np.sin(angles), "vz": -np.cos(angles)}
    evaluation = recorded(columns, scene, robot=robot, prove=0)
    table = evaluation.table
    assert (table.values("energy_gained") > 0.0).tolist() == [True, True, False, False]
    (line,) = recorded_report("log", evaluation.landings, table).warnings
    assert "2 of 4" in line
    assert "energy" in line
