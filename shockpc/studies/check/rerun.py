"""The command that computes a number of a check anew."""

import shlex
from pathlib import Path

from shockpc.evaluation.budgets import Budget, Case
from shockpc.landing.places import Place
from shockpc.studies.check.plan import Planned


def rerun_command(path: Path, planned: Planned, budget: Budget, place: Place) -> str:
    """An analysis of the case, or for a percentile a sweep over its random designs, as typed.

    Args:
        path: of the file of budgets.
        planned: the landing.
        budget: the limits of the number.
        place: where it is.
    """
    at = place.name
    of_point = budget.selection.quantity.of == "point"
    if of_point and place.centre:
        body = planned.robot.bodies[place.body]
        at = f"{body.name}:{','.join(map(str, body.com.tolist()))}"
    folder = Path.cwd()
    if path.is_relative_to(folder):
        path = path.relative_to(folder)
    landing = [f"{path}:{planned.case.name}"]
    if planned.angle is not None:
        landing.append(f"--strike-angle={str(planned.angle).removesuffix('.0')}")
    if budget.percentile is not None:
        quantity = [f"--quantity={budget.metric}@{at}", "--out=designs"]
        return shlex.join(["shockpc", "sweep", *landing, *_designs(planned.case), *quantity])
    if of_point:
        landing.append(f"--at={at}")
    return shlex.join(["shockpc", "analyze", *landing])


def _designs(case: Case) -> list[str]:
    """The random designs of a case as options of a sweep."""
    options = []
    for unknown in case.vary:
        if unknown.quantity:
            options.append(f"--vary={unknown.quantity}={unknown.values}")
        else:
            options.append(f"--vary-each={unknown.each}={unknown.values}")
    return [*options, f"--sample={case.designs:.0f}", "--lhs"]
