"""Landings on finite stiffness: closed forms, laws of mechanics, other integrators, and the impulse
as the limit.
"""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from compliant import follow
from scipy.integrate import solve_ivp

from shockpc.core.impulse import TOLERANCE, solve_impact
from shockpc.wings.compliant.motion import crossing, stiff_motion
from shockpc.wings.compliant.motion import state as stiff_state
from shockpc.wings.compliant.motion.contacts import simulate_landing
from shockpc.wings.compliant.motion.elements import Elements, attach_rotors
from shockpc.wings.compliant.motion.laws import damper_restitution

SEEDS = range(3)


def normals(rows, stiffness=1e4, restitution=1.0):
    """Frictionless contacts."""
    rows = np.atleast_2d(np.asarray(rows, dtype=float))
    full = np.broadcast_to(stiffness, len(rows)), np.broadcast_to(restitution, len(rows))
    return Elements.alike(rows, *full, np.arange(len(rows)), np.ones(len(rows), dtype=bool))


def sticking(rows, stiffness=1e4, tangential=0.0, normal=0.0):
    """Contacts of three rows each, the normal last."""
    m = len(rows) // 3
    restitution = np.tile([tangential, tangential, normal], m)
    return Elements.alike(
        rows,
        np.full(3 * m, stiffness),
        restitution,
        np.repeat(np.arange(m), 3),
        np.tile([False, False, True], m),
    )


def with_springs(elements, rows, stiffness):
    """Elements and springs between bodies."""
    s = len(rows)
    added = rows, np.broadcast_to(stiffness, s), np.ones(s), np.full(s, -1), np.zeros(s, dtype=bool)
    return Elements.alike(*(np.concatenate(both) for both in zip(elements[:5], added, strict=True)))


def landing(seed, n=6, contacts=1):
    """A random inertia, rows of contacts and a velocity with which the first contact approaches."""
    rng = np.random.default_rng(seed)
    X, rows, velocity = (
        rng.normal(size=(n, n + 3)),
        rng.normal(size=(3 * contacts, n)),
        rng.normal(size=n),
    )
    return X @ X.T, rows, -velocity * np.sign(rows[2] @ velocity), rng


def impulsive(M, rows, velocity, restitution):
    """The jump of Eq. 4."""
    b = (1.0 + restitution) * rows @ velocity
    return solve_impact(
        M[None], rows[None], b[None, :, None], lambda: np.abs(rows)[None], TOLERANCE
    ).delta_qd[0, :, 0]


# Closed forms


@pytest.mark.parametrize("e", [1.0, 0.5, 0.1, 0.0])
@pytest.mark.parametrize("m", [1e-6, 2.0, 1e6])
def test_one_mass(m, e):
    """T = (1 + e)/2 π √(m/k), F = v √(km) for every e, and the mass returns with −e times its
    velocity.
    """
    k, v = 1e5, 1.5
    motion = simulate_landing(np.array([[m]]), normals([[1.0]], k, e), np.array([-v]))
    quarter = np.pi / 2.0 * np.sqrt(m / k)
    assert motion.duration == pytest.approx((1.0 + e) * quarter, rel=1e-10)
    assert motion.first("unloads")[0] == pytest.approx(quarter, rel=1e-10)
    assert motion.at([motion.duration]).jump[0, 0] == pytest.approx((1.0 + e) * v, rel=1e-10)
    t = np.linspace(0.0, quarter, 9)
    np.testing.assert_allclose(
        motion.at(t).force[:, 0], v * np.sqrt(k * m) * np.sin(np.pi / 2.0 * t / quarter), rtol=1e-9
    )
    np.testing.assert_allclose(
        motion.at(t).displacement[:, 0],
        -v * np.sqrt(m / k) * np.sin(np.pi / 2.0 * t / quarter),
        rtol=1e-9,
    )
    peak, when = motion.peak(m * motion.response[None])
    assert peak[0] == pytest.approx(v * np.sqrt(k * m), rel=1e-9)
    assert when[0] == pytest.approx(quarter, rel=1e-5)
    np.testing.assert_allclose(motion.modes.frequency, [1.0 / (4.0 * quarter)])
    np.testing.assert_allclose(motion.modes.energy, [m * v**2 / 2.0])


