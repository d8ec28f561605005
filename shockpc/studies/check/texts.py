"""Outcomes in words, as tables and annotations of CI say them."""

from shockpc.studies.check.outcome import Check, Outcome


def order(outcome: Outcome) -> tuple[bool, bool, bool]:
    """Sort key: what fails first, then what is not met with a warning.

    Of both, what the drives decide comes last.
    """
    return not outcome.fails, not outcome.reason, outcome.status == "undecided"


def case_angle_text(outcome: Outcome) -> str:
    """The strike angle after the name of a case, if it is one of the case's."""
    angle = outcome.strike_angle_deg
    return "" if angle is None else f", {angle:g} deg"


def place_text(outcome: Outcome) -> str:
    """The place and landing of a value, in words."""
    return f"{outcome.case}{case_angle_text(outcome)}: {outcome.budget.metric} at {outcome.at}"


def case_joints_text(check: Check, case: str) -> str:
    """The joint model of a case, and the source of its drives; empty if it was not computed."""
    if case not in check.profiles:
        return ""
    return check.profiles[case].landing.joint_model.summary
