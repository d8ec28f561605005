"""A single planar body in closed form (shock paper, Eqs. 1–3): what every solver in this package is held against.

Eqs. 1 and 3 hold for a strike across the line from pivot to centre of mass that leaves the body free along it; a contact that
sticks under an oblique strike is another problem.
"""

import math

__all__ = ["centre_of_percussion", "radius_of_percussion", "shock"]


def centre_of_percussion(c: float, r_g: float) -> float:
    """Eq. 1: distance p of the centre of percussion from the pivot, c (p − c) = r_g².

    Args:
        c: distance of the centre of mass from the pivot [m], not zero.
        r_g: radius of gyration about the centre of mass [m].
    """
    return c + r_g**2 / c


def shock(r: float, r_p: float) -> float:
    """Eq. 2: shock relative to the strike at a distance r from the centre of percussion, r / r_p [1]."""
    return r / r_p


def radius_of_percussion(d: float, r_g: float) -> float:
    """Eq. 3: r_p = |d + r_g² / d|; infinite for a strike through the centre of mass.

    Args:
        d: distance of the centre of mass from the line of the strike [m].
        r_g: radius of gyration about the centre of mass [m].
    """
    return abs(d + r_g**2 / d) if d else math.inf
