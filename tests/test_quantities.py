"""The table of quantities: one formula in two arithmetics, names, and what the document holds."""

import itertools
import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from commands import good, run
from random_landings import random_landing
from robot_texts import link, urdf

from shockpc import (
    Contact,
    Joints,
    Point,
    Scene,
    Strike,
    UnknownName,
    assert_shock,
    compare,
    resolve,
    shock_profile,
    sweep,
)
from shockpc.core.spatial import in_body_axes
from shockpc.evaluation.budgets import Budget
from shockpc.evaluation.designs import Design
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.landed import solved
from shockpc.quantities.quantity import quantity_values
from shockpc.quantities.renamed import RenamedQuantity
from shockpc.quantities.selection import QUANTITIES, quantities_of, select
from shockpc.robot.load import load_robot

COMMON = [entry for entry in QUANTITIES if entry.computation.postures == "many"]


def in_doubles(landing, strikes=None):
    """The landing's impact in double precision, in its posture."""
    with_strike = strikes is None or landing.before.omega.any() or landing.before.joint_rates.any()
    equation, solution, jumps = solved(landing, landing.state, bool(with_strike))
    return DoubleImpact(
        landing, equation, solution, in_body_axes(jumps, landing.state.rotation), strikes=strikes
    )


def assert_same(profile, impact, strike, places):
    """Each quantity in double precision against the proven one, relative to its natural size or its
    largest value.
    """
    for entry in COMMON:
        chosen = places if entry.of == "point" else profile.places(entry.of)
        if not chosen:
            continue
        double, exact = (
            quantity_values(entry, impact, chosen)[0],
            profile.value(entry.key, entry.of, chosen),
        )
        double = double[min(strike, len(double) - 1)]
        assert (np.isnan(double) == np.isnan(exact)).all(), entry.key
        known = np.isfinite(exact)
        if entry.key.endswith("direction"):
            # the direction of a shock that is zero is any
            known &= profile.value("least_severe", "body").min() > 1e-6
            double, exact = np.abs(double), np.abs(exact)
        natural = np.max(entry.size(impact, double[None, None]), initial=0.0)
        size = max(np.abs(exact[known]).max(initial=0.0), natural)
        np.testing.assert_allclose(
            double[known], exact[known], rtol=0, atol=1e-8 * size + 1e-14, err_msg=entry.key
        )


@pytest.mark.parametrize("number", [3, 41, 52, 63, 64, 67, 72])
def test_every_quantity_is_the_same_in_doubles_and_in_balls(number):
    """Random mechanisms, contacts, drives and motions before the impact; landings with a verdict,
    where no body stays at rest.
    """
    robot, scene = random_landing(number)
    scene = replace(scene, point=(Point(frame=robot.bodies[-1].name, offset=(0.1, -0.2, 0.3)),))
    profile = shock_profile(scene, robot)
    assert_same(profile, in_doubles(profile.landing), 0, profile.landing.points)


@pytest.mark.parametrize("omega", [None, (0.3, -0.2, 0.1)])
def test_a_quantity_of_many_strikes_is_that_of_each(omega):
    """Strikes of one posture as products, against a landing of their own."""
    robot = load_robot("go2")
    strike = Strike(velocity=(0.0, 0.0, -1.0), angular_velocity=omega)
    scene = Scene(
        robot="go2",
        contact=(Contact(frame="FL_foot"),),
        strike=strike,
        joints=Joints(armature={"*": 0.01}),
        pulse="half-sine:5ms",
    )
    velocities = np.array([[0.3, 0.1, -1.0], [-0.2, 0.0, -0.5]])
    impact = in_doubles(resolve(scene, robot), velocities[None])
    for k, velocity in enumerate(velocities):
        profile = shock_profile(
            replace(scene, strike=replace(strike, velocity=tuple(velocity))), robot
        )
        assert_same(profile, impact, k, profile.landing.points)


