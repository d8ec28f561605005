"""Figure 1 and Section 2: what the paper says of a single body."""

import math

import numpy as np

from shockpc.core.beam import centre_of_percussion, radius_of_percussion
from shockpc.paper.landings import along, changed, land, scene
from shockpc.paper.statement import Reading, Statement, outcomes
from shockpc.result import ShockProfile

__all__ = ["beam_statements"]

EXACT = 1e-12
"""What rounding may leave of a length or of a shock of order 1."""

STICKS_OBLIQUELY = (("x", "y", "z"), 45.0)

SLIDES = Reading(
    "the struck point",
    {
        "free along the beam, struck across it": (("z",), 0.0),
        "sticking, struck across": (("x", "y", "z"), 0.0),
        "sticking, struck at 45°": STICKS_OBLIQUELY,
    },
)
"""Eqs. 1 and 3 are derived for the first; the others are what a robot meets."""

ASKEW = Reading(
    "the strike",
    {
        "askew, at an edge of the tip": ((1.0, 0.04, 0.04), (0.3, 0.4, -1.0)),
        "in one plane with the beam": ((1.0, 0.0, 0.0), (0.3, 0.0, -1.0)),
    },
)
"""Where it is struck, over the length [1], and the velocity [m/s]."""

PLACES = Reading("beam B struck at", {"the tip": 1.0, "a third of the length": 1.0 / 3.0})


def beam_statements() -> tuple[Statement, ...]:
    """The statements, in the paper's order."""
    beam_a, beam_c, beam_d = (land(f"fig1_{letter}") for letter in "acd")
    length = _length(beam_a)
    percussion = float(beam_d.copc[0, 0]) / length
    return (
        Statement(
            1,
            "Figure 1, beam A",
            "a strike at the centre of mass gives a purely translational shock",
            "spread of the shock over the beam [1]",
            outcomes((), lambda: float(np.ptp(_shock(beam_a))), lambda x: x < EXACT and bool(beam_a.translates[0])),
            "the beam turns",
        ),
        Statement(
            1,
            "Figure 1, beam C",
            "a strike at the CoPc of O leaves the slider without shock",
            "shock at O [1]",
            outcomes((), lambda: float(_shock(beam_c)[0]), lambda x: x < EXACT),
            "O moves",
        ),
        Statement(
            1,
            "Figure 1, beam B",
            "a strike anywhere else does not leave it without shock",
            "shock at O [1]",
            outcomes((PLACES,), lambda at: float(_shock(_struck(at))[0]), lambda x: x > EXACT),
            "O does not move",
        ),
        Statement(
            1,
            "Figure 1, beam D",
            "struck at O, no shock is produced at the CoPc: the two can be interchanged",
            "shock at 2/3 of the length [1]",
            outcomes((), lambda: float(_shock(beam_d, 2.0 / 3.0)[0]), lambda x: x < EXACT),
            "that point moves",
        ),
        Statement(
            1,
            "Eq. 1",
            "for a slender uniform beam p = 2/3 l",
            "CoPc for a strike at O, as a share of the length [1]",
            outcomes((), lambda: percussion, lambda x: abs(x - centre_of_percussion(0.5, 1.0 / math.sqrt(12.0))) < EXACT),
            "the CoPc lies elsewhere",
        ),
        Statement(
            1,
            "Section 2.1",
            "pivot and CoPc lie on opposite sides of the centre of mass",
            "product of their distances from it, over r_g² [1]; below 0 if they do",
            outcomes((), lambda: -6.0 * (percussion - 0.5), lambda x: x < 0.0),
            "they lie on one side",
        ),
        Statement(
            1,
            "Section 2.1",
            "the magnitude of the strike is irrelevant",
            "change of CoPc and RoPc for a strike a thousand times as fast [m]",
            outcomes((), _change_with_speed, lambda x: x < EXACT),
            "they move",
        ),
        Statement(
            1,
            "Section 2.1",
            "in space there is an axis of minimum, but not zero, shock",
            "shock on the axis of the jump's screw [1]",
            outcomes((ASKEW,), lambda how: _least_in_space(*how), lambda x: x > EXACT),
            "a jump in a plane is a pure rotation, whose axis feels nothing",
        ),
        Statement(
            1,
            "Eq. 2",
            "shock grows in proportion to the distance from the CoPc, Δ|ṽ| = r / r_p",
            "greatest deviation over beams B to D [1]",
            outcomes((), lambda: max(_deviation(f"fig1_{letter}") for letter in "bcd"), lambda x: x < EXACT),
            "it does not",
        ),
        Statement(
            1,
            "Eq. 3",
            "r_p = |d + r_g²/d|, d the distance of the centre of mass from the line of the strike",
            "greatest deviation for strikes at O, at 1/3, 2/3 and the tip, over the length [1]",
            outcomes((SLIDES,), lambda how: _eq_3(*how), lambda x: x < EXACT),
            "a contact that sticks stops the beam along itself too, which turns the line of the impulse away from the strike's "
            f"(struck at O at 45°: r_p is {_ropc(0.0, *STICKS_OBLIQUELY):.3f} l, Eq. 3 gives {_eq_3_radius(0.0, 45.0):.3f} l)",
        ),
        Statement(
            1,
            "Figure 1",
            "r_p = p for beams B, C and D",
            "greatest deviation from 2/3 of the length [1]",
            outcomes(
                (PLACES,),
                lambda at: max(abs(_struck(x).ropc[0] / length - percussion) for x in (at, 2.0 / 3.0, 0.0)),
                lambda x: x < EXACT,
            ),
            "they differ",
        ),
        Statement(
            1,
            "Eq. 12",
            "r_p = v_in / Δω_z",
            "least r_p over beams B to D [m]",
            outcomes((), lambda: _least_radius(absolute=False), lambda x: x > 0.0),
            "a radius comes out negative wherever the body turns clockwise; it lacks the absolute value, with which the least is "
            f"{_least_radius(absolute=True):.3f} m",
        ),
    )


