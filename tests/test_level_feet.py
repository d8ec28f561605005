"""Which feet land together: the landings of a robot without contacts, and of a landing on some of
several level feet.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from commands import good, run
from standing import quadruped, soles

import shockpc
from shockpc import Scene, shock_profile
from shockpc.landing.feet.level_feet import default_landings
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Posture
from shockpc.landing.scenes.strike import Strike
from shockpc.robot.load import load_robot
from shockpc.text.errors import SceneError

# Shock at an IMU, 1 m/s straight down in the default posture, of an independent dense solution
# (CRBA, frame Jacobians).
GO2 = {
    "FL_foot+FR_foot+RL_foot+RR_foot": 0.186132,
    "FL_foot+FR_foot": 0.076117,
    "FL_foot+RL_foot": 0.130300,
    "FR_foot+RR_foot": 0.130322,
    "RL_foot+RR_foot": 0.112096,
    "FL_foot": 0.057668,
    "FR_foot": 0.057643,
    "RL_foot": 0.077240,
    "RR_foot": 0.077281,
}
ANYMAL = {
    "LF_FOOT+LH_FOOT+RF_FOOT+RH_FOOT": 0.047043,
    "LF_FOOT+LH_FOOT": 0.048698,
    "LF_FOOT+RF_FOOT": 0.027503,
    "LH_FOOT+RH_FOOT": 0.018799,
    "RF_FOOT+RH_FOOT": 0.035149,
    "LF_FOOT": 0.026917,
    "LH_FOOT": 0.021617,
    "RF_FOOT": 0.020130,
    "RH_FOOT": 0.015694,
}
HYQ = {
    "lf_foot+lh_foot+rf_foot+rh_foot": 0.005986,
    "lf_foot+lh_foot": 0.003279,
    "lf_foot+rf_foot": 0.009109,
    "lh_foot+rh_foot": 0.008573,
    "rf_foot+rh_foot": 0.003729,
    "lf_foot": 0.005100,
    "lh_foot": 0.004166,
    "rf_foot": 0.005457,
    "rh_foot": 0.004558,
}
G1 = {
    "left_ankle_roll_link+right_ankle_roll_link": 0.498531,
    "left_ankle_roll_link": 0.245673,
    "right_ankle_roll_link": 0.245647,
}
TALOS = {
    "left_sole_link+right_sole_link": 0.876107,
    "left_sole_link": 0.735733,
    "right_sole_link": 0.735699,
}
CALF = {
    "FL_shank+FR_shank+RL_shank+RR_shank": 0.042182,
    "FL_shank+FR_shank": 0.020900,
    "FL_shank+RL_shank": 0.030045,
    "FR_shank+RR_shank": 0.019659,
    "RL_shank+RR_shank": 0.023437,
    "FL_shank": 0.014233,
    "FR_shank": 0.010473,
    "RL_shank": 0.016677,
    "RR_shank": 0.010651,
}
ANKLE = {
    "FL_foot+FR_foot+RL_foot+RR_foot": 0.040781,
    "FL_foot+FR_foot": 0.018975,
    "FL_foot+RL_foot": 0.028145,
    "FR_foot+RR_foot": 0.017436,
    "RL_foot+RR_foot": 0.024312,
    "FL_foot": 0.012827,
    "FR_foot": 0.009161,
    "RL_foot": 0.016289,
    "RR_foot": 0.009993,
}
SOLES = {"left_foot+right_foot": 0.181483, "left_foot": 0.095134, "right_foot": 0.095134}
UNEVEN = {
    "RL_foot+RR_foot": 0.024396,
    "FL_foot": 0.013743,
    "FR_foot": 0.009728,
    "RL_foot": 0.017564,
    "RR_foot": 0.011015,
}
DIAGONAL = Joints(carried=False)
"""The numbers above are by solutions with rotors on the diagonal of the inertia alone."""

PAIR = ("FL_foot+FR_foot", "FL_foot+RL_foot", "FR_foot+RR_foot", "RL_foot+RR_foot")


def landed(robot, scene) -> list[str]:
    """What strikes in each default landing of a scene."""
    return [
        "+".join(contact.frame for contact in contacts)
        for contacts in default_landings(robot, scene)
    ]


def at_imu(profile) -> float:
    """The shock at the IMU."""
    return next(point.shock for point in profile.points if "imu" in point.frame)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with robots whose feet differ: spheres on calves, ankles, longer hind legs, a foot
    without geometry, soles.
    """
    folder = tmp_path_factory.mktemp("robots")
    quadruped(folder, "q_calf", "sphere_on_calf")
    quadruped(folder, "q_ankle", "ankle")
    quadruped(folder, "q_uneven", "fixed", {"RL": 0.012, "RR": 0.012})
    quadruped(folder, "q_bare", "fixed", bare=("FR",))
    soles(folder, "b_soles")
    return folder


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("go2", GO2),
        ("anymal_b", ANYMAL),
        ("hyq", HYQ),
        ("g1", G1),
        ("talos", TALOS),
        ("q_calf.urdf", CALF),
        ("q_ankle.urdf", ANKLE),
        ("b_soles.urdf", SOLES),
        ("q_uneven.urdf", UNEVEN),
    ],
)
def test_landings_without_contacts_are_all_level_feet_edges_and_single_feet(made, name, expected):
    path = str(made / name) if name.endswith(".urdf") else name
    robot, scene = load_robot(path), Scene(robot=path, joints=DIAGONAL)
    assert landed(robot, scene) == list(expected)
    found = [
        at_imu(shock_profile(replace(scene, contact=contacts), robot))
        for contacts in default_landings(robot, scene)
    ]
    np.testing.assert_allclose(found, list(expected.values()), rtol=0, atol=1e-6)


