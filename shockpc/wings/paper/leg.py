"""Claims of Figures 2 and 4 and Sections 3.4 and 5, about the human leg and chains of bodies."""

import functools
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from shockpc import ShockProfile, Strike
from shockpc.wings.paper.claim import ROUNDING, Options, Panel, PaperFigure
from shockpc.wings.paper.panel_landings import land, largest, middle_lines, shock_along
from shockpc.wings.paper.quadruped import ANGLES, quadruped

OPEN: Options = {
    "lower leg at −15°": {"lower_leg": -15.0},
    "A, B and C struck at 0°, 30° and 60°": {"strikes": (0.0, 30.0, 60.0)},
    "E and F struck at 45°": {"steep": 45.0},
    "ankle's 75° counted from the line of the lower leg": {"ankle": 75.0},
}
"""Other values of what the text leaves open, each as arguments of `cases`."""

LEG = PaperFigure(
    2,
    "a human leg",
    "The text gives neither the strike angles nor the angle of the lower leg; the scene files "
    "state the values chosen here.",
    (
        Panel("A", "fig2_a", "walking"),
        Panel("B", "fig2_b", "running"),
        Panel("C", "fig2_c", "climbing stairs"),
        Panel("D", "fig2_d", "C with a torso"),
        Panel("E", "fig2_e", "steep, with a torso"),
        Panel("F", "fig2_f", "E with a foot"),
    ),
)
chain = functools.partial(LEG.claim, interpretation="cases A to F as drawn", options=OPEN)
level = functools.partial(
    LEG.claim, interpretation="leg upright, foot level and struck along its normal"
)


@functools.cache
def cases(
    lower_leg: float = 0.0,
    strikes: tuple[float, float, float] = (15.0, 45.0, 75.0),
    steep: float = 15.0,
    ankle: float = 105.0,
) -> tuple[ShockProfile, ...]:
    """Cases A to F of Figure 2.

    Args:
        lower_leg: angle of the lower leg from the vertical, counter-clockwise [deg].
        strikes: strike angles of A, B, and of C and D [deg].
        steep: strike angle of E and F [deg].
        ankle: angle of the foot from the line of the lower leg [deg].
    """
    profiles = []
    for letter, angle in zip("abcdef", (*strikes, strikes[2], steep, steep), strict=True):
        # the upper leg is at 15 degrees
        joints = {"knee": lower_leg - 15.0} | ({"ankle": ankle} if letter == "f" else {})
        profiles.append(land(f"fig2_{letter}", joints, strike=Strike(strike_angle_deg=angle)))
    return tuple(profiles)


def reductions(**how: Any) -> dict[str, float]:
    """Reduction by case F of the largest shock of each link of case E [%].

    The arguments are those of `cases`.
    """
    without, with_foot = map(largest, cases(**how)[4:])
    return {body: 100.0 * (1.0 - with_foot[body] / shock) for body, shock in without.items()}


def _lower_leg_centre(profile: ShockProfile) -> tuple[float, float]:
    """Distances of the lower leg's CoPc in front of its line, and from its nearest point.

    Both are divided by the lower leg's length [1].
    """
    front, _, height = profile.copc[profile.bodies.index("lower_leg")] / 0.4
    return float(front), math.hypot(front, max(height, -1.0 - height, 0.0))


def _shown(torso: bool = False, figure_5: Sequence[float] = (), **how: Any) -> list[ShockProfile]:
    """Cases A to F, or the quadruped at some angles of its legs; those with a torso, or all."""
    profiles = [quadruped(angle) for angle in figure_5] or cases(**how)
    return [profile for profile in profiles if "torso" in profile.bodies or not torso]


def _off_eq_1(profile: ShockProfile, body: str, in_plane: bool = False) -> float:
    """Distance of a CoPc from 2/3 of a body's middle line, over the body's length [1].

    It is measured along the line or in the plane.
    """
    low, high = middle_lines(profile)[body]
    axis = high - low
    off = profile.copc[profile.bodies.index(body)] - low - 2.0 / 3.0 * axis
    return float(
        np.linalg.norm(off) / np.linalg.norm(axis) if in_plane else abs(off @ axis) / (axis @ axis)
    )


@chain(
    "Section 3.4: when the robot moves forward, the CoPc of the struck lower leg lies on its front "
    "side",
    "smallest distance of the CoPc in front of the lower leg, over its length [1]",
    above=ROUNDING,
    interpretation="cases A to E as drawn",
)
def _in_front(**how: Any) -> float:
    return min(_lower_leg_centre(profile)[0] for profile in cases(**how)[:5])


@chain(
    "Section 3.4: upper bodies are generally subject to less shock",
    "largest ratio of the shock at a body's centre of mass to that of the body below [1]",
    below=1.0 - ROUNDING,
    options=OPEN
    | {
        "largest shock on the middle line of a body": {"on_line": True},
        "Figure 5 at 0°": {"figure_5": (0.0,)},
    },
)
def _rise(on_line: bool = False, **how: Any) -> float:
    ratios: list[float] = []
    for profile in _shown(**how):
        shock = largest(profile)
        if not on_line:
            at_com = dict(zip(profile.bodies, map(float, profile.shock_com), strict=True))
            shock = {body: at_com[body] for body in shock}
        ratios += [upper / lower for lower, upper in itertools.pairwise(shock.values())]
    return max(ratios)


