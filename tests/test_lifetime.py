"""What belongs to a robot or to a landing is held by it: it is computed once, and nothing else
keeps either alive.
"""

import gc
import pickle
import threading
import weakref
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import numpy as np
import pytest
from robot_texts import body, floating, loaded, mjcf

from shockpc import (
    Contact,
    Design,
    Robot,
    Scene,
    batch,
    compare,
    load_robot,
    resolve,
    sensitivity,
    shock_maps,
    shock_profile,
    sweep,
)
from shockpc.core.memo import memoized
from shockpc.impact import friction
from shockpc.method.dynamics import dynamics
from shockpc.robot.shapes.geometry import body_outline
from shockpc.studies.analyze.report import document, landing_report

FOOT = Scene(robot="anymal_b", contact=Contact(frame="LF_FOOT"))
SLIDING, STIFF = replace(FOOT, friction=0.3), replace(FOOT, contact_stiffness=1e5)

CALLS: dict[str, Callable[[Robot], object]] = {
    "landing": lambda robot: document(shock_profile(FOOT, robot)),
    "friction": lambda robot: document(shock_profile(SLIDING, robot)),
    "stiffness": lambda robot: document(shock_profile(STIFF, robot)),
    "report": lambda robot: landing_report(shock_profile(STIFF, robot)).files(),
    "maps": lambda robot: shock_maps(resolve(FOOT, robot), robot.start[None]),
    "sweep": lambda robot: (
        sweep(SLIDING, {"strike-angle": "-20:20:3"}, robot=robot, quantities=["feasible"]).table
    ),
    "sensitivity": lambda robot: sensitivity(FOOT, "shock@base", robot),
    "batch": lambda robot: batch(["anymal_b"], lambda _: (robot, [FOOT])),
    "compare": lambda robot: compare(
        [Design("A", SLIDING, robot), Design("B", SLIDING, robot)], ["shock_friction"]
    ),
}


def test_what_is_remembered_of_an_object_cannot_go_stale():
    """The fields of a robot, a scene, a landing and a profile cannot be changed, added or deleted;
    a copy has others.
    """
    profile = shock_profile(FOOT)
    for record in (profile.robot, FOOT, FOOT.contact[0], FOOT.strike, profile.landing, profile):
        name, before = next(iter(vars(record).items()))
        for change, *arguments in (
            (setattr, name, before),
            (setattr, "undeclared", 1),
            (delattr, name),
        ):
            with pytest.raises(FrozenInstanceError, match=type(record).__name__):
                change(record, *arguments)
        assert getattr(record, name) is before
        assert not hasattr(record, "undeclared")
    other = pickle.loads(pickle.dumps(replace(FOOT, friction=0.3)))
    assert (other.friction, FOOT.friction) == (0.3, None)
    assert other == SLIDING != FOOT


@pytest.mark.slow
@pytest.mark.parametrize("call", CALLS)
def test_a_robot_ends_with_its_last_reference(call: str):
    """Whatever was computed of it."""
    robot = load_robot("anymal_b")
    assert CALLS[call](robot) is not None
    left = weakref.ref(robot)
    del robot
    gc.collect()
    assert left() is None


def test_a_robot_of_an_mjcf_ends_with_its_last_reference(tmp_path: Path):
    """With what MuJoCo compiled of its file."""
    robot = loaded(tmp_path, mjcf(floating(body("b"))), "dog.xml")
    assert body_outline(robot).shapes
    left, source = weakref.ref(robot), weakref.ref(robot.source)
    del robot
    gc.collect()
    assert (left(), source()) == (None, None)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [FOOT, SLIDING, STIFF], ids=["landing", "friction", "stiffness"])
def test_a_landing_ends_with_its_last_reference(scene: Scene):
    """Though what was solved of it refers to it."""
    profile = shock_profile(scene)
    assert landing_report(profile).files()
    left = weakref.ref(profile.landing)
    del profile
    gc.collect()
    assert left() is None


def solved_once(scene: Scene, module: object, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Check that six landings, whose numbers are read one after the other, are solved once each."""
    solved, solve = [], getattr(module, name)
    monkeypatch.setattr(
        module,
        name,
        lambda *given, **named: solved.append(pickle.dumps(given)) or solve(*given, **named),
    )
    scenes = [
        replace(scene, strike=replace(scene.strike, strike_angle_deg=5.0 * k)) for k in range(6)
    ]
    profiles = [shock_profile(one) for one in scenes]
    for _ in range(2):
        assert all(document(profile) for profile in profiles)
    assert len(solved) == len(set(solved)) >= 6


def test_every_landing_is_solved_once(monkeypatch: pytest.MonkeyPatch):
    solved_once(SLIDING, friction, "solve_friction", monkeypatch)


def test_results_are_of_their_object_and_arguments():
    """Those of another object are others; the oldest are given up; a pickled object has none."""
    counted = []

    @memoized(most=2)
    def shifted(contact: Robot, by: float = 0.0) -> float:
        counted.append(by)
        return contact.mass + by

    one, other = load_robot("go2"), load_robot("beam")
    assert [shifted(one, 1.0), shifted(other, 1.0), shifted(one, 1.0)] == [
        one.mass + 1.0,
        other.mass + 1.0,
        one.mass + 1.0,
    ]
    assert counted == [1.0, 1.0]
    _ = shifted(one, 2.0), shifted(one, by=3.0), shifted(one, 1.0)
    assert counted == [1.0, 1.0, 2.0, 3.0, 1.0]
    again = pickle.loads(pickle.dumps(one))
    assert (shifted(again, 1.0), len(counted)) == (one.mass + 1.0, 6)


def test_threads_that_evaluate_one_robot_do_not_disturb_each_other():
    """Each has Pinocchio's data of its own."""
    robot = load_robot("anymal_b")
    rng = np.random.default_rng(0)
    postures = [np.tile(robot.start, (200, 1)) for _ in range(4)]
    for Q in postures:
        Q[:, 7:] += rng.uniform(-0.5, 0.5, Q[:, 7:].shape)
    expected = [dynamics(robot, Q).H for Q in postures]
    found: dict[int, np.ndarray] = {}
    threads = [
        threading.Thread(target=lambda k=k, Q=Q: found.update({k: dynamics(robot, Q).H}))
        for k, Q in enumerate(postures)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k, H in enumerate(expected):
        np.testing.assert_array_equal(found[k], H)