def test_two_masses_and_a_rotor_behind_a_spring():
    """Both modes of mass and rotor, from the quadratic equation for ω²."""
    m, rotor, k, spring, v = 1.0, 0.3, 4e4, 9e3, 2.0
    M, rows, springs, velocity = attach_rotors(
        np.array([[m]]), np.array([[1.0]]), np.array([-v]), np.eye(1), np.array([rotor])
    )
    motion = simulate_landing(M, with_springs(normals(rows, k), springs, spring), velocity)
    half, product = (k + spring) / (2.0 * m) + spring / (2.0 * rotor), k * spring / (m * rotor)
    squares = half + np.array([1.0, -1.0]) * np.sqrt(half**2 - product)
    np.testing.assert_allclose(motion.modes.frequency, np.sqrt(squares) / (2.0 * np.pi))
    shape = np.array([[1.0, 1.0], spring / (spring - rotor * squares)])
    t = np.linspace(0.0, 0.99 * motion.first("opens")[0], 20)
    t = t[t <= motion.first("unloads")[0]]
    x = (
        np.sin(np.outer(t, np.sqrt(squares)))
        * (np.linalg.solve(shape, velocity) / np.sqrt(squares))
        @ shape.T
    )
    np.testing.assert_allclose(motion.at(t).displacement, x, atol=1e-12)
    np.testing.assert_allclose(
        motion.at(t).force,
        np.column_stack([-k * x[:, 0], -spring * (x[:, 0] - x[:, 1])]),
        atol=1e-8,
    )
    np.testing.assert_allclose(motion.modes.participation.sum(axis=0), 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1e-3, 0.05, 0.6, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 2.0, 30.0])
def test_a_damper_returns_what_its_mass_has_when_the_force_is_zero(ratio):
    """Integrated in time, m ẍ = −k x − c ẋ from x = 0; and a damper on each of two contacts under
    one mass is one of 2c and 2k.
    """

    def force(t, y):
        return y[0] + 2.0 * ratio * y[1] + (t == 0.0)

    force.terminal, force.direction = True, 1.0
    exact = {"events": force, "rtol": 1e-11, "atol": 1e-14, "method": "Radau"}
    motion = solve_ivp(
        lambda t, y: [y[1], -y[0] - 2.0 * ratio * y[1]], (0.0, 1e4), [0.0, -1.0], **exact
    )
    expected = motion.y_events[0][0][1]
    assert damper_restitution(np.array(ratio)) == pytest.approx(expected, rel=1e-5, abs=1e-9)
    m, k, v = 3.0, 2e4, 0.7
    damped = normals([[1.0], [1.0]], k, 0.0)._replace(
        damping=np.full(2, ratio * np.sqrt(2.0 * k * m))
    )
    motion = simulate_landing(np.array([[m]]), damped, np.array([-v]))
    e = float(damper_restitution(np.array(ratio)))
    assert motion.at([motion.duration]).jump[0, 0] == pytest.approx((1.0 + e) * v, rel=1e-8)


@pytest.mark.parametrize("stiffness", [1e2, 1e12])
@pytest.mark.parametrize("seed", SEEDS)
def test_one_direction_gives_the_rigid_solution_times_a_half_sine(seed, stiffness):
    """Every acceleration is a half-sine of length π √(m/k) with the jump of Eq. 4, whatever the
    stiffness.
    """
    M, rows, velocity, _ = landing(seed)
    motion = simulate_landing(M, normals(rows[2:], stiffness), velocity)
    length = np.pi / np.sqrt(stiffness * (rows[2] @ np.linalg.solve(M, rows[2])))
    jump = impulsive(M, rows[2:], velocity, 1.0)
    t = np.linspace(0.0, length, 17)
    history = motion.at(t)
    assert motion.duration == pytest.approx(length, rel=1e-10)
    np.testing.assert_allclose(
        history.jump, np.outer((1.0 - np.cos(np.pi * t / length)) / 2.0, jump), atol=1e-9
    )
    np.testing.assert_allclose(
        history.force @ motion.response.T * length,
        np.outer(np.pi / 2.0 * np.sin(np.pi * t / length), jump),
        atol=1e-8,
    )


# Laws


