"""A baseline: the numbers of an earlier design, with which a later one is compared, and that
design. A JSON file.

Values have six significant digits, and their order is that of their names, so that two baselines
differ where designs do. The file says which scenes it belongs to; the robot's file may change,
since that is the design, but not the landing.

Schema `shockpc.baseline/2`.
"""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import shockpc
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import scene_table, with_paths
from shockpc.method.dynamics import PINOCCHIO
from shockpc.quantities.renamed import current_name
from shockpc.quantities.selection import select
from shockpc.studies.check.design_record import design_record, read_design, six_digits
from shockpc.text.errors import StudyError
from shockpc.text.paths import read_file
from shockpc.text.printed import json_text, printable

SCHEMA = "shockpc.baseline/2"

FILES = ("robot", "srdf", "packages")
"""Keys of a scene that say where files are, which differs from computer to computer."""

READ_OUT = ("point", "part", "range_g", "ground_tolerance")
"""Keys of a scene that change no value of another place, or only which landings are feasible."""


class OutcomeKey(NamedTuple):
    """What a value belongs to: case, strike angle [deg] (None: the scene's strike), place and
    metric.
    """

    case: str
    strike_angle_deg: float | None
    at: str
    metric: str


class Baseline(NamedTuple):
    """A baseline as read.

    Attributes:
        path: of its file.
        version: of shockpc that wrote it.
        cases: what identifies the scene of each case.
        designs: of which the numbers of each case are, as `design_record` gives it.
        values: the numbers.
    """

    path: Path
    version: str
    cases: Mapping[str, Any]
    designs: Mapping[str, Any]
    values: Mapping[OutcomeKey, float]

    def largest(self, metric: str) -> float:
        """Magnitude of the largest finite value of a metric; 0 where there is none."""
        return max(
            (abs(x) for key, x in self.values.items() if key.metric == metric and math.isfinite(x)),
            default=0.0,
        )


def case_record(landing: PosedLanding, angle_of_scene: bool) -> dict[str, Any]:
    """What identifies the scene of a case, the robot's name and the scene without the paths of
    files; and the design.

    Args:
        landing: one landing of the case.
        angle_of_scene: whether the strike angle is the scene's, rather than one of a list.
    """
    scene = with_paths(landing.scene, lambda path: Path(path).name)
    table = {
        key: part for key, part in scene_table(scene).items() if key not in (*FILES, *READ_OUT)
    }
    if not angle_of_scene:
        table["strike"] = {
            key: part for key, part in table["strike"].items() if key != "strike_angle_deg"
        }
    record = {"robot": landing.robot.name, "scene": table, "design": design_record(landing)}
    plain: dict[str, Any] = json.loads(json.dumps(record))
    return plain


def baseline_text(cases: Mapping[str, Any], values: Mapping[OutcomeKey, float]) -> str:
    """The file of a baseline.

    Args:
        cases: as `case_record` gives them.
        values: the numbers.
    """
    designs: list[dict[str, Any]] = []
    for name in sorted(cases):
        record = {"cases": [name], **cases[name]["design"]}
        alike = next((design for design in designs if {**design, "cases": [name]} == record), None)
        if alike is None:
            designs.append(record)
        else:
            alike["cases"].append(name)
    order = sorted(
        values,
        key=lambda key: (
            key.case,
            -math.inf if key.strike_angle_deg is None else key.strike_angle_deg,
            key.at,
            key.metric,
        ),
    )
    listed = [
        {**key._asdict(), "value": "inf" if math.isinf(values[key]) else six_digits(values[key])}
        for key in order
    ]
    return json_text(
        {
            "schema": SCHEMA,
            "shockpc": shockpc.__version__,
            "pinocchio": PINOCCHIO,
            "cases": {
                name: {key: cases[name][key] for key in ("robot", "scene")}
                for name in sorted(cases)
            },
            "designs": designs,
            "values": listed,
        }
    )


