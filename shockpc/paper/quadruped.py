"""Figure 5: what the paper says of the quadruped, for every way to turn its knees and its torso."""

import dataclasses
import functools
import itertools

import numpy as np

from shockpc.core.spatial import Array
from shockpc.model.joint_model import Joints
from shockpc.paper.landings import changed, land, line_shock, scene
from shockpc.paper.statement import Reading, Statement, outcomes
from shockpc.result import ShockProfile

__all__ = ["ANGLES", "quadruped", "quadruped_lines", "quadruped_statements"]

NOSE = Reading("the torso's 15°", {"nose up": 15.0, "nose down": -15.0})
HIND = Reading("the hind knee", {"forward": 1.0, "backward": -1.0})
FRONT = Reading("the front knee", {"backward": -1.0, "forward": 1.0})
ANGLES = (0.0, 10.0, 20.0, 30.0)
SHOWN = Reading("leg segments at", {f"{angle:g}°": angle for angle in (10.0, 0.0, 20.0, 30.0)})
FREE = 0.25
"""Below this a body is called relatively free of shock [1]: no part of it leaves the two lightest colours."""

DRIVES = Reading(
    "the drives",
    {
        "geared (0.05 kg m²)": Joints(armature={"*": 0.05}),
        "geared (0.005 kg m²)": Joints(armature={"*": 0.005}),
        "locked": Joints(model="locked"),
    },
)
BENT = Reading("leg segments at", {f"{angle:g}°": angle for angle in (30.0, 20.0, 10.0, 0.0)})
NOTICED = 0.05
"""A share of the shock of a place above which something matters to it [1]."""


def quadruped_statements() -> tuple[Statement, ...]:
    """The statements, in the paper's order."""
    ways = (HIND, NOSE, FRONT)
    return (
        Statement(
            5,
            "Section 4.3",
            "the torso is relatively free of shock",
            "greatest shock on the torso's middle line [1]; below 0.25, the two lightest colours",
            outcomes((BENT, *ways), _torso, lambda x: x < FREE),
            "straight legs pass the strike on, as the paper says itself",
        ),
        Statement(
            5,
            "Section 4.3",
            "this changes as the legs approach a singular configuration",
            "least ratio of the torso's greatest shock to that with legs bent by 10° more [1]",
            outcomes(
                ways,
                lambda *how: min(_torso(a, *how) / _torso(b, *how) for a, b in itertools.pairwise(ANGLES)),
                lambda x: x > 1.0,
            ),
            "it does not grow",
        ),
        Statement(
            5,
            "Section 4.3",
            "the CoPc of the torso moves towards the front as the legs are stretched",
            "least step forward on the page from one panel to the next, over the torso's length [1]",
            outcomes(ways, _step_forward, lambda x: x > 0.0),
            "it moves up or down from far away",
        ),
        Statement(
            5,
            "Section 4.3",
            "at 10° shock at the front of the torso is more than a factor of two lower than at the back",
            "shock at the back end over that at the front end [1]",
            outcomes((SHOWN, *ways), _back_to_front, lambda x: x > 2.0),
            "bent legs spare both ends alike",
        ),
        Statement(
            5,
            "Section 4.3",
            "the front leg does not significantly influence shock in the rest of the robot",
            "greatest change of shock when it is left out, over the shock there: both ends of the torso, hind leg [1]",
            outcomes(
                (Reading("at", {"the torso's front end": 1.0, "the torso's back end": -1.0, "the hind leg": 0.0}), SHOWN),
                _without_front,
                lambda x: x < NOTICED,
            ),
            "it hangs where the torso gives way most easily, so its mass counts there",
        ),
        Statement(
            5,
            "Section 3.1.2",
            "gearbox and rotor inertia will in most cases not have to be included",
            "greatest shock of the torso with them, over that without [1]; below 1.05",
            outcomes((BENT, DRIVES), _geared, lambda x: x < 1.0 + NOTICED),
            "what keeps shock from the torso is how easily the knee gives way; it holds only behind a series elasticity",
        ),
        Statement(
            5,
            "Section 4.3",
            "the pattern is mirrored when the robot lands on its front legs",
            "greatest difference of the torso's shock in the mirrored landing [1]",
            outcomes((SHOWN, *ways), _mirrored, lambda x: x < 1e-11),
            "it is not",
        ),
    )