@pytest.mark.parametrize("e", [(1.0, 1.0), (1.0, 0.4), (0.3, 0.5), (0.0, 0.0), (1.0, 0.0)])
@pytest.mark.parametrize("seed", SEEDS)
def test_energy_never_grows_and_momentum_changes_by_the_impulses(seed, e):
    """½ẋᵀMẋ + Σ e² f²/(2k) falls; it is constant with e = 1 until a contact opens; M Δẋ is what the
    forces add up to.
    """
    M, rows, velocity, rng = landing(seed, contacts=2)
    elements = with_springs(sticking(rows, 1e3, *e), rng.normal(size=(2, 6)), 200.0)
    motion = simulate_landing(M, elements, velocity, until=1.0)
    t = np.linspace(0.0, motion.duration, 40001)
    history = motion.at(t)
    qd = velocity + history.jump
    stored = np.where(elements.restitution > 0.0, elements.restitution, 0.0) ** 2 / (
        2.0 * elements.stiffness
    )
    energy = np.einsum("ti,ij,tj->t", qd, M, qd) / 2.0 + history.force**2 @ stored
    assert np.diff(energy).max() <= 1e-9 * energy[0]
    if e == (1.0, 1.0):
        before = t < min(
            (event.time for event in motion.events if event.kind == "opens"), default=np.inf
        )
        np.testing.assert_allclose(energy[before], energy[0], rtol=1e-12)
    impulse = (history.force[1:] + history.force[:-1]).sum(axis=0) * t[1] / 2.0
    # The trapezoidal rule loses a share of a step at each jump of a force.
    np.testing.assert_allclose(
        M @ history.jump[-1],
        elements.rows.T @ impulse,
        atol=5e-3 * np.abs(M @ history.jump[-1]).max(),
    )
    forces, normal = history.force, elements.normal
    assert np.all(forces[:, normal] >= -1e-9 * np.abs(forces).max())


@pytest.mark.parametrize("seed", [5, 7, 8, 11])
@pytest.mark.parametrize("stiffness", [1e3, 1e9])
def test_without_restitution_the_velocity_is_the_one_of_the_impulse_model(seed, stiffness):
    """For every stiffness, in landings whose contact does not slip before all its rows are at rest."""
    M, rows, velocity, _ = landing(seed)
    motion = simulate_landing(M, sticking(rows, stiffness), velocity)
    np.testing.assert_allclose(
        motion.at([motion.duration]).jump[0], impulsive(M, rows, velocity, 0.0), atol=1e-9
    )


def test_the_impulse_is_the_limit_of_a_stiff_contact():
    """Springs play no part where the contact is much stiffer: the error falls with 1/k, to 1e-9."""
    M, rows, velocity, _ = landing(3)
    joints, inertia = np.eye(6), np.full(6, 0.5)
    full, contact, springs, before = attach_rotors(M, rows[2:], velocity, joints, inertia)
    expected = np.append(impulsive(M, rows[2:], velocity, 1.0), np.zeros(6))
    errors = []
    for k in (1e6, 1e8, 1e10, 1e12):
        motion = simulate_landing(full, with_springs(normals(contact, k), springs, 100.0), before)
        errors.append(np.abs(motion.at([motion.duration]).jump[0] - expected).max())
    # Rotors see the integral of the springs' forces, of the order √(1/k) squared.
    np.testing.assert_allclose(np.array(errors[:2]) / errors[1:3], 100.0, rtol=0.1)
    assert errors[-1] < 1e-9


# Other integrators


@pytest.mark.parametrize("seed", SEEDS)
def test_runge_kutta_agrees(seed):
    """M ẍ + K x = 0 until the contact opens, on random trees of springs."""
    M, rows, velocity, rng = landing(seed, n=7)
    elements = with_springs(
        sticking(rows, 1e3, 1.0, 1.0), rng.normal(size=(4, 7)), 10.0 ** rng.uniform(1.0, 4.0, 4)
    )
    motion = simulate_landing(M, elements, velocity)
    K = (elements.rows.T * elements.stiffness) @ elements.rows
    end = motion.first("opens")[2]
    t = np.linspace(0.0, end, 30)

    def rate(_, state):
        return np.concatenate([state[7:], -np.linalg.solve(M, K @ state[:7])])

    reference = solve_ivp(
        rate,
        (0.0, end),
        np.append(np.zeros(7), velocity),
        t_eval=t,
        rtol=1e-12,
        atol=1e-14,
        method="DOP853",
    ).y.T
    history = motion.at(t)
    np.testing.assert_allclose(history.displacement, reference[:, :7], atol=1e-9)
    np.testing.assert_allclose(velocity + history.jump, reference[:, 7:], atol=1e-9)
    assert rows[2] @ reference[-1, :7] == pytest.approx(0.0, abs=1e-9)


