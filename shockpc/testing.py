"""Assertions for tests of a robot's design."""

import os
from pathlib import Path

from shockpc.evaluation.budgets import Budget, Budgets, Case
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import scene_of
from shockpc.show.tables import as_text
from shockpc.studies.check.report import check_sheet
from shockpc.studies.check.study import check_budgets
from shockpc.studies.check.texts import place_text
from shockpc.text.arguments import checked
from shockpc.text.errors import StudyError


@checked
def assert_shock(
    scene: Scene | str | os.PathLike[str],
    *,
    at: str,
    metric: str = "shock",
    max: float | None = None,
    min: float | None = None,
) -> None:
    """Assert that a number of a landing is within limits.

    Args:
        scene: the landing, or the path of its file, relative to the current folder, not to that of
            the test.
        at: name or glob of points, bodies, joints or contacts, whichever the metric belongs to.
        metric: the quantity, as in a file of budgets.
        max: largest value allowed, in the unit of the metric.
        min: smallest value allowed.

    Raises:
        AssertionError: it is not; the message is the row of the table.
        ShockError: the landing cannot be computed as asked, or has no such number.
    """
    __tracebackhide__ = True
    landing = scene_of(scene)
    name = landing.robot if isinstance(scene, Scene) else Path(scene).stem
    budget = Budget(at=at, metric=metric, max=max, min=min)
    check = check_budgets(Budgets(None, (Case(name=name, **vars(landing)),), (budget,), ()))
    for outcome in check.outcomes:
        if outcome.status == "not computed":
            raise StudyError(outcome.reason)
    if check.exit_code:
        failed = [outcome for outcome in check.outcomes if outcome.fails]
        table = as_text(check_sheet(check, most=len(failed)))
        raise AssertionError(f"{place_text(failed[0])}: {failed[0].reason}\n{table}")
