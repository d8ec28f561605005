"""What the paper says of Figures 2 and 4, and of chains in general."""

import math

import numpy as np

from shockpc.paper.landings import changed, land, scene
from shockpc.paper.leg import ANGLE_ABC, ANGLE_EF, BODIES, FOOT, LOWER_LEG, case, cases, ends, greatest, lower_leg_centre, segment
from shockpc.paper.statement import Reading, Statement, outcomes
from shockpc.paper.upper_bodies import torso_statements, upper_bodies_statements
from shockpc.result import ShockProfile

__all__ = ["leg_statements", "reductions"]

EXACT = 1e-11
BAND = 0.25
"""A change of shock that the colours of a figure hardly show [1]."""

ANGLE_CD = Reading("strike angle of C and D", {f"{angle}°": float(angle) for angle in (75, 80, 60, 45, 30, 15, 0)})
STRUCK_ACROSS = Reading("the strike", {"along the foot's normal": 0.0, "15° from it": 15.0, "45° from it": 45.0})
CASE = Reading("strike of case", {"A (15°)": 15.0, "B (45°)": 45.0, "C (75°)": 75.0})
HEEL = Reading("the foot", {"reaches beyond the ankle by half its length": "0.1", "ends at the ankle, as in the paper": "0"})


def leg_statements() -> tuple[Statement, ...]:
    """The statements, in the paper's order."""
    return (
        Statement(
            2,
            "Section 3.4",
            "when the robot moves forward, the CoPc of the struck lower leg lies on its front side",
            "least distance of the CoPc in front of the lower leg's line, cases A to E, over its length [1]",
            outcomes(
                (LOWER_LEG, ANGLE_ABC, ANGLE_EF),
                lambda *how: min(lower_leg_centre(p)[0] for p in cases(*how)[:5]),
                lambda x: x > 0.0,
            ),
            "a strike flatter than across the lower leg puts it behind",
        ),
        *upper_bodies_statements(),
        Statement(
            2,
            "Section 3.4",
            "shock can be kept from spreading altogether; the CoPc then coincides with the next joint",
            "greatest shock above the foot; leg upright, foot level, part of the foot's mass behind the ankle [1]",
            outcomes((HEEL, STRUCK_ACROSS), _spread, lambda x: x < EXACT),
            "it asks for mass beyond the ankle and for one strike direction, as the paper says itself",
        ),
        Statement(
            2,
            "Section 3.4",
            "two slender bodies hinged perpendicularly can each mitigate one component of the shock",
            "greatest shock of the lower leg in case F, leg upright and foot level, over that without foot [1]",
            outcomes((STRUCK_ACROSS,), _one_component, lambda x: x < 0.5),
            "what is along the foot passes it whole",
        ),
        Statement(
            2,
            "Section 3.4",
            "for the body at the end of the chain, the CoPc lies at 2/3 of a slender body",
            "greatest deviation along the body, cases A to F, over its length [1]",
            outcomes(
                (LOWER_LEG, ANGLE_ABC, ANGLE_EF, FOOT), lambda *how: max(map(_end_of_chain, cases(*how))), lambda x: x < EXACT
            ),
            "it lies elsewhere",
        ),
        Statement(
            2,
            "Section 4.1, C against D",
            "the torso hardly changes the shock of the legs",
            "greatest change of shock on the legs' middle lines [1]; below 0.25, a band of the colours",
            outcomes((ANGLE_CD, LOWER_LEG), _torso_changes, lambda x: x < BAND),
            "a steeper strike goes up the leg, and then the torso's mass counts",
        ),
        Statement(
            2,
            "Section 4.1, A to C",
            "flattening the impact brings the CoPc of the lower leg closer to the body",
            "greatest ratio of its distance from the body to that in the steeper case before [1]",
            outcomes((LOWER_LEG, ANGLE_ABC), lambda leg, angles: _approach(cases(leg, angles, 15.0)), lambda x: x < 1.0),
            "once the CoPc is a fifth of the leg away, a still flatter strike moves it off again",
        ),
        Statement(
            2,
            "Section 4.1, E against F",
            "the foot reduces shock by more than 80 % in every link",
            "least reduction of the greatest shock of lower leg, upper leg and torso [%]",
            outcomes((ANGLE_EF, LOWER_LEG, FOOT), lambda *how: min(reductions(*how).values()), lambda x: x > 80.0),
            "only what strikes along the foot's normal is kept from the lower leg; what is along the foot passes it",
        ),
        Statement(
            2,
            "Footnote 4",
            "the vertical impulse exceeds the horizontal one, so nothing slips at a friction coefficient of 1",
            "greatest coefficient of friction needed, cases A to F [1]",
            outcomes((LOWER_LEG, ANGLE_ABC, ANGLE_EF, FOOT), lambda *how: max(map(_friction, cases(*how))), lambda x: x < 1.0),
            "flat strikes on a slanting lower leg, and a foot whose normal is far from the strike, need more",
        ),
        Statement(
            4,
            "Figure 4",
            "moving the IMU from the middle of the lower leg forward and down lowers its shock",
            "shock a tenth of the leg further forward and down, over that in the middle [1]",
            outcomes((CASE, LOWER_LEG), lambda strike, leg: _moved_imu(case("A", strike, leg)), lambda x: x < 1.0),
            "a flat strike has its CoPc above the middle of the lower leg, so that moving down leads away from it",
        ),
        *torso_statements(),
    )