def step_by_step(M, elements, velocity, end, steps):
    """Forces and the final velocity of the same elements by the leapfrog method, which asks in
    every step what changes.
    """
    inverse, step, x, v = np.linalg.inv(M), end / steps, np.zeros(len(M)), velocity.copy()
    k, e, normal, r = elements.stiffness, elements.restitution, elements.normal, len(elements.rows)
    slope, slack, peak = k.copy(), np.zeros(r), np.zeros(r)
    closed, loading, forces = (
        np.repeat((elements.rows @ v)[normal] < 0.0, 3),
        np.ones(r, dtype=bool),
        [],
    )
    for _ in range(steps):
        x = x + step / 2.0 * v
        y, rate = elements.rows @ x, elements.rows @ v
        f = np.where(closed, -slope * (y - slack), 0.0)
        for i in np.flatnonzero(closed & (e < 1.0)):
            if loading[i] and f[i] * rate[i] > 0.0:
                loading[i], peak[i], slope[i] = False, f[i], k[i] / e[i] ** 2
                slack[i] = y[i] + f[i] / slope[i]
            elif not loading[i] and f[i] * peak[i] > peak[i] ** 2:
                loading[i], slope[i], slack[i] = True, k[i], y[i] + f[i] / k[i]
            elif not loading[i] and f[i] * peak[i] < 0.0 and not normal[i]:
                loading[i], slope[i], slack[i], f[i] = True, k[i], y[i], 0.0
        for i in np.flatnonzero(normal):
            tangents = slice(i - 2, i)
            if closed[i] and f[i] < 0.0:
                if not closed[tangents].any():
                    closed[i], slack[i] = False, y[i]
                closed[tangents], f[i - 2 : i + 1] = False, 0.0
            elif not closed[i] and y[i] < slack[i]:
                whole = slice(i - 2, i + 1)
                closed[whole], loading[whole], slope[whole], slack[whole] = (
                    True,
                    True,
                    k[whole],
                    y[whole],
                )
        forces.append(f)
        v = v + step * (inverse @ (elements.rows.T @ f))
        x = x + step / 2.0 * v
    return np.array(forces), v


@pytest.mark.parametrize(
    ("seed", "tangential", "normal"), [(7, 1.0, 1.0), (3, 1.0, 0.5), (5, 0.6, 0.4), (5, 0.3, 0.3)]
)
def test_steps_in_time_agree(seed, tangential, normal):
    """Contacts that load, unload, slip, open and close again, at steps of 1/20000."""
    M, rows, velocity, _ = landing(seed, contacts=3)
    elements = sticking(rows, 300.0, tangential, normal)
    motion = simulate_landing(M, elements, velocity, until=1.0)
    forces, final = step_by_step(M, elements, velocity, 1.0, 20000)
    assert len(motion.events) >= 9
    history = motion.at((np.arange(0, 20000, 100) + 0.5) / 20000)
    assert np.abs(history.force - forces[::100]).max() < 5e-3 * np.abs(forces).max()
    np.testing.assert_allclose(velocity + motion.at([1.0]).jump[0], final, atol=5e-3)


@pytest.mark.parametrize("e", [0.0, 0.05, 0.5])
@pytest.mark.parametrize("seed", [1, 4, 7])
def test_matrix_exponentials_agree(seed, e):
    """Three contacts and springs: peak forces, final velocity and the time of 99 % of each normal
    impulse.

    Without restitution rows are held and loaded again from their peaks, also where holding another
    row makes their force jump.
    """
    M, rows, velocity, rng = landing(seed, contacts=3)
    elements = with_springs(sticking(rows, 1e3, e, e), rng.normal(size=(2, 6)), 200.0)
    motion = simulate_landing(M, elements, velocity, until=0.4)
    t, force, speed = follow(M, elements, velocity, 0.4, 2000)
    jump, peaks = speed[-1] - velocity, np.abs(force).max(axis=0)
    np.testing.assert_allclose(motion.at([0.4]).jump[0], jump, atol=1e-5 * np.abs(jump).max())
    np.testing.assert_allclose(
        motion.peak(np.eye(len(peaks))[:, None, :])[0], peaks, atol=1e-4 * peaks.max()
    )
    normals = np.flatnonzero(elements.normal)
    given = np.cumsum(
        (force[1:, normals] + force[:-1, normals]) / 2.0 * np.diff(t)[:, None], axis=0
    )
    late = [t[1 + np.argmax(one >= 0.99 * one[-1])] if one[-1] > 0.0 else 0.0 for one in given.T]
    np.testing.assert_allclose(motion.impulse_time(normals, 0.99), late, atol=2e-3)