def test_selections_are_named_by_key_kind_and_component():
    """A key alone means the first kind that has it; a vector counts by its length."""
    assert select("moment").quantity.of == "joint"
    assert select("contact.moment.z").quantity.of == "contact"
    assert select("contact.moment.z").scalar(np.array([1.0, 2.0, 3.0])) == 3.0
    assert select("delta_v").scalar(np.array([3.0, 0.0, 4.0])) == 5.0
    with pytest.raises(
        UnknownName, match=r'no quantity "shok".*nearest: "shock".*shockpc quantities'
    ):
        select("shok")


def test_a_key_is_unique_in_its_kind():
    for kind in ("robot", "body", "point", "joint", "contact"):
        keys = [entry.key for entry in quantities_of(kind)]
        assert len(keys) == len(set(keys)) > 0


def test_the_greatest_jump_over_a_box_is_that_of_a_corner(tmp_path):
    """|Δv + Δω × r| at the eight corners of a box that is struck beside its centre; budgets and
    tables take it by its name.
    """
    size, origin = np.array([0.6, 0.2, 0.4]), np.array([0.1, -0.05, 0.02])
    shape = (
        f'<collision><origin xyz="{" ".join(map(str, origin))}"/><geometry><box '
        f'size="{" ".join(map(str, size))}"/></geometry>'
    )
    (tmp_path / "box.urdf").write_text(urdf(link("box", more=f"{shape}</collision>")))
    contact, strike = (
        Contact(frame="box", offset=(0.3, 0.1, -0.2)),
        Strike(speed=1.5, strike_angle_deg=20.0),
    )
    scene = Scene(robot=str(tmp_path / "box.urdf"), contact=contact, strike=strike)
    profile = shock_profile(scene)
    corners = origin + size / 2 * np.array(list(itertools.product((-1, 1), repeat=3)))
    expected = np.linalg.norm(
        profile.delta_v[0] + np.cross(profile.delta_omega[0], corners), axis=1
    ).max()
    assert profile.value("delta_v_max", "body")[0] == pytest.approx(expected, rel=1e-14)
    assert_shock(scene, at="box", metric="delta_v_max", max=expected * (1 + 1e-12))
    rows = sweep(scene, {"speed": "1,2,3"}, quantities=["delta_v_max@box"]).table.values(
        "delta_v_max"
    )
    np.testing.assert_allclose(rows, expected * np.array([1.0, 2.0, 3.0]) / 1.5, rtol=1e-12)
    designs = [Design(name, scene, profile.robot) for name in "ab"]
    (compared,) = (
        one
        for one in compare(designs, ["delta_v_max"]).quantities
        if one.selection.name == "delta_v_max"
    )
    assert compared.rows[0].values == pytest.approx((expected, expected), rel=1e-14)


def reachable(value, seen):
    """Every array reachable from a result, at any depth."""
    if id(value) in seen:
        return
    seen[id(value)] = value
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, Mapping):
        yield from (array for part in value.values() for array in reachable(part, seen))
    elif isinstance(value, tuple | list):
        yield from (array for part in value for array in reachable(part, seen))
    elif (
        type(value).__module__.startswith("shockpc")
        and hasattr(value, "__dict__")
        and type(value).__name__ != "BallImpact"
    ):
        yield from reachable(vars(value), seen)


def test_no_array_of_a_result_can_be_written_to():
    """Neither those of a profile, nor those of its landing, its proof or its records."""
    profile = shock_profile(
        Scene(
            robot="anymal_b",
            contact=(Contact(frame="LF_FOOT"), Contact(frame="RF_FOOT", kind="flat")),
        )
    )
    names = [name for name in dir(type(profile)) if not name.startswith("_")]
    read = {name: getattr(profile, name) for name in names}
    with pytest.raises(ValueError, match="read-only"):
        profile.proof.jumps[...] = 0.0
    arrays = [array for array in reachable([profile, read], {}) if array.dtype != object]
    assert len(arrays) > 50
    assert not [array.shape for array in arrays if array.flags.writeable]