def reductions(strike: float, lower_leg: float, ankle: float) -> dict[str, float]:
    """By how much case F lowers the greatest shock of every link of case E [%]."""
    without, with_ = case("E", strike, lower_leg), case("F", strike, lower_leg, ankle)
    return {body: 100.0 * (1.0 - greatest(with_, body) / greatest(without, body)) for body in BODIES}


def _end_of_chain(profile: ShockProfile) -> float:
    """How far the last body's CoPc is from 2/3 of its length, along it [1]."""
    last = "torso" if "torso" in profile.bodies else "upper_leg"
    low, high = ends(profile.robot, last)
    centre = float(profile.copc[profile.bodies.index(last), 2])
    # From the joint below to the free end: an upper leg without a torso ends at the hip.
    joint, tip = low[2], high[2]
    return abs(float((centre - joint) / (tip - joint)) - 2.0 / 3.0)


def _upright(foot: bool, strike: float, heel: str = "0") -> ShockProfile:
    """Leg upright with a level foot, or without a foot, under torso and upper leg as in the figure."""
    found = scene("fig2_f" if foot else "fig2_e")
    joints = {"knee": -15.0, **({"ankle": 90.0} if foot else {})}
    xacro = {"heel": heel} if foot else {}
    return land(changed(found, joints_deg=joints, strike={"speed": 1.0, "strike_angle_deg": strike}, xacro=xacro))


def _spread(heel: str, strike: float) -> float:
    """Greatest shock above the foot."""
    profile = _upright(True, strike, heel)
    return max(greatest(profile, body) for body in BODIES)


def _one_component(strike: float) -> float:
    """What is left of the lower leg's shock."""
    return greatest(_upright(True, strike), "lower_leg") / greatest(_upright(False, strike), "lower_leg")


def _torso_changes(strike: float, lower_leg: float) -> float:
    """Greatest change of shock over the legs from C to D."""
    without, with_ = case("C", strike, lower_leg), case("D", strike, lower_leg)
    share = np.linspace(0.0, 1.0, 41)[:, None]
    change = []
    for body in ("lower_leg", "upper_leg"):
        low, high = ends(without.robot, body)
        points = (1.0 - share) * low + share * high
        change.append(float(np.abs(with_.shock_at(body, points) - without.shock_at(body, points)).max()))
    return max(change)


def _approach(cases: list[ShockProfile]) -> float:
    """From A to B and from B to C, the greater ratio of distances."""
    a, b, c = (lower_leg_centre(profile)[1] for profile in cases[:3])
    return max(b / a, c / b)


def _friction(profile: ShockProfile) -> float:
    """Coefficient of friction that the contact needs; infinite where the ground would have to pull."""
    needed = profile.contacts[0].friction_needed
    return math.inf if needed is None else needed


def _moved_imu(profile: ShockProfile) -> float:
    """Shock at the new place over that at the old one."""
    length = segment(profile.robot)
    middle = np.array([0.0, 0.0, -0.5 * length])
    moved = middle + 0.1 * length * np.array([1.0, 0.0, -1.0])
    return float(profile.shock_at("lower_leg", moved) / profile.shock_at("lower_leg", middle))