@pytest.mark.parametrize("e", [0.0, 0.05, 0.5, 1.0])
@pytest.mark.parametrize("seed", [1, 4])
def test_matrix_exponentials_agree_under_constant_forces(seed, e):
    """As before, with accelerations of free fall, springs that are loaded before the impact, and
    constant forces of motors.
    """
    M, rows, velocity, rng = landing(seed, contacts=3)
    elements = with_springs(
        sticking(rows, 1e3, e, e), rng.normal(size=(4, 6)), np.array([200.0, 200.0, 0.0, 0.0])
    )
    elements = elements._replace(load=np.append(np.zeros(9), 10.0 * rng.normal(size=4)))
    gravity = 5.0 * rng.normal(size=6) - 5.0 * np.linalg.solve(M, rows[2]) / np.linalg.norm(rows[2])
    motion = simulate_landing(M, elements, velocity, until=0.15, gravity=gravity)
    _, force, speed = follow(M, elements, velocity, 0.15, 750, gravity)
    jump, peaks = speed[-1] - velocity, np.abs(force).max(axis=0)
    np.testing.assert_allclose(motion.at([0.15]).jump[0], jump, atol=1e-5 * np.abs(jump).max())
    np.testing.assert_allclose(
        motion.peak(np.eye(len(peaks))[:, None, :])[0], peaks, atol=1e-4 * peaks.max()
    )
    np.testing.assert_allclose(motion.at(np.zeros(1)).force[0], elements.load, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("e", [0.0, 1e-3, 1e-2, 0.1])
def test_a_contact_that_opens_for_an_instant_is_followed(e):
    """A mass behind a spring presses a foot on the ground for long after the foot is at rest: the
    rebound depends little on e.
    """
    M, rows, springs, velocity = attach_rotors(
        np.array([[0.2]]), np.ones((1, 1)), -np.ones(1), np.eye(1), np.array([2.0])
    )
    elements = with_springs(normals(rows, 1e5, e), springs, 1e3)
    motion = simulate_landing(M, elements, velocity)
    # The mass of 2 kg turns on its spring in half a period; that of the foot on the ground is 9 ms
    # of it.
    assert motion.duration == pytest.approx(np.pi * np.sqrt(2.0 / 1e3), rel=0.03)
    assert motion.at([motion.duration]).jump[0, 1] == pytest.approx(2.0, rel=0.03)
    later = simulate_landing(M, elements, velocity, until=5.0 * motion.duration)
    # What closes then compresses the ground by less than a hundredth.
    assert [event[1:] for event in later.events[: len(motion.events)]] == [
        event[1:] for event in motion.events
    ]


def test_a_foot_that_carries_nothing_does_not_prolong_the_contact():
    """A contact is given 99 % of its impulse by a mass that stops, though a soft spring holds it on
    the ground for long.
    """
    M, rows, springs, velocity = attach_rotors(
        np.ones((1, 1)), np.ones((1, 1)), -np.ones(1), np.eye(1), np.array([1e-4])
    )
    motion = simulate_landing(M, with_springs(normals(rows, 1e5, 0.0), springs, 1e-3), velocity)
    assert motion.duration > 0.9
    assert motion.impulse_time(np.array([0]), 0.99)[0] == pytest.approx(
        np.arccos(0.01) / np.sqrt(1e5), rel=1e-3
    )


def test_a_reversal_that_is_undone_at_once_is_no_event():
    """Pressed on the ground harder and harder, a foot of small restitution unloads and is loaded
    again hundreds of times.
    """
    M, rows, springs, velocity = attach_rotors(
        np.array([[0.2]]), np.ones((1, 1)), -np.ones(1), np.eye(1), np.array([2.0])
    )
    motion = simulate_landing(M, with_springs(normals(rows, 1e5, 1e-3), springs, 1e3), velocity)
    assert len(motion.segments) > 5 * len(motion.events)
    for first, second in pairwise(motion.events):
        assert {first.kind, second.kind} != {
            "unloads",
            "reloads",
        } or second.time - first.time >= 1e-3 / np.sqrt(1e5 / 0.2)


def test_a_fast_spring_does_not_hinder_the_search_for_a_contact_that_closes_again():
    """After the rebound a rotor oscillates on 1e12 N m/rad some millions of times in the time in
    which no contact closes.
    """
    M, rows, springs, velocity = attach_rotors(
        np.eye(1), np.ones((1, 1)), -np.ones(1), np.eye(1), np.array([1e-3])
    )
    motion = simulate_landing(M, with_springs(normals(rows, 1e2, 1.0), springs, 1e12), velocity)
    assert motion.duration == pytest.approx(np.pi * np.sqrt(1.001 / 1e2), rel=1e-6)


def test_dependent_rows_bring_no_events_of_rounding():
    """Two contacts with the same tangent, as on one edge: in steps of time, and without
    restitution, where no contact chatters.
    """
    M, rows, velocity, _ = landing(3, contacts=3)
    rows[3] = rows[0]
    elements = sticking(rows, 300.0, 0.6, 0.4)
    _, final = step_by_step(M, elements, velocity, 1.0, 20000)
    np.testing.assert_allclose(
        velocity + simulate_landing(M, elements, velocity, until=1.0).at([1.0]).jump[0],
        final,
        atol=5e-3,
    )
    M, rows, velocity, _ = landing(4, contacts=3)
    rows[3] = rows[0]
    assert len(simulate_landing(M, sticking(rows, 300.0), velocity, until=1.0).events) < 100


@pytest.mark.parametrize("contact", [1e2, 1e12])
@pytest.mark.parametrize("spring", [1e-2, 1e12])
@pytest.mark.parametrize("rotor", [1e-9, 1e3])
def test_frequencies_far_apart(contact, spring, rotor):
    """Contacts of 1e2 and 1e12 N/m and rotors from 1e-9 to 1e3 kg m² behind springs of 1e-2 and
    1e12 N m, against 50 digits.
    """
    M, rows, velocity, _ = landing(4, n=3)
    M, rows, springs, velocity = attach_rotors(M, rows[2:], velocity, np.eye(3), np.full(3, rotor))
    elements = with_springs(normals(rows, contact), springs, spring)
    motion = simulate_landing(M, elements, velocity)
    end = motion.segments[0].length
    with mpmath.workdps(50):
        B, inverse = mpmath.matrix(elements.rows.tolist()), mpmath.matrix(M.tolist()) ** -1
        root = mpmath.diag([mpmath.sqrt(k) for k in elements.stiffness.tolist()])
        squares, Q = mpmath.eigsy(root * B * inverse * B.T * root)
        start = Q.T * root * B * mpmath.matrix(velocity.tolist())
        omega = [mpmath.sqrt(abs(value)) for value in squares]
        z = Q * mpmath.matrix(
            [c * mpmath.sin(w * end) / w for c, w in zip(start, omega, strict=True)]
        )
        p = Q * mpmath.matrix(
            [c * (1 - mpmath.cos(w * end)) / w**2 for c, w in zip(start, omega, strict=True)]
        )
        force, jump = (
            np.array((-value).tolist(), dtype=float)[:, 0]
            for value in (root * z, inverse * B.T * root * p)
        )
    history = motion.at([end])
    np.testing.assert_allclose(history.force[0], force, atol=1e-7 * np.abs(force).max())
    np.testing.assert_allclose(history.jump[0], jump, atol=1e-9 * np.abs(jump).max())


def kelvin_voigt(M, elements, velocity, gravity, end):
    """Forces at 400 times until an end: every contact max(0, −k x − c ẋ) while x ≤ 0, by Runge and
    Kutta.
    """
    B, k, c, n = (
        elements.rows,
        elements.stiffness,
        np.broadcast_to(elements.damping, len(elements.rows)),
        len(M),
    )
    grounded, inverse = elements.contact >= 0, np.linalg.inv(M)

    def force(y):
        x = B @ y[:n]
        f = -k * x - c * (B @ y[n:])
        return np.where(grounded & ((f < 0.0) | (x > 0.0)), 0.0, f)

    def rate(_, y):
        return np.concatenate([y[n:], inverse @ (B.T @ force(y)) + gravity])

    t = np.linspace(0.0, end, 401)
    motion = solve_ivp(
        rate,
        (0.0, end),
        np.append(np.zeros(n), velocity),
        t_eval=t,
        rtol=1e-8,
        atol=1e-10,
        max_step=end / 1000,
    )
    return t, np.array([force(y) for y in motion.y.T]), motion.y.T[:, n:]


@pytest.mark.parametrize("seed", [1, 4])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 4.0])
@pytest.mark.slow
def test_dampers_in_parallel_agree_with_steps_in_time(seed, ratio):
    """Contacts of springs and dampers, which separate where they would pull and close again, under
    gravity, beside springs.
    """
    rng = np.random.default_rng(seed)
    X, rows = rng.normal(size=(6, 9)), rng.normal(size=(5, 6))
    M, velocity = X @ X.T, -rows[0] - rows[1] - rows[2]
    own = 1.0 / np.einsum("ri,ij,rj->r", rows[:3], np.linalg.inv(M), rows[:3])
    elements = with_springs(normals(rows[:3], 1e4), rows[3:], 3e3)
    elements = elements._replace(damping=np.append(2.0 * ratio * np.sqrt(1e4 * own), [0.0, 0.0]))
    gravity = 3.0 * np.linalg.solve(M, -rows[:3].sum(axis=0))
    end = 0.4
    motion = simulate_landing(M, elements, velocity, until=end, gravity=gravity)
    t, force, speed = kelvin_voigt(M, elements, velocity, gravity, end)
    found = motion.at(t)
    assert any(event.kind == "opens" for event in motion.events)
    np.testing.assert_allclose(velocity + found.jump, speed, atol=2e-4 * np.abs(speed).max())
    # A force that jumps does so at a slightly different time.
    wrong = np.abs(found.force - force).max(axis=1) > 1e-3 * np.abs(force).max()
    assert np.count_nonzero(wrong) <= 3
    largest = np.abs(force).max(axis=0)
    np.testing.assert_allclose(
        motion.peak(np.eye(5)[:, None])[0], largest, atol=1e-2 * largest.max()
    )


