"""Warnings of a sweep: numbers without a value, infeasible landings, and what has no effect."""

from collections.abc import Iterator

from shockpc.evaluation.column import Column
from shockpc.evaluation.variations.kinds.posture import beyond_limits
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.profile import profile_of_scene
from shockpc.show.wording import LEFT_OUT, STICKING, without_value
from shockpc.studies.sweep.row_options import row_text
from shockpc.studies.sweep.summary import Summary
from shockpc.text.wings import from_wings


def sweep_warnings(summary: Summary[VariedLandings]) -> Iterator[str]:
    """The warnings, one a line."""
    yield from _without_value(summary)
    yield from _relative_shock(summary)
    yield from _infeasible(summary)
    yield from _of_the_scene(summary.evaluation.landings)
    yield from _without_effect(summary)
    if summary.evaluation.landings.base_scene.yields:
        yield LEFT_OUT
        yield from _worst_of_wings(summary)


def _without_value(summary: Summary[VariedLandings]) -> Iterator[str]:
    """The reasons why quantities have no value, where landings were computed."""
    missing = [extent.column for extent in summary.extents if extent.greatest_row < 0]
    if summary.failed < summary.rows:
        yield from without_value((column.name, column.selection.quantity) for column in missing)


def _relative_shock(summary: Summary[VariedLandings]) -> Iterator[str]:
    """That a shock does not depend on the speed, where that varies."""
    places = [extent.column.place.name for extent in summary.extents if extent.column.shock]
    varies = any(varied.kind.scales for varied in summary.evaluation.landings.variations)
    if places and varies:
        yield (
            f"shock is relative to the contact velocity, and the same at every speed; --quantity "
            f"delta_v@{places[0]} gives m/s, and peak_g@{places[0]} with --pulse g"
        )


def _infeasible(summary: Summary[VariedLandings]) -> Iterator[str]:
    """The landings that flat ground does not allow, and those that it allows with a small tilt."""
    refused = summary.refused
    causes = {
        "a contact would have to be pulled": refused.pulled,
        "the impact would gain energy": refused.gained,
        "another link is below the contacts, or they differ in height": refused.below,
    }
    listed = ", ".join(f"{number} because {cause}" for cause, number in causes.items() if number)
    left = "--feasible leaves them out"
    if summary.evaluation.feasible:
        left = "they are left out"
    if refused.rows:
        yield (
            f"warning: flat ground does not allow {refused.rows} of {summary.rows} landings: "
            f"{listed}; {left}"
        )
    if summary.tilted:
        yield (
            f"{summary.tilted} of {summary.rows} landings leave out feet that are level, which "
            f"only a small tilt does (column feasible_if_tilted)"
        )


def _of_the_scene(landings: VariedLandings) -> Iterator[str]:
    """Warnings of the robot's changes, of the scene, and of joints beyond their limits."""
    _, robot = landings.case(0)
    for warning in robot.change_warnings:
        yield f"warning: {warning}"
    # Rows with landings of their own may have other warnings.
    if all(varied.stage for varied in landings.variations):
        for warning in landings.first.warnings:
            if warning.kind == "scene":
                yield f"warning: {warning}"
    for varied in landings.variations:
        text = beyond_limits(landings.robot, varied)
        if text:
            yield f"warning: {text}"


def _without_effect(summary: Summary[VariedLandings]) -> Iterator[str]:
    """Remarks on what varies, or a friction, on which no number that is computed depends."""
    landings = summary.evaluation.landings
    stiff = landings.base_scene.yields
    if not stiff or not any(map(_on_stiffness, summary.evaluation.computed)):
        needed = "--quantity peak_acceleration or peak_force"
        if not stiff:
            needed += ", with --contact-stiffness,"
        for varied in landings.variations:
            if varied.kind.lasting:
                yield f"warning: nothing computed here depends on {varied.subject}; {needed} does"
    quantities = [extent.column.selection.quantity for extent in summary.extents]
    slides = landings.base_scene.friction is not None
    if slides and not any(quantity.of_ground(landings.scene) for quantity in quantities):
        yield f"warning: {STICKING}"


def _worst_of_wings(summary: Summary[VariedLandings]) -> Iterator[str]:
    """The worst warning of the shared checks of wings.

    It is of the rows with the most severe values of what depends on the stiffness of the contacts.
    """
    landings = summary.evaluation.landings
    rows = set()
    for extent in summary.extents:
        if extent.greatest_row >= 0 and _on_stiffness(extent.column):
            rows.add(extent.most_severe_row)
    warnings = []
    for row in sorted(rows):
        profile = profile_of_scene(*landings.case(row))
        for shared in from_wings("checks", "SHARED"):
            for check in shared.values():
                warnings += [(warning.size, -row, str(warning)) for warning in check(profile)]
    if warnings:
        # Of equal ones the first row.
        _, row, text = max(warnings)
        yield f"warning: row {-row} ({row_text(landings, -row)}): {text}"


def _on_stiffness(column: Column) -> bool:
    """True if a column may depend on the stiffness of the contacts."""
    return column.selection.quantity.computation.exact != "always"