def test_soles_carry_a_landing_together_that_tips_each_alone(made):
    """With locked joints the centre of mass is between the soles; it comes to rest on both, and
    pivots about an edge of one.
    """
    path = str(made / "b_soles.urdf")
    for feet, kind, shock in (
        (("left_foot", "right_foot"), "flat", 1.0),
        (("left_foot",), "edge", 0.998185),
    ):
        profile = shock_profile(Scene(robot=path, contact=feet, joints=Joints(model="locked")))
        assert {contact.kind for contact in profile.scene.contact} == {kind}
        assert at_imu(profile) == pytest.approx(shock, abs=1e-6)


def test_the_tolerance_the_tilt_and_the_normal_decide_which_feet_are_level(made):
    uneven = load_robot(made / "q_uneven.urdf")
    everything = landed(uneven, Scene(robot="", ground_tolerance=0.01))
    assert len(everything) == 9
    assert everything[0] == "FL_foot+FR_foot+RL_foot+RR_foot"
    go2 = load_robot("go2")
    for rpy, pair in (((0.0, 10.0, 0.0), PAIR[0]), ((10.0, 0.0, 0.0), PAIR[2])):
        tilted = landed(go2, Scene(robot="go2", posture=Posture(base_rpy_deg=rpy)))
        assert (len(tilted), tilted[0]) == (5, pair)
    slope = default_landings(
        go2, Scene(robot="go2"), (np.sin(np.radians(10.0)), 0.0, np.cos(np.radians(10.0)))
    )
    assert [contact.frame for contact in slope[0]] == PAIR[3].split("+")


def test_frames_are_compared_where_a_foot_has_no_geometry(made):
    assert (
        landed(load_robot(made / "q_bare.urdf"), Scene(robot="q_bare"))[0]
        == "FL_foot+FR_foot+RL_foot+RR_foot"
    )


@pytest.mark.parametrize(
    ("name", "options", "expected"),
    [
        ("quadruped", {}, ["front_foot", "hind_foot"]),
        ("go2", {"base": "fixed"}, ["FL_foot", "FR_foot", "RL_foot", "RR_foot"]),
        ("go2", {"stance": ("FR_foot",)}, ["FL_foot", "RL_foot", "RR_foot"]),
        ("ur5", {}, ["tool0"]),
    ],
)
def test_feet_land_singly_where_they_are_not_level_or_the_robot_does_not_fall(
    name, options, expected
):
    assert landed(load_robot(name), Scene(robot=name, **options)) == expected


def test_three_feet_on_one_edge_land_together():
    """A hexapod's edges are its two sides, with three feet each, and its ends."""
    from shockpc.landing.feet.level_feet import _edges

    points = np.array([(x, y, 0.0) for y in (0.2, -0.2) for x in (0.3, 0.0, -0.3)])
    assert sorted(_edges(points, np.array([0.0, 0.0, 1.0]))) == [
        (0, 1, 2),
        (0, 3),
        (2, 5),
        (3, 4, 5),
    ]
    assert _edges(points[:3], np.array([0.0, 0.0, 1.0])) == []


def test_feasible_is_a_drop_on_all_level_feet():
    """On some of several level feet only a tilt makes it: of the posture, or of a strike that
    rotates the robot.
    """

    def values(feet: str, **scene) -> list[float]:
        profile = shock_profile(Scene(robot="go2", contact=tuple(feet.split("+")), **scene))
        return [
            float(profile.value("feasible", "robot")[0]),
            float(profile.value("feasible_if_tilted", "robot")[0]),
        ]

    assert values("FL_foot+FR_foot+RL_foot+RR_foot") == [1.0, 0.0]
    assert values(PAIR[0]) == values("FL_foot") == [0.0, 1.0]
    tilted = Posture(base_rpy_deg=(-10.0, 10.0, 0.0))
    assert (
        values("FL_foot", posture=tilted)
        == values("FL_foot", strike=Strike(angular_velocity=(0.0, 1.0, 0.0)))
        == [1.0, 0.0]
    )
    assert values("FR_foot", posture=tilted) == [0.0, 0.0]


