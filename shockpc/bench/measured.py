"""Measured landings: how far the model is from reality, which is another matter than the error of its solution."""

from dataclasses import replace

from shockpc import Joints, read_scene
from shockpc.evaluation.table_files import read_table
from shockpc.landing.scene_file import robot_of
from shockpc.robot.catalogue import own_robots_folder
from shockpc.show.reports.landings import agreement_sheet
from shockpc.show.tables import Sheet
from shockpc.studies.landings import compare_measured

MOTORS = ("hip_*", "knee_left", "knee_right", "toe_*")

MODELS = {
    "geared, springs free": Joints(),
    "no reflected inertia, springs free": Joints(model="free"),
    "geared, springs rigid": Joints(model="rigid"),
    "motors locked, springs free": Joints(locked=MOTORS),
}
"""Joint models of Cassie."""

STIFFNESS = 1e5
"""Of each of the four contact points [N/m], where the prediction has finite stiffness: a generic value, fitted to nothing."""

IGNORED = {"second_foot_later_ms": "", "ankle_spring_joint_*": ""}
"""Columns of its table that are not used: the angle of the heel springs was not measured."""


def measured_landings(budget: float = 0.0) -> Sheet:
    """The jumps of Cassie's joint rates, measured against predicted. Args: budget, of clocks, which are none here."""
    del budget
    folder = own_robots_folder() / "measured"
    scene = read_scene(folder / "cassie.toml")
    scenes = {name: replace(scene, joints=joints) for name, joints in MODELS.items()}
    geared = next(iter(MODELS))
    scenes[geared] = replace(scenes[geared], contact_stiffness=STIFFNESS)
    comparison = compare_measured(read_table(folder / "cassie_landings.csv"), scenes, robot_of(scene), IGNORED)
    rates = tuple(one for one in comparison.agreements if one.name == "joint rates")
    sheet = agreement_sheet(comparison._replace(agreements=rates))
    return sheet._replace(title="measured landings of Cassie, 14 joint rates in each of 14 landings")