def read_baseline(path: Path) -> Baseline:
    """Read a baseline.

    Raises:
        StudyError: it cannot be read, or is none.
    """
    renew = "write it anew with --update-baseline"
    if not path.exists():
        raise StudyError(
            f'no baseline "{path}" (looked in {Path.cwd()}); write it with --update-baseline'
        )
    try:
        data = read_file(path, "baseline", StudyError)
        document = json.loads(data, object_pairs_hook=_unique, parse_constant=str)
        _refuse_deep(document)
        if document["schema"] != SCHEMA:
            raise StudyError(
                f'"{path}" has schema {printable(str(document["schema"]), 60)}, not {SCHEMA}; '
                f"{renew}"
            )
        values = _unique(
            (
                _outcome_key(entry),
                _number(entry["value"], _outcome_key(entry).metric),
            )
            for entry in document["values"]
        )
        for key in values:
            _number(key.strike_angle_deg or 0.0, key.metric)
        cases = dict(document["cases"])
        designs = {
            name: read_design(design) for design in document["designs"] for name in design["cases"]
        }
        return Baseline(
            path, str(document["shockpc"]), cases, {name: designs[name] for name in cases}, values
        )
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError):
        raise StudyError(f'"{path}" is not a baseline that shockpc check wrote; {renew}') from None


def _outcome_key(entry: Mapping[str, Any]) -> OutcomeKey:
    """What an entry of a baseline belongs to, with the current key of its metric."""
    key = OutcomeKey(*(entry[name] for name in OutcomeKey._fields))
    return key._replace(metric=current_name(key.metric))


def _unique(pairs: Iterable[tuple[Any, Any]]) -> dict[Any, Any]:
    """A table; ValueError if a key is there twice."""
    listed = list(pairs)
    table = dict(listed)
    if len(table) < len(listed):
        raise ValueError("a key is there twice")
    return table


def _number(value: Any, metric: str) -> float:
    """A value; "inf" only where less is worse, so that no number is compared with infinity and
    passes. ValueError if it is none.
    """
    if value == "inf" and select(metric).quantity.worse == "less":
        return math.inf
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError("not a finite number")
    return float(value)


def _refuse_deep(value: Any, levels: int = 20) -> None:
    """Refuse, by a ValueError, more levels than a scene has."""
    if not levels:
        raise ValueError("nested too deep")
    for part in (
        value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    ):
        _refuse_deep(part, levels - 1)


def refuse_other_scene(baseline: Baseline, case: str, record: Mapping[str, Any]) -> None:
    """Refuse a baseline that does not hold a case, or holds another scene under its name.

    Raises:
        StudyError: the text names what differs.
    """
    if case not in baseline.cases:
        raise StudyError(
            f'baseline "{baseline.path}" has no case "{printable(case)}"; write it anew with '
            f"--update-baseline"
        )
    here, there = (
        {key: value for key, value in _leaves(table, "") if key.startswith(("robot", "scene"))}
        for table in (record, baseline.cases[case])
    )
    # A baseline of an older version has no keys that scenes have had since then: it is of a scene
    # with their defaults.
    there = {
        key: value for key, value in _leaves(scene_table(Scene(robot="")), "scene") if key in here
    } | there
    differing = [
        key
        for key in (*here, *(key for key in there if key not in here))
        if here.get(key) != there.get(key)
    ]
    if differing:
        listed = "; ".join(
            f"{key} is {_shown(here.get(key))} here and {_shown(there.get(key))} there"
            for key in differing[:3]
        )
        more = f"; and {len(differing) - 3} more" if len(differing) > 3 else ""
        raise StudyError(
            f'baseline "{baseline.path}" is of another scene: {listed}{more}; '
            "restore the scene, or write the baseline anew with --update-baseline"
        )


def _leaves(table: Any, key: str) -> Iterator[tuple[str, Any]]:
    if isinstance(table, Mapping):
        for name, part in table.items():
            yield from _leaves(part, f"{key}.{name}" if key else str(name))
    elif isinstance(table, list) and any(isinstance(part, Mapping) for part in table):
        for k, part in enumerate(table):
            yield from _leaves(part, f"{key}[{k}]")
    else:
        yield key, table


def _shown(value: Any) -> str:
    return "not set" if value is None else printable(json.dumps(value, ensure_ascii=False), 60)
