"""Measured landings: the difference of the model from reality.

It is another matter than the error of the model's solution.
"""

from dataclasses import replace

from shockpc import Contact, Joints, Scene, load_robot, read_scene
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.robot.catalogue import project_robots_folder
from shockpc.show.tables import Sheet
from shockpc.wings.recordings.recorded.report import agreement_sheet
from shockpc.wings.recordings.recorded.study import compare_measured
from shockpc.wings.recordings.tables.table_files import read_table

MOTORS = ("hip_*", "knee_left", "knee_right", "toe_*")

MODELS = {
    "with reflected inertia, springs free": Joints(),
    "no reflected inertia, springs free": Joints(model="free"),
    "with reflected inertia, springs rigid": Joints(model="rigid"),
    "motors locked, springs free": Joints(locked=MOTORS),
}
"""Joint models of Cassie."""

STIFFNESS = 1e5
"""Stiffness of each of the four contact points where the prediction has a finite one [N/m].

It is a generic value, fitted to nothing.
"""

IGNORED = {"second_foot_later_ms": "", "ankle_spring_joint_*": ""}
"""Columns of its table that are not used: the angle of the heel springs was not measured."""

LAWS = {
    "sticks": (0.0, None),
    "friction 0.2": (0.0, 0.2),
    "friction 0.2, restitution 0.2": (0.2, 0.2),
}
"""Laws of the contact of the hinged blocks: coefficients of restitution and of friction."""

CLEAR = 0.006
"""Height of the next corner above the lowest one from which on that one alone struck [m].

It is what the blocks' motion capture tells.
"""


def measured_landings(budget: float = 0.0) -> Sheet:
    """The jumps of Cassie's joint rates, measured against predicted.

    Args: budget, of clocks, which are none here.
    """
    del budget
    folder = project_robots_folder() / "measured"
    scene = read_scene(folder / "cassie.toml")
    scenes = {name: replace(scene, joints=joints) for name, joints in MODELS.items()}
    geared = next(iter(MODELS))
    scenes[geared] = replace(scenes[geared], contact_stiffness=STIFFNESS)
    comparison = compare_measured(
        read_table(folder / "cassie_landings.csv"), scenes, robot_of(scene), IGNORED
    )
    rates = tuple(
        agreement for agreement in comparison.agreements if agreement.name == "joint rates"
    )
    sheet = agreement_sheet(comparison._replace(agreements=rates), intervals=True)
    return sheet._replace(
        title="measured landings of Cassie, 14 joint rates in each of 14 landings"
    )


def measured_tosses(budget: float = 0.0) -> Sheet:
    """The jumps of two hinged blocks that struck with one corner, by law of contact.

    Args: budget, of clocks; here are none.
    """
    del budget
    folder = project_robots_folder() / "measured" / "elbow"
    columns, robot = (
        read_table(folder / "elbow_landings.csv"),
        load_robot(str(folder / "elbow.urdf")),
    )
    clear = columns.pop("gap") > CLEAR
    columns = {name: values[clear] for name, values in columns.items()}
    scenes = {
        law: Scene(
            robot=str(folder / "elbow.urdf"),
            contact=(Contact(frame="elbow_1_corner_0", restitution=e),),
            friction=mu,
        )
        for law, (e, mu) in LAWS.items()
    }
    sheet = agreement_sheet(compare_measured(columns, scenes, robot), intervals=True)
    title = (
        f"measured impacts of two hinged blocks, {clear.sum()} tosses with one clear corner, by "
        f"law of contact"
    )
    return sheet._replace(title=title, header=("contact", *sheet.header[1:]))


def measured_steps(budget: float = 0.0) -> Sheet:
    """The jumps of both legs' rates in heel strikes of a compass-gait biped.

    Args: budget, of clocks; here are none.
    """
    del budget
    folder = project_robots_folder() / "measured" / "sydney"
    columns, file = read_table(folder / "landings.csv"), str(folder / "sydney_compass_gait.urdf")
    foot = Contact(frame="inner_foot", directions=("x", "z"))
    scene = Scene(robot=file, base="planar", joints=Joints(model="free"), contact=(foot,))
    comparison = compare_measured(columns, {"free": scene}, load_robot(file))
    title = (
        f"measured heel strikes of a compass-gait biped, rates of both legs in "
        f"{len(columns['contact'])} strikes"
    )
    return agreement_sheet(comparison, intervals=True)._replace(title=title)
