"""Where a sensor has the smallest shock: places, margins, the shock in each landing, what is gained
and what is proven.
"""

from typing import Any

import numpy as np

from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND, MOVED
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.document import record
from shockpc.show.header import shared_lines, shared_warnings
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Column, Lines, Row, Sheet, sheet_of
from shockpc.show.wording import count, proof_text, robot_name
from shockpc.studies.place.study import PlaceStudy
from shockpc.text.errors import ShockError
from shockpc.text.printed import cause_lines, causes, few, listed

MOST_MOVED = 0.01
"""Distance by which a place moves over the drives for the places of both ends to be given [m]."""


def place_report(study: PlaceStudy) -> Report:
    """The places of minimum shock on a body."""
    number = "maximum shock" if study.weights is None else "weighted mean of the shock"
    asked = dict.fromkeys(
        point.label for profile in study.profiles for point in profile.scene.point
    )
    apart = [name for name in asked if name not in {place.name for place in study.today}]
    outside = (
        [
            f"warning: no place on {study.robot.bodies[study.body].name}, so left out: "
            f"{listed(apart, 6)}"
        ]
        if apart
        else []
    )
    refused = causes((name, str(reason)) for name, reason in study.failures)
    failed = [f"not computed: {line}" for line in cause_lines(refused, "landings", 6)]
    return Report(
        name="place",
        title=(
            f"Place of minimum shock on {study.robot.bodies[study.body].name} of "
            f"{robot_name(study.robot)}"
        ),
        body=lambda full: [
            Lines(
                [
                    *shared_lines(_named(study)),
                    ("where", study.region.text),
                    ("compared by", f"{number} over the landings"),
                ]
            ),
            Picture(
                "place", "maximum shock over the body", "studies.place.figure:draw_place", (study,)
            ),
            _places(study).without("present", "bound"),
            *([_margins(study)] if _judged(study) else []),
            _landings(study, None if full else 6),
            *([_drives(study)] if moves_over_drives(study) else []),
        ],
        lead=3,
        closing=[*_gains(study), *_over_drives(study), *_proof(study)],
        warnings=[
            *failed,
            *outside,
            *(f"warning: {text}" for text in study.region.warnings),
            *shared_warnings(_named(study), "sensor"),
        ],
        sheets={
            "places": lambda: _places(study),
            "landings": lambda: _landings(study),
            "velocity_changes": lambda: _changes(study),
            **({"margins": lambda: _margins(study)} if _judged(study) else {}),
            **({"drives": lambda: _drives(study)} if study.ends else {}),
        },
        document=lambda: _document(study),
        tables=True,
        landings=_named(study),
    )


def _named(study: PlaceStudy) -> dict[str, ShockProfile]:
    return dict(zip(study.landings, study.profiles, strict=True))


def _document(study: PlaceStudy) -> dict[str, Any]:
    return {
        "robot": {"name": study.robot.name, "file": study.robot.label},
        "body": study.robot.bodies[study.body].name,
        "region": study.region.text,
        "compared_by": "maximum" if study.weights is None else "weighted mean",
        **record(study, "count", "combined", "bound", "gap"),
        "proven": study.complete,
        "keep": None if study.kept is None else study.kept.name,
        "apart": study.apart,
        "landings": [
            {
                "landing": name,
                "copc": profile.copc[study.body],
                **record(profile.health, "error_bound", "warnings"),
                "scene": profile.scene,
            }
            for name, profile in _named(study).items()
        ],
        "failures": [{"landing": name, "reason": str(reason)} for name, reason in study.failures],
    }


def _places(study: PlaceStudy) -> Sheet:
    notes = []
    if study.count > 1:
        notes.append("together: in each landing the sensor with the smallest shock")
    elif len(study.places) > 1:
        notes.append(
            f"each further place: the best one at least {study.apart:.3g} m along x, y or z from "
            f"those before"
        )
    if study.combined > (1.0 + 1e-6) * study.least:
        notes.insert(
            0,
            f"among places within 1 % of the optimum, {study.least:.4g}, each has the smallest "
            f"mean over the landings",
        )
    title = (
        f"places on {study.robot.bodies[study.body].name} (in its frame; shock relative to the "
        f"strike)"
    )
    sheet, found = sheet_of(study.table, title, notes), (*study.today, *study.places)
    more = [(one.bound is None, one.bound) for one in found] + [(False, None)] * (
        len(sheet.rows) - len(found)
    )
    rows = [(*row, *cells) for row, cells in zip(sheet.rows, more, strict=True)]
    return sheet._replace(header=[*sheet.header, "present", "bound [-]"], rows=rows)


