"""Where a sensor sees least shock: places, margins, the shock in each landing, what is gained and what is proven."""

from typing import TYPE_CHECKING, Any

import numpy as np

from shockpc.show.document import head, plain, record
from shockpc.show.header import count, header_lines
from shockpc.show.reports.report import Report
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.place.study import PlaceStudy, SensorPlace

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["place_report"]


def place_report(study: PlaceStudy) -> Report:
    """The places of least shock on a body."""

    def draw() -> "Figure":
        from shockpc.show.figure.place import draw_place

        return draw_place(study)

    return Report(
        name="place",
        title=f"Place of least shock on {study.robot.bodies[study.body].name} of {study.robot.name}",
        header=_header(study),
        tables=lambda most: [_places(study), *_margins(study), _landings(study, most)],
        short=6,
        closing=_closing(study),
        sheets={"places": lambda: _places(study), "landings": lambda: _landings(study)},
        document=lambda: _document(study),
        picture="place",
        caption="greatest shock over the body",
        draw=draw,
    )


def _document(study: PlaceStudy) -> dict[str, Any]:
    """The document, schema `shockpc.place/1`; positions in the body's frame [m]."""
    return {
        **head("place"),
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
                "weight": None if study.weights is None else float(study.weights[k]),
                "sensor": study.places[study.assigned[k]].name,
                "copc": plain(study.profiles[k].copc[study.body]),
                **record(study.profiles[k].health, "error_bound", "warnings"),
                "scene": plain(study.profiles[k].scene),
            }
            for k, name in enumerate(study.landings)
        ],
        "failures": [{"landing": name, "reason": reason} for name, reason in study.failures],
    }


def _place(one: SensorPlace) -> dict[str, Any]:
    """One place; its shock and its jump of velocity in the order of the landings."""
    found = {
        **record(one, "name", "position"),
        "greatest": float(one.shocks.max()),
        **record(one, "combined", "bound"),
        "shock": plain(one.shocks),
        "delta_v": plain(one.delta_v),
        "margin": None,
    }
    if one.margin is not None:
        mounting = one.margin.mounting
        turned = {"rotation": plain(mounting.rotation), "peak_g": mounting.greatest, "bound": mounting.bound}
        found["margin"] = {**record(one.margin, "peak_g", "left"), "mounting": {**turned, "left": one.margin.mounted_left}}
    return found


def _header(study: PlaceStudy) -> list[tuple[str, str]]:
    """What was computed: what all landings share, and how many they are."""
    shared = [dict(header_lines(profile)) for profile in study.profiles]
    lines = []
    for name in ("robot", "posture", "base", "joint model"):
        texts = {one[name] for one in shared}
        lines.append((name, texts.pop() if len(texts) == 1 else "differs between the landings"))
    names = study.landings
    listed = "; ".join(names) if len(names) <= 4 else f"{len(names)}, from {names[0]} to {names[-1]}"
    number = "greatest shock" if study.weights is None else "weighted mean of the shock"
    return [*lines, ("landings", listed), ("where", study.region.text), ("compared by", f"{number} over the landings")]


def _places(study: PlaceStudy) -> Sheet:
    """Today's sensors, then the places found, in coordinates of the body's frame."""
    mean = study.weights is not None
    rows: list[tuple[Cell, ...]] = []
    for one in (*study.today, *study.places):
        k = int(np.argmax(one.shocks))
        means = (one.combined,) if mean else ()
        rows.append((one.name, *map(float, one.position), *means, float(one.shocks[k]), study.landings[k]))
    notes = []
    if study.count > 1:
        rows.append(("together", None, None, None, *((study.combined,) if mean else ()), *_together(study)))
        notes.append("together: in each landing the sensor with the least shock")
    elif len(study.places) > 1:
        notes.append(f"each further place: the best one at least {study.apart:.3g} m along x, y or z from those before")
    header = ("place", "x [m]", "y [m]", "z [m]", *(("weighted mean [-]",) if mean else ()), "greatest shock [-]", "in landing")
    return Sheet(
        f"places on {study.robot.bodies[study.body].name} (in its frame; shock relative to the strike)", header, rows, tuple(notes)
    )


def _landings(study: PlaceStudy, most: int | None = None) -> Sheet:
    """The shock at each place in each landing. Args: most, rows to show, those of the greatest shock."""
    places = (*study.today, *study.places)
    shocks = np.array([one.shocks for one in places])
    order = list(range(len(study.landings)))
    kept = order if most is None else sorted(sorted(order, key=lambda k: -float(shocks[:, k].max()))[:most])
    rows: list[tuple[Cell, ...]] = [(study.landings[k], *map(float, shocks[:, k])) for k in kept]
    if study.weights is not None:
        rows = [(row[0], float(study.weights[k]), *row[1:]) for k, row in zip(kept, rows, strict=True)]
    left = len(order) - len(kept)
    notes = (f"{count(left, 'landing')} with less shock not shown; --out writes all",) if left else ()
    header = ("landing", *(("weight [-]",) if study.weights is not None else ()), *(f"{one.name} [-]" for one in places))
    return Sheet("shock in each landing", header, rows, notes)