def test_a_tangential_damper_starts_with_a_force_too():
    """A point mass that strikes at an angle: each row is a spring and a damper, here critical,
    whose force starts at c v.
    """
    m, k = 2.0, 1e4
    omega = np.sqrt(k / m)
    elements = sticking(np.eye(3), k)._replace(damping=np.full(3, 2.0 * m * omega))
    motion = simulate_landing(m * np.eye(3), elements, np.array([0.3, 0.0, -1.0]))
    # x = v t exp(−ωt): force 2 ω v m (1 − ωt/2) exp(−ωt), zero at ωt = 2.
    assert motion.duration == pytest.approx(2.0 / omega, rel=1e-7)
    t = np.linspace(0.0, motion.duration, 9)
    expected = 2.0 * m * omega * (1.0 - omega * t / 2.0) * np.exp(-omega * t)
    np.testing.assert_allclose(motion.at(t).force, np.outer(expected, [-0.3, 0.0, 1.0]), atol=1e-6)


def test_many_springs_and_few_dampers():
    """A hundred masses in a row, a damper at the foot: the energy falls by what the damper takes,
    and the end is found soon.
    """
    n = 100
    rows, springs = np.eye(1, n), np.eye(n - 1, n) - np.eye(n - 1, n, 1)
    elements = with_springs(normals(rows, 1e5), springs, 1e6)._replace(
        damping=np.append(40.0, np.zeros(n - 1))
    )
    motion = simulate_landing(np.eye(n) / n, elements, -np.ones(n))
    history = motion.at(np.linspace(0.0, motion.duration, 4001))
    qd, k = -1.0 + history.jump, elements.stiffness
    lost = 40.0 * np.trapezoid(qd[:, 0] ** 2, dx=motion.duration / 4000)
    kinetic = (qd**2).sum(axis=1) / n / 2.0
    springs_left = (history.force[-1, 1:] ** 2 / k[1:]).sum() / 2.0 + k[0] * history.displacement[
        -1, 0
    ] ** 2 / 2.0
    assert kinetic[-1] + springs_left + lost == pytest.approx(0.5, rel=1e-3)