def _changes(study: PlaceStudy) -> Sheet:
    """The jump of velocity at each place in each landing."""
    rows = [
        (one.name, name, float(shock), *jump)
        for one in (*study.today, *study.places)
        for name, shock, jump in zip(study.landings, one.shocks, one.delta_v.tolist(), strict=True)
    ]
    return Sheet(
        "jumps of velocity",
        ("place", "landing", "shock [-]", "Δv x [m/s]", "Δv y [m/s]", "Δv z [m/s]"),
        rows,
    )


def _judged(study: PlaceStudy) -> bool:
    """Whether peaks are compared with the range of a sensor."""
    return any(one.margin is not None for one in (*study.today, *study.places))


def _landings(study: PlaceStudy, most: int | None = None) -> Sheet:
    """The shock at each place in each landing.

    Args: most, rows to show, those of the largest shock.
    """
    places = (*study.today, *study.places)
    shocks = np.array([one.shocks for one in places]).T
    weights = {} if study.weights is None else {"weight [-]": study.weights}
    felt = {Column(one.name, one.name, "-"): one.shocks for one in places}
    least = (
        {"minimum at": [study.places[k].name for k in study.assigned]} if study.count > 1 else {}
    )
    sheet = Sheet.of(
        "shock in each landing", {"landing": study.landings, **weights, **felt, **least}
    )
    return sheet.largest(most, "landing", shocks.max(axis=1).tolist())


def _margins(study: PlaceStudy) -> Sheet:
    """Peaks along the axes of each sensor with what is left of its range."""
    scene = study.profiles[0].scene
    span = "" if scene.range_g is None else f", range {scene.range_g:g} g"
    along: list[Row] = []
    for one in (*study.today, *study.places):
        if one.margin is not None:
            along.append(
                (
                    one.name,
                    *one.margin.peak_g,
                    *((None,) * 3 if one.margin.left is None else one.margin.left),
                )
            )
    header = (
        "place",
        *(f"peak {axis} [g]" for axis in "xyz"),
        *(f"left {axis} [%]" for axis in "xyz"),
    )
    note = "axes: those of the present sensors; for new places those of the body"
    given = [
        "at most, for a pulse of any length" if scene.pulse is None else f"pulse {scene.pulse}"
    ]
    given += [f"behind a filter of {scene.imu_bandwidth}"] * (scene.imu_bandwidth is not None)
    title = (
        f"peak acceleration along each axis ({', '.join(given)}{span}; left: share of the range)"
    )
    return Sheet(title, header, along, [note]).known()


def _gains(study: PlaceStudy) -> list[str]:
    """How much less shock the best place sees than each present sensor."""
    n = len(study.places)
    new = (
        "the best place"
        if study.count == 1
        else "the sensor"
        if n == 1
        else "the pair"
        if n == 2
        else f"{n} sensors"
    )
    chosen = study.places if study.count > 1 else study.places[:1]
    new += " " + " and ".join(
        "({:g}, {:g}, {:g})".format(*one.position.round(3) + 0.0) for one in chosen
    )
    lines = [] if study.today else [f"{new} sees {study.combined:.3g}"]
    for one in study.today:
        if one is study.kept:
            seen = (
                f"keep {one.name}, which sees {one.combined:.3g}: no place is better by more than "
                f"1 %"
            )
            lines.append(f"{seen}; {new} sees {study.combined:.3g}")
            continue
        factor = one.combined / study.combined if study.combined > 0.0 else np.inf
        less = f"; a factor of {factor:.3g}" if factor < 1e6 else ""
        lines.append(f"{one.name} sees {one.combined:.3g}, {new} {study.combined:.3g}{less}")
    return lines


