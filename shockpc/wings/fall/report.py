"""Falls: how the robot tips, and every strike as a landing, the worst first.

The pictures are in the attitude of the impact.
"""

import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from shockpc.landing.ratings import torque_limits
from shockpc.landing.scenes.scene import Scene
from shockpc.show.document import record
from shockpc.show.header import scene_lines, shared_warnings, unknown_lines
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.text.printed import count, few, in_degrees, listed, not_computed
from shockpc.wings.fall.margins import EFFORTS
from shockpc.wings.fall.planar_fall import Phase
from shockpc.wings.fall.study import Falls
from shockpc.wings.fall.tip_over import Tip

PAGE, ROWS = 12, 16
"""Strikes that the page shows in three dimensions; rows of a table on a terminal."""

LEAST_ROTATION = math.radians(1.0)
"""Rotation below which a part of the motion is not reported separately [rad]."""


def fall_report(falls: Falls) -> Report:
    """The falls."""
    profiles = {result.strike.name: result.profile for result in falls.results}
    sheets = {"strikes": lambda: _every_strike(falls), "falls": lambda: _tips(falls)}
    if _judged(falls):
        sheets["margins"] = lambda: _margins(falls)
    return Report(
        name="fall",
        title=f"Falls of {falls.robot.label}, {manner(falls)}",
        body=lambda full: _body(falls, full),
        # All but the margins.
        lead=3 + bool(falls.results) + bool(falls.tips),
        closing=not_computed(falls.failures, "falls", 6),
        warnings=list(_warnings(falls)),
        sheets=sheets,
        tables=True,
        document=lambda: _document(falls),
        landings=dict(list(profiles.items())[:PAGE]),
    )


def manner(falls: Falls) -> str:
    """Text of how the robot falls."""
    return f"dropped from {falls.drop:g} m" if falls.drop is not None else "tipping over"


def _body(falls: Falls, full: bool) -> Iterator[Section]:
    """The sections. Args: full, whether with all rows and columns."""
    yield Lines(list(_lines(falls)))
    if falls.results:
        title = "the robot in the moment of the worst impacts"
        yield Picture("fall", title, "wings.fall.figure:draw_falls", (falls,))
    if falls.tips:
        yield _tips(falls)
    yield from _strikes(falls, full)
    if _judged(falls):
        yield _margins(falls).largest(None if full else ROWS, "margin")


def _lines(falls: Falls) -> Iterator[tuple[str, str]]:
    """The lines above the tables: what falls, on what ground, and how."""
    if falls.results:
        profile = falls.results[0].profile
        header = dict(scene_lines(profile))
        scenes = [result.profile.landing.scene for result in falls.results]
        postures = dict.fromkeys(scene.posture.reference or "" for scene in scenes)
        yield from unknown_lines(result.profile for result in falls.results)
        yield "robot", header["robot"]
        yield (
            "posture",
            f"{listed(postures)}; joints are held until a strike, and move in it with their drives",
        )
        yield "joint model", header["joint model"]
        yield "ground", f"level, rigid, no restitution; {_contact_law(profile.scene)}"
    if falls.drop is not None:
        yield "attitudes", _attitudes(falls)
    for note in falls.notes:
        yield "geometry", note


def _contact_law(scene: Scene) -> str:
    """Text of how contacts of a scene stick or slide."""
    if scene.friction is not None:
        law = f"friction {scene.friction:g}"
    else:
        law = (
            "contacts stick unless they would be pulled, and slide then; --friction MU for "
            "contacts that slide"
        )
    if scene.yields:
        law += "; with a contact stiffness, contacts that exist before a strike are left out of it"
    return law


def _attitudes(falls: Falls) -> str:
    """Text of the attitudes of drops."""
    # The names of drops end with "face top", "edge right-top" and so on, or "attitude 1".
    kinds = {result.strike.fall.split()[-2] for result in falls.results}
    if "attitude" not in kinds:
        return (
            "faces, edges and corners of the box around the posture, the centre of mass above "
            "it (MIL-STD-810H, method "
            "516.8, procedure IV; diagonals of the box are another interpretation)"
        )
    return "spread evenly; rotation about the vertical does not matter"