def test_a_spring_that_rings_does_not_prolong_the_landing():
    """A rotor rings on its spring without loss; the landing ends where the contacts carry no more
    than constant forces make.
    """
    rng = np.random.default_rng(0)
    for _ in range(10):
        M, rows, velocity, _ = landing(int(rng.integers(1000)), contacts=2)
        joints, inertia = rng.normal(size=(2, 6)), 10.0 ** rng.uniform(-2.0, 1.0, 2)
        full, contact, springs, before = attach_rotors(M, rows, velocity, joints, inertia)
        elements = with_springs(sticking(contact, 1e4), springs, 10.0 ** rng.uniform(1.0, 5.0, 2))
        gravity = np.append(-3.0 * np.linalg.solve(M, rows[2] + rows[5]), [0.0, 0.0])
        for pull in (0.0 * gravity, gravity):
            assert len(simulate_landing(full, elements, before, gravity=pull).segments) < 400


# Contacts and outputs


def test_a_plate_on_four_corners_shares_the_force():
    """Rows that depend on one another: equal springs carry equal forces, and tangents that cannot
    be moved carry none.
    """
    rows = np.array([[0.0, 0.0, 0.0]] * 8 + [[1.0, x, y] for x in (-1, 1) for y in (-1, 1)])
    order = [0, 1, 8, 2, 3, 9, 4, 5, 10, 6, 7, 11]
    for e in (0.0, 0.5, 1.0):
        motion = simulate_landing(
            np.diag([4.0, 1.0, 1.0]), sticking(rows[order], 1e4, e, e), np.array([-1.0, 0.0, 0.0])
        )
        force = motion.at([motion.first("unloads")[2] / 3.0]).force[0].reshape(4, 3)
        np.testing.assert_allclose(force, np.tile([0.0, 0.0, 50.0], (4, 1)), atol=1e-9)
        np.testing.assert_allclose(
            motion.at([motion.duration]).jump[0], [1.0 + e, 0.0, 0.0], atol=1e-9
        )