def moves_over_drives(study: PlaceStudy) -> bool:
    """Whether the best place differs between the ends of the drives by more than 1 cm, or its shock
    by more than 1 %.
    """
    every = (study, *study.ends.values())
    if any(isinstance(one, ShockError) for one in every):
        return True
    distance, numbers = _moved(study)
    return distance > MOST_MOVED or max(numbers) > (1.0 + MOVED) * min(numbers)


def _moved(study: PlaceStudy) -> tuple[float, list[float]]:
    """The largest distance between the best places over the drives [m], and their shocks [1].

    Of several sensors the distance is the largest of those in their order.
    """
    every = [study, *(one for one in study.ends.values() if isinstance(one, PlaceStudy))]
    positions = [np.array([place.position for place in one.places[: study.count]]) for one in every]
    known = [one for one in positions if one.shape == positions[0].shape]
    distance = max(float(np.linalg.norm(a - b, axis=1).max()) for a in known for b in known)
    return distance, [one.combined for one in every]


def _drives(study: PlaceStudy) -> Sheet:
    """The best place with the smallest and the largest inertias of the drives, beside that as
    modelled and present sensors.
    """
    named = "maximum shock [-]" if study.weights is None else "weighted mean [-]"
    header = ("drives", "place", "x [m]", "y [m]", "z [m]", named)
    rows: list[Row] = []
    for end, found in study.ends.items():
        if isinstance(found, ShockError):
            rows.append((end, str(found), None, None, None, None))
            continue
        best = study.places[: study.count]
        for one in (*found.places[: study.count], *found.today):
            rows.append((end, one.name, *one.position.tolist(), one.combined))
        if study.count == 1 and not np.array_equal(best[0].position, found.places[0].position):
            (at,) = found.fields.at(best[0].position[None])
            rows.append((end, "best as modelled", *best[0].position.tolist(), float(at)))
    return Sheet(AT_BOTH, header, rows, [BEYOND])


def _over_drives(study: PlaceStudy) -> list[str]:
    """How the answer depends on the drives."""
    if not study.ends:
        return []
    if not moves_over_drives(study):
        return [
            f"drives: from {BETWEEN}, the best place moves by less than 1 cm, and its shock by "
            f"less than 1 %"
        ]
    distance, numbers = _moved(study)
    seen = f"its shock is {min(numbers):.3g} to {max(numbers):.3g}"
    lines = [
        f"drives: from {BETWEEN}, the best place moves by {100.0 * distance:.2g} cm, and {seen}"
    ]
    for end, found in study.ends.items():
        if isinstance(found, ShockError):
            lines.append(f"with the {end} inertias there is no answer: {found}")
        elif found.kept is not None and study.kept is None:
            lines.append(
                f"with the {end} inertias keep {found.kept.name}: no place is better by more than "
                f"1 %"
            )
        elif found.kept is None and study.kept is not None:
            gain = 100.0 * found.better(min(found.today, key=lambda one: one.combined))
            lines.append(
                f"with the {end} inertias a place is better than {study.kept.name}, by {gain:.2g} %"
            )
    return lines


def _proof(study: PlaceStudy) -> list[str]:
    bound = max(profile.health.error_bound for profile in study.profiles)
    slides = [
        name
        for name, one in _named(study).items()
        if one.friction is not None and one.friction.impact is not None
    ]
    sliding = (
        f"; with friction, in double precision, where contacts slide: {few(slides, 4)}"
        if slides
        else ""
    )
    what = "no place" if study.count == 1 else f"no {count(study.count, 'sensor')}"
    verb = "is" if study.count == 1 else "are"
    enough = count(len(study.places), "sensor")
    fewer = (
        [f"{enough} of {study.count}: with more, the shock compared is not less"]
        if len(study.places) < study.count
        else []
    )
    unfinished = (
        "" if study.complete else "; the search ended at its limit before the optimum was proven"
    )
    return [
        *fewer,
        f"optimum: {what} {study.region.text} {verb} below {study.bound:.6g} (gap "
        f"{study.gap:.0e}){unfinished}",
        f"accuracy of the shock at these places: {proof_text(bound)}{sliding}",
    ]
