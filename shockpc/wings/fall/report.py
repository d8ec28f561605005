"""Falls: how the robot tips, and every strike as a landing, the worst first.

The pictures are in the attitude of the impact.
"""

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from shockpc.landing.ratings import torque_limits
from shockpc.show.document import record
from shockpc.show.header import scene_lines, shared_warnings, unknown_lines
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Column, Lines, Row, Sheet
from shockpc.text.printed import cause_lines, causes, count, few, in_degrees, listed
from shockpc.wings.fall.strikes import FallStrike, Tip
from shockpc.wings.fall.study import EFFORTS, Falls, StrikeResult

PAGE, ROWS = 12, 16
"""Strikes that the page shows in three dimensions; rows of a table on a terminal."""

LEAST_ROTATION = math.radians(1.0)
"""Rotation below which a part of the motion is not reported separately [rad]."""

LIMITS = ("height", "contact", "limits")
"""Kinds of warnings that every strike of a fall may have.

They are of flat ground, on which its strikes are chosen, and of the posture.
"""


def fall_report(falls: Falls) -> Report:
    """The falls."""
    what = f"dropped from {falls.drop:g} m" if falls.drop is not None else "tipping over"
    picture = Picture(
        "fall",
        "the robot in the moment of the worst impacts",
        "wings.fall.figure:draw_falls",
        (falls,),
    )
    profiles = {result.strike.name: result.profile for result in falls.results}
    return Report(
        name="fall",
        title=f"Falls of {falls.robot.label}, {what}",
        body=lambda full: [
            Lines(list(_lines(falls))),
            *([picture] if falls.results else []),
            *([_tips(falls)] if falls.tips else []),
            *_strikes(falls, full),
            *(
                [_margins(falls).largest(None if full else ROWS, "margin")]
                if _judged(falls)
                else []
            ),
        ],
        lead=3 + bool(falls.results) + bool(falls.tips),
        closing=[
            f"not computed: {line}"
            for line in cause_lines(
                causes((name, str(why)) for name, why in falls.failures), "falls", 6
            )
        ],
        warnings=[
            *(f"warning: {tip.name}: {text}" for tip in falls.tips for text in tip.warnings),
            *_warnings(falls),
        ],
        sheets={
            "strikes": lambda: _every_strike(falls),
            "falls": lambda: _tips(falls),
            **({"margins": lambda: _margins(falls)} if _judged(falls) else {}),
        },
        tables=True,
        document=lambda: _document(falls),
        landings=dict(list(profiles.items())[:PAGE]),
    )


def _lines(falls: Falls) -> Iterator[tuple[str, str]]:
    if falls.results:
        header = dict(scene_lines(falls.results[0].profile))
        postures = dict.fromkeys(
            result.profile.landing.scene.posture.reference or "" for result in falls.results
        )
        yield from unknown_lines(result.profile for result in falls.results)
        yield "robot", header["robot"]
        yield (
            "posture",
            f"{listed(postures)}; joints are held until a strike, and move in it with their drives",
        )
        yield "joint model", header["joint model"]
        friction = falls.results[0].profile.scene.friction
        sticks = (
            "contacts stick unless they would be pulled, and slide then; --friction MU for "
            "contacts that slide"
        )
        rest = f"friction {friction:g}" if friction is not None else sticks
        if falls.results[0].profile.scene.yields:
            rest += (
                "; with a contact stiffness, contacts that exist before a strike are left out of it"
            )
        yield "ground", f"level, rigid, no restitution; {rest}"
    if falls.drop is not None:
        yield (
            "attitudes",
            (
                "faces, edges and corners of the box around the posture, the centre of mass above "
                "it (MIL-STD-810H, method "
                "516.8, procedure IV; diagonals of the box are another interpretation)"
                if any(name.split()[-2:][0] in ("face", "edge", "corner") for name in _names(falls))
                else "spread evenly; rotation about the vertical does not matter"
            ),
        )
    for note in falls.notes:
        yield "geometry", note


def _names(falls: Falls) -> list[str]:
    return [result.strike.fall for result in falls.results]


def _warnings(falls: Falls) -> list[str]:
    profiles = {result.strike.name: result.profile for result in falls.results}
    remarks = [
        f"warning: {result.strike.name}: {result.strike.remark}"
        for result in falls.results
        if result.strike.remark
    ]
    return [*remarks, *(line for line in shared_warnings(profiles, without="height"))]