@pytest.mark.parametrize("seed", SEEDS)
def test_peaks_are_those_of_a_dense_history(seed):
    """Of vectors that mix accelerations and forces, over all events."""
    M, rows, velocity, rng = landing(seed, contacts=2)
    motion = simulate_landing(
        M,
        with_springs(sticking(rows, 1e3, 1.0, 0.3), rng.normal(size=(2, 6)), 1e4),
        velocity,
        until=0.7,
    )
    G, P = rng.normal(size=(4, 3, 6)), rng.normal(size=(4, 3, 8))
    t = np.linspace(0.0, 0.7, 60001)

    def lengths(t):
        history = motion.at(t)
        acceleration = history.force @ motion.response.T
        vector = np.einsum("mkn,tn->tmk", G, acceleration) + np.einsum(
            "mkr,tr->tmk", P, history.force
        )
        return np.linalg.norm(vector, axis=-1)

    dense, (peak, when) = lengths(t).max(axis=0), motion.peak(G @ motion.response + P)
    assert np.all(peak >= dense * (1.0 - 1e-9))
    np.testing.assert_allclose(peak, dense, rtol=1e-2)
    # At an event the peak is that before or after it.
    reached = [np.diagonal(lengths(np.clip(when + shift, 0.0, 0.7))) for shift in (-1e-12, 1e-12)]
    np.testing.assert_allclose(np.max(reached, axis=0), peak, rtol=1e-6)
    assert np.all((when >= 0.0) & (when <= 0.7))


@pytest.mark.parametrize(
    ("changes", "error", "text"),
    [
        ({"M": np.diag([1.0, 0.0])}, ArithmeticError, "positive definite"),
        ({"M": np.ones((2, 2))}, ArithmeticError, "positive definite"),
        ({"velocity": np.array([1.0, 0.0])}, ValueError, "approaches"),
        ({"velocity": np.array([np.nan, 0.0])}, ValueError, "finite"),
        ({"until": 0.0}, ValueError, "above 0 s"),
        ({"elements": normals([[1.0, 0.0]])._replace(damping=-np.ones(1))}, ValueError, "damping"),
        ({"elements": normals([[1.0, 0.0]], 0.0)}, ValueError, "stiffness"),
        ({"elements": normals([[1.0, 0.0]], 1.0, 1.5)}, ValueError, "restitution"),
        (
            {"elements": normals([[1.0, 0.0]])._replace(normal=np.array([False]))},
            ValueError,
            "normal",
        ),
    ],
)
def test_what_cannot_be_computed_is_refused(changes, error, text):
    elements = with_springs(normals([[1.0, 0.0]]), np.array([[1.0, -1.0]]), 1e4)
    given = {"M": np.eye(2), "elements": elements, "velocity": np.array([-1.0, 0.0])} | changes
    with pytest.raises(error, match=text):
        simulate_landing(**given)


def test_a_peak_that_oscillates_too_often_is_refused():
    """A rotor that does not follow its joint oscillates on a spring of 1e10 N m/rad some 25 000
    times within the contact.
    """
    M, rows, springs, velocity = attach_rotors(
        np.eye(1), np.ones((1, 1)), -np.ones(1), np.eye(1), np.array([1e-3])
    )
    motion = simulate_landing(
        M, with_springs(normals(rows, 1e3), springs, 1e10), velocity * [1.0, 0.5]
    )
    with pytest.raises(ArithmeticError, match="the fastest mode oscillates more than 8738 times"):
        motion.peak(M @ motion.response[None])


def test_what_takes_too_many_terms_is_refused(monkeypatch):
    """Their number does not depend on the machine, as a time would: one fewer than a motion, or a
    peak, takes is refused.
    """
    elements = with_springs(normals([[1.0, 0.0]]), np.array([[1.0, -1.0]]), 1e4)
    M, velocity, spent = np.eye(2), np.array([-1.0, 0.0]), []

    class Counted(crossing.Effort):
        def spend(self, terms):
            super().spend(terms)
            spent.append(self.terms)

    for module in (stiff_state, stiff_motion):
        monkeypatch.setattr(module, "Effort", Counted)
    motion = simulate_landing(M, elements, velocity)
    for_events = max(spent)
    spent.clear()
    motion.peak(motion.response[None])
    for_peak = max(spent)
    for most, act in (
        (for_events, lambda: simulate_landing(M, elements, velocity)),
        (for_peak, lambda: motion.peak(motion.response[None])),
    ):
        monkeypatch.setattr(crossing, "MOST_TERMS", most)
        act()
        monkeypatch.setattr(crossing, "MOST_TERMS", most - 1)
        with pytest.raises(
            ArithmeticError, match="terms to follow; take the stiffest springs as rigid"
        ):
            act()
