"""Sections 3.4 and 5: what becomes of shock up a chain, and of the body at its top; over all figures that show chains."""

import itertools

import numpy as np

from shockpc.core.beam import centre_of_percussion
from shockpc.core.spatial import Array
from shockpc.paper.landings import along, land, line_shock
from shockpc.paper.leg import ANGLE_ABC, ANGLE_EF, BODIES, FOOT, LOWER_LEG, cases, ends
from shockpc.paper.quadruped import ANGLES, quadruped, quadruped_lines
from shockpc.paper.statement import Reading, Statement, outcomes
from shockpc.result import ShockProfile

__all__ = ["torso_statements", "upper_bodies_statements"]

LESS = 1.0 - 1e-9
"""Two bodies share a joint: where that is the place of most shock in both, their ratio is 1 but for rounding, and none has less."""

WELL = 0.05
"""A share of its length by which a point of a body may be off, and still be well described [1]."""

MEASURED = Reading("shock of a body", {"at its centre of mass": False, "the greatest on its middle line": True})
QUADRUPED: dict[str, object] = {f"Figure 5 at {angle:g}°": angle for angle in reversed(ANGLES)}
SHOWN = Reading("shown in", {"Figure 2": None, **QUADRUPED})
BODY = Reading("the body", {name: name.replace(" ", "_") for name in ("upper leg", "foot", "lower leg")})
TORSO = Reading("the torso of", {"Figure 2": None, "Figure 3": "fig3", **QUADRUPED})
EQ_1 = Reading("Eq. 1 taken for", {"where along the body its CoPc lies": 0, "where in the plane it lies": 1})
LEG = (LOWER_LEG, ANGLE_ABC, ANGLE_EF, FOOT)
"""What Figure 2 leaves open; the other figures have no use for it."""

AS_TAKEN = [next(iter(reading.options.values())) for reading in LEG]


def upper_bodies_statements() -> tuple[Statement, ...]:
    """What Section 3.4 says of bodies further up, over both figures that show chains of slender bodies with all dimensions."""
    return (
        Statement(
            2,
            "Section 3.4",
            "upper bodies are generally subject to less shock",
            "greatest ratio of the shock of a body to that of the body below it, cases A to F or torso and hind leg [1]",
            outcomes((MEASURED, SHOWN, *LEG), _rise, lambda x: x < LESS, distinct=_distinct),
            "two bodies share a joint, and where that is the place of most shock in both the upper one has no less; and what "
            "strikes along a straight leg goes up it whole",
        ),
        Statement(
            2,
            "Section 3.4",
            "the CoPc of a body tends to move toward the next joint in the chain",
            "its distance from the next joint over that from the joint or contact below, greatest of the figure [1]; below 1",
            outcomes(
                (BODY, SHOWN, *LEG),
                _nearer,
                lambda x: x < LESS,
                distinct=lambda body, shown, *leg: _distinct(body, shown, *leg) and (body != "foot" or shown is None),
            ),
            "a steep strike throws out a knee that gives way, faster than the foot comes in; and a straight leg moves as a whole",
        ),
    )


def torso_statements() -> tuple[Statement, ...]:
    """What Section 5 says of the torso of humanoids, or the main slender body of another robot."""
    return (
        Statement(
            2,
            "Section 5",
            "the torso is well described by Eq. 1",
            "distance of its CoPc from 2/3 of its length, over the length [1]; below 0.05",
            outcomes(
                (EQ_1, TORSO, *LEG),
                lambda how, *which: max(_off_eq_1(how, *t) for t in _torsos(*which)),
                lambda x: x < WELL,
                distinct=_distinct,
            ),
            "a joint below that moves along the torso too puts the CoPc beside it, and a torso that carries another leg is not the "
            "end of a chain",
        ),
        Statement(
            2,
            "Section 5",
            "sensitive equipment is best placed above the torso's centre of mass, but below its top",
            "place of least shock on the torso's middle line, from the hip, over its length [1]; above 1/2 and below 1",
            outcomes(
                (TORSO, *LEG),
                lambda *which: _best_place(_torsos(*which)),
                lambda x: 0.5 < x < 1.0,
                distinct=lambda *which: _distinct(None, *which),
            ),
            "shock is least at an end",
        ),
    )


