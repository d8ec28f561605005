"""Section 3.4: whether upper bodies are subject to less shock, which hangs on where shock is read and in which figure."""

import itertools

from shockpc.core.spatial import Array
from shockpc.paper.landings import line_shock
from shockpc.paper.leg import ANGLE_ABC, ANGLE_EF, BODIES, FOOT, LOWER_LEG, cases, ends
from shockpc.paper.quadruped import ANGLES, quadruped, quadruped_lines
from shockpc.paper.statement import Reading, Statement, outcomes
from shockpc.record import ShockProfile

__all__ = ["upper_bodies_statement"]

LESS = 1.0 - 1e-9
"""Two bodies share a joint: where that is the place of most shock in both, their ratio is 1 but for rounding, and none has less."""

MEASURED = Reading("shock of a body", {"at its centre of mass": False, "the greatest on its middle line": True})
SHOWN = Reading("shown in", {"Figure 2": None} | {f"Figure 5 at {angle:g}°": angle for angle in reversed(ANGLES)})
LEG = (LOWER_LEG, ANGLE_ABC, ANGLE_EF, FOOT)
"""What Figure 2 leaves open; Figure 5 has no use for it."""

AS_TAKEN = [next(iter(reading.options.values())) for reading in LEG]


def upper_bodies_statement() -> Statement:
    """The statement, over both figures that show chains of slender bodies with all their dimensions."""
    return Statement(
        2,
        "Section 3.4",
        "upper bodies are generally subject to less shock",
        "greatest ratio of the shock of a body to that of the body below it, cases A to F or torso and hind leg [1]",
        outcomes(
            (MEASURED, SHOWN, *LEG),
            _rise,
            lambda x: x < LESS,
            distinct=lambda _, shown, *leg: shown is None or list(leg) == AS_TAKEN,
        ),
        "two bodies share a joint, and where that is the place of most shock in both the upper one has no less; and what strikes "
        "along a straight leg goes up it whole",
    )


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