def _warnings(falls: Falls) -> Iterator[str]:
    """The warnings of tips, strikes and their landings."""
    for tip in falls.tips:
        for text in tip.warnings:
            yield f"warning: {tip.name}: {text}"
    for result in falls.results:
        if result.strike.remark:
            yield f"warning: {result.strike.name}: {result.strike.remark}"
    profiles = {result.strike.name: result.profile for result in falls.results}
    yield from shared_warnings(profiles, without="height")


class TippingMotion(NamedTuple):
    """Phases of a fall that are one motion.

    Attributes:
        kinds: how the body moves.
        end: rotation at the end [rad].
        short: it turns by less than `LEAST_ROTATION`.
    """

    kinds: set[str]
    end: float
    short: bool


def moves(tip: Tip, until: float) -> str:
    """Text of how a robot moves, and to which rotations [deg], up to one [rad].

    What alternates within `LEAST_ROTATION`, as on a round foot, is one motion.
    """
    motions: list[TippingMotion] = []
    phases = [phase for phase in tip.fall.phases if phase.start.theta < until]
    for kind, group in itertools.groupby(phases, lambda phase: phase.kind):
        same_kind = list(group)
        end = min(same_kind[-1].end.theta, until)
        short = end - same_kind[0].start.theta < LEAST_ROTATION
        kinds: set[str] = {kind}
        if motions and short and motions[-1].short:
            kinds |= motions.pop().kinds
        motions.append(TippingMotion(kinds, end, short))
    # Of motions with the same words the last one counts.
    words: list[tuple[str, float]] = []
    for motion in motions:
        if motion.short and len(motion.kinds) == 1 and len(motions) > 1:
            continue
        text = " and ".join(sorted(motion.kinds))
        if words and words[-1][0] == text:
            words.pop()
        words.append((text, motion.end))
    return ", ".join(f"{text} to {in_degrees(end):.3g}" for text, end in words)


