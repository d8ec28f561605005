"""A number of a landing is the same in every study: as an analysis, a row of a sweep or of a table,
a design, a case, a robot.
"""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from trees import known_robot

import shockpc
from shockpc import Contact, Design, Joints, Part, Posture, Scene, Strike, StudyError, shock_profile
from shockpc.evaluation.budgets import Budget, Budgets, Case
from shockpc.evaluation.column import Column, places_at, selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.profiles import proven_profiles
from shockpc.evaluation.variations.arguments import varied_landings
from shockpc.quantities.selection import QUANTITIES, select
from shockpc.studies.check.study import check_budgets

IMU = Part(name="IMU", at="imu_link", rating="half-sine 1500 g 0.5 ms")
KNEE = Part(name="knee", joint="LF_KFE", momentary_torque=80.0, torque_duration=0.02)
PLAIN = Scene(robot="anymal_b", contact="LF_FOOT", strike=Strike(speed=1.3, strike_angle_deg=10.0))
SCENES = {
    "a drop with parts": replace(
        PLAIN, strike=Strike(drop_height=0.3), pulse="half-sine:15ms", part=(IMU, KNEE)
    ),
    "friction": replace(
        PLAIN, contact=("LF_FOOT", "RH_FOOT"), strike=Strike(strike_angle_deg=30.0), friction=0.3
    ),
    "stops and restitution": replace(
        PLAIN,
        contact=Contact(frame="LF_FOOT", restitution=0.2),
        posture=Posture(joints_deg={"LF_KFE": 0.0}),
        strike=Strike(joint_velocities={"LF_KFE": 2.0}),
        stops=True,
    ),
    "a standing foot": replace(
        PLAIN,
        stance=("RH_FOOT",),
        strike=Strike(velocity=(0.2, 0.0, -1.0), angular_velocity=(0.0, 0.5, 0.0)),
    ),
    "finite stiffness": replace(
        PLAIN, contact_stiffness=1e5, part=(IMU, KNEE), joints=Joints(torque={"LF_KFE": 5.0})
    ),
    "redundant": replace(
        PLAIN, contact=("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"), joints=Joints(model="locked")
    ),
}


def of_sweep(scene, profile, texts):
    joint = profile.robot.joint("RF_HAA")
    evaluation = shockpc.sweep(
        scene, {"RF_HAA": math.degrees(joint.value(profile.q))}, quantities=texts, prove=0
    )
    return of_table(evaluation, texts)


def of_recorded(scene, profile, texts):
    velocity = dict(
        zip(("vx", "vy", "vz"), np.reshape(profile.landing.before.velocity, (3, 1)), strict=True)
    )
    return of_table(shockpc.recorded(velocity, scene, texts, prove=0), texts)


def of_table(evaluation, texts):
    table = evaluation.table
    assert not table.messages
    named = {
        column.name: (column.selection.name, column.place.name) for column in evaluation.computed
    }
    return {key: table.columns[name][0] for name, key in named.items() if key[0] in texts}


def of_designs(scene, profile, texts):
    designs = [Design(name, scene, profile.robot) for name in "ab"]
    known = [
        text
        for text in texts
        if not np.isnan(profile.numbers(select(text), places(profile, text))).all()
    ]
    found = shockpc.compare(designs, known).quantities
    return {
        (one.selection.name, row.place): row.values[0]
        for one in found
        for row in one.rows
        if one.selection.name in texts
    }


def of_budgets(scene, profile, texts):
    case = Case(name="a", **{part.name: getattr(scene, part.name) for part in fields(Scene)})
    budgets = tuple(Budget(metric=text, min=-1e99, max=1e99) for text in texts)
    return {
        (one.budget.metric, one.at): np.nan if one.value is None else one.value
        for one in check_budgets(Budgets(None, (case,), budgets, ())).outcomes
        if "(" not in one.at  # a centre of mass, which a metric of points has in a check alone
    }


def of_batch(scene, profile, texts):
    asked = {
        f"{text}@{place.name}": (text, place.name)
        for text in texts
        if select(text).quantity.of != "robot"
        for place in places(profile, text)
    }
    (row,) = shockpc.batch(
        ["a"], lambda name: (profile.robot, [scene]), quantities=list(asked)
    ).rows
    return {
        key: np.nan if row.values[text] is None else row.values[text] for text, key in asked.items()
    }


def places(profile, text):
    return places_at(profile.landing, select(text).quantity)


@pytest.mark.slow
@pytest.mark.parametrize("study", [of_sweep, of_recorded, of_designs, of_budgets, of_batch])
@pytest.mark.parametrize(
    ("name", "proven"),
    [
        (name, proven)
        for name in SCENES
        for proven in (True, False)
        if proven or name != "finite stiffness"
    ],
)
def test_a_number_is_the_same_in_every_study(name, study, proven):
    """To 1e-10 of the largest at the places of its kind, whether it needs a proof or is computed in
    double precision.
    """
    scene = SCENES[name]
    profile = shock_profile(scene, known_robot("anymal_b"))
    expected, sizes = {}, {}
    for entry in QUANTITIES:
        text = f"{entry.of}.{entry.key}"
        if proven is not entry.per_landing(scene):
            continue
        try:
            found = profile.numbers(select(text), places(profile, text))
        except StudyError:
            continue
        expected |= {
            (text, place.name): value
            for place, value in zip(places(profile, text), found.tolist(), strict=True)
        }
        sizes[text] = max(np.nan_to_num(np.abs(found), posinf=0.0).max(initial=0.0), 1e-5)
    computed = study(scene, profile, list(sizes))
    assert len(computed) > 20
    for key, value in computed.items():
        assert expected[key] == pytest.approx(
            value, rel=1e-10, abs=1e-10 * sizes[key[0]], nan_ok=True
        ), key


@pytest.mark.parametrize("given", [{"contact_stiffness": 1e5}, {"friction": 0.5}])
def test_a_new_study_refuses_options_without_effect(given):
    """A study that is written here, with columns or with profiles, asks nothing of the ground; the
    engine does.
    """
    scene = replace(PLAIN, **given)

    def by_columns(key):
        source = varied_landings(scene, {"speed": [1.0, 2.0]}, robot=known_robot("anymal_b"))
        selection, places = selected(source.first, key)
        return Evaluation(source, (Column(selection, places[0]),), prove=0).table

    def by_profiles(key):
        return proven_profiles({"landing": (scene, known_robot("anymal_b"))}, [select(key)])

    for study in (by_columns, by_profiles):
        with pytest.raises(StudyError, match=next(iter(given)).replace("_", " ")):
            study("shock_com")
        assert len(study("shock_com_friction" if "friction" in given else "peak_force"))