def _length(profile: ShockProfile) -> float:
    """From O to the tip [m]."""
    return float(profile.robot.frame("tip").offset[0])


def _shock(profile: ShockProfile, *at: float) -> np.ndarray:
    """Shock at shares of the length, or at many points along it [1]."""
    tip = np.array([_length(profile), 0.0, 0.0])
    if at:
        return profile.shock_at("beam", np.array(at)[:, None] * tip)
    return along(profile, "beam", (np.zeros(3), tip))


def _struck(at: float, directions: tuple[str, ...] = ("z",), angle: float = 0.0) -> ShockProfile:
    """The beam struck at a share of its length."""
    found = scene("fig1_d")
    offset = (at * _length(land(found)), 0.0, 0.0)
    strike = {"speed": 1.0, "strike_angle_deg": angle}
    return land(changed(found, strike=strike, contact={"frame": "pivot", "offset": offset, "directions": directions}))


def _ropc(at: float, directions: tuple[str, ...], angle: float) -> float:
    """Radius of percussion over the length [1]."""
    profile = _struck(at, directions, angle)
    return float(profile.ropc[0]) / _length(profile)


def _eq_3(directions: tuple[str, ...], angle: float) -> float:
    """How far Eq. 3 is off [1]."""
    return max(abs(_ropc(at, directions, angle) - _eq_3_radius(at, angle)) for at in (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0))


def _eq_3_radius(at: float, angle: float) -> float:
    """What Eq. 3 gives for a strike at a share of the length, that many degrees from across the beam, over the length [1]."""
    return radius_of_percussion(abs(at - 0.5) * math.cos(math.radians(angle)), 1.0 / math.sqrt(12.0))


def _change_with_speed() -> float:
    """Largest change of a CoPc or RoPc [m]."""
    found = [scene(f"fig1_{letter}") for letter in "bcd"]
    pairs = [(land(one), land(changed(one, strike={"speed": 1000.0, "strike_angle_deg": 0.0}))) for one in found]
    return max(float(np.abs([*(a.copc - b.copc).ravel(), *(a.ropc - b.ropc)]).max()) for a, b in pairs)


def _least_in_space(at: tuple[float, float, float], velocity: tuple[float, float, float]) -> float:
    """Shock on the axis of the screw, where no point has less [1]."""
    found = scene("fig1_d")
    offset = tuple(_length(land(found)) * x for x in at)
    contact = {"frame": "pivot", "offset": offset, "directions": ("x", "y", "z")}
    profile = land(changed(found, strike={"velocity": velocity}, contact=contact))
    omega, v = profile.delta_omega[0], profile.delta_v[0]
    return float(profile.shock_at("beam", np.cross(omega, v) / (omega @ omega)))


def _deviation(stem: str) -> float:
    """How far shock along the beam is from r / r_p [1]."""
    profile = land(stem)
    x = np.linspace(0.0, _length(profile), 41)
    return float(np.abs(_shock(profile) - np.abs(x - profile.copc[0, 0]) / profile.ropc[0]).max())


def _least_radius(absolute: bool) -> float:
    """Eq. 12 with Δω about the paper's z, which is the plane's normal here."""
    radii = []
    for letter in "bcd":
        profile = land(f"fig1_{letter}")
        turn = float(profile.delta_omega[0] @ (profile.plane.normal @ profile.rotation[0]))
        radii.append(profile.v_in / (abs(turn) if absolute else turn))
    return min(radii)
