"""End stops: which act, with what impulse, what they change, and what they leave as it is."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from commands import document, good, says
from random_landings import random_landing
from robot_texts import BOX, COLUMN, floating, joint, mjcf, urdf
from scipy.integrate import solve_ivp

from shockpc import (
    Contact,
    Joints,
    Posture,
    Scene,
    Strike,
    resolve,
    sensitivity,
    shock_maps,
    shock_profile,
    sweep,
)
from shockpc.impact.stops import stop_rows, with_stops
from shockpc.text.errors import SceneError, ShockError, SolveError

DOWN = Contact(frame="foot", directions=("z",))
"""A foot that stops along the vertical alone."""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with two masses of 0.5 and 3 kg on a slide, of which the upper one cannot come
    nearer.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "column.urdf").write_text(
        COLUMN.replace('<limit effort="50"/>', '<limit lower="0" upper="0.4" effort="50"/>')
    )
    (tmp_path / "box.urdf").write_text(BOX)
    return tmp_path


def column(**changes):
    return Scene(
        **(
            {"robot": "column.urdf", "contact": DOWN, "stops": True, "strike": Strike(speed=2.0)}
            | changes
        )
    )


# Closed forms


def test_a_mass_on_its_stop(here):
    """The stop carries m v of the upper mass, the contact that of both, and the slide's drive
    nothing; nothing moves against it.
    """
    profile = shock_profile(column())
    assert [stop.frame for stop in profile.landing.acting] == ["slide"]
    assert profile.value("stop_impulse", "joint") == pytest.approx([6.0], rel=1e-15)
    assert profile.value("stop_acts", "joint").tolist() == [1.0]
    assert profile.contacts[0].impulse[2] == pytest.approx(7.0, rel=1e-15)
    assert abs(profile.delta_qd[6]) < 1e-15
    assert profile.value("along", "joint") == pytest.approx([0.0], abs=1e-15)
    assert profile.energy_lost == pytest.approx(7.0, rel=1e-15)
    free = shock_profile(column(stops=None))
    assert (free.energy_lost, free.contacts[0].impulse[2]) == (
        pytest.approx(1.0),
        pytest.approx(1.0),
    )


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_restitution_of_a_stop(here, e):
    """The upper mass comes at 2 + 3 m/s and leaves the foot, which rests, at e times the 3 m/s with
    which it ran to the stop.
    """
    profile = shock_profile(
        column(stop_restitution=e, strike=Strike(speed=2.0, joint_velocities={"slide": -3.0}))
    )
    after = profile.landing.before.joint_rates[6] + profile.delta_qd[6]
    assert after == pytest.approx(3.0 * e, abs=1e-14)
    assert profile.value("stop_impulse", "joint")[0] == pytest.approx(
        3.0 * (5.0 + 3.0 * e), rel=1e-14
    )
    assert profile.energy_lost == pytest.approx(
        0.25 * 2.0**2 + 1.5 * (25.0 - (3.0 * e) ** 2), rel=1e-13
    )


def test_a_stop_at_the_greatest_value_pushes_down(here):
    """A foot thrown against the body above: the slide opens at 3 m/s at its largest value, and the
    stop pulls both together.
    """
    strike = Strike(speed=2.0, joint_velocities={"slide": 5.0})
    profile = shock_profile(column(posture=Posture(joints={"slide": 0.4}), strike=strike))
    # The body rises at 5 − 2 = 3 m/s; the contact holds the foot, so the stop takes 3 kg · 3 m/s
    # downwards.
    assert profile.value("stop_impulse", "joint") == pytest.approx([-9.0], rel=1e-14)
    assert profile.landing.before.joint_rates[6] + profile.delta_qd[6] == pytest.approx(
        0.0, abs=1e-14
    )


def test_loads_of_joints_leave_the_stop_out(here):
    """With reflected inertia in the drive the gear carries none of what the stop does, for its
    rotor does not turn.
    """
    profile = shock_profile(column(joints=Joints(armature={"slide": 1.0})))
    assert profile.value("along", "joint") == pytest.approx([0.0], abs=1e-14)
    assert profile.value("stop_impulse", "joint") == pytest.approx([6.0], rel=1e-14)
    assert profile.loads[0].force[2] == pytest.approx(0.0, abs=1e-14)


# Any robot


def at_limits(number):
    """A random landing with most of its single joints at a limit: robot, scene, and how many are."""
    robot, scene = random_landing(number)
    rng = np.random.default_rng([7, number])
    landing = resolve(replace(scene, base=scene.base), robot)
    limits, count = {}, 0
    for one in robot.single_joints:
        value = one.value(landing.q) if one.kind in ("revolute", "prismatic") else math.nan
        if rng.random() < 0.8 and count < 6 and math.isfinite(value):
            limits[one.name], count = (
                [(value, math.inf), (-math.inf, value)][int(rng.integers(2))],
                count + 1,
            )
    joints = tuple(
        one._replace(limits=limits.get(one.name, (-math.inf, math.inf))) for one in robot.joints
    )
    vars(robot)["joints"] = joints
    for name in ("single_joints", "independent_joints"):
        vars(robot).pop(name, None)
    return robot, replace(scene, stops=True)


def complementary(landing):
    """The jump of the joint velocities by trying every set of stops that push, and their impulses;
    None where none fits.
    """
    equation = landing.equation(landing.state)
    blocks, rows, before = stop_rows(landing)
    G = np.eye(rows.shape[1]) if equation.G is None else equation.G[0]
    H, J, b = equation.H[0], equation.J_c[0], equation.b[0, :, 3]
    S, n = rows @ G, len(equation.H[0])
    target = -np.array([block.restitution for block in blocks]) * before
    for size in range(len(blocks) + 1):
        for chosen in itertools.combinations(range(len(blocks)), size):
            trial = list(chosen)
            K = np.vstack([J, S[trial]])
            right = np.concatenate([np.zeros(n), -b, target[trial] - before[trial]])
            # Symmetric, with the mass metric as unit, so that dependent rows are found.
            L = np.linalg.inv(np.linalg.cholesky(H))
            M = K @ L.T
            impulse = np.linalg.lstsq(M @ M.T, right[n:], rcond=1e-11)[0]
            moved = L.T @ M.T @ impulse
            held = np.abs(K @ moved - right[n:]).max(initial=0.0) < 1e-8
            pushes, w = impulse[len(J) :], S @ moved + before - target
            if held and np.all(pushes > -1e-9) and np.all(w > -1e-8):
                return G @ moved, dict(zip(trial, pushes, strict=True))
    return None


@pytest.mark.slow
@pytest.mark.parametrize("number", range(40))
def test_stops_are_complementary(number):
    """They push or are left, against all sets of stops by trying; the energy lost is that of the
    motion, and none is gained.
    """
    robot, scene = at_limits(number)
    scene = replace(
        scene, contact=tuple(replace(contact, restitution=0.0) for contact in scene.contact)
    )
    try:
        bare = shock_profile(replace(scene, stops=None), robot)
    except ShockError:
        return
    expected = complementary(bare.landing)
    if expected is None:
        with pytest.raises(SolveError):
            shock_profile(scene, robot)
        return
    moved, pushes = expected
    profile = shock_profile(scene, robot)
    size = np.abs(moved).max()
    np.testing.assert_allclose(profile.delta_qd, moved, atol=1e-7 * size)
    blocks, rows, before = stop_rows(profile.landing)
    names = [place.name for place in profile.places("joint")]
    impulse = dict(zip(names, profile.value("stop_impulse", "joint"), strict=True))
    after = before + rows @ profile.delta_qd
    for k, (block, row) in enumerate(zip(blocks, rows, strict=True)):
        push = impulse[block.frame] * row.sum()
        if math.isfinite(push):
            assert push >= 0.0
            assert push == pytest.approx(
                pushes.get(k, 0.0), abs=1e-6 * (1.0 + max(pushes.values(), default=0.0))
            )
        assert after[k] >= -1e-9 * size
        assert math.isnan(push) or abs(push * after[k]) <= 1e-9 * size * (1.0 + push)
    if not math.isnan(profile.energy_lost) and not scene.strike.joint_velocities:
        assert profile.energy_lost >= bare.energy_lost * (1.0 - 1e-9) >= 0.0


def test_a_stop_that_is_not_reached_changes_nothing(here):
    """To the last bit: a joint off its limit, and one that the impact moves away from it."""
    lifted = column(posture=Posture(joints={"slide": 0.2}))
    leaving = column(posture=Posture(joints={"slide": 0.4}))
    for scene in (lifted, leaving):
        with_them, without = shock_profile(scene), shock_profile(replace(scene, stops=None))
        assert not with_them.landing.acting
        assert with_them.delta_qd.tobytes() == without.delta_qd.tobytes()
        assert with_them.delta_v.tobytes() == without.delta_v.tobytes()
        assert with_them.value("stop_impulse", "joint").tolist() == [0.0]
        assert np.isnan(without.value("stop_impulse", "joint")).all()


def test_contacts_that_leave_a_stop_no_way_have_no_verdict(here):
    """Two contacts that pull a slide apart beyond its limit: no impulse of the stop can help."""
    apart = (
        replace(DOWN, velocity=(0.0, 0.0, -1.0)),
        Contact(frame="body", directions=("z",), velocity=(0.0, 0.0, -3.0)),
    )
    scene = column(contact=apart)
    # The body is stopped from 3 m/s and the foot from 1 m/s, so the slide opens: at its smallest
    # value this is no matter …
    assert not shock_profile(scene).landing.acting
    closing = column(contact=apart[::-1], strike=Strike(speed=2.0))
    scene = replace(
        closing,
        contact=tuple(
            replace(c, velocity=(0.0, 0.0, -1.0 - 2.0 * (c.frame == "foot"))) for c in apart
        ),
    )
    with pytest.raises(SolveError, match="drive joints beyond their stops"):
        shock_profile(scene)


def test_a_search_for_stops_that_does_not_end_is_refused(here, monkeypatch):
    """SciPy raises RuntimeError at its limit of iterations."""

    def endless(*_):
        raise RuntimeError("Maximum number of iterations reached.")

    monkeypatch.setattr("scipy.optimize.nnls", endless)
    with pytest.raises(SolveError, match="search for the end stops that push does not end"):
        shock_profile(column())


# A joint that runs into its stop


PENDULUM = urdf(
    '<link name="world"/>',
    '<link name="rod"><inertial><origin xyz="0 0 -0.3"/><mass value="2"/>'
    '<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.01"/></inertial></link>',
    joint(
        "hinge",
        "world",
        "rod",
        axis="0 1 0",
        more='<limit lower="-0.5" upper="1" effort="1" velocity="9"/>',
    ),
)


@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
@pytest.mark.parametrize(
    ("value", "rate", "side"), [(-0.5, -3.0, 1.0), (1.0, 2.0, -1.0)], ids=["least", "greatest"]
)
def test_a_pendulum_on_its_stop(here, e, value, rate, side):
    """(1 + e) I ω at the stop, with I = I_c + m l² about the hinge, which carries (1 + e) m l ω; ½
    I ω² (1 − e²) is lost.
    """
    (here / "pendulum.urdf").write_text(PENDULUM)
    inertia = 0.05 + 2.0 * 0.3**2
    contact = Contact(frame="stop:hinge", restitution=e)
    strike = Strike(joint_velocities={"hinge": rate})
    scene = Scene(
        robot="pendulum.urdf",
        base="fixed",
        contact=contact,
        strike=strike,
        posture=Posture(joints={"hinge": value}),
    )
    profile = shock_profile(scene)
    assert profile.delta_qd[-1:] == pytest.approx([-(1.0 + e) * rate], rel=1e-15)
    assert profile.value("stop_impulse", "joint") == pytest.approx(
        [-(1.0 + e) * inertia * rate], rel=1e-14
    )
    assert np.linalg.norm(profile.loads[0].force) == pytest.approx(
        (1.0 + e) * 2.0 * 0.3 * abs(rate), rel=1e-14
    )
    assert profile.loads[0].along == pytest.approx(0.0, abs=1e-14)
    assert profile.energy_lost == pytest.approx(0.5 * inertia * rate**2 * (1.0 - e**2), abs=1e-14)
    (struck,) = profile.contacts
    assert struck.effective_mass == pytest.approx(inertia, rel=1e-14)
    assert struck.moment == pytest.approx([0.0, -(1.0 + e) * inertia * rate, 0.0], abs=1e-13)
    assert np.linalg.norm(struck.approach) == pytest.approx(0.3 * abs(rate), rel=1e-14)
    assert profile.shock_com[-1] == pytest.approx(1.0 + e, rel=1e-14)


@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_a_pendulum_on_a_stop_of_finite_stiffness(here, e):
    """One coordinate: the peak torque is ω √(k I) for every restitution; without loss the stop acts
    for half a period.
    """
    (here / "pendulum.urdf").write_text(PENDULUM)
    inertia, k = 0.05 + 2.0 * 0.3**2, 4e3
    scene = Scene(
        robot="pendulum.urdf",
        base="fixed",
        contact=Contact(frame="stop:hinge", restitution=e),
        gravity=False,
        strike=Strike(joint_velocities={"hinge": -3.0}),
        posture=Posture(joints={"hinge": -0.5}),
        contact_stiffness=1.0,
        stop_stiffness=k,
    )
    profile = shock_profile(scene)
    assert profile.value("peak_stop", "joint") == pytest.approx(
        [3.0 * math.sqrt(k * inertia)], rel=1e-12
    )
    half = math.pi / 2.0 * math.sqrt(inertia / k)
    assert profile.stiffness.motion.duration == pytest.approx((1.0 + e) * half, rel=1e-9)
    assert profile.value("delta_qd_separated", "joint") == pytest.approx(
        [(1.0 + e) * 3.0], rel=1e-9
    )
    assert np.isnan(profile.value("peak_force", "contact")).all()


def test_a_slide_that_runs_into_its_stop(here):
    """Two masses in free fall that meet at 3 m/s: p = 3 m₁ m₂ / (m₁ + m₂); no ground takes part in
    it.
    """
    contact = Contact(frame="stop:slide")
    profile = shock_profile(
        column(contact=contact, stops=None, strike=Strike(joint_velocities={"slide": -3.0}))
    )
    together = 0.5 * 3.0 / 3.5
    assert profile.value("stop_impulse", "joint") == pytest.approx([3.0 * together], rel=1e-14)
    np.testing.assert_allclose(profile.contacts[0].impulse, [0.0, 0.0, 3.0 * together], atol=1e-14)
    assert profile.total_impulse == pytest.approx([0.0, 0.0, 0.0], abs=1e-15)
    assert profile.energy_lost == pytest.approx(0.5 * together * 9.0, rel=1e-14)
    np.testing.assert_allclose(
        profile.delta_v[:, 2], [-3.0 * together / 0.5, 3.0 * together / 3.0], rtol=1e-14
    )


def test_a_stop_and_the_ground_at_once(here):
    """A joint that runs into its stop when the foot lands: both are contacts, with a restitution of
    their own.
    """
    contacts = (DOWN, Contact(frame="stop:slide", restitution=0.5))
    strike = Strike(speed=2.0, joint_velocities={"slide": -3.0})
    both = shock_profile(column(contact=contacts, stops=None, strike=strike))
    stops = shock_profile(column(stop_restitution=0.5, strike=strike))
    np.testing.assert_allclose(both.delta_qd, stops.delta_qd, atol=1e-15)
    np.testing.assert_allclose(
        both.value("stop_impulse", "joint"), stops.value("stop_impulse", "joint"), rtol=1e-15
    )


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"strike": Strike()}, "does not move, so it does not reach its end stop"),
        (
            {"posture": Posture(joints={"slide": 0.2})},
            "is at 0.2 m and moves down, but its stop is at 0 m",
        ),
        (
            {"contact": Contact(frame="stop:slide", kind="flat")},
            "takes only a restitution",
        ),
        ({"contact": Contact(frame="stop:slid")}, 'no joint "slid"'),
        ({"contact": Contact(frame="stop:sl*")}, r'no joint "sl\*"'),
        ({"friction": 0.5}, "is an end stop, and friction is for"),
        ({"contact_stiffness": 1e5}, "give the stops a stop_stiffness too"),
    ],
)
def test_stops_that_cannot_be_struck(here, changes, fault):
    """A joint that rests, is elsewhere or unknown; and what the ground alone has."""
    given = {
        "contact": Contact(frame="stop:slide"),
        "stops": None,
        "strike": Strike(joint_velocities={"slide": -3.0}),
    }
    with pytest.raises(ShockError, match=fault):
        shock_profile(column(**(given | changes)))


def test_stops_that_strike_on_the_command_line(capfd, here):
    """Names and globs, the report, and rows of a sweep in which the joint is not at its stop."""
    words = ("column.urdf", "--contact", "stop:sl*", "--joint-velocity", "slide=-3")
    text = good(capfd, "analyze", *words)
    assert "contact      stop:slide, the end stop at the minimum value" in text
    assert says(text, "slide", "minimum", "1.286 N s")
    assert says(text, "stop:slide", "1.286 N s", "0.4286 kg")
    scene = column(
        contact=Contact(frame="stop:slide"),
        stops=None,
        strike=Strike(joint_velocities={"slide": -3.0}),
    )
    table = sweep(scene, {"slide": "0,0.1"}, quantities=("stop_impulse@slide",)).table
    assert table.columns["stop_impulse@slide"][0] == pytest.approx(9.0 / 7.0, rel=1e-12)
    assert np.isnan(table.columns["stop_impulse@slide"][1])
    assert "stop" in table.messages[1]


# With friction


def test_a_stop_and_a_contact_that_slides(here):
    """Where all contacts stick it is the proven result; where one slides, the stop and the contact
    obey their laws together.
    """
    oblique = Strike(velocity=(1.5, 0.0, -2.0))
    contact = Contact(frame="foot")
    sticking = shock_profile(column(contact=contact, strike=oblique, friction=5.0))
    assert sticking.friction.impact is None
    sliding = shock_profile(column(contact=contact, strike=oblique, friction=0.1))
    assert sliding.friction.state == ("slides",)
    assert sliding.value("stop_impulse_friction", "joint") == pytest.approx([6.0], rel=1e-12)
    np.testing.assert_allclose(
        sliding.value("impulse_friction", "contact")[0], [-0.7, 0.0, 7.0], atol=1e-12
    )
    assert sliding.friction.energy_lost > 0.0
    assert sliding.value("along_friction", "joint") == pytest.approx([0.0], abs=1e-12)


@pytest.mark.parametrize("number", range(12))
def test_friction_and_stops_of_any_robot(number):
    """No joint moves beyond its limit, the laws of friction hold, and no energy is gained."""
    robot, scene = at_limits(number)
    contacts = tuple(
        Contact(frame=contact.frame, offset=contact.offset) for contact in scene.contact[:2]
    )
    try:
        friction = shock_profile(replace(scene, contact=contacts, stance=(), friction=0.3), robot)
    except ShockError:
        return
    found = friction.friction
    assert found.residual < 1e-9
    assert found.energy_lost > 0.0
    moved = (found.impact or friction.proof).delta_qd
    _, rows, before = stop_rows(friction.landing)
    after = before + rows @ (moved[0, :, 3] if moved.ndim == 3 else moved[:, 3])
    assert np.all(after > -1e-7 * np.abs(friction.delta_qd).max())


# With finite stiffness


def integrated(k, stop, rate):
    """Peak forces of contact and stop, and the final velocities: two masses on springs that only
    push, by Runge–Kutta steps.
    """

    def forces(x):
        return k * max(-x[0], 0.0), stop * max(x[0] - x[1], 0.0)

    def derivative(_, y):
        ground, between = forces(y[:2])
        return [y[2], y[3], (ground - between) / 0.5, between / 3.0]

    found = solve_ivp(
        derivative,
        (0.0, 0.06),
        [0.0, 0.0, -2.0, -2.0 + rate],
        "DOP853",
        max_step=2e-5,
        rtol=1e-10,
        atol=1e-12,
    )
    peaks = np.array([forces(x) for x in found.y[:2].T]).max(axis=0)
    return peaks, found.y[2:, -1]


@pytest.mark.parametrize("rate", [0.0, -1.5])
@pytest.mark.parametrize("stop", [3e4, 4e5])
def test_a_stop_of_finite_stiffness(here, rate, stop):
    """Two masses that land: the stop is a spring that only pushes, closes when it is driven, and
    gives all back with e = 1.
    """
    contact, strike = (
        replace(DOWN, restitution=1.0),
        Strike(speed=2.0, joint_velocities={"slide": rate} if rate else {}),
    )
    scene = column(
        contact=contact,
        strike=strike,
        contact_stiffness=1e5,
        stop_stiffness=stop,
        stop_restitution=1.0,
        gravity=False,
    )
    profile = shock_profile(scene)
    peaks, _ = integrated(1e5, stop, rate)
    assert profile.value("peak_stop", "joint")[0] == pytest.approx(peaks[1], rel=1e-4)
    assert profile.value("peak_force", "contact")[0] == pytest.approx(peaks[0], rel=1e-4)
    assert profile.value("peak_torque", "joint")[0] == pytest.approx(0.0, abs=1e-6)
    if rate:
        both = (contact, Contact(frame="stop:slide", restitution=1.0))
        struck = shock_profile(replace(scene, contact=both, stops=None, stop_restitution=None))
        for key, kind in (
            ("peak_stop", "joint"),
            ("delta_qd_separated", "joint"),
            ("shock_separated", "point"),
        ):
            np.testing.assert_allclose(
                struck.value(key, kind), profile.value(key, kind), rtol=1e-10, err_msg=key
            )
        assert struck.value("peak_force", "contact") == pytest.approx(peaks, rel=1e-4)


def test_a_stiff_stop_is_a_rigid_one(here):
    """Much stiffer than the contact, without restitution, it makes one body of 3.5 kg of both."""
    profile = shock_profile(column(contact_stiffness=1e4, stop_stiffness=1e9, gravity=False))
    assert profile.value("peak_force", "contact")[0] == pytest.approx(
        2.0 * math.sqrt(3.5e4), rel=1e-3
    )
    assert profile.value("peak_stop", "joint")[0] == pytest.approx(
        3.0 / 3.5 * 2.0 * math.sqrt(3.5e4), rel=1e-2
    )
    np.testing.assert_allclose(
        profile.value("shock_separated", "point"), profile.value("shock", "point"), rtol=1e-6
    )


def test_a_stop_of_finite_stiffness_that_is_not_reached(here):
    """It takes no force, and changes nothing."""
    posture = Posture(joints={"slide": 0.2})
    scene = column(posture=posture, contact_stiffness=1e5, stop_stiffness=1e5)
    with_stops, without = (
        shock_profile(scene),
        shock_profile(replace(scene, stops=None, stop_stiffness=None)),
    )
    assert with_stops.value("peak_stop", "joint").tolist() == [0.0]
    assert (
        with_stops.value("peak_force", "contact").tobytes()
        == without.value("peak_force", "contact").tobytes()
    )


# Where they are given, and where they go


def test_a_joint_that_is_driven_beyond_its_limit_is_a_warning(capfd, here):
    """With the option that counts its stop; and no such warning with it, but what the stop does."""
    words = ("column.urdf", "--contact", "foot", "--slide", "--speed", "2")
    found = document(capfd, *words)
    (warned,) = [one for one in found["health"]["warnings"] if one["kind"] == "limits"]
    assert says(warned["text"], "slide", "2 m/s", "--stops")
    assert found["tables"]["joints"][0]["stop_acts"] is False
    assert "stop_impulse" not in found["tables"]["joints"][0]
    text = good(capfd, "analyze", *words, "--stops", "--save-scene", "s.toml")
    assert "the end stop of slide at its minimum value acts with 6 N s" in text
    assert "beyond" not in text
    assert "stops = true" in (here / "s.toml").read_text()
    found = document(capfd, "s.toml")
    (joint,) = found["tables"]["joints"]
    assert (joint["stop_impulse"], joint["stop_acts"]) == (pytest.approx(6.0), True)
    assert "no end stop acts" in good(capfd, "analyze", "s.toml", "--set", "slide=0.2")


def test_a_joint_that_can_have_no_stop_is_a_warning(here):
    """Two slides of one body of an MJCF: the lower one is at its limit, and its stop is left out in
    any case.
    """
    slides = (
        '<joint name="low" type="slide" axis="0 0 1" range="0 1" limited="true"/><joint '
        'name="side" type="slide" axis="1 0 0"/>'
    )
    upper = (
        f'<body name="upper" pos="0 0 .3">{slides}<inertial pos="0 0 0" mass="3" diaginertia=".1 '
        f'.1 .1"/></body>'
    )
    (here / "two.xml").write_text(mjcf(floating(upper)))
    scene = Scene(robot="two.xml", contact=Contact(frame="base", directions=("z",)), stops=True)
    profile = shock_profile(scene)
    assert not profile.landing.acting
    (warned,) = [one.text for one in profile.health.warnings if one.kind == "limits"]
    assert says(warned, "low ", "1 m/s", "shares its body")


def test_rows_of_studies_are_those_of_analyses(here):
    """A sweep over speed and posture: rows in which a stop acts are proven one by one, and the
    others are as without stops.
    """
    wanted = ("stop_impulse@slide", "stop_acts@slide", "shock_com@body")
    table = sweep(column(), {"slide": "0,0.1", "speed": "1,2"}, quantities=wanted, prove=0).table
    assert table.columns["proven"].tolist() == [True, True, False, False]
    np.testing.assert_allclose(
        table.columns["stop_impulse@slide"], [3.0, 6.0, 0.0, 0.0], rtol=1e-14
    )
    np.testing.assert_allclose(table.columns["shock_com@body"], [1.0, 1.0, 0.0, 0.0], atol=1e-14)
    effects = sensitivity(column(), "stop_impulse@slide", vary={"mass:body": "0.9x:1.1x"}).effects
    assert effects[0].derivatives[0] == pytest.approx(6.0, rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"stops": None, "stop_restitution": 0.5}, "give stops = true"),
        ({"contact_stiffness": 1e5}, "give the stops a stop_stiffness too"),
        ({"stop_stiffness": 1e5}, "needs stops = true .* and the stiffness of the contacts"),
        ({"stop_restitution": 1.5}, "stop_restitution must be ≥ 0 and ≤ 1, got 1.5"),
        ({"stops": "yes"}, 'stops has to be true or false, not "yes"'),
    ],
)
def test_refusals(here, changes, fault):
    """What has no meaning without stops, and what is no value."""
    with pytest.raises(SceneError, match=fault):
        resolve(column(**changes), shock_profile(column()).robot)


def test_maps_of_landings_with_stops_do_not_exist(here):
    """They are not linear in the strike."""
    landing = with_stops(resolve(column(), shock_profile(column()).robot))
    with pytest.raises(SceneError, match="not linear in the contact velocity"):
        shock_maps(landing, landing.q[None])