def _tips(falls: Falls) -> Sheet:
    """A row for each posture and heading."""
    rows: list[Row] = []
    for tip in falls.tips:
        strikes = [strike for strike in falls.strikes if strike.fall == tip.name]
        balance = in_degrees(tip.balance)
        if not strikes:
            motion = moves(tip, math.inf)
            rows.append((tip.name, balance, tip.least_push, motion, None, None, 0, None, None))
            continue
        first = strikes[0]
        fastest = max(strikes, key=lambda strike: (strike.speed, strike.number))
        rows.append(
            (
                tip.name,
                balance,
                tip.least_push,
                moves(tip, first.rotation),
                first.struck_text,
                first.speed,
                len(strikes),
                fastest.number,
                fastest.speed,
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


def _strikes(falls: Falls, full: bool) -> list[Sheet]:
    """The strikes, the worst first.

    Args: full, whether with all rows and columns, in two tables.
    """
    every = _every_strike(falls)
    name = every.keys.index("strike")
    by_name = {row[name]: row for row in every.rows}
    sheet = every._replace(rows=[by_name[result.strike.name] for result in falls.results])
    values: list[str] = []
    for text in falls.quantities:
        values.append(text)
        if full or text == falls.rank:
            values.append(f"{text}_at")
    caused = [*values, "trunk_free", "trunk_with_drives", "trunk_locked"]
    motion = ["struck_links"]
    if falls.tips:
        if full:
            motion += ["motion", "rate"]
        motion.append("rotation_deg")
    motion.append("speed")
    notes = _notes(falls, full)
    title = f"{count(len(falls.results), 'strike')}, ranked by {falls.rank}"
    if not full:
        shown = sheet.only("strike", *motion, *caused)._replace(title=title, notes=notes)
        return [shown.largest(ROWS, "strike")]
    before = sheet.only("strike", *motion, "first_at_its_stop", "stop_after")
    effects = sheet.only("strike", *caused)
    return [
        before._replace(title=title),
        effects._replace(title="what these strikes cause", notes=notes),
    ]


def _notes(falls: Falls, full: bool) -> list[str]:
    """The notes under the strikes."""
    notes = [
        "struck links: that meet the ground together, with their speeds if they differ; speed: of "
        "the fastest towards the ground",
        "trunk: |Δv| at the heaviest body's centre of mass with free joints, drives and locked "
        "joints; any may be the largest",
    ]
    if _filtered_bound(falls):
        notes.append(
            "filtered_peak: at most, for a pulse of any length; a pulse or a contact stiffness "
            "gives the reading"
        )
    near: dict[str, str] = {}
    stands: dict[str, str] = {}
    end_stops: dict[str, str] = {}
    for result in falls.results:
        strike = result.strike
        if strike.near:
            near[strike.name] = listed(strike.near)
        if strike.stands:
            stands[strike.name] = listed(strike.stands)
        if result.stop is not None and not full:
            joint, time = result.stop
            end_stops[strike.name] = f"{joint} {1e3 * time:.3g} ms"
    for subject, texts in (
        ("within 5 mm of striking too", near),
        ("on the ground already and pressing", stands),
        ("first at its stop if rates stay", end_stops),
    ):
        if texts:
            first = itertools.islice(texts.items(), 4)
            notes.append(f"{subject}: " + "; ".join(f"{text} ({name})" for name, text in first))
    if not full:
        notes.append("places, rates and stops of every strike: --out DIR, --format md or json")
    return notes


def _filtered_bound(falls: Falls) -> bool:
    """True if filtered peaks are bounds, as the scene says nothing of how long a strike lasts."""
    if not falls.results:
        return False
    scene = falls.results[0].profile.scene
    filtered = any(text.startswith("filtered_peak") for text in falls.quantities)
    return filtered and scene.pulse is None and not scene.yields


def _judged(falls: Falls) -> bool:
    """True if parts or joints are compared with what they withstand."""
    return bool(falls.margins) or EFFORTS in falls.quantities


def _margins(falls: Falls) -> Sheet:
    """The parts and joints nearest to what they withstand, each with its worst strike."""
    rows: list[Row] = []
    for margin in falls.margins:
        rows.append(
            (
                margin.name,
                margin.kind,
                margin.margin,
                margin.torque,
                margin.withstands,
                margin.strike,
            )
        )
    scene = falls.results[0].profile.scene
    limits = torque_limits(falls.robot, scene.part)[0]
    named = {margin.name for margin in falls.margins}
    notes: list[str] = []
    bare = []
    for joint in falls.robot.single_joints:
        if joint.axis is not None and np.isnan(limits[joint.v.start]):
            bare.append(joint.name)
    if bare:
        unrated = few([name for name in bare if name not in named], 4)
        notes.append(f"no torque or effort limit is known of {unrated}")
    unjudged = []
    for result in falls.results:
        if result.profile.redundant and math.isnan(result.values.get(EFFORTS, 0.0)):
            unjudged.append(result.strike.name)
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


def _every_strike(falls: Falls) -> Sheet:
    """All strikes in the order in which they happen."""
    sheet = sheet_of(falls.table, messages="failure").without("proven")
    return sheet.headed({"stop_after": "stop after [ms]"})


def _document(falls: Falls) -> dict[str, Any]:
    """The document, beside its tables, schema `shockpc.fall/2`.

    Angles are in degrees; the worst strikes come first.
    """
    return {
        "rank": falls.rank,
        "drop": falls.drop,
        "falls": list(map(_tip_document, falls.tips)),
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


def _tip_document(tip: Tip) -> dict[str, Any]:
    """A fall in the document."""
    return {
        "fall": tip.name,
        "forward": tip.forward,
        "hinged": tip.hinged,
        "rests": tip.fall.rests,
        "phases": list(map(_phase_document, tip.fall.phases)),
        "warnings": tip.warnings,
    }


def _phase_document(phase: Phase) -> dict[str, Any]:
    """A part of a fall in the document."""
    return {
        "motion": phase.kind,
        "from_deg": in_degrees(phase.start.theta),
        "to_deg": in_degrees(phase.end.theta),
        "rate": phase.end.omega,
    }
