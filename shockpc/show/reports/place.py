"""Where a sensor sees least shock: places, margins, the shock in each landing, what is gained and what is proven."""

from typing import Any

import numpy as np

from shockpc.quantities.profile import ShockProfile
from shockpc.show.document import record
from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.show.wording import count, proof_text, robot_name, shared_lines, shared_warnings
from shockpc.studies.place.study import PlaceStudy, SensorPlace
from shockpc.text.printed import cause_lines, causes, few, listed


def place_report(study: PlaceStudy) -> Report:
    """The places of least shock on a body."""
    number = "greatest shock" if study.weights is None else "weighted mean of the shock"
    asked = dict.fromkeys(point.label for profile in study.profiles for point in profile.scene.point)
    apart = [name for name in asked if name not in {place.name for place in study.today}]
    outside = [f"warning: no place on {study.robot.bodies[study.body].name}, so left out: {listed(apart, 6)}"] if apart else []
    refused = causes((name, str(reason)) for name, reason in study.failures)
    failed = [f"not computed: {line}" for line in cause_lines(refused, "landings", 6)]
    return Report(
        name="place",
        title=f"Place of least shock on {study.robot.bodies[study.body].name} of {robot_name(study.robot)}",
        body=lambda full: [
            Lines([*shared_lines(_named(study)), ("where", study.region.text), ("compared by", f"{number} over the landings")]),
            Picture("place", "greatest shock over the body", "place:draw_place", (study,)),
            _places(study),
            *_margins(study),
            _landings(study, None if full else 6),
        ],
        lead=3,
        closing=[*_gains(study), *_proof(study)],
        warnings=[
            *failed,
            *outside,
            *(f"warning: {text}" for text in study.region.warnings),
            *shared_warnings(_named(study), "sensor"),
        ],
        sheets={"places": lambda: _places(study), "landings": lambda: _landings(study)},
        document=lambda: _document(study),
        landings=_named(study),
    )


def _named(study: PlaceStudy) -> dict[str, ShockProfile]:
    return dict(zip(study.landings, study.profiles, strict=True))


def _document(study: PlaceStudy) -> dict[str, Any]:
    weights = [None] * len(study.landings) if study.weights is None else study.weights
    return {
        "robot": {"name": study.robot.name, "file": study.robot.label},
        "body": study.robot.bodies[study.body].name,
        "region": study.region.text,
        "compared_by": "greatest" if study.weights is None else "weighted mean",
        "today": [_place(one) for one in study.today],
        "places": [_place(one) for one in study.places],
        **record(study, "count", "combined", "bound", "gap"),
        "proven": study.complete,
        "apart": study.apart,
        "landings": [
            {
                "landing": name,
                "weight": weight,
                "sensor": study.places[sensor].name,
                "copc": profile.copc[study.body],
                **record(profile.health, "error_bound", "warnings"),
                "scene": profile.scene,
            }
            for name, weight, sensor, profile in zip(study.landings, weights, study.assigned, study.profiles, strict=True)
        ],
        "failures": [{"landing": name, "reason": str(reason)} for name, reason in study.failures],
    }


def _place(one: SensorPlace) -> dict[str, Any]:
    margin = one.margin
    return {
        **record(one, "name", "position"),
        "greatest": one.shocks.max(),
        **record(one, "combined", "bound"),
        "shock": one.shocks,
        "delta_v": one.delta_v,
        "margin": margin and record(margin, "peak_g", "left"),
    }


def _places(study: PlaceStudy) -> Sheet:
    notes = []
    if study.count > 1:
        notes.append("together: in each landing the sensor with the least shock")
    elif len(study.places) > 1:
        notes.append(f"each further place: the best one at least {study.apart:.3g} m along x, y or z from those before")
    if study.combined > (1.0 + 1e-6) * study.least:
        notes.insert(0, f"among places within 1 % of the optimum, {study.least:.4g}, each has the least mean over the landings")
    title = f"places on {study.robot.bodies[study.body].name} (in its frame; shock relative to the strike)"
    return sheet_of(study.table, title, notes)


def _landings(study: PlaceStudy, most: int | None = None) -> Sheet:
    """The shock at each place in each landing. Args: most, rows to show, those of the greatest shock."""
    places = (*study.today, *study.places)
    shocks = np.array([one.shocks for one in places]).T
    weights = np.zeros((len(shocks), 0)) if study.weights is None else study.weights[:, None]
    rows: list[Row] = [(name, *row) for name, row in zip(study.landings, np.hstack([weights, shocks]), strict=True)]
    header = ["landing", *(["weight [-]"] * weights.shape[1]), *(f"{one.name} [-]" for one in places)]
    return Sheet("shock in each landing", header, rows).largest(most, "landing", shocks.max(axis=1).tolist())


def _margins(study: PlaceStudy) -> list[Sheet]:
    """Peaks along the axes of each sensor with what is left of its range; nothing without a pulse."""
    places = [(one.name, one.margin) for one in (*study.today, *study.places) if one.margin is not None]
    if not places:
        return []
    scene = study.profiles[0].scene
    span = "" if scene.range_g is None else f", range {scene.range_g:g} g"
    along: list[Row] = [(name, *margin.peak_g, *(() if margin.left is None else 100.0 * margin.left)) for name, margin in places]
    header = ["place", "peak x [g]", "y [g]", "z [g]", *(["left x [%]", "y [%]", "z [%]"] if span else [])]
    note = "axes: those of the present sensors; for new places those of the body"
    title = f"peak acceleration along each axis (pulse {scene.pulse}{span}; left: share of the range)"
    return [Sheet(title, header, along, [note])]


def _gains(study: PlaceStudy) -> list[str]:
    """How much less shock the best place sees than each present sensor."""
    n = len(study.places)
    new = "the best place" if study.count == 1 else "the sensor" if n == 1 else "the pair" if n == 2 else f"{n} sensors"
    chosen = study.places if study.count > 1 else study.places[:1]
    new += " " + " and ".join("({:g}, {:g}, {:g})".format(*one.position.round(3) + 0.0) for one in chosen)
    lines = [] if study.today else [f"{new} sees {study.combined:.3g}"]
    for one in study.today:
        factor = one.combined / study.combined if study.combined > 0.0 else np.inf
        less = f"; a factor of {factor:.3g}" if factor < 1e6 else ""
        lines.append(f"{one.name} sees {one.combined:.3g}, {new} {study.combined:.3g}{less}")
    return lines


def _proof(study: PlaceStudy) -> list[str]:
    bound = max(profile.health.error_bound for profile in study.profiles)
    slides = [name for name, one in _named(study).items() if one.friction is not None and one.friction.impact is not None]
    sliding = f"; with friction, in double precision, where contacts slide: {few(slides, 4)}" if slides else ""
    what = "no place" if study.count == 1 else f"no {count(study.count, 'sensor')}"
    verb = "is" if study.count == 1 else "are"
    enough = count(len(study.places), "sensor")
    fewer = [f"{enough} of {study.count}: with more, the shock compared is not less"] if len(study.places) < study.count else []
    unfinished = "" if study.complete else "; the search ended at its limit before the optimum was proven"
    return [
        *fewer,
        f"optimum: {what} {study.region.text} {verb} below {study.bound:.6g} (gap {study.gap:.0e}){unfinished}",
        f"accuracy: the shock at these places is {proof_text(bound)}{sliding}",
    ]
