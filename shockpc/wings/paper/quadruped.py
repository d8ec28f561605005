"""Figure 5: the claims about the quadruped."""

import functools
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from shockpc import Joints, ShockProfile
from shockpc.core.spatial import Array
from shockpc.wings.paper.claim import ROUNDING, Options, Panel, PaperFigure
from shockpc.wings.paper.panel_landings import land, shock_along

QUADRUPED = PaperFigure(
    5,
    "a quadruped on its hind leg",
    "The text does not give the directions of knees and torso; here the hind knee points forward "
    "and the nose is up.",
    (
        Panel("0°", "fig5_00", "straight legs"),
        Panel("10°", "fig5_10", "leg segments from the vertical"),
        Panel("20°", "fig5_20", "leg segments from the vertical"),
        Panel("30°", "fig5_30", "leg segments from the vertical"),
    ),
)

ANGLES = (0.0, 10.0, 20.0, 30.0)
"""Angles of the leg segments from the vertical [deg]."""

OPEN: Options = {
    "hind knee backward": {"hind": -1.0},
    "nose down": {"nose": -15.0},
    "hind knee backward, nose down": {"hind": -1.0, "nose": -15.0},
    "front knee forward": {"front": 1.0},
}
"""Other values of what the text leaves open, each as arguments of `quadruped`."""

drawn = functools.partial(
    QUADRUPED.claim,
    interpretation="hind knee forward, front knee backward, nose up, as drawn",
    options=OPEN,
)
PLACES = ("back end of the torso", "front end of the torso", "hind leg")


@functools.cache
def quadruped(
    angle: float,
    hind: float = 1.0,
    nose: float = 15.0,
    front: float = -1.0,
    foot: str = "hind_foot",
    front_leg: bool = True,
) -> ShockProfile:
    """The landing on one foot.

    Args:
        angle: of the leg segments from the vertical [deg].
        hind: 1 if the hind knee points forward, −1 if backward.
        nose: angle by which the front end of the torso is raised [deg].
        front: 1 if the front knee points forward, −1 if backward.
        foot: frame that strikes.
        front_leg: whether the robot has a front leg.
    """
    joints = {"hind_hip": hind * angle - nose, "hind_knee": -2.0 * hind * angle}
    if front_leg:
        joints |= {"front_hip": front * angle - nose, "front_knee": -2.0 * front * angle}
    return land(
        "fig5_00", joints, -nose, xacro={"front": str(front_leg).lower()}, contact={"frame": foot}
    )


def _torso(*angles: float, **how: Any) -> float:
    """Largest shock on the torso over landings at these angles [1]."""
    return max(float(shock_along(quadruped(angle, **how), "torso", 2).max()) for angle in angles)


@drawn(
    "Section 4.3: the torso is relatively free of shock",
    "largest shock on the middle line of the torso [1]",
    below=0.25,
    interpretation="legs bent by 20° and 30°; the paper itself excepts 10° and 0°",
    options=OPEN | {"legs bent by 10°": {"angles": (10.0,)}, "legs bent by 0°": {"angles": (0.0,)}},
)
def _free_of_shock(angles: Sequence[float] = (20.0, 30.0), **how: Any) -> float:
    return _torso(*angles, **how)


@drawn(
    "Section 4.3: this changes as the legs approach a singular configuration",
    "smallest ratio of the torso's largest shock to that with legs bent by 10° more [1]",
    above=1.0,
)
def _near_singular(**how: Any) -> float:
    return min(_torso(a, **how) / _torso(b, **how) for a, b in itertools.pairwise(ANGLES))


@drawn(
    "Section 4.3: the CoPc of the torso moves towards the front as the robot lands with more "
    "extended legs",
    "smallest step of the CoPc to the front from one panel to the next, over the torso's length "
    "[1]",
    above=0.0,
)
def _step_forward(**how: Any) -> float:
    profiles = [quadruped(angle, **how) for angle in reversed(ANGLES)]
    places = [
        float((p.copc_world - p.position)[p.bodies.index("torso"), 0]) / 0.8 for p in profiles
    ]
    return min(b - a for a, b in itertools.pairwise(places))


@drawn(
    "Section 4.3: at 10° the shock in the front side is more than a factor of two lower than in "
    "the back side",
    "shock at the back end of the torso over that at its front end [1]",
    above=2.0,
)
def _back_over_front(**how: Any) -> float:
    return float(np.divide(*shock_along(quadruped(10.0, **how), "torso", 2)))


@QUADRUPED.claim(
    "Section 4.3: the front leg does not significantly influence shock in the rest of the robot",
    "largest relative change of shock when the front leg is left out [1]",
    below=0.05,
    interpretation="both ends of the torso and the hind leg; a change of 5 % is an influence",
    options={place: {"places": (place,)} for place in PLACES},
)
def _without_front(places: Sequence[str] = PLACES) -> float:
    changes = []
    for angle in ANGLES:
        before = _shocks(quadruped(angle))
        after = _shocks(quadruped(angle, front_leg=False))
        for place in places:
            change = np.abs(before[place] - after[place]).max(-1)
            changes.append((change / before[place].max(-1)).max())
    return float(max(changes))


def _shocks(profile: ShockProfile) -> dict[str, Array]:
    """Shock at the `PLACES`: both ends of the torso, and 21 points of each link of the hind leg."""
    lower = shock_along(profile, "hind_lower_leg", 21)
    upper = shock_along(profile, "hind_upper_leg", 21)
    torso = shock_along(profile, "torso", 21)
    return dict(zip(PLACES, (torso[:1], torso[-1:], np.stack([lower, upper])), strict=True))


@QUADRUPED.claim(
    "Section 3.1.2: gearbox and rotor inertia will in most cases not have to be included",
    "largest shock of the torso over that with free joints [1]",
    below=1.05,
    interpretation=(
        "0.05 kg m² reflected at every joint, legs bent by 30°; a change of 5 % is an influence"
    ),
    options={
        "0.005 kg m² at every joint": {"armature": {"*": 0.005}},
        "joints locked": {"model": "locked"},
        "legs straight": {"angle": 0.0},
    },
)
def _geared(angle: float = 30.0, **joints: Any) -> float:
    free = quadruped(angle)
    resisting = land(free.scene, joints=Joints(**joints or {"armature": {"*": 0.05}}))
    return float(shock_along(resisting, "torso", 2).max() / shock_along(free, "torso", 2).max())


@drawn(
    "Section 4.3: the pattern is mirrored when the robot lands on its front legs",
    "largest difference of the torso's shock from the mirrored landing [1]",
    below=ROUNDING,
)
def _mirrored(hind: float = 1.0, nose: float = 15.0, front: float = -1.0) -> float:
    # Turned about on its front leg: hind becomes front, nose up nose down.
    differences = []
    for angle in ANGLES:
        landing = quadruped(angle, hind, nose, front)
        turned = quadruped(angle, -front, -nose, -hind, "front_foot")
        difference = shock_along(landing, "torso", 21) - shock_along(turned, "torso", 21)[::-1]
        differences.append(np.abs(difference).max())
    return float(max(differences))
