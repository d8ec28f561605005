"""The output of a placement: table, Markdown, CSV, JSON (schema `shockpc.place/1`), and the files of a folder."""

import json
from typing import Any

import shockpc
from shockpc.model.dynamics import PINOCCHIO
from shockpc.printed import printable
from shockpc.scene import scene_table
from shockpc.show.document import plain
from shockpc.show.header import header_lines
from shockpc.show.tables.place import combined_text, gain_lines, landings_sheet, margin_sheets, places_sheet, proof_lines
from shockpc.show.tables.text import SHORT, as_csv, as_markdown, as_text, markdown_list
from shockpc.studies.place.study import PlaceStudy, SensorPlace

__all__ = ["SCHEMA", "place_document", "place_files", "place_text"]

SCHEMA = "shockpc.place/1"


def place_text(study: PlaceStudy, format_: str) -> str:
    """What goes to standard output. Args: format_, "table", "markdown", "csv" or "json"."""
    if format_ == "json":
        return json.dumps(place_document(study), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    if format_ == "csv":
        return as_csv(places_sheet(study))
    if format_ == "markdown":
        return _report(study)
    header = "\n".join(f"{name:<12} {text}" for name, text in _header(study)) + "\n"
    sheets = [places_sheet(study), *margin_sheets(study), landings_sheet(study, SHORT)]
    return "\n".join([header, *map(as_text, sheets), "".join(f"{printable(line)}\n" for line in _closing(study))])


def place_document(study: PlaceStudy) -> dict[str, Any]:
    """The study as JSON; positions in the body's frame [m], `null` where a thing does not exist."""
    return {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        "robot": {"name": study.robot.name, "file": study.robot.label},
        "body": study.robot.bodies[study.body].name,
        "region": study.region.text,
        "compared_by": "greatest" if study.weights is None else "weighted mean",
        "today": [_place(one, study) for one in study.today],
        "places": [_place(one, study) for one in study.places],
        "count": study.count,
        "combined": study.combined,
        "bound": study.bound,
        "gap": study.gap,
        "proven": study.complete,
        "apart": study.apart,
        "landings": [
            {
                "landing": name,
                "weight": None if study.weights is None else float(study.weights[k]),
                "sensor": study.places[study.assigned[k]].name,
                "copc": plain(study.profiles[k].copc[study.body]),
                "error_bound": study.profiles[k].health.error_bound,
                "warnings": [str(warning) for warning in study.profiles[k].health.warnings],
                "scene": scene_table(study.profiles[k].scene),
            }
            for k, name in enumerate(study.landings)
        ],
        "failures": [{"landing": name, "reason": reason} for name, reason in study.failures],
    }


def place_files(study: PlaceStudy) -> dict[str, str | bytes]:
    """The files of a folder by name."""
    from shockpc.show.figure.place import place_figure

    return {
        **place_figure(study),
        "place.json": place_text(study, "json"),
        "places.csv": place_text(study, "csv"),
        "landings.csv": as_csv(landings_sheet(study)),
        "report.md": _report(study, "place.svg"),
    }


def _place(one: SensorPlace, study: PlaceStudy) -> dict[str, Any]:
    """One place; its shock and its jump of velocity in the order of the landings."""
    margin = one.margin
    return {
        "name": one.name,
        "position": plain(one.position),
        "greatest": float(one.shocks.max()),
        "combined": one.combined,
        "bound": one.bound,
        "shock": plain(one.shocks),
        "delta_v": plain(one.delta_v),
        "margin": None
        if margin is None
        else {
            "peak_g": plain(margin.peak_g),
            "left": plain(margin.left),
            "mounting": {
                "rotation": plain(margin.mounting.rotation),
                "peak_g": margin.mounting.greatest,
                "bound": margin.mounting.bound,
                "left": margin.mounted_left,
            },
        },
    }


def _header(study: PlaceStudy) -> list[tuple[str, str]]:
    """What was computed: what all landings share, and how many they are."""
    shared = [dict(header_lines(profile)) for profile in study.profiles]
    lines = []
    for name in ("robot", "posture", "base", "joint model"):
        texts = {one[name] for one in shared}
        lines.append((name, texts.pop() if len(texts) == 1 else "differs between the landings"))
    names = study.landings
    listed = "; ".join(names) if len(names) <= 4 else f"{len(names)}, from {names[0]} to {names[-1]}"
    lines += [("landings", printable(listed)), ("where", printable(study.region.text)), ("compared by", combined_text(study))]
    return lines


def _closing(study: PlaceStudy) -> list[str]:
    """What was gained, what is proven, what could not be computed, and warnings."""
    return [
        *gain_lines(study),
        *proof_lines(study),
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


def _report(study: PlaceStudy, figure: str | None = None) -> str:
    """The study as Markdown."""
    picture = [] if figure is None else [f"![greatest shock over the body]({figure})\n"]
    sheets = [places_sheet(study), *margin_sheets(study), landings_sheet(study)]
    title = f"## Place of least shock on {study.robot.bodies[study.body].name} of {study.robot.name}\n"
    header = markdown_list(f"{name}: {text}" for name, text in _header(study))
    return "\n".join([title, header, *picture, *map(as_markdown, sheets), markdown_list(_closing(study))])
