"""Comparison of a number with the limits of its budget, for all drives, and with a baseline."""

from collections.abc import Sequence
from typing import NamedTuple

from shockpc.evaluation.budgets import Budget, DesignVariation
from shockpc.judgement.drive_range import Range, deciding_joints, deciding_text, range_of
from shockpc.landing.places import Place
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.studies.check.baseline import Baseline
from shockpc.studies.check.design_record import six_digits
from shockpc.studies.check.outcome import Status

SIDES = ((1.0, "above", "+", "less"), (-1.0, "below", "−", "greater"))
"""Sides of a baseline: sign, name, sign in texts, and the metrics for which that side is better."""


class BudgetedNumber(NamedTuple):
    """A number with its budget.

    Attributes:
        budget: its limits.
        place: where it is.
        value: the number, as modelled.
        before: the number in the baseline; None without one.
    """

    budget: Budget
    place: Place
    value: float
    before: float | None


class Verdict(NamedTuple):
    """The comparison of a number with its limits; the fields are those of an `Outcome`."""

    status: Status
    reason: str
    smallest: float | None = None
    largest: float | None = None
    range_kind: str = ""
    deciding: tuple[str, ...] = ()


def verdict_of(
    number: BudgetedNumber,
    profile: ShockProfile,
    vary: Sequence[DesignVariation],
    baseline: Baseline | None,
) -> Verdict:
    """Compare a number with its limits for all drives, and as modelled with what a baseline allows.

    Args:
        number: the number.
        profile: its landing.
        vary: what varies in the designs of the case.
        baseline: numbers of an earlier design.
    """
    budget = number.budget
    limited = budget.max is not None or budget.min is not None
    beyond_limits = _beyond_limits(budget, number.value)
    reasons = [*beyond_limits, *_beyond_baseline(number, baseline)]
    over_drives = _range(number, profile, vary) if limited else None
    ends: tuple[float | None, float | None, str] = (None, None, "")
    if over_drives is not None:
        ends = over_drives
        # A change against the baseline for the worse is one whatever the drives.
        only_limits = reasons == beyond_limits
        if only_limits and over_drives.meets(budget.min, budget.max) is None:
            joints = deciding_joints(profile, budget.selection, number.place)
            reason = f"{_undecided(budget, over_drives)}; {deciding_text(joints)}"
            return Verdict("undecided", reason, *ends, tuple(joints))
    if reasons:
        return Verdict("exceeded", "; ".join(reasons), *ends)
    if limited or baseline is not None:
        return Verdict("passed", "", *ends)
    return Verdict("skipped", "", *ends)


def _range(
    number: BudgetedNumber, profile: ShockProfile, vary: Sequence[DesignVariation]
) -> Range | None:
    """The range of a number over the drives.

    Of a percentile it is that of the design as it is, in proportion. Random designs whose drives
    vary have them, so that their percentile has no range besides.
    """
    budget, place, value, _ = number
    of_design = range_of(profile, budget.selection, place)
    if of_design is None or budget.percentile is None:
        return of_design
    if any(_of_drives(unknown) for unknown in vary):
        return None
    low, high = of_design.smallest, of_design.largest
    as_modelled = float(profile.numbers(budget.selection, [place])[0])
    if as_modelled == 0.0:
        ends = value, low, high
    else:
        ends = value, value * low / as_modelled, value * high / as_modelled
    return of_design._replace(kind="samples", smallest=min(ends), largest=max(ends))


def _of_drives(unknown: DesignVariation) -> bool:
    """True if designs vary in a drive."""
    word, _, _ = (unknown.quantity or unknown.each or "").partition(":")
    return word in ("armature", "rotor")


def _undecided(budget: Budget, over_drives: Range) -> str:
    """Between which values the drives decide, and about which limits."""
    unit = _unit(budget)
    limits = {"min": budget.min, "max": budget.max}
    known = [f"{name} {x:.6g}{unit}" for name, x in limits.items() if x is not None]
    return (
        f"from {over_drives.smallest:.3g} to {over_drives.largest:.3g}{unit} over the drives, so "
        f"{' and '.join(known)} may be met or not"
    )


def _beyond_limits(budget: Budget, value: float) -> list[str]:
    """The limits of a budget that a value exceeds."""
    unit = _unit(budget)
    share = "" if budget.percentile is None else f" ({budget.percentile:g} % of the designs)"
    excesses = []
    if budget.max is not None and value > budget.max:
        number = f"{_digits(value, budget.max)}{unit}{share}"
        excesses.append(f"{number} is above max {budget.max:.6g}{unit}")
    if budget.min is not None and value < budget.min:
        number = f"{_digits(value, budget.min)}{unit}{share}"
        excesses.append(f"{number} is below min {budget.min:.6g}{unit}")
    return excesses


def _beyond_baseline(number: BudgetedNumber, baseline: Baseline | None) -> list[str]:
    """The changes against a baseline that a budget does not allow."""
    budget, before = number.budget, number.before
    if budget.baseline_tolerance is None or baseline is None or before is None:
        return []
    unit = _unit(budget)
    value = six_digits(number.value)
    margin = budget.margin(before, baseline.largest(budget.metric))
    excesses = []
    for sign, word, plus, better in SIDES:
        limit = before + sign * margin
        if budget.worse != better and sign * value > sign * limit:
            allowed = f"the baseline {before:.6g} {plus} {budget.baseline_tolerance}"
            text = f"{_digits(value, limit)}{unit}"
            excesses.append(f"{text} is {word} {limit:.6g}{unit}, which is {allowed}")
    return excesses


def _unit(budget: Budget) -> str:
    """The unit of a budget's metric behind a number."""
    unit = budget.selection.quantity.unit
    return "" if unit == "1" else f" {unit}"


def _digits(value: float, limit: float) -> str:
    """A value with as many digits as tell it from its limit."""
    short = f"{value:.6g}"
    return repr(value) if short == f"{limit:.6g}" else short