def _distinct(_: object, shown: object, *leg: object) -> bool:
    """What Figure 2 leaves open is tried for that alone."""
    return shown is None or list(leg) == AS_TAKEN


def _rise(
    on_line: bool, shown: float | None, lower_leg: float, angles: tuple[float, float, float], steep: float, ankle: float
) -> float:
    """Greatest ratio in a figure."""
    if shown is not None:
        profile = quadruped(shown)
        return _greatest_ratio([_shock(profile, body, line, on_line) for body, line in quadruped_lines(profile).items()])
    ratios = []
    for profile in cases(lower_leg, angles, steep, ankle):
        chain = [body for body in ("foot", *BODIES) if body in profile.bodies]
        ratios.append(_greatest_ratio([_shock(profile, body, ends(profile.robot, body), on_line) for body in chain]))
    return max(ratios)


def _shock(profile: ShockProfile, body: str, line: tuple[Array, Array], on_line: bool) -> float:
    """Shock of a body, as it is measured [1]."""
    return line_shock(profile, body, line) if on_line else float(profile.shock_com[profile.bodies.index(body)])


def _greatest_ratio(shock: list[float]) -> float:
    """Greatest ratio of a body to the one below, from the ground up."""
    return max(upper / lower for lower, upper in itertools.pairwise(shock))


def _nearer(
    body: str, shown: float | None, lower_leg: float, angles: tuple[float, float, float], steep: float, ankle: float
) -> float:
    """Greatest ratio of a body's CoPc's distances in a figure: by Eq. 2 that of the shock at its joints."""
    if shown is None:
        profiles = cases(lower_leg, angles, steep, ankle)
        # Without a torso the upper leg has no next joint.
        found = [p for p in profiles if body in p.bodies and (body != "upper_leg" or "torso" in p.bodies)]
        shock = [along(p, body, ends(p.robot, body), 2) for p in found]
    else:
        profile = quadruped(shown)
        shock = [along(profile, f"hind_{body}", quadruped_lines(profile)[f"hind_{body}"], 2)]
    return max(float(above / below) for below, above in shock)


def _torsos(
    which: float | str | None, lower_leg: float, angles: tuple[float, float, float], steep: float, ankle: float
) -> list[tuple[ShockProfile, tuple[Array, Array]]]:
    """The landings of a figure that have a torso, with the ends of its middle line, from the hip that is struck."""
    if which is None:
        return [(p, ends(p.robot, "torso")) for p in cases(lower_leg, angles, steep, ankle) if "torso" in p.bodies]
    if isinstance(which, str):
        profile = land(which)
        return [(profile, (np.zeros(3), np.asarray(profile.robot.frame("head").offset)))]
    profile = quadruped(which)
    return [(profile, quadruped_lines(profile)["torso"])]


def _off_eq_1(in_plane: int, profile: ShockProfile, line: tuple[Array, Array]) -> float:
    """How far the torso's CoPc is from where Eq. 1 puts that of a slender body, along it or in the plane, over its length [1]."""
    low, high = line
    off = (profile.copc[profile.bodies.index("torso")] - low) / np.linalg.norm(high - low)
    axis = (high - low) / np.linalg.norm(high - low)
    off = off - centre_of_percussion(0.5, 1.0 / np.sqrt(12.0)) * axis
    return float(np.linalg.norm(off) if in_plane else abs(off @ axis))


def _best_place(torsos: list[tuple[ShockProfile, tuple[Array, Array]]]) -> float:
    """Place of least shock on a torso, from 0 at the hip to 1 at the other end; of several the one nearest to either limit."""
    places = [float(np.argmin(along(profile, "torso", line, 121))) / 120.0 for profile, line in torsos]
    return max(places, key=lambda place: abs(place - 0.75))