def moves(tip: Tip, until: float) -> str:
    """Text of how a robot moves, and to which rotations [deg], up to one [rad].

    What alternates within `LEAST_ROTATION`, as on a round foot, is one motion.
    """
    parts: list[tuple[bool, set[str], float]] = []
    for kind, phases in itertools.groupby(
        (p for p in tip.fall.phases if p.start.theta < until), lambda phase: phase.kind
    ):
        same_kind = list(phases)
        end = min(same_kind[-1].end.theta, until)
        short = end - same_kind[0].start.theta < LEAST_ROTATION
        alternates = parts and short and parts[-1][0]
        kinds = {kind} | (parts.pop()[1] if alternates else set())
        parts.append((short, kinds, end))
    words = [
        (" and ".join(sorted(kinds)), end)
        for short, kinds, end in parts
        if not short or len(kinds) > 1 or len(parts) == 1
    ]
    last = [list(same)[-1] for _, same in itertools.groupby(words, lambda part: part[0])]
    return ", ".join(f"{kind} to {in_degrees(end):.3g}" for kind, end in last)


def _tips(falls: Falls) -> Sheet:
    """A row for each posture and heading."""
    rows: list[Row] = []
    for tip in falls.tips:
        strikes = [strike for strike in falls.strikes if strike.fall == tip.name]
        first = (struck_words(strikes[0]), strikes[0].speed) if strikes else (None, None)
        speed, number = max(
            ((strike.speed, strike.number) for strike in strikes), default=(None, None)
        )
        rows.append(
            (
                tip.name,
                in_degrees(tip.balance),
                tip.least_push,
                moves(tip, strikes[0].rotation if strikes else math.inf),
                *first,
                len(strikes),
                number,
                speed,
            )
        )
    header = (
        "fall",
        "balance [deg]",
        "minimum push [m/s]",
        "motion [deg]",
        "first strike",
        "speed [m/s]",
        "strikes",
        "fastest",
        "at most [m/s]",
    )
    note = (
        "balance: rotation from which it falls by itself; minimum push: speed that a level push "
        "has to give to its centre of mass"
    )
    return Sheet(
        f"{count(len(rows), 'fall')}, each followed until the robot rests", header, rows, [note]
    )


def struck_words(strike: FallStrike) -> str:
    """Text of what strikes: each link, its speed where these differ, and if it separates."""
    speeds = {f"{speed:.3g}" for speed in strike.struck.values()}
    named = (
        f"{link}{f' {speed:.3g}' * (len(speeds) > 1)}"
        f"{' (separates)' * (link not in strike.pressing)}"
        for link, speed in strike.struck.items()
    )
    return few(list(named), 4) if len(strike.struck) > 1 else next(iter(strike.struck))


def _strikes(falls: Falls, full: bool) -> list[Sheet]:
    """The strikes, the worst first.

    Args: full, whether with all rows and columns, in two tables.
    """
    every, tipping = _every_strike(falls), bool(falls.tips)
    name = [column.key for column in every.columns].index("strike")
    by_name = {row[name]: row for row in every.rows}
    values = [
        key
        for text in falls.quantities
        for key in (text, *[f"{text}_at"] * (full or text == falls.rank))
    ]
    motion = [
        "struck_links",
        *("motion", "rate") * (tipping and full),
        *("rotation_deg",) * tipping,
        "speed",
    ]
    causes_ = [*values, "trunk_free", "trunk_with_drives", "trunk_locked"]
    sheet = every._replace(rows=[by_name[result.strike.name] for result in falls.results])
    stops = {one.strike.name: text for one in falls.results if not full and (text := _stop(one))}
    listings: dict[str, dict[str, str]] = {
        "within 5 mm of striking too": {
            one.strike.name: listed(one.strike.near) for one in falls.results if one.strike.near
        },
        "on the ground already and pressing": {
            one.strike.name: listed(one.strike.stands) for one in falls.results if one.strike.stands
        },
        "first at its stop if rates stay": stops,
    }
    scene = falls.results[0].profile.scene if falls.results else None
    bound = any(text.startswith("filtered_peak") for text in falls.quantities)
    bound = bound and scene is not None and scene.pulse is None and not scene.yields
    notes = [
        "struck links: that meet the ground together, with their speeds if they differ; speed: of "
        "the fastest towards the ground",
        "trunk: |Δv| at the heaviest body's centre of mass with free joints, drives and locked "
        "joints; any may be the largest",
        "filtered_peak: at most, for a pulse of any length; a pulse or a contact stiffness gives "
        "the reading" * bound,
        *(
            f"{what}: "
            + "; ".join(f"{text} ({name})" for name, text in itertools.islice(named.items(), 4))
            for what, named in listings.items()
            if named
        ),
        "places, rates and stops of every strike: --out DIR, --format md or json" * (not full),
    ]
    title, notes = (
        f"{count(len(falls.results), 'strike')}, ranked by {falls.rank}",
        list(filter(None, notes)),
    )
    if full:
        before = sheet.only("strike", *motion, "first_at_its_stop", "stop_after")._replace(
            title=title
        )
        return [
            before,
            sheet.only("strike", *causes_)._replace(title="what these strikes cause", notes=notes),
        ]
    return [
        sheet.only("strike", *motion, *causes_)
        ._replace(title=title, notes=notes)
        .largest(ROWS, "strike")
    ]