def _margins(study: PlaceStudy) -> list[Sheet]:
    """Peaks along the axes of each sensor with what is left of its range, and its best mounting; nothing without a pulse."""
    places = [(one.name, one.margin) for one in (*study.today, *study.places) if one.margin is not None]
    if not places:
        return []
    scene = study.profiles[0].scene
    span = "" if scene.range_g is None else f", range {scene.range_g:g} g"
    along: list[tuple[Cell, ...]] = []
    turned: list[tuple[Cell, ...]] = []
    for name, margin in places:
        left = () if margin.left is None else tuple(float(100.0 * share) for share in margin.left)
        along.append((name, *map(float, margin.peak_g), *left))
        mounted = () if margin.mounted_left is None else (100.0 * margin.mounted_left,)
        turned.append((name, *margin.mounting.rpy_deg, margin.mounting.greatest, *mounted))
    header = ("place", "peak x [g]", "y [g]", "z [g]", *(("left x [%]", "y [%]", "z [%]") if span else ()))
    mounting = ("place", "roll [deg]", "pitch [deg]", "yaw [deg]", "greatest peak [g]", *(("left [%]",) if span else ()))
    note = "axes: those of the present sensors; for new places those of the body"
    return [
        Sheet(f"peak acceleration along each axis (pulse {scene.pulse}{span}; left: share of the range)", header, along, (note,)),
        Sheet("mounting with the largest margin (rotation against the body)", mounting, turned),
    ]


def _gains(study: PlaceStudy) -> list[str]:
    """How much less shock the best place sees than each present sensor."""
    new = "the pair" if study.count == 2 else f"{study.count} sensors" if study.count > 2 else "the best place"
    where = " and ".join(map(_coordinates, study.places if study.count > 1 else study.places[:1]))
    if not study.today:
        return [f"{new} {where} sees {study.combined:.3g}"]
    lines = []
    for one in study.today:
        factor = one.combined / study.combined if study.combined > 0.0 else np.inf
        less = f"; a factor of {factor:.3g}" if factor < 1e6 else ""
        lines.append(f"{one.name} sees {one.combined:.3g}, {new} {where} {study.combined:.3g}{less}")
    return lines


def _proof(study: PlaceStudy) -> list[str]:
    """The bound on the optimum, and the accuracy of the numbers."""
    bound = max(profile.health.error_bound for profile in study.profiles)
    what = "no place" if study.count == 1 else f"no {count(study.count, 'sensor')}"
    optimum = (
        f"optimum: {what} {study.region.text} {'is' if study.count == 1 else 'are'} below {study.bound:.6g} (gap {study.gap:.0e})"
    )
    if not study.complete:
        optimum += "; the search ended at its limit before the optimum was proven"
    return [optimum, f"accuracy: the shock at these places is proven to {bound:.0e} of the body's motion"]


def _together(study: PlaceStudy) -> tuple[float, str]:
    """The greatest of the least shocks, and its landing."""
    least = np.min([one.shocks for one in study.places], axis=0)
    return float(least.max()), study.landings[int(least.argmax())]


def _coordinates(one: SensorPlace) -> str:
    """A place in the body's frame, to a millimetre."""
    return "({})".format(", ".join(f"{round(float(x), 3) + 0.0:g}" for x in one.position))


def _closing(study: PlaceStudy) -> list[str]:
    """What was gained, what is proven, what could not be computed, and warnings."""
    return [
        *_gains(study),
        *_proof(study),
        *(f"not computed: {name}: {reason}" for name, reason in study.failures),
        *(f"warning: {text}" for text in [*study.region.warnings, *_warnings(study)]),
    ]


def _warnings(study: PlaceStudy) -> list[str]:
    """One line for each thing that landings warn of, with the landing in which it is largest; margins stand in a table."""
    found: dict[tuple[str, str], list[tuple[float, str, str]]] = {}
    for name, profile in zip(study.landings, study.profiles, strict=True):
        for one in profile.health.warnings:
            if one.kind != "sensor":
                found.setdefault((one.kind, one.subject), []).append((abs(one.value or 0.0), str(one), name))
    lines = []
    for every in found.values():
        _, text, name = max(every, key=lambda one: one[0])
        where = (
            ""
            if len(every) == len(study.landings)
            else f" (in {name}" + (f", less in {len(every) - 1} more)" if every[1:] else ")")
        )
        lines.append(text + where)
    return lines
