"""The rivals: on regular cases all agree with the reference; where they cannot, they say so, or are seen to fail."""

import numpy as np
import pinocchio as pin
import pytest

from shockpc.bench.accuracy import body_errors
from shockpc.bench.cases import family
from shockpc.bench.cases.robots import FOOTED
from shockpc.bench.measure import measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.bench.reference import reference
from shockpc.bench.simulate import SIMULATED, Stepper, land
from shockpc.bench.system import Unsuited, system_of
from shockpc.bench.throughput import PEERS, WORK, postures
from shockpc.errors import SceneError

REGULAR = {
    "one foot": ("robots", "one foot", FOOTED.index("anymal_b")),
    "two feet": ("restitution", "two feet", 0.0),
    "two feet that bounce": ("restitution", "two feet", 0.5),
    "drives": ("armature", "one foot", 0.01),
    "a loop": ("flat four-bar", "crank struck", 1.0),
    "hips free": ("locked feet", "hips free", 1),
    "held base": ("knee", "fixed base, foot slides", 1.0),
}
UNSUITED = {
    "partition (Eq. 6)": {"two feet", "two feet that bounce", "a loop", "held base"},
    "pin.impulseDynamics, Jacobian": {"hips free", "held base"},
    "pin.impulseDynamics, damped": {"hips free", "held base"},
    "pin.impulseDynamics, constraints": {"a loop", "hips free", "held base"},
    "pin.impulseDynamics, constraints, µ = 1e-6": {"a loop", "hips free", "held base"},
}
DAMPED = {"pin.impulseDynamics, damped": 1e-6, "pin.impulseDynamics, constraints, µ = 1e-6": 1e-4}
"""What damping may cost on a regular case: about 14 times the damping, relative to the mass behind a foot."""


def solved(method, where):
    family_name, variant, value = REGULAR[where]
    system = system_of(*family(family_name).case(variant, value).build())
    prepared = method.prepare(system)
    return system, prepared.read(prepared.run())


PAIRS = [(method, where) for method in DIRECT for where in REGULAR]


@pytest.mark.parametrize(("method", "where"), PAIRS, ids=[f"{method.name}-{where}" for method, where in PAIRS])
def test_every_method_agrees_on_regular_cases(method, where):
    """All ways lead to the same jumps, or say in words that they cannot take the scene."""
    if where in UNSUITED.get(method.name, ()):
        with pytest.raises(Unsuited):
            solved(method, where)
        return
    system, jumps = solved(method, where)
    truth = reference(system.robot, system.scene, system.landing)
    # 18 to 24 unknowns; a body that hardly moves is a difference of others.
    assert body_errors(system.robot, truth, jumps).own.max() < DAMPED.get(method.name, 1e-11)


STEPPED = [SIMULATED[1:4], SIMULATED[6:9], MUJOCO[1:4], MUJOCO[5:8]]


@pytest.mark.parametrize("methods", STEPPED, ids=["ABA, 2 steps", "ABA, 10 steps", "MuJoCo, 2 steps", "MuJoCo, 10 steps"])
def test_simulated_landings_come_near_as_the_ground_hardens(methods):
    """Ten times the hardness leaves a tenth of the error: the limit of a simulated landing is the impulsive answer."""
    system = system_of(*family("robots").case("one foot", FOOTED.index("anymal_b")).build())
    truth = reference(system.robot, system.scene, system.landing)
    errors = []
    for method in methods:
        prepared = method.prepare(system)
        errors.append(body_errors(system.robot, truth, prepared.read(prepared.run())).whole.max())
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 10.0, rtol=0.1)
    assert errors[-1] < 3e-3


def test_simulation_takes_loops_and_held_joints():
    """Pads under the rows of a loop, and columns that are left out, lead to the impulsive answer as well."""
    for name, variant, value in (("flat four-bar", "crank struck", 1.0), ("locked feet", "hips free", 1)):
        system = system_of(*family(name).case(variant, value).build())
        truth = reference(system.robot, system.scene, system.landing)
        prepared = SIMULATED[4].prepare(system)
        assert body_errors(system.robot, truth, prepared.read(prepared.run())).whole.max() < 1e-3


def test_a_simulation_without_end_is_not_begun():
    """Masses so far apart that the steps would be too many are refused in words."""
    system = system_of(*family("light link").case("toe", 1e-8).build())
    with pytest.raises(Unsuited, match=r"^\d+ steps of .* s are too many to simulate; the limit is 60000$"):
        land(Stepper(system, 0.0), np.ones(3), 1e-3)


def test_failures_are_seen_and_named():
    """On four corners the textbook ways fail aloud, Pinocchio's in silence; the bench tells the two apart."""
    results = {r.method: r for r in measure(family("corners").case("sticking", 4), DIRECT, budget=0.0).results}
    assert results["shockpc"].outcome == "right"
    assert results["dense KKT (Eq. 4)"].outcome in ("failed", "wrong", "right")
    assert results["Schur, Cholesky of H"].outcome == "failed"
    assert results["partition (Eq. 6)"].outcome == "unsuited"
    assert results["reduced (Eq. 7)"].outcome == "right"
    assert results["pin.impulseDynamics, Jacobian"].outcome == "wrong"
    assert results["pin.impulseDynamics, constraints"].outcome == "nan"


def test_an_answer_where_there_is_none_is_invented():
    """A straight leg on a base that cannot move does not give way along itself: the product says so, others make something up."""
    results = {r.method: r for r in measure(family("knee").case("fixed base", 0.0), DIRECT, budget=0.0).results}
    assert results["shockpc"].outcome == "refused"
    assert results["reduced (Eq. 7)"].outcome == "invented"


@pytest.mark.parametrize("work", WORK[:2], ids=lambda work: work.name)
def test_peers_do_the_same_work(work):
    """In random postures every peer gets the product's jumps."""
    system = work.system()
    Q = postures(system, 5)
    (_, ours), *others = [(prepared := peer(system, Q), prepared.read(prepared.run())) for _, peer in PEERS]
    size = np.abs(ours).max(axis=(1, 2), keepdims=True)
    for prepared, found in others:
        np.testing.assert_array_less(np.abs(found - ours) / size, 1e-12)
        np.testing.assert_array_equal(prepared.read(prepared.run()), found)  # what is prepared may be run again


def test_pinocchio_solves_once(monkeypatch):
    """However many iterations its proximal settings allow, the answer is the same, and µ stays in it."""
    allowed = pin.ProximalSettings
    _, once = solved(DIRECT[-1], "one foot")
    monkeypatch.setattr(pin, "ProximalSettings", lambda *settings: allowed(*settings[:3], 5000))
    _, often = solved(DIRECT[-1], "one foot")
    np.testing.assert_array_equal(once, often)


def test_restitutions_that_differ_are_no_single_ground():
    """Pinocchio takes one restitution; two feet that bounce differently are refused."""
    robot, scene = family("restitution").case("two feet", 0.5).build()
    one, other = scene.contact
    scene = type(scene)(**(vars(scene) | {"contact": (one, type(other)(frame=other.frame))}))
    system = system_of(robot, scene)
    for method in (*DIRECT[7:], SIMULATED[0]):
        with pytest.raises(SceneError, match="restitution"):
            method.prepare(system)