def _judged(falls: Falls) -> bool:
    """True if parts or joints are compared with what they withstand."""
    return bool(falls.margins) or EFFORTS in falls.quantities


def _margins(falls: Falls) -> Sheet:
    """The parts and joints nearest to what they withstand, each with its worst strike."""
    rows: list[Row] = [
        (one.name, one.kind, one.margin, one.torque, one.withstands, one.strike)
        for one in falls.margins
    ]
    scene, robot = falls.results[0].profile.scene, falls.robot
    limits, named = torque_limits(robot, scene.part)[0], {one.name for one in falls.margins}
    bare = [
        joint.name
        for joint in robot.single_joints
        if joint.axis is not None and np.isnan(limits[joint.v.start])
    ]
    notes = (
        [
            f"no torque or effort limit is known of "
            f"{few([name for name in bare if name not in named], 4)}"
        ]
        if bare
        else []
    )
    unjudged = [
        one.strike.name
        for one in falls.results
        if one.profile.redundant and math.isnan(one.values.get(EFFORTS, 0.0))
    ]
    if unjudged:
        notes.append(
            f"joints are not judged in {few(unjudged, 4)}, because contacts or loops are "
            "redundant; give a contact stiffness"
        )
    if scene.pulse is not None and not scene.yields:
        notes.append(
            f"torque: peak of one that has the pulse {scene.pulse} and the impulse along the axis"
        )
    if scene.friction is not None:
        notes.append("of contacts that stick")
    header = (
        "part or joint",
        "kind",
        "margin [-]",
        "torque [N m, N]",
        "withstands [N m, N]",
        "strike",
    )
    title = "margins (survivable contact velocity / contact velocity), each in its worst strike"
    return Sheet(title, header, rows, notes)


def _stop(result: StrikeResult) -> str | None:
    return None if result.stop is None else f"{result.stop[0]} {1e3 * result.stop[1]:.3g} ms"


def _every_strike(falls: Falls) -> Sheet:
    """All strikes in the order in which they happen."""
    table, stop_of = falls.table, {one.strike.name: one.stop for one in falls.results}
    known = {(one.fall, one.number): one for one in falls.strikes}
    keys = zip(table.columns["fall"].tolist(), table.columns["number"].tolist(), strict=True)
    strikes = [known.get(key) for key in keys]
    names = [one and one.name for one in strikes]
    stops = [stop_of.get(name or "") for name in names]
    columns: dict[Any, Any] = {}
    for name, values in table.columns.items():
        if name not in ("landing", "proven"):
            columns[name, table.units[name]] = [
                cell if cell != "" else None for cell in values.tolist()
            ]
        if name == "number":
            columns["strike", ""] = names
        if name == "struck":
            columns["struck links", ""] = [one and struck_words(one) for one in strikes]
    columns["first at its stop", ""] = [stop and stop[0] for stop in stops]
    columns["stop after", "ms"] = [stop and float(stop[1]) for stop in stops]
    columns["failure", ""] = [table.messages.get(i) for i in range(len(table))]
    return Sheet.of(
        "",
        {
            Column.of(f"{name} [{unit}]" if unit else name): cells
            for (name, unit), cells in columns.items()
        },
    )


def _document(falls: Falls) -> dict[str, Any]:
    """The document, beside its tables, schema `shockpc.fall/2`.

    Angles are in degrees; the worst strikes come first.
    """
    return {
        "rank": falls.rank,
        "drop": falls.drop,
        "falls": [
            {
                "fall": tip.name,
                "forward": tip.forward,
                "hinged": tip.hinged,
                "rests": tip.fall.rests,
                "phases": [
                    {
                        "motion": phase.kind,
                        "from_deg": in_degrees(phase.start.theta),
                        "to_deg": in_degrees(phase.end.theta),
                        "rate": phase.end.omega,
                    }
                    for phase in tip.fall.phases
                ],
                "warnings": tip.warnings,
            }
            for tip in falls.tips
        ],
        "strikes": [
            {
                **record(result.strike, "fall", "number", "struck", "near", "pressing", "stands"),
                "remark": result.strike.remark or None,
                "warnings": result.profile.health.warnings,
                "scene": result.profile.scene,
            }
            for result in falls.results
        ],
        "failures": [{"fall": name, "reason": str(reason)} for name, reason in falls.failures],
        "notes": falls.notes,
    }
