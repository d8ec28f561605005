"""A kind of variation that is registered works in every study, with no other line of the package.

A drop from height h ends with the speed √(2 g h), and velocities are proportional to it.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from commands import good, run

from shockpc import Scene, ShockCost, Strike, shock_profile
from shockpc.evaluation.variations.kinds.registry import KINDS
from shockpc.evaluation.variations.variation import Kind
from shockpc.show.wording import varied_text
from shockpc.studies.limits.study import limits
from shockpc.studies.sensitivity.study import sensitivity
from shockpc.studies.sweep.study import sweep

HEIGHT = 0.2
LANDING = Scene(robot="go2", contact="FL_foot", strike=Strike(drop_height=HEIGHT))
TARGET = "delta_v@imu"


@dataclass(frozen=True)
class DropHeight(Kind):
    """The height of the drop before the landing [m]."""

    def scene_with(self, varied, scene, robot, value):
        return replace(scene, strike=replace(scene.strike, drop_height=float(value)))

    def present(self, varied, landing):
        return [landing.scene.strike.drop_height]


@pytest.fixture(autouse=True)
def drop_height(monkeypatch):
    kind = DropHeight("drop-height", "m", nonnegative=True, option="drop-height")
    monkeypatch.setitem(KINDS, kind.word, kind)


def jump(height):
    """The size of the target after a drop from a height [m/s]."""
    profile = shock_profile(replace(LANDING, strike=Strike(drop_height=height)))
    places = [place for place in profile.places("point") if place.name == "imu"]
    (delta_v,) = profile.value("delta_v", "point", places)
    return float(np.linalg.norm(delta_v))


def test_a_sweep_has_its_values():
    table = sweep(LANDING, {"drop-height": [0.1, 0.4]}, quantities=[TARGET]).table
    low, high = table.columns[TARGET]
    assert low == pytest.approx(jump(0.1), rel=1e-12)
    assert high == pytest.approx(2.0 * low, rel=1e-12)
    assert table.columns["drop-height [m]"].tolist() == [0.1, 0.4]


def test_a_sensitivity_has_its_derivative():
    """√h changes by 1 / (2 h) of itself."""
    study = sensitivity(LANDING, TARGET, vary={"drop-height": "0.1:0.3"})
    (effect,) = study.effects
    assert effect.value == HEIGHT
    (derivative,) = effect.derivatives
    assert derivative / study.value == pytest.approx(1.0 / (2.0 * HEIGHT), rel=1e-6)


def test_a_limit_is_a_height():
    study = limits(
        LANDING, "drop-height", TARGET, max=jump(HEIGHT), joint_range=(0.05, 0.5), step=0.05
    )
    (low, high) = study.limits[0].usable[0]
    assert low == 0.05
    assert high == pytest.approx(HEIGHT, abs=1e-4)


def test_a_cost_has_it_as_a_variable():
    cost = ShockCost(LANDING, TARGET, {"drop-height": "0.1:0.4"}, ground=False)
    assert cost.x0.tolist() == [HEIGHT]
    assert cost([0.4]) == pytest.approx(2.0 * cost([0.1]), rel=1e-12)


def test_commands_know_its_option_and_its_name(capfd):
    assert varied_text("drop-height", "m") == "drop height"
    words = ("sweep", "go2", "--contact", "FL_foot", "--vary", "drop-height=0.1,0.4")
    assert "drop-height" in good(capfd, *words)
    refused = run(capfd, *words, "--drop-height", "0.3")
    assert refused.code == 2
    assert "--drop-height has no effect" in refused.err