def test_a_sweep_over_attitudes_keeps_named_feet_that_a_tilt_makes_land_alone():
    scene = Scene(robot="go2", contact="FL_foot")
    table = shockpc.sweep(
        scene, {"base-pitch": [0.0, 10.0], "base-roll": [0.0, -10.0, 10.0]}, prove=0, feasible=True
    ).table
    name = "go2_description"
    assert table.columns["row"].tolist() == [0, 1, 3, 4]
    assert table.columns[f"feasible@{name}"].tolist() == [0.0, 0.0, 0.0, 1.0]
    assert table.columns[f"feasible_if_tilted@{name}"].tolist() == [1.0, 1.0, 1.0, 0.0]


def test_several_landings_are_one_table_with_the_worst_marked(capfd):
    lines = good(capfd, "analyze", "go2", "--drop-height", "0.3", "--no-carried").splitlines()
    assert all(
        text in lines[0]
        for text in ("all four feet together: imu 0.1861", "worst single foot 0.0773")
    )
    table = lines[lines.index(next(line for line in lines if line.startswith("───"))) + 1 :]
    rows = [line.split("  ")[0] for line in table[: len(GO2)]]
    assert rows == [
        "all four feet",
        "FL + FR",
        "FL + RL",
        "FR + RR",
        "RL + RR",
        "FL",
        "FR",
        "RL",
        "RR",
    ]
    assert table[0].split()[3:5] == ["imu", "0.1861"]
    assert not any("imu" in line for line in table[1 : len(GO2)])


def test_one_foot_has_a_remark_that_names_the_other_level_feet(capfd):
    found = run(capfd, "analyze", "go2", "--contact", "FL_foot", "--strict", "--no-carried")
    assert (found.code, found.err) == (0, "")
    assert found.out.splitlines()[0].split(maxsplit=1)[1].startswith("FL_foot only: imu 0.0577")
    (remark,) = (line for line in found.out.splitlines() if line.startswith("level feet"))
    assert all(text in remark for text in ("FR_foot, RL_foot, RR_foot", "5 mm", "imu 0.1861"))
    assert "level feet" not in good(
        capfd, "analyze", "go2", "--contact", "FL_foot", "--base-rpy=-10,10,0"
    )


@pytest.mark.parametrize(
    "words",
    [("limits", "--joint", "FL_calf_joint"), ("compare", "--change", "mass:base=1.1x"), ("sweep",)],
)
def test_commands_of_one_landing_ask_for_a_contact_all_level_feet_first(capfd, words):
    command, *others = words
    found = run(
        capfd,
        command,
        "go2",
        *others,
        *(("--at", "imu", "--max", "1") if command == "limits" else ()),
        *(("--vary", "speed=1") if command == "sweep" else ()),
    )
    assert found.code == 2
    assert found.err.index("--contact FL_foot+FR_foot+RL_foot+RR_foot") > 0


def test_a_scene_without_contacts_names_the_landing_on_all_level_feet():
    with pytest.raises(SceneError, match='"FL_foot", "FR_foot", "RL_foot", "RR_foot"'):
        shock_profile(Scene(robot="go2"))


def test_a_contact_above_a_foot_does_not_stand_for_the_foot(capfd):
    """The calf, struck 2 cm above its foot, is level with no foot."""
    assert "level feet" not in good(capfd, "analyze", "go2", "--contact", "FL_calf")


def test_standing_feet_leave_the_others_singly(capfd):
    document = json.loads(good(capfd, "analyze", "go2", "--stance", "FR_foot", "--format", "json"))
    assert [one["tables"]["landing"][0]["contact"] for one in document] == [
        "FL_foot",
        "RL_foot",
        "RR_foot",
    ]


def test_studies_take_the_same_landings_of_a_scene_without_contacts():
    scene = Scene(robot="go2", joints=DIAGONAL)
    found = shockpc.sensitivity(scene, "shock@imu", vary={"speed": [0.9, 1.1]})
    assert found.landings == tuple(GO2)
    np.testing.assert_allclose(found.values, list(GO2.values()), rtol=0, atol=1e-6)


def test_the_mean_decides_among_places_that_are_nearly_equal():
    """The largest shock of nine landings, and of every subset of the feet, at the best place
    (independent bounds).
    """
    study = shockpc.place(Scene(robot="go2", joints=DIAGONAL), alternatives=0)
    (best,) = study.places
    assert study.landings == tuple(GO2)
    assert study.least == pytest.approx(0.1618, abs=5e-5)
    assert study.complete
    assert study.least <= best.combined <= 1.01 * study.least + 1e-9
    feet = Contact(frame="FL_foot"), Contact(frame="RR_foot")
    diagonal = shock_profile(Scene(robot="go2", contact=feet, joints=DIAGONAL))
    assert float(diagonal.shock_at("base", best.position)) <= 0.1640
    singles = {
        foot: Scene(robot="go2", contact=foot, joints=DIAGONAL) for foot in GO2 if "+" not in foot
    }
    assert shockpc.place(singles, alternatives=0).combined == pytest.approx(0.0487, abs=5e-5)
