"""Contacts with a damper in series with each spring: closed forms, steps in time, and forces
without steps in flexible links.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from test_stiffness import normals, sticking, with_springs
from trees import known_robot

from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene import Contact, Joints, Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.profile import shock_profile
from shockpc.quantities.parts.peaks import ALONG
from shockpc.text.errors import SceneError
from shockpc.wings.compliant.motion.contacts import simulate_landing
from shockpc.wings.compliant.motion.laws import series_damping
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding


def relaxing(elements, rates):
    return elements._replace(relaxation=np.append(rates, np.zeros(len(elements.rows) - len(rates))))


@pytest.mark.parametrize("e", [1.0, 0.5, 0.1, 0.01, 0.0])
def test_one_mass_returns_with_the_restitution(e):
    """s̈ + 2ζω ṡ + ω² s = 0 of the force s, ṡ(0) = k v: s = k v exp(−ζωt) sin(ω_d t) / ω_d, and it
    separates at π / ω_d.
    """
    m, k, v = 2.0, 1e5, 1.5
    omega, ratio = np.sqrt(k / m), float(series_damping(np.array(e)))
    motion = simulate_landing(
        np.eye(1) * m, relaxing(normals([[1.0]], k, e), [2.0 * ratio * omega]), np.array([-v])
    )
    turning = omega * np.sqrt(1.0 - ratio**2)
    t = np.linspace(0.0, motion.duration, 20)
    shape = np.sin(turning * t) / turning if e else t
    np.testing.assert_allclose(
        motion.at(t).force[:, 0],
        k * v * np.exp(-ratio * omega * t) * shape,
        atol=1e-5 * v * np.sqrt(k * m),
    )
    end = motion.at([motion.duration])
    if e:
        assert motion.duration == pytest.approx(np.pi / turning, rel=1e-9)
        assert end.jump[0, 0] == pytest.approx((1.0 + e) * v, rel=1e-9)
    else:
        # It comes to rest without end: until two periods of the spring alone, (1 + 4π) exp(−4π) of
        # the speed are left.
        assert end.jump[0, 0] / v == pytest.approx(
            1.0 - (4.0 * np.pi - 1.0) * np.exp(-4.0 * np.pi), rel=1e-5
        )
        assert motion.peak(np.ones((1, 1, 1)))[0][0] == pytest.approx(
            v * np.sqrt(k * m) / np.e, rel=1e-6
        )


@pytest.mark.parametrize("seed", range(3))
def test_steps_in_time_agree(seed):
    """Three rows of contacts, more than there are coordinates, which relax at different rates,
    beside springs and under gravity.
    """
    rng = np.random.default_rng(seed)
    X, rows = rng.normal(size=(4, 7)), rng.normal(size=(5, 4))
    M, velocity = X @ X.T, np.linalg.lstsq(rows[:3], -np.ones(3), rcond=None)[0]
    rates = np.array([20.0, 60.0, 200.0, 0.0, 0.0])
    elements = relaxing(with_springs(normals(rows[:3], 1e4), rows[3:], 3e3), rates)
    gravity, inverse, k = (
        3.0 * np.linalg.solve(M, -rows[:3].sum(axis=0)),
        np.linalg.inv(M),
        elements.stiffness,
    )
    motion = simulate_landing(M, elements, velocity, gravity=gravity)
    end = float(motion.first("opens")[np.isfinite(motion.first("opens"))].min())

    def rate(_, y):
        return np.concatenate(
            [y[4:8], inverse @ rows.T @ y[8:] + gravity, -k * (rows @ y[4:8]) - rates * y[8:]]
        )

    t = np.linspace(0.0, end, 50)
    exact = solve_ivp(
        rate,
        (0.0, end),
        np.concatenate([np.zeros(4), velocity, np.zeros(5)]),
        t_eval=t,
        rtol=1e-10,
        atol=1e-10,
    ).y.T
    found = motion.at(t)
    np.testing.assert_allclose(found.force, exact[:, 8:], atol=1e-6 * np.abs(exact[:, 8:]).max())
    np.testing.assert_allclose(
        velocity + found.jump, exact[:, 4:8], atol=1e-7 * np.abs(exact[:, 4:8]).max()
    )
    np.testing.assert_allclose(
        found.displacement, exact[:, :4], atol=1e-7 * np.abs(exact[:, :4]).max()
    )


def test_creep_under_a_constant_force():
    """A mass that rests on a damper in series sinks at m g / c, with c = k / rate."""
    m, k, rate, g = 2.0, 1e4, 300.0, 9.81
    motion = simulate_landing(
        np.eye(1) * m,
        relaxing(normals([[1.0]], k), [rate]),
        -0.1 * np.ones(1),
        3.0,
        -g * np.ones(1),
    )
    late = motion.at([2.8, 3.0])
    np.testing.assert_allclose(late.force[:, 0], m * g, rtol=1e-9)
    assert np.diff(late.displacement[:, 0])[0] == pytest.approx(-0.2 * m * g * rate / k, rel=1e-9)


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_a_stiff_link_is_a_rigid_one(e):
    """Two masses joined by a spring that is ever stiffer: the force in it becomes that in a rigid
    body.
    """
    m, k, n = 1.0, 1e5, 2
    omega, ratio = np.sqrt(k / m), float(series_damping(np.array(e)))
    contact = normals(np.eye(1, n), k, e)
    link = np.array([[1.0, -1.0]])

    rigid = (
        np.exp(-ratio * np.arccos(ratio) / np.sqrt(1.0 - ratio**2)) if ratio < 1.0 else np.exp(-1.0)
    )
    for stiffness, off in ((1e9, 0.03), (1e11, 0.003)):
        elements = relaxing(with_springs(contact, link, stiffness), [2.0 * ratio * omega])
        motion = simulate_landing(np.eye(n) * m / n, elements, -np.ones(n))
        assert motion.peak(np.array([[[0.0, 1.0]]]))[0][0] / np.sqrt(k * m) == pytest.approx(
            rigid / 2.0, rel=off
        )


def test_tangents_relax_too():
    """A point mass that strikes at an angle on critical dampers: both components of the velocity
    decay alike.
    """
    m, k = 2.0, 1e4
    elements = sticking(np.eye(3), k)
    motion = simulate_landing(
        m * np.eye(3),
        relaxing(elements, np.full(3, 2.0 * np.sqrt(k / m))),
        np.array([0.3, 0.0, -1.0]),
    )
    end = np.array([0.3, 0.0, -1.0]) + motion.at([motion.duration]).jump[0]
    assert np.abs(end).max() < 1e-4


def test_of_a_robot():
    """Go2's foot: the impulse is (1 + e) times the one without restitution within 12 %, as of two
    coupled directions.
    """

    def landing(**given):
        contact = Contact(frame="FL_foot", restitution=given.pop("e", 0.0))
        return shock_profile(
            Scene(robot="go2", contact=(contact,), gravity=False, contact_stiffness=1e5, **given),
            known_robot("go2"),
        )

    def impulse(profile):
        motion = profile.stiffness.motion
        return sum(segment.impulse(segment.length)[2] for segment in motion.segments)

    once = impulse(landing())
    for e in (0.0, 0.5, 0.8):
        found = landing(contact_law="damper", e=e)
        assert impulse(found) / once == pytest.approx(1.0 + e, rel=0.12)
        assert found.stiffness.restitution == pytest.approx(e)
    with pytest.raises(SceneError, match="contact law"):
        landing(contact_law="damper", contact_damping=1.0)
    given = landing(contact_law="hysteresis", e=0.5), landing(e=0.5)
    assert impulse(given[0]) == impulse(given[1])


def test_the_torque_of_a_thigh_with_stiff_links():
    """Go2's thigh on 1e5 N/m: as of rigid links with the damper; by hysteresis of e = 0 it rings,
    and is nearly twice as large.
    """
    rigid = Scene(
        robot="go2",
        contact=Contact(frame="FL_foot"),
        joints=Joints(drives="go2"),
        contact_stiffness=1e5,
        contact_law="damper",
        gravity=False,
    )
    tubes = dict.fromkeys(("FL_calf", "FL_thigh"), "EI:6.74e5,EA:1e10")
    found = {}
    for law in ("damper", "hysteresis"):
        peaks = []
        for flex in ({}, tubes):
            landing = CompliantLanding(
                resolve(replace(rigid, contact_law=law, flex=flex), known_robot("go2"))
            )
            places = landing.landing.places("joint")
            (thigh,) = (k for k, place in enumerate(places) if place.name == "FL_thigh_joint")
            peaks.append(landing.peaks(ALONG.compute, places)[0][thigh])
        found[law] = peaks[1] / peaks[0]
    assert found["damper"] == pytest.approx(1.0, abs=0.15)
    assert found["hysteresis"] > 1.5


@pytest.mark.slow
@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("stiffness", [1e4, 1e7])
def test_four_feet_and_eight_links(stiffness, e):
    """Go2 on 96 springs of links that bend and stretch: followed to the end, and all peaks of
    joints are found.
    """
    scene = Scene(
        robot="go2",
        contact=tuple(
            Contact(frame=f"{side}_foot", restitution=e) for side in ("FL", "FR", "RL", "RR")
        ),
        joints=Joints(drives="go2"),
        contact_stiffness=stiffness,
        contact_law="damper",
        flex=dict.fromkeys(("*_calf", "*_thigh"), "tube:70e9,0.025,0.021,hinges:4"),
    )
    landing = CompliantLanding(resolve(scene, known_robot("go2")))
    assert len(landing.number) == 12 + 96
    assert len(landing.motion.events) < 50
    assert np.all(landing.peaks(ALONG.compute, landing.landing.places("joint"))[0] > 0.0)


def test_the_end_under_gravity():
    """Without restitution a mass sinks at m g / c in the end, and the motion ends when 1 % of its
    speed is left beyond that.
    """
    m, k, v, g = 2.0, 1e5, 1.5, 9.81
    omega = np.sqrt(k / m)
    contact = relaxing(normals([[1.0]], k), [2.0 * omega])
    motion = simulate_landing(np.eye(1) * m, contact, np.array([-v]), gravity=np.array([-g]))
    speed = -v + motion.at([motion.duration]).jump[0, 0]
    assert not motion.separated
    assert speed == pytest.approx(-m * g * 2.0 * omega / k, abs=0.011 * v)
    assert motion.duration < 4.0 * np.pi / omega / 1.5


@pytest.mark.parametrize("v", [0.05, 0.25, 0.38])
def test_a_strike_slower_than_the_weight_sinks(v):
    """Below 2g/ω the weight decides: the force is m g + (A + B t) exp(−ωt) with A = −m g, B = k (v
    − g/ω).
    """
    m, k, g = 4.0, 1e4, 9.81
    omega = np.sqrt(k / m)
    motion = simulate_landing(
        np.eye(1) * m,
        relaxing(normals([[1.0]], k), [2.0 * omega]),
        np.array([-v]),
        gravity=np.array([-g]),
    )
    t = np.linspace(0.0, motion.duration, 2000)
    force = m * g + (k * (v - g / omega) * t - m * g) * np.exp(-omega * t)
    np.testing.assert_allclose(motion.at(t).force[:, 0], force, atol=1e-7 * m * g)
    assert force[-1] == pytest.approx(m * g, rel=1e-3)
    assert motion.peak(np.ones((1, 1, 1)))[0][0] == pytest.approx(force.max(), rel=1e-5)


def test_robots_whose_weight_decides():
    """Go2 with locked joints at 1 m/s, whose softer contacts it sinks into, and G1 at 0.5 m/s,
    which is warned about.
    """
    contact = Contact(frame="FL_foot", restitution=0.5, restitution_along="directions")
    scene = Scene(
        robot="go2",
        contact=contact,
        joints=Joints(model="locked"),
        contact_stiffness=1e5,
        contact_law="damper",
    )
    found = shock_profile(scene, known_robot("go2"))
    assert found.value("peak_force", "contact")[0] == pytest.approx(776.45, rel=1e-4)
    assert not [warning for warning in found.health.warnings if "weight presses" in str(warning)]
    contact = Contact(frame="left_ankle_roll_link")
    slow = Scene(
        robot="g1",
        contact=contact,
        contact_stiffness=1e4,
        contact_law="damper",
        strike=Strike(speed=0.5),
    )
    warnings = shock_profile(slow, known_robot("g1")).health.warnings
    assert [warning for warning in warnings if "weight presses" in str(warning)]