@chain(
    "Section 3.4: the CoPc of a body tends to move toward the next joint in the chain",
    "largest distance of the CoPc from the joint above over that from the joint below [1]",
    below=1.0 - ROUNDING,
    interpretation="upper leg, cases D to F as drawn",
    options=OPEN
    | {
        "lower leg": {"body": "lower_leg"},
        "Figure 5 at 0°": {"body": "hind_upper_leg", "figure_5": (0.0,)},
    },
)
def _nearer(body: str = "upper_leg", **how: Any) -> float:
    # By Eq. 2 the ratio of the distances is that of the shocks there.
    ratios = []
    for profile in _shown(torso=True, **how):
        lower, upper = shock_along(profile, body, 2)
        ratios.append(float(upper / lower))
    return max(ratios)


@level(
    "Section 3.4: a design can eliminate further propagation of shock; the CoPc then coincides "
    "with the next joint",
    "largest shock above the foot, a third of which lies behind the ankle [1]",
    below=ROUNDING,
    options={
        "foot ends at the ankle": {"heel": "0"},
        "struck 15° from the normal": {"strike": 15.0},
    },
)
def _above_foot(heel: str = "0.1", strike: float = 0.0) -> float:
    _, *above = largest(
        land(cases(steep=strike, ankle=90.0)[5].scene, xacro={"heel": heel})
    ).values()
    return max(above)


@level(
    "Section 3.4: two slender bodies hinged perpendicularly can each mitigate one translational "
    "component of the shock",
    "largest shock of the lower leg over that without the foot [1]",
    below=0.5,
    options={"struck 45° from the normal": {"strike": 45.0}},
)
def _one_component(strike: float = 0.0) -> float:
    return 1.0 - reductions(steep=strike, ankle=90.0)["lower_leg"] / 100.0


@chain(
    "Section 3.4: for a body at the end of the chain, the CoPc lies at 2/3 of a slender body",
    "largest deviation along the body, over its length [1]",
    below=ROUNDING,
)
def _at_the_end(**how: Any) -> float:
    return max(_off_eq_1(profile, list(middle_lines(profile))[-1]) for profile in cases(**how))


@LEG.claim(
    "Section 4.1: the effect of the torso on the shock of the legs is minimal (C against D)",
    "largest change of shock on the middle lines of the legs [1]",
    below=0.25,
    interpretation="both struck at 75°; 0.25 is one step of the colour scale",
    options={"both struck at 45°": {"strike": 45.0}, "both struck at 15°": {"strike": 15.0}},
)
def _torso_changes(strike: float = 75.0) -> float:
    c, d = cases(strikes=(15.0, 45.0, strike))[2:4]
    return max(
        float(np.abs(shock_along(d, body) - shock_along(c, body)).max()) for body in middle_lines(c)
    )


@chain(
    "Section 4.1: flattening the impact brings the CoPc of the lower leg closer to the body "
    "(A to C)",
    "largest ratio of its distance from the body to that in the case before [1]",
    below=1.0,
)
def _approach(**how: Any) -> float:
    distances = [_lower_leg_centre(profile)[1] for profile in cases(**how)[:3]]
    return max(after / before for before, after in itertools.pairwise(distances))


@chain(
    "Section 4.1: the foot reduces the shock of all links by more than 80 % (E against F)",
    "smallest reduction of the largest shock on a link [%]",
    above=80.0,
    interpretation="both struck at 15°, lower leg vertical, ankle's 75° counted from the knee",
)
def _least_reduction(**how: Any) -> float:
    return min(reductions(**how).values())


@chain(
    "Footnote 4: the vertical impulse exceeds the horizontal one, so nothing slips at a friction "
    "coefficient of 1",
    "largest friction coefficient that a contact needs [1]",
    below=1.0,
)
def _friction(**how: Any) -> float:
    # None where the ground would have to pull.
    needed = [profile.contacts[0].friction_needed for profile in cases(**how)]
    return max(math.inf if friction is None else friction for friction in needed)


@LEG.claim(
    "Figure 4: moving the IMU from the middle of the lower leg forward and down lowers its shock",
    "shock at the new place over that at the old one [1]",
    below=1.0,
    interpretation="case A; moved by a tenth of the length both ways",
    options={"case B": {"case": 1}, "case C": {"case": 2}},
)
def _moved_imu(case: int = 0) -> float:
    old, new = cases()[case].shock_at(
        "lower_leg", 0.4 * np.array([[0.0, 0.0, -0.5], [0.1, 0.0, -0.6]])
    )
    return float(new / old)


@chain(
    "Section 5: the torso is well described by Eq. 1",
    "largest distance of its CoPc from 2/3 of the length, over the length [1]",
    below=0.05,
    interpretation="distance along the torso, cases D to F as drawn",
    options=OPEN | {"distance in the plane": {"in_plane": True}, "Figure 5": {"figure_5": ANGLES}},
)
def _torso_by_eq_1(in_plane: bool = False, **how: Any) -> float:
    return max(_off_eq_1(profile, "torso", in_plane) for profile in _shown(torso=True, **how))


@chain(
    "Section 5: sensitive equipment is generally best placed above the torso's centre of mass, but "
    "below its top",
    "largest distance of the place of minimum shock from 3/4 of the torso, over its length [1]",
    below=0.25,
    interpretation="cases D to F as drawn",
    options=OPEN | {"Figure 5": {"figure_5": ANGLES}},
)
def _off_three_quarters(**how: Any) -> float:
    places = [
        float(np.argmin(shock_along(profile, "torso", 121))) / 120.0
        for profile in _shown(torso=True, **how)
    ]
    return max(abs(place - 0.75) for place in places)
