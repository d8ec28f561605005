"""The lines below the tables of a landing.

They are on energy, impact mitigation, loops, end stops, friction and accuracy.
"""

import math

from shockpc.landing.closure import Assembly
from shockpc.landing.end_stops import side_of
from shockpc.method.constraints import Constraint
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import STOP
from shockpc.show.wording import proof_text
from shockpc.text.printed import count, shown_as
from shockpc.text.wings import from_wings

NO_MITIGATION = (
    "no impact mitigation factor (it requires a free base, no stance, and no loop that ties the "
    "robot to the world)"
)


def closing_lines(profile: ShockProfile) -> list[str]:
    """All lines below the tables."""
    health = profile.health
    return [
        _energy_line(profile),
        *_mitigation_lines(profile),
        *([_loop_line(profile.assembly)] if profile.assembly else []),
        *ground_lines(profile),
        f"contact rows: {health.rank} of {health.rows} independent",
        accuracy_line(profile),
    ]


def ground_lines(profile: ShockProfile) -> list[str]:
    """Lines on the end stops that act, and on what friction and wings say of the landing."""
    lines = [*_stop_lines(profile), *_friction_lines(profile)]
    for lines_of in from_wings("report", "lines"):
        lines += lines_of(profile)
    return lines


def accuracy_line(profile: ShockProfile) -> str:
    """The bound on rounding, and the effects of double precision and of the data's last digit."""
    health = profile.health
    rounding = f"{proof_text(health.error_bound)}, {health.bits} bits"
    double = "finds no solution"
    if math.isfinite(health.double_error):
        double = f"was off by {health.double_error:.0e}"
    data = f"last-digit changes of the data move it by {health.data_sensitivity:.0e}"
    return f"accuracy: {rounding}; double precision {double}; {data}"


def _energy_line(profile: ShockProfile) -> str:
    """The kinetic energy that is lost, also as a share."""
    if not math.isfinite(profile.energy_lost):
        return "energy lost: not determined: a motor does work"
    line = f"energy lost: {profile.energy_lost:.4g} J"
    if profile.energy_share is None:
        return line
    return f"{line}, {100.0 * profile.energy_share:.3g} % of the kinetic energy before impact"


def _mitigation_lines(profile: ShockProfile) -> list[str]:
    """The impact mitigation factor of each contact."""
    lines = []
    for contact in profile.contacts:
        if contact.mitigation is not None:
            lines.append(
                f"{contact.frame}: impact mitigation factor {contact.mitigation:.3f} sticking, "
                f"{contact.mitigation_frictionless:.3f} frictionless"
            )
    return lines or [NO_MITIGATION]


def _loop_line(assembly: Assembly) -> str:
    """The gap from which loops were closed, and the joints that moved."""
    gap = shown_as(assembly.gap, "m")
    if assembly.turn > 0.0:
        gap += f" and {shown_as(assembly.turn, 'rad')}"
    moved = [f"{name} by {shown_as(by, unit)}" for name, by, unit in assembly.moved]
    return f"loops closed from a gap of {gap}: {', '.join(moved) or 'no joint had to move'}"


def _stop_lines(profile: ShockProfile) -> list[str]:
    """A line for each end stop that acts, with its impulse."""
    striking = [contact for contact in profile.landing.contacts if contact.kind == "stop"]
    acting = profile.landing.acting
    if not profile.scene.stops and not striking:
        return []
    lines = [_stop_line(profile, stop) for stop in (*striking, *acting)]
    if acting:
        lines.append(
            "numbers of other impact directions, such as the most severe one, are computed with "
            "these stops held"
        )
    return lines or ["no end stop acts"]


def _stop_line(profile: ShockProfile, stop: Constraint) -> str:
    """The impulse of an end stop, and its largest force where the scene says how stiff it is."""
    name = stop.frame.removeprefix(STOP)
    side = "minimum" if side_of(profile.robot, stop) > 0.0 else "maximum"
    names = [place.name for place in profile.places("joint")]
    impulse = abs(float(profile.value("stop_impulse", "joint")[names.index(name)]))
    unit = "N m s" if len(stop.moments) else "N s"
    line = f"the end stop of {name} at its {side} value acts with {impulse:.4g} {unit}"
    if profile.stiffness is None:
        return line
    peak = profile.stiffness.stop_peaks.get(name, 0.0)
    return f"{line}, at most {peak:.4g} {unit.removesuffix(' s')}"


def _friction_lines(profile: ShockProfile) -> list[str]:
    """Lines on what friction says of the landing, and when that holds."""
    friction = profile.friction
    if friction is None:
        return []
    line = f"friction {profile.scene.friction:g}: "
    solutions = ""
    if friction.solutions > 1:
        solutions = f"; {count(friction.solutions, 'solution')} found"
    if friction.impact is None:
        return [f"{line}every contact sticks, so the results hold as they are{solutions}"]
    if len(friction.state) > 1:
        solutions += "; there may be more solutions"
    return [
        f"{line}energy lost {friction.energy_lost:.4g} J, residual "
        f"{friction.residual:.0e}{solutions}; all other tables are without friction, for contacts "
        "that stick"
    ]
