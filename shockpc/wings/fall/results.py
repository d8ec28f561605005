"""The landings of strikes: worst values, motion of the trunk, and the first end stop."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc.evaluation.column import selected
from shockpc.evaluation.profiles import proven_profiles
from shockpc.evaluation.table import Table
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Scene
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.robot.tolerances import LIMIT_SLACK
from shockpc.text.errors import DefectError, ShockError, StudyError, attempt, traces
from shockpc.text.trace import Trace
from shockpc.wings.fall.strikes import FallStrike


class StrikeResult(NamedTuple):
    """A strike and its results.

    Attributes:
        strike: the strike.
        values: the worst value of each quantity, by its text; NaN where there is none.
        places: where it is the worst, by text.
        trunk: |Δv| of the heaviest body's centre of mass, with friction where it is given: free
            joints, with drives, locked; NaN without a verdict [m/s].
        stop: joint that reaches its limit first after the strike if its rate stays, and when
            [s]; None if none moves towards it.
        profile: of the landing.
    """

    strike: FallStrike
    values: Mapping[str, float]
    places: Mapping[str, str]
    trunk: tuple[float, ...]
    stop: tuple[str, float] | None
    profile: ShockProfile


def landings_of_strikes(
    strikes: Sequence[FallStrike],
    robot: Robot,
    selections: Sequence[Selection],
    texts: Sequence[str],
    trace: Trace,
) -> tuple[dict[str, StrikeResult], dict[str, ShockError]]:
    """The landings of strikes by their names, and why others have none."""
    cases = {strike.name: (strike.scene, robot) for strike in strikes}
    if len(cases) < len(strikes):
        raise StudyError("two falls have one name; give each posture and heading once")
    free = proven_profiles(_with_joints(cases, "free"), selections, trace)
    driven = proven_profiles(cases, selections, trace)
    locked = proven_profiles(_with_joints(cases, "locked"), selections, trace)

    # The landing itself is the one with drives; of the others only defects are told.
    refused: dict[str, ShockError] = {}
    for name, error in free.items():
        if isinstance(error, DefectError):
            refused[name] = error
    for name, error in driven.items():
        if isinstance(error, ShockError):
            refused[name] = error
    for name, error in locked.items():
        if isinstance(error, DefectError):
            refused[name] = error
    results: dict[str, StrikeResult] = {}
    for strike in strikes:
        name = strike.name
        profile = driven[name]
        if isinstance(profile, ShockError):
            continue
        landings = [free[name], profile, locked[name]]
        result = attempt(_result, strike, profile, texts, landings)
        if isinstance(result, ShockError):
            refused[name] = result
        else:
            results[name] = result
    return results, refused


def _with_joints(
    cases: Mapping[str, tuple[Scene, Robot]], model: Literal["free", "locked"]
) -> dict[str, tuple[Scene, Robot]]:
    """Landings with another joint model."""
    joints = Joints(model=model)
    return {name: (replace(scene, joints=joints), robot) for name, (scene, robot) in cases.items()}


def strikes_table(
    strikes: Sequence[FallStrike],
    results: Mapping[str, StrikeResult],
    refused: Mapping[str, ShockError],
    texts: Sequence[str],
) -> Table:
    """All strikes, with columns that tell them apart and the worst value of each quantity."""
    # What the fall says of a strike.
    columns: dict[str, np.ndarray] = {}
    columns["fall"] = np.array([strike.fall for strike in strikes])
    columns["number"] = np.array([strike.number for strike in strikes])
    columns["strike"] = np.array([strike.name for strike in strikes])
    for key in ("motion", "rate", "speed", "energy"):
        columns[key] = np.array([getattr(strike, key) for strike in strikes])
    columns["struck"] = np.array(["+".join(strike.struck) for strike in strikes])
    columns["struck links"] = np.array([strike.struck_text for strike in strikes])
    columns["rotation"] = np.degrees([strike.rotation for strike in strikes]).round(9)
    units = {"rotation": "deg", "rate": "rad/s", "speed": "m/s", "energy": "J", "stop after": "s"}

    # A strike that was refused keeps its row, so that the table has all strikes in their order.
    of_strikes = [results.get(strike.name) for strike in strikes]
    known = np.array([result is not None for result in of_strikes])
    computed = [result for result in of_strikes if result is not None]
    for text in texts:
        values = np.full(len(strikes), math.nan)
        values[known] = [result.values[text] for result in computed]
        places = np.full(len(strikes), None)
        places[known] = [result.places[text] or None for result in computed]
        columns[text] = values
        columns[f"{text} at"] = places
    # What the joints do changes the trunk's motion most, so that each joint model has a column.
    trunk = np.full((len(strikes), 3), math.nan)
    trunk[known] = [result.trunk for result in computed]
    for k, model in enumerate(("free", "with drives", "locked")):
        columns[f"trunk {model}"] = trunk[:, k]
        units[f"trunk {model}"] = "m/s"
    end_stops = np.full((len(strikes), 2), None)
    end_stops[known] = [result.stop or (None, None) for result in computed]
    columns["first at its stop"] = end_stops[:, 0]
    columns["stop after"] = end_stops[:, 1].astype(float)
    columns["proven"] = known
    # A defect with joints free or locked leaves the result with drives, and is no message.
    messages: dict[int, str] = {}
    for i, strike in enumerate(strikes):
        if strike.name in refused and strike.name not in results:
            messages[i] = str(refused[strike.name])
    return Table((), columns, messages, defects=tuple(traces(refused.values())), label_units=units)


def _trunk(profile: ShockProfile | ShockError) -> float:
    """|Δv| of the heaviest body's centre of mass [m/s]; NaN without a verdict.

    It is with friction where this is given.
    """
    if isinstance(profile, ShockError):
        return math.nan
    key = "shock_com" if profile.scene.friction is None else "shock_com_friction"
    heaviest = int(np.argmax(profile.robot.masses))
    return float(profile.value(key, "body")[heaviest]) * profile.v_in


def _result(
    strike: FallStrike,
    profile: ShockProfile,
    texts: Sequence[str],
    landings: Sequence[ShockProfile | ShockError],
) -> StrikeResult:
    """The result of a strike.

    Args: landings, the same with joints free, with drives and locked.
    """
    values: dict[str, float] = {}
    places: dict[str, str] = {}
    for text in texts:
        values[text], places[text] = _worst(profile, text)
    return StrikeResult(
        strike=strike,
        values=values,
        places=places,
        trunk=tuple(map(_trunk, landings)),
        stop=_first_end_stop(profile),
        profile=profile,
    )


def _worst(profile: ShockProfile, text: str) -> tuple[float, str]:
    """The worst value of a quantity, and where; NaN and no place where it has no value."""
    key, at, place = text.partition("@")
    if profile.scene.friction is None:
        key = key.removesuffix("_friction")  # as its remark says
    if select(key).quantity.scope.lacks(profile.landing):
        return math.nan, ""
    selection, where = selected(profile.landing, key + at + place)
    if not len(where):
        return math.nan, ""
    numbers = profile.numbers(selection, where)
    if not np.isfinite(numbers).any():
        return math.nan, ""
    k = int(np.argmax(selection.worse(numbers)))
    return float(numbers[k]), where[k].name


def _first_end_stop(profile: ShockProfile) -> tuple[str, float] | None:
    """The joint that first reaches a limit after a strike, and when [s].

    Only joints within their limits count.
    """
    key = "delta_qd" if profile.scene.friction is None else "delta_qd_friction"
    rates = profile.value(key, "joint").tolist()
    first: tuple[str, float] | None = None
    for place, rate in zip(profile.places("joint"), rates, strict=True):
        joint = profile.robot.joint(place.name)
        if joint.kind not in ("revolute", "prismatic") or abs(rate) <= 1e-9:
            continue
        low, high = joint.limits
        left = (high if rate > 0.0 else low) - joint.value(profile.q)
        if not (math.isfinite(left) and left * rate > 0.0 and abs(left) > LIMIT_SLACK):
            continue
        if first is None or left / rate < first[1]:
            first = joint.name, float(left / rate)
    return first