@functools.cache
def quadruped(
    angle: float, hind: float = 1.0, nose: float = 15.0, front: float = -1.0, foot: str = "hind_foot", front_leg: bool = True
) -> ShockProfile:
    """The landing with leg segments at an angle from the vertical; the signs of the knees say which way they point."""
    joints = {"hind_hip": hind * angle - nose, "hind_knee": -2.0 * hind * angle}
    if front_leg:
        joints |= {"front_hip": front * angle - nose, "front_knee": -2.0 * front * angle}
    xacro = {"front": "true" if front_leg else "false"}
    contact = {"frame": foot}
    return land(changed(scene("fig5_00"), joints, base_pitch_deg=-nose, xacro=xacro, contact=contact))


def _half(profile: ShockProfile) -> Array:
    """From the torso's middle to its front end [m]."""
    i = profile.bodies.index("hind_upper_leg")
    torso = profile.bodies.index("torso")
    return np.array([float(np.linalg.norm(profile.position[i] - profile.position[torso])), 0.0, 0.0])


def quadruped_lines(profile: ShockProfile) -> dict[str, tuple[Array, Array]]:
    """The ends (3,) of the middle lines of torso and hind leg, in their bodies' frames [m], from the ground up."""
    length = np.array([0.0, 0.0, abs(float(profile.robot.frame("hind_foot").offset[2]))])
    leg = (-length, np.zeros(3))
    return {"hind_lower_leg": leg, "hind_upper_leg": leg, "torso": (-_half(profile), _half(profile))}


def _torso(angle: float, hind: float, nose: float, front: float) -> float:
    """Greatest shock on the torso [1]."""
    return _greatest(quadruped(angle, hind, nose, front))


def _greatest(profile: ShockProfile) -> float:
    return line_shock(profile, "torso", (-_half(profile), _half(profile)))


def _geared(angle: float, drives: Joints) -> float:
    """Greatest shock on the torso with drives that resist, over that with free ones."""
    free = quadruped(angle, 1.0, 15.0, -1.0)
    return _greatest(land(dataclasses.replace(free.scene, joints=drives))) / _greatest(free)


def _back_to_front(angle: float, hind: float, nose: float, front: float) -> float:
    """Shock at the back end of the torso over that at its front end [1]."""
    profile = quadruped(angle, hind, nose, front)
    back, ahead = profile.shock_at("torso", np.stack([-_half(profile), _half(profile)]))
    return float(back / ahead)


def _step_forward(hind: float, nose: float, front: float) -> float:
    """Least step of the torso's CoPc from bent to straight legs, along world x from the torso's middle."""
    places = []
    for angle in ANGLES[::-1]:
        profile = quadruped(angle, hind, nose, front)
        i = profile.bodies.index("torso")
        places.append(float(profile.copc_world[i, 0] - profile.position[i, 0]) / (2.0 * float(_half(profile)[0])))
    return min(b - a for a, b in itertools.pairwise(places))


def _without_front(place: float, angle: float) -> float:
    """Change of shock at a place when the front leg is left out, over the shock there."""
    with_, without = (quadruped(angle, 1.0, 15.0, -1.0, front_leg=leg) for leg in (True, False))
    if place:
        points = {"torso": place * _half(with_)[None]}
    else:
        length = abs(float(with_.robot.frame("hind_foot").offset[2]))
        line = np.linspace(0.0, -length, 21)[:, None] * np.array([0.0, 0.0, 1.0])
        points = {"hind_upper_leg": line, "hind_lower_leg": line}
    found = [(with_.shock_at(body, r), without.shock_at(body, r)) for body, r in points.items()]
    return max(float(np.abs(a - b).max() / a.max()) for a, b in found)


def _mirrored(angle: float, hind: float, nose: float, front: float) -> float:
    """The landing on the front leg of the robot turned about: what was behind is in front, and nose up is nose down."""
    one, other = quadruped(angle, hind, nose, front), quadruped(angle, -front, -nose, -hind, "front_foot")
    share = np.linspace(-1.0, 1.0, 21)[:, None]
    difference = one.shock_at("torso", share * _half(one)) - other.shock_at("torso", -share * _half(other))
    return float(np.abs(difference).max())
