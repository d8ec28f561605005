"""A baseline, a JSON file: the numbers of an earlier design, and the design.

A later design is compared with them. Values have six significant digits, and their order is that of
their names, so that two baselines differ where designs do. The file says which scenes it belongs
to; the robot's file may change, since that is the design, but not the landing.

Schema `shockpc.baseline/2`.
"""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import shockpc
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import scene_table, with_paths
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

SHOWN = 3
"""Keys of another scene that a message lists."""

READ_OUT = ("point", "part", "range_g", "ground_tolerance")
"""Keys of a scene that change no value of another place, or only which landings are feasible."""


class OutcomeKey(NamedTuple):
    """Case, strike angle [deg], place and metric of a value; None for the scene's strike."""

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
        values = [abs(x) for key, x in self.values.items() if key.metric == metric]
        return max(filter(math.isfinite, values), default=0.0)


def case_record(landing: PosedLanding, angle_of_scene: bool) -> dict[str, Any]:
    """The record of a case: the robot's name, the scene without the paths of files, and the design.

    Args:
        landing: one landing of the case.
        angle_of_scene: whether the strike angle is the scene's, rather than one of a list.
    """
    scene = scene_table(with_paths(landing.scene, lambda path: Path(path).name))
    for key in (*FILES, *READ_OUT):
        scene.pop(key, None)
    if not angle_of_scene:
        scene["strike"] = dict(scene["strike"])
        scene["strike"].pop("strike_angle_deg", None)
    record = {"robot": landing.robot.name, "scene": scene, "design": design_record(landing)}
    plain: dict[str, Any] = json.loads(json.dumps(record))
    return plain


def baseline_text(cases: Mapping[str, Any], values: Mapping[OutcomeKey, float]) -> str:
    """The file of a baseline.

    Args:
        cases: as `case_record` gives them.
        values: the numbers.
    """
    scenes = {}
    for name in sorted(cases):
        scenes[name] = {"robot": cases[name]["robot"], "scene": cases[name]["scene"]}
    listed = []
    for key in sorted(values, key=_rank):
        value: float | str = six_digits(values[key])
        if math.isinf(values[key]):
            value = "inf"
        listed.append({**key._asdict(), "value": value})
    document = {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        "cases": scenes,
        "designs": _designs(cases),
        "values": listed,
    }
    return json_text(document)


def _designs(cases: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The designs of cases, each once, with the names of its cases."""
    designs: list[dict[str, Any]] = []
    names: list[list[str]] = []
    for name in sorted(cases):
        design = cases[name]["design"]
        if design in designs:
            names[designs.index(design)].append(name)
        else:
            designs.append(design)
            names.append([name])
    return [{"cases": of, **design} for of, design in zip(names, designs, strict=True)]


def _rank(key: OutcomeKey) -> tuple[str, float, str, str]:
    """Sort key of a value in the file: case, strike angle (the scene's first), place, metric."""
    angle = -math.inf if key.strike_angle_deg is None else key.strike_angle_deg
    return key.case, angle, key.at, key.metric


def read_baseline(path: Path) -> Baseline:
    """Read a baseline.

    Raises:
        StudyError: it cannot be read, or is none.
    """
    if not path.exists():
        raise StudyError(
            f'no baseline "{path}" (looked in {Path.cwd()}); write it with --update-baseline'
        )
    try:
        data = read_file(path, "baseline", StudyError)
        document = json.loads(data, object_pairs_hook=_unique, parse_constant=str)
        _refuse_deep(document)
        if document["schema"] != SCHEMA:
            schema = printable(str(document["schema"]), 60)
            raise StudyError(
                f'"{path}" has schema {schema}, not {SCHEMA}; write it anew with --update-baseline'
            )
        return _baseline(path, document)
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError):
        raise StudyError(
            f'"{path}" is not a baseline that shockpc check wrote; write it anew with '
            f"--update-baseline"
        ) from None


def _baseline(path: Path, document: Mapping[str, Any]) -> Baseline:
    """A baseline from its JSON. Raises ValueError, KeyError or TypeError if it is none."""
    numbers = []
    for entry in document["values"]:
        key = _outcome_key(entry)
        _number(key.strike_angle_deg or 0.0, key.metric)
        numbers.append((key, _number(entry["value"], key.metric)))
    cases = dict(document["cases"])
    designs = {}
    for design in document["designs"]:
        read = read_design(design)
        for name in design["cases"]:
            designs[name] = read
    of_cases = {name: designs[name] for name in cases}
    return Baseline(path, str(document["shockpc"]), cases, of_cases, _unique(numbers))


def _outcome_key(entry: Mapping[str, Any]) -> OutcomeKey:
    """The key of an entry of a baseline, with the current key of its metric."""
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
    """A value of a metric.

    It may be "inf" only where less is worse, so that no number passes because it is compared with
    infinity.

    Raises:
        ValueError: it is no such value.
    """
    if value == "inf" and select(metric).quantity.worse == "less":
        return math.inf
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value):
        raise ValueError("not a finite number")
    return float(value)


def _refuse_deep(value: Any, levels: int = 20) -> None:
    """Refuse, by a ValueError, more levels than a scene has."""
    if not levels:
        raise ValueError("nested too deep")
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
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
    here = _scene_leaves(record)
    # A baseline of an older version has no keys that scenes have had since then: it is of a scene
    # with their defaults.
    there = {}
    for key, value in _leaves(scene_table(Scene(robot="")), "scene"):
        if key in here:
            there[key] = value
    there |= _scene_leaves(baseline.cases[case])
    differing = [key for key in dict.fromkeys([*here, *there]) if here.get(key) != there.get(key)]
    if not differing:
        return
    listed = []
    for key in differing[:SHOWN]:
        listed.append(f"{key} is {_shown(here.get(key))} here and {_shown(there.get(key))} there")
    more = ""
    if len(differing) > SHOWN:
        more = f"; and {len(differing) - SHOWN} more"
    raise StudyError(
        f'baseline "{baseline.path}" is of another scene: {"; ".join(listed)}{more}; '
        "restore the scene, or write the baseline anew with --update-baseline"
    )


def _scene_leaves(record: Mapping[str, Any]) -> dict[str, Any]:
    """The values of the robot's name and the scene, by their keys in one line."""
    leaves = {}
    for key, value in _leaves(record, ""):
        if key.startswith(("robot", "scene")):
            leaves[key] = value
    return leaves


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