def test_a_landing_is_the_same_from_any_thread():
    """The precision of ball arithmetic is one setting of the process; four threads read quantities
    of unlike landings at once.
    """
    still = Joints(locked=("neck_*",))  # nothing resists the neck of iCub
    scenes = [
        Scene(robot="anymal_b", contact="LF_FOOT"),
        Scene(robot="icub", contact="l_sole", joints=still),
    ]
    keys = [(entry.key, entry.of) for entry in COMMON if entry.of in ("body", "joint")]

    def numbers(scene):
        profile = shock_profile(scene)
        return [profile.value(*key) for key in keys]

    alone = [numbers(scene) for scene in scenes]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(numbers, scenes * 4))
    for k, values in enumerate(together):
        for one, other in zip(values, alone[k % 2], strict=True):
            np.testing.assert_array_equal(one, other)


def test_a_name_that_is_not_known_is_answered_with_the_nearest():
    profile = shock_profile(Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),)))
    with pytest.raises(UnknownName, match='nearest: "LF_HIP"'):
        profile.shock_at("LF_HP", np.zeros(3))
    assert profile.shock_at("imu_link", np.zeros(3)) == pytest.approx(
        profile.points[0].shock, rel=1e-14
    )


def test_former_keys_mean_the_renamed_quantities(capfd):
    """In Python, in JSON, in a command with one note for each key, and in budgets."""
    profile = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT"))
    for record, former, current in (
        (profile.contacts[0], "mass_sticking", "effective_mass_sticking"),
        (profile.contacts[0], "pull", "tensile_impulse"),
        (profile, "off_plane", "out_of_plane_share"),
    ):
        with pytest.warns(RenamedQuantity, match=f'"{former}" is now "{current}"'):
            np.testing.assert_array_equal(getattr(record, former), getattr(record, current))
        with pytest.raises(AttributeError, match="no_such_key"):
            record.no_such_key  # noqa: B018
    tables = json.loads(
        good(capfd, "analyze", "anymal_b", "--contact", "LF_FOOT", "--format", "json")
    )["tables"]
    for table, former, current in (
        ("bodies", "pitch", "screw_pitch"),
        ("contacts", "mass_frictionless", "effective_mass_frictionless"),
        ("landing", "needs_tilt", "feasible_if_tilted"),
        ("landing", "depth", "depth_below_contacts"),
    ):
        assert all(row[former] == row[current] for row in tables[table])
    landings = "sweep", "anymal_b", "--contact", "LF_FOOT", "--vary", "strike-angle=0,5"
    swept = run(capfd, *landings, "--quantity", "pull", "--quantity", "contact.pull")
    assert "tensile_impulse" in swept.out
    assert swept.err.count('"pull" is now "tensile_impulse"') == 1
    with pytest.warns(RenamedQuantity, match="energy_gained"):
        assert Budget(metric="energy_made", max=1.0).metric == "energy_gained"


def test_the_rate_after_the_impact_is_that_before_and_its_jump():
    """Of a knee that moves before the impact; a motor has to follow what is left."""
    scene = Scene(
        robot="hyq",
        contact="lf_foot",
        strike=Strike(joint_velocities={"lf_kfe_joint": 2.0}),
        friction=0.6,
    )
    profile = shock_profile(scene)
    number = [place.name for place in profile.places("joint")].index("lf_kfe_joint")
    v = profile.robot.joint("lf_kfe_joint").v.start
    assert profile.landing.before.joint_rates[v] == 2.0
    assert profile.value("rate_after", "joint")[number] == pytest.approx(
        2.0 + profile.delta_qd[v], rel=1e-14
    )
    slid = profile.value("delta_qd_friction", "joint")[number]
    assert profile.value("rate_after_friction", "joint")[number] == pytest.approx(
        2.0 + slid, rel=1e-12
    )
