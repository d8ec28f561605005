"""The report of the places where a sensor has the smallest shock.

It gives the places, margins, the shock in each landing, what is gained and what is proven.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND, MOVED
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.document import record
from shockpc.show.header import shared_lines, shared_warnings
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Heading, Lines, Row, Sheet, sheet_of
from shockpc.show.wording import proof_text, robot_name
from shockpc.studies.place.study import PlaceStudy, SensorPlace
from shockpc.text.errors import ShockError
from shockpc.text.printed import few, listed, not_computed

MOST_MOVED = 0.01
"""Distance by which a place moves over the drives for the places of both ends to be given [m]."""

SHORT = 6
"""Landings in the short table."""


def place_report(placement: PlaceStudy) -> Report:
    """The places of minimum shock on a body."""
    body_name = placement.robot.bodies[placement.body].name
    judged = any(sensor.margin is not None for sensor in _sensors(placement))
    header = [
        *shared_lines(_profiles(placement)),
        ("where", placement.region.text),
        ("compared by", "maximum shock over the landings"),
    ]
    picture = Picture(
        "place", "maximum shock over the body", "studies.place.figure:draw_place", (placement,)
    )

    def body(full: bool) -> list[Section]:
        sections: list[Section] = [Lines(header), picture]
        sections.append(_places(placement).without("present", "bound"))
        if judged:
            sections.append(_margins(placement))
        sections.append(_landings(placement, None if full else SHORT))
        if moves_over_drives(placement):
            sections.append(_drives(placement))
        return sections

    sheets: dict[str, Callable[[], Sheet]] = {
        "places": lambda: _places(placement),
        "landings": lambda: _landings(placement),
        "velocity_changes": lambda: _velocity_changes(placement),
    }
    if judged:
        sheets["margins"] = lambda: _margins(placement)
    if placement.ends:
        sheets["drives"] = lambda: _drives(placement)
    return Report(
        name="place",
        title=f"Place of minimum shock on {body_name} of {robot_name(placement.robot)}",
        body=body,
        lead=3,
        closing=[*_gains(placement), *_over_drives(placement), *_proof(placement)],
        warnings=_warnings(placement),
        sheets=sheets,
        document=lambda: _document(placement),
        tables=True,
        landings=_profiles(placement),
    )


def _sensors(placement: PlaceStudy) -> tuple[SensorPlace, ...]:
    """Present sensors, then new places."""
    return (*placement.today, *placement.places)


def _profiles(placement: PlaceStudy) -> dict[str, ShockProfile]:
    """The profiles by the names of the landings."""
    return dict(zip(placement.landings, placement.profiles, strict=True))


def _warnings(placement: PlaceStudy) -> list[str]:
    """Landings that could not be computed, points on other bodies, and what the landings share."""
    lines = not_computed(placement.failures, "landings", 6)
    present = {sensor.name for sensor in placement.today}
    labels: dict[str, None] = {}
    for profile in placement.profiles:
        labels |= dict.fromkeys(point.label for point in profile.scene.point)
    elsewhere = [label for label in labels if label not in present]
    if elsewhere:
        body = placement.robot.bodies[placement.body].name
        lines.append(f"warning: no place on {body}, so left out: {listed(elsewhere, 6)}")
    lines += [f"warning: {text}" for text in placement.region.warnings]
    return [*lines, *shared_warnings(_profiles(placement), "sensor")]


def _document(placement: PlaceStudy) -> dict[str, Any]:
    """The entries of the document that are no tables, schema `shockpc.place/2`."""
    return {
        "robot": {"name": placement.robot.name, "file": placement.robot.label},
        "body": placement.robot.bodies[placement.body].name,
        "region": placement.region.text,
        **record(placement, "combined", "bound", "gap"),
        "proven": placement.complete,
        "keep": None if placement.kept is None else placement.kept.name,
        "apart": placement.apart,
        "landings": [
            {
                "landing": name,
                "copc": profile.copc[placement.body],
                **record(profile.health, "error_bound", "warnings"),
                "scene": profile.scene,
            }
            for name, profile in _profiles(placement).items()
        ],
        "failures": [
            {"landing": name, "reason": str(reason)} for name, reason in placement.failures
        ],
    }


def _places(placement: PlaceStudy) -> Sheet:
    """Positions and maximum shocks, whether a sensor is present, and bounds of new places."""
    notes = []
    if placement.combined > (1.0 + 1e-6) * placement.least:
        notes.append(
            f"among places within 1 % of the optimum, {placement.least:.4g}, each has the smallest "
            f"mean over the landings"
        )
    if len(placement.places) > 1:
        notes.append(
            f"each further place: the best at least {placement.apart:.3g} m along x, y or z from "
            "the places above"
        )
    body = placement.robot.bodies[placement.body].name
    title = f"places on {body} (in its frame; shock: |Δv| / v_in)"
    return sheet_of(placement.table, title, notes)


def _velocity_changes(placement: PlaceStudy) -> Sheet:
    """The jump of velocity at each place in each landing."""
    header = ("place", "landing", "shock [-]", "Δv x [m/s]", "Δv y [m/s]", "Δv z [m/s]")
    rows: list[Row] = []
    for sensor in _sensors(placement):
        shocks, jumps = sensor.shocks.tolist(), sensor.delta_v.tolist()
        for landing, shock, jump in zip(placement.landings, shocks, jumps, strict=True):
            rows.append((sensor.name, landing, shock, *jump))
    return Sheet("jumps of velocity", header, rows)


def _landings(placement: PlaceStudy, most: int | None = None) -> Sheet:
    """The shock at each place in each landing.

    Args:
        placement: the result.
        most: rows to show, those of the largest shock; None for all.
    """
    sensors = _sensors(placement)
    columns = {Heading(sensor.name, sensor.name, "-"): sensor.shocks for sensor in sensors}
    sheet = Sheet.of("shock in each landing", {"landing": placement.landings, **columns})
    largest = np.max([sensor.shocks for sensor in sensors], axis=0)
    return sheet.largest(most, "landing", largest.tolist())


def _margins(placement: PlaceStudy) -> Sheet:
    """Peaks along the axes of each sensor with what is left of its range."""
    header = (
        "place",
        *(f"peak {axis} [g]" for axis in "xyz"),
        *(f"left {axis} [%]" for axis in "xyz"),
    )
    rows: list[Row] = []
    for sensor in _sensors(placement):
        margin = sensor.margin
        if margin is not None:
            left = (None, None, None) if margin.left is None else margin.left
            rows.append((sensor.name, *margin.peak_g, *left))
    scene = placement.profiles[0].scene
    pulse = f"pulse {scene.pulse}"
    conditions = ["at most, for a pulse of any length" if scene.pulse is None else pulse]
    if scene.imu_bandwidth is not None:
        conditions.append(f"behind a filter of {scene.imu_bandwidth}")
    if scene.range_g is not None:
        conditions.append(f"range {scene.range_g:g} g")
    title = f"peak acceleration along each axis ({', '.join(conditions)}; left: share of the range)"
    note = "axes: those of the present sensors; for new places those of the body"
    return Sheet(title, header, rows, [note]).known()


def _gains(placement: PlaceStudy) -> list[str]:
    """The gain of the best place over each present sensor, in words."""
    position = placement.places[0].position.round(3) + 0.0
    best = "the best place, at ({:g}, {:g}, {:g}) m,".format(*position)
    if not placement.today:
        return [f"{best} sees {placement.combined:.3g}"]
    lines = []
    for sensor in placement.today:
        if sensor is placement.kept:
            lines.append(
                f"keep {sensor.name}, which sees {sensor.combined:.3g}: no place is better by more "
                f"than 1 %; {best} sees {placement.combined:.3g}"
            )
            continue
        line = f"{sensor.name} sees {sensor.combined:.3g}; {best} sees {placement.combined:.3g}"
        factor = sensor.combined / placement.combined if placement.combined > 0.0 else np.inf
        if factor < 1e6:
            line += f", a factor of {factor:.3g}"
        lines.append(line)
    return lines


def moves_over_drives(placement: PlaceStudy) -> bool:
    """True if the best place differs between the ends of the drives.

    It differs by more than 1 cm, or its shock by more than 1 %.
    """
    if any(isinstance(end, ShockError) for end in placement.ends.values()):
        return True
    distance, numbers = _moved(placement)
    largest = (1.0 + MOVED) * min(numbers)
    return distance > MOST_MOVED or max(numbers) > largest


def _moved(placement: PlaceStudy) -> tuple[float, list[float]]:
    """The largest distance between the best places over the drives [m], and their shocks [1]."""
    studies = [placement, *(end for end in placement.ends.values() if isinstance(end, PlaceStudy))]
    positions = np.array([end.places[0].position for end in studies])
    distances = np.linalg.norm(positions[:, None] - positions, axis=-1)
    return float(distances.max()), [end.combined for end in studies]


def _drives(placement: PlaceStudy) -> Sheet:
    """The best place with the smallest and the largest inertias of the drives.

    Beside it are that as modelled, and present sensors.
    """
    header = ("drives", "place", "x [m]", "y [m]", "z [m]", "maximum shock [-]")
    modelled = placement.places[0].position
    rows: list[Row] = []
    for end, result in placement.ends.items():
        if isinstance(result, ShockError):
            rows.append((end, str(result), None, None, None, None))
            continue
        best = result.places[0]
        for sensor in (best, *result.today):
            rows.append((end, sensor.name, *sensor.position.tolist(), sensor.combined))
        if not np.array_equal(modelled, best.position):
            (value,) = result.fields.at(modelled[None]).tolist()
            rows.append((end, "best as modelled", *modelled.tolist(), value))
    return Sheet(AT_BOTH, header, rows, [BEYOND])


def _over_drives(placement: PlaceStudy) -> list[str]:
    """Lines on how the answer depends on the drives."""
    if not placement.ends:
        return []
    if not moves_over_drives(placement):
        return [
            f"drives: from {BETWEEN}, the best place moves by less than 1 cm, and its shock by "
            f"less than 1 %"
        ]
    distance, numbers = _moved(placement)
    lines = [
        f"drives: from {BETWEEN}, the best place moves by {100.0 * distance:.2g} cm, and its shock "
        f"is {min(numbers):.3g} to {max(numbers):.3g}"
    ]
    for end, result in placement.ends.items():
        if isinstance(result, ShockError):
            lines.append(f"with the {end} inertias there is no answer: {result}")
        elif result.kept is not None and placement.kept is None:
            lines.append(
                f"with the {end} inertias keep {result.kept.name}: no place is better by more than "
                f"1 %"
            )
        elif result.kept is None and placement.kept is not None:
            present = min(result.today, key=lambda sensor: sensor.combined)
            gain = 100.0 * result.better(present)
            lines.append(
                f"with the {end} inertias a place is better than {placement.kept.name}, by "
                f"{gain:.2g} %"
            )
    return lines


def _proof(placement: PlaceStudy) -> list[str]:
    """The bound of the optimum, and the accuracy of the shocks."""
    bound = max(profile.health.error_bound for profile in placement.profiles)
    accuracy = f"accuracy of the shock at these places: {proof_text(bound)}"
    slides = []
    for name, profile in _profiles(placement).items():
        if profile.friction is not None and profile.friction.impact is not None:
            slides.append(name)
    if slides:
        accuracy += f"; with friction, in double precision, where contacts slide: {few(slides, 4)}"
    return [
        f"optimum: no place {placement.region.text} is below {placement.bound:.6g} (gap "
        f"{placement.gap:.0e})",
        accuracy,
    ]
