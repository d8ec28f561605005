"""Figure 1 and Section 2: the claims about a single body."""

import functools
import math
from typing import Any

import numpy as np

from shockpc import ShockProfile, Strike
from shockpc.wings.paper.claim import ROUNDING, Panel, PaperFigure
from shockpc.wings.paper.panel_landings import land, shock_along

BEAM = PaperFigure(
    1,
    "a slender beam on a slider",
    "The pivot O is the left end. The text does not give the impact point of B; Eq. 3 allows the "
    "tip or a third of the length.",
    (
        Panel("A", "fig1_a", "at the centre of mass"),
        Panel("B", "fig1_b", "elsewhere: the tip"),
        Panel("C", "fig1_c", "at 2/3, the CoPc of O"),
        Panel("D", "fig1_d", "at the pivot O"),
    ),
)
SLIDER = (
    "free beam; the contact stops its point across the beam and slides along it, like a massless "
    "slider"
)
ELSEWHERE = (
    "impact at the tip; the text gives no place, and a third of the length has the same RoPc"
)
zero = functools.partial(BEAM.claim, below=ROUNDING, interpretation=SLIDER)

C, R_G2 = 0.5, 1.0 / 12.0
"""Distance of the centre of mass from O [m], and squared radius of gyration [m²].

The beam is 1 m long.
"""

STICKING = ("x", "y", "z")


def beam(*at: float, directions: tuple[str, ...] = ("z",), **strike: Any) -> ShockProfile:
    """The landing of the beam of Figure 1 on a point.

    The point (3,) is from O [m]; coordinates that are left out are zero.
    """
    return land(
        "fig1_d",
        contact={"offset": (*at, 0.0, 0.0)[:3], "directions": directions},
        strike=Strike(**strike),
    )


def _turning(**changes: Any) -> list[ShockProfile]:
    return [land(f"fig1_{letter}", **changes) for letter in "bcd"]


def _shock(letter: str, thirds: int = 0) -> float:
    """Shock of a beam of Figure 1 at a number of thirds of its length from O [1]."""
    return float(shock_along(land(f"fig1_{letter}"), "beam", 4)[thirds])


def _percussion() -> float:
    """Distance of the CoPc from O for an impact at O [m]."""
    return float(land("fig1_d").copc[0, 0])


@zero(
    "Figure 1, beam A: an impact at the centre of mass causes a purely translational shock",
    "range of the shock over the beam [1]",
)
def _a() -> float:
    return float(np.ptp(shock_along(land("fig1_a"), "beam")))


@zero(
    "Figure 1, beam C: an impact at the CoPc of O causes no shock at the slider", "shock at O [1]"
)
def _c() -> float:
    return _shock("c")


@BEAM.claim(
    "Figure 1, beam B: an impact anywhere else causes a shock at the slider",
    "shock at O [1]",
    above=ROUNDING,
    interpretation=ELSEWHERE,
)
def _b() -> float:
    return _shock("b")


@zero(
    "Figure 1, beam D: an impact at O causes no shock at the CoPc: the two points can be "
    "interchanged",
    "shock at 2/3 of the length [1]",
)
def _d() -> float:
    return _shock("d", 2)


@zero(
    "Eq. 1: c (p − c) = r_g²: p = 2/3 l for a slender uniform beam",
    "deviation of p, the distance of the CoPc from O for an impact at O, over the length [1]",
)
def _eq_1() -> float:
    return abs(_percussion() - (C + R_G2 / C))


@BEAM.claim(
    "Section 2.1: pivot and CoPc lie on opposite sides of the centre of mass",
    "product of their signed distances from it, over r_g² [1]",
    below=0.0,
    interpretation="impact at O",
)
def _opposite_sides() -> float:
    return -C * (_percussion() - C) / R_G2


@zero(
    "Section 2.1: the magnitude of the applied impulse is irrelevant",
    "largest change of CoPc and RoPc [m]",
    interpretation="beams B to D at 1000 m/s instead of 1 m/s",
)
def _change_with_speed() -> float:
    pairs = zip(_turning(), _turning(strike=Strike(speed=1000.0)), strict=True)
    return max(
        float(np.abs([*(a.copc - b.copc).ravel(), *(a.ropc - b.ropc)]).max()) for a, b in pairs
    )


@BEAM.claim(
    "Section 2.1: in 3D there is an axis of minimum, but not zero, shock",
    "shock on the screw axis of the velocity change [1]",
    above=ROUNDING,
    interpretation="impact at an edge of the tip, oblique in space",
    options={"impact in a plane with the beam": {"at": (1.0,), "velocity": (0.3, 0.0, -1.0)}},
)
def _on_screw_axis(
    at: tuple[float, ...] = (1.0, 0.04, 0.04), velocity: tuple[float, ...] = (0.3, 0.4, -1.0)
) -> float:
    profile = beam(*at, velocity=velocity, directions=STICKING)
    omega, v = profile.delta_omega[0], profile.delta_v[0]
    return float(profile.shock_at("beam", np.cross(omega, v) / (omega @ omega)))


@zero(
    "Eq. 2: shock is proportional to the distance from the CoPc: Δ|ṽ| = r / r_p",
    "largest deviation [1]",
    interpretation="beams B to D, 41 points each",
)
def _off_eq_2() -> float:
    x = np.linspace(0.0, 1.0, 41)
    return max(
        float(np.abs(shock_along(p, "beam") - np.abs(x - p.copc[0, 0]) / p.ropc[0]).max())
        for p in _turning()
    )


@zero(
    "Eq. 3: r_p = |d + r_g² / d|, d the distance of the centre of mass from the line of the impact",
    "largest deviation for impacts at O, 1/3, 2/3 and the tip, over the length [1]",
    interpretation="impact across the beam; the contact slides along it",
    options={
        "sticking contact, impact 45° from across the beam": {"directions": STICKING, "angle": 45.0}
    },
)
def _off_eq_3(directions: tuple[str, ...] = ("z",), angle: float = 0.0) -> float:
    off = []
    for at in (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0):
        d = (at - C) * math.cos(math.radians(angle))
        off.append(
            float(beam(at, directions=directions, strike_angle_deg=angle).ropc[0])
            - abs(d + R_G2 / d)
        )
    return max(map(abs, off))


@zero("Figure 1: r_p = p for beams B, C and D", "largest deviation, over the length [1]")
def _same_radius() -> float:
    return max(abs(float(p.ropc[0]) - _percussion()) for p in _turning())


@BEAM.claim(
    "Eq. 12: r_p = v_in / Δω_z is a radius, so it is positive",
    "smallest r_p of beams B to D [m]",
    above=0.0,
    interpretation="as printed",
    options={"with the absolute value of Δω_z": {"absolute": True}},
)
def _eq_12(absolute: bool = False) -> float:
    turns = [
        float(p.delta_omega[0] @ (p.plane.normal @ p.rotation[0])) / p.v_in for p in _turning()
    ]
    return min(1.0 / (abs(turn) if absolute else turn) for turn in turns)
