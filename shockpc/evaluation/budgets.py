"""Budgets: which numbers of which landings have limits.

Read from a TOML file for them or from a pyproject.toml.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple

from shockpc.core.frozen import frozen
from shockpc.core.number import number_from
from shockpc.core.spatial import Array
from shockpc.evaluation.table import percentile
from shockpc.landing.scenes.scene import Part, Scene
from shockpc.landing.scenes.scene_fields import CHECKED
from shockpc.landing.scenes.scene_file import read_scene, record_schema, scene_from, scene_table
from shockpc.landing.scenes.strike import replaced_ways
from shockpc.quantities.renamed import current_name
from shockpc.quantities.selection import Selection, select, selections
from shockpc.text.errors import SceneError, ShockError, StudyError
from shockpc.text.paths import read_file, usable_path
from shockpc.text.printed import printable
from shockpc.text.toml import converted, reading, unknown_key

STANDARD = ("budgets.toml", "pyproject.toml")
"""Files that are looked for in the current folder."""


KEYS = ("case", "budget", "part", "baseline")
"""Keys of a file of budgets."""

LEAST_CHANGE = 1e-3
"""Share of a metric's largest value in the baseline by which a value may always be off.

It is for tolerances that are shares.
"""

DESIGNS, MOST_DESIGNS = 1000.0, 1_000_000
"""Random designs of one landing: by default, and at most."""


@dataclass(frozen=True, kw_only=True)
class DesignVariation:
    """A property of a design that is not known.

    Attributes:
        values: its distribution, as `sweep --vary` takes it with --sample, such as "±5%" or
            "0.5x:2x".
        quantity: a quantity of a sweep, such as "mass:*_calf"; one value for all links or joints
            that a glob means.
        each: the same with a value for each of them; in place of `quantity`.

    Raises:
        StudyError: not one of `quantity` and `each` is given.
    """

    __pydantic_config__ = CHECKED

    values: str
    quantity: str | None = None
    each: str | None = None

    def __post_init__(self) -> None:
        """Refuse a distribution of nothing, or of two things."""
        if (self.quantity is None) == (self.each is None):
            raise StudyError(
                "vary needs either quantity, with the same value for all links that match, or "
                "each, with a value for each link"
            )


@frozen(kw_only=True)
class Case(Scene):
    """Landings that are checked: a scene with a name, with some strike angles or random designs.

    Attributes:
        name: by which budgets and the baseline refer to it.
        scene: file of a scene, of which the keys of the case replace some.
        strike_angle_deg: a landing for each of these angles; in place of that of the scene's file
            [deg].
        drop_height: as in `Strike`; in place of the velocity of the scene's file [m].
        vary: what is not known of the design, for budgets with a percentile.
        designs: number of random designs of which the percentiles are.

    Raises:
        SceneError: a path holds a NUL character.
        StudyError: the number of designs is not valid, or the case and its strike give the same.
    """

    name: str
    scene: str | None = None
    strike_angle_deg: tuple[float, ...] = ()
    drop_height: float | None = None
    vary: tuple[DesignVariation, ...] = ()
    designs: float = DESIGNS

    def __post_init__(self) -> None:
        """Refuse a number of designs that is not valid, and what no scene may hold."""
        super().__post_init__()
        for name in ("strike_angle_deg", "drop_height"):
            of_case, of_strike = getattr(self, name), getattr(self.strike, name, None)
            if of_case not in (None, ()) and of_strike is not None:
                raise StudyError(
                    f"{name} is given for the case and for its strike; leave one of the two out"
                )
        if not (1.0 <= self.designs <= MOST_DESIGNS and self.designs == int(self.designs)):
            raise StudyError(
                f"designs is {self.designs:g}; it has to be a whole number from 1 to {MOST_DESIGNS}"
            )
        if self.designs != DESIGNS and not self.vary:
            raise StudyError(
                f"designs = {self.designs:g} is the number of random designs, and nothing of the "
                "case varies; vary a parameter with [[case.vary]], or leave it out"
            )

    @property
    def landings(self) -> tuple[tuple[float | None, Scene], ...]:
        """Each strike angle with its scene; None for the angle where the scene gives the strike."""
        scene = Scene(**{item.name: getattr(self, item.name) for item in fields(Scene)})
        if self.drop_height is not None:
            scene = replace(scene, strike=replace(scene.strike, drop_height=self.drop_height))
        if not self.strike_angle_deg:
            return ((None, scene),)
        landings = {}
        for angle in self.strike_angle_deg:
            strike = replace(scene.strike, strike_angle_deg=angle)
            landings[angle] = replace(scene, strike=strike)
        return tuple(landings.items())


@dataclass(frozen=True, kw_only=True)
class Budget:
    """A limit of one number of some landings.

    Attributes:
        case: name or glob of the cases.
        at: name or glob of points, bodies, joints or contacts, whichever the metric belongs to; all
            by default.
        metric: a quantity, as `select` takes it.
        max: largest value allowed, in the unit of the metric.
        min: smallest value allowed.
        baseline_tolerance: how much worse than the baseline it may be: a number with the unit of
            the metric, such as "0.01 kg", where "-" is the unit of a ratio; or a share such as
            "5%", and at least a change that may be given after it, as in "5%, 1e-3 N s", by default
            a thousandth of the largest value of the metric in the baseline, and the share if less.
        percentile: share of the case's random designs that have to meet each limit [%]; None for
            the design as it is.
        severity: whether the check fails when the budget is exceeded.

    Raises:
        UnknownName: there is no such metric.
        StudyError: it has no limit, its limits exclude every value or let any negative one pass, or
            the tolerance or the percentile is not valid.
    """

    __pydantic_config__ = CHECKED

    case: str = "*"
    at: str = "*"
    metric: str
    max: float | None = None
    min: float | None = None
    baseline_tolerance: str | None = None
    percentile: float | None = None
    severity: Literal["error", "warning"] = "error"

    def __post_init__(self) -> None:
        """Refuse what no landing can meet, or every landing meets."""
        object.__setattr__(self, "metric", current_name(self.metric))
        fault = self._fault_of_limits() or self._fault_of_percentile()
        if fault:
            raise StudyError(f"{self.metric} at {printable(self.at)}{fault}")
        if self.baseline_tolerance is not None:
            self.margin(1.0)

    def _fault_of_limits(self) -> str:
        """The fault of max and min, worded to follow the number's name; empty if there is none."""
        if self.max is None and self.min is None and self.baseline_tolerance is None:
            return " has no limit; give max, min or baseline_tolerance"
        limits = [limit for limit in (self.min, self.max) if limit is not None]
        if not all(map(math.isfinite, limits)):
            return ": max and min have to be finite, so that a number can exceed them"
        if limits != sorted(limits):
            return f": min {self.min:g} is above max {self.max:g}"
        either_sign = self.selection.signed and self.selection.quantity.worse == "greater"
        if len(limits) == 1 and either_sign:
            return " may be of either sign; give both min and max"
        return ""

    def _fault_of_percentile(self) -> str:
        """The fault of the percentile; empty if there is none."""
        if self.percentile is None:
            return ""
        if not 50.0 <= self.percentile <= 100.0:
            return (
                f": percentile is {self.percentile:g}; it is the share of designs that meet the "
                f"limits, from 50 to 100 %, such as 95"
            )
        if self.baseline_tolerance is not None:
            return " has a percentile, but a baseline has none; give max or min"
        return ""

    @cached_property
    def selection(self) -> Selection:
        """The metric."""
        return select(self.metric)

    @property
    def worse(self) -> Literal["greater", "less", "neither"]:
        """The direction of change against the baseline that is for the worse.

        It is that towards the only limit, else that of the metric. Neither means that any change
        is.
        """
        if (self.max is None) != (self.min is None):
            return "greater" if self.min is None else "less"
        return "neither" if self.selection.signed else self.selection.quantity.worse

    def representative(self, values: Array) -> float:
        """The value, among those (n,) of random designs, that has to meet the limits."""
        upper = float(percentile(values, self.percentile))
        lower = -float(percentile(-values, self.percentile))
        if self.max is None:
            return lower
        if self.min is None:
            return upper
        # The end that is farther beyond its limit.
        return lower if self.min - lower > upper - self.max else upper

    def margin(self, baseline: float, largest: float = 0.0) -> float:
        """The distance from a baseline that the value may have.

        An infinite radius has no share; no finite one is near it.

        Args:
            baseline: the value there.
            largest: magnitude of the metric's largest finite value there.
        """
        text = self.baseline_tolerance or ""
        share, comma, change = (part.strip() for part in text.partition(","))
        unit = self.selection.quantity.unit_text
        relative = share.endswith("%")
        units = {unit: 1.0}
        if relative or comma:
            units = {"%": 1.0}
        try:
            size = number_from(share, units)
            least = number_from(change, {unit: 1.0, "": 1.0}) if comma else 0.0
        except ValueError:
            size = least = -1.0
        if size < 0.0 or least < 0.0:
            raise StudyError(
                f'baseline_tolerance "{printable(text)}" is not valid; give a share such as "5%", '
                f'a number with the unit of {self.metric}, such as "0.01 {unit}", or a share and '
                f'at least a change: "5%, 0.01 {unit}"'
            )
        if not relative:
            return size
        part = size / 100.0
        if not comma:
            least = min(LEAST_CHANGE, part) * largest
        of_baseline = abs(baseline) if math.isfinite(baseline) else 1.0
        return max(part * of_baseline, least)


class Budgets(NamedTuple):
    """The contents of a file of budgets.

    Attributes:
        path: of the file; None if they are from Python.
        cases: the landings.
        budgets: their limits.
        lines: the line at which each budget begins; empty if that is not known.
        baseline: the file of earlier numbers that it names; None if it names none.
    """

    path: Path | None
    cases: tuple[Case, ...]
    budgets: tuple[Budget, ...]
    lines: tuple[int, ...]
    baseline: Path | None = None


def budgets_file(folder: Path) -> Path:
    """The file of budgets in a folder.

    It is budgets.toml, or a pyproject.toml with a table [tool.shockpc].

    Raises:
        StudyError: there is none.
    """
    budgets, project = (folder / name for name in STANDARD)
    if budgets.exists():
        return budgets
    if project.exists():
        with reading(project, "budgets", StudyError) as table:
            if "shockpc" in _table(table.get("tool", {}), "tool"):
                return project
    of_project = ", and no pyproject.toml"
    if project.exists():
        of_project = ", and the pyproject.toml there has no table [tool.shockpc]"
    raise StudyError(
        f'there is no budgets.toml in "{folder}"{of_project}; name the file: shockpc check FILE'
    )


def budgets_schema() -> dict[str, Any]:
    """The JSON Schema of a file of budgets, for editors; it lists the metrics."""
    case, budget = record_schema(Case), record_schema(Budget)
    budget["properties"]["metric"] = {"enum": list(selections())}
    kinds = {
        "case": case | {"required": ["name"]},
        "budget": budget,
        "part": {"$ref": "#/$defs/Part"},
    }
    return {
        "title": "shockpc budgets",
        "$defs": case.pop("$defs"),
        "type": "object",
        "properties": {
            "baseline": {"type": "string"},
            **{name: {"type": "array", "items": kind} for name, kind in kinds.items()},
        },
        "required": ["case", "budget"],
        "additionalProperties": False,
    }


def read_budgets(path: Path) -> Budgets:
    """Read a file of budgets; in a pyproject.toml they are the table [tool.shockpc].

    Paths in it are relative to its folder.

    Raises:
        StudyError: the file or a scene named in it cannot be read, a key or a value is not valid,
            or two cases have one name.
    """
    with reading(path, "budgets", StudyError) as document:
        prefix, table = "", _table(document, "the file")
        if path.name == STANDARD[1]:
            table = _table(_table(table.get("tool", {}), "tool").get("shockpc"), "[tool.shockpc]")
            prefix = "tool.shockpc."
        folder = path.resolve().parent
        faults: list[str] = []
        cases, budgets, baseline = _read(table, prefix, folder, faults)
        if faults:
            raise StudyError("; ".join(faults))
        _refuse_nothing(cases, budgets, prefix)
        text = read_file(path, "budgets file", StudyError).decode("utf-8-sig")
        lines = _lines(text, f"{prefix}budget")
        if len(lines) != len(budgets):
            lines = ()
        file = None if baseline is None else folder / usable_path(baseline)
        return Budgets(path, tuple(cases), tuple(budgets), lines, file)


def _read(
    table: Mapping[str, Any], prefix: str, folder: Path, faults: list[str]
) -> tuple[list[Case], list[Budget], str | None]:
    """The cases and budgets of a table, and the file of the baseline.

    Args:
        table: with case, budget, part and baseline.
        prefix: of these keys in the file.
        folder: to which paths are relative.
        faults: filled with what is wrong.
    """
    for key in table:
        if key not in KEYS:
            faults.append(unknown_key(f"{prefix}{key}", key, KEYS))
    parts = converted(table.get("part", []), tuple[Part, ...], f"{prefix}part", faults)
    if faults:
        parts = ()
    entries = {}
    for key in ("case", "budget"):
        entries[key] = _entries(table.get(key, []), f"{prefix}{key}", faults)
    baseline = converted(table.get("baseline"), str | None, f"{prefix}baseline", faults)
    cases = []
    for k, entry in enumerate(entries["case"]):
        case = _case(entry, parts, folder, f"{prefix}case[{k}]", faults)
        if case is not None:
            cases.append(case)
    budgets = []
    for k, entry in enumerate(entries["budget"]):
        budget = _budget(entry, f"{prefix}budget[{k}]", faults)
        if budget is not None:
            budgets.append(budget)
    return cases, budgets, baseline


def _refuse_nothing(cases: Sequence[Case], budgets: Sequence[Budget], prefix: str) -> None:
    """Refuse a file without cases or budgets, and two cases of one name."""
    if not cases:
        raise StudyError(f"there is no case; begin each with [[{prefix}case]]")
    if not budgets:
        raise StudyError(f"there is no budget; begin each with [[{prefix}budget]]")
    names = [case.name for case in cases]
    for name in names:
        if names.count(name) > 1:
            raise StudyError(f'two cases have the name "{printable(name)}"; rename one of them')


def _case(
    entry: Mapping[str, Any], parts: tuple[Part, ...], folder: Path, key: str, faults: list[str]
) -> Case | None:
    """A case as its table in a file gives it.

    Its keys replace those of the scene's file, and the parts of all cases are added to those of the
    file.
    """
    if "scene" not in entry and "robot" not in entry:
        faults.append(
            f"{key} has neither a scene nor a robot; give the path of a scene file, or a robot and "
            f"its contact"
        )
        return None
    try:
        file = entry.get("scene")
        if isinstance(file, str):
            scene = scene_table(read_scene(folder / usable_path(file)))
            entry = _with_scene(scene, entry)
        case_parts = entry.get("part", [])
        if parts and isinstance(case_parts, list):
            entry = {**entry, "part": [*case_parts, *parts]}
        return scene_from(Case, entry, folder, key)
    except SceneError as refusal:
        faults.append(str(refusal))
    except (StudyError, ValueError) as refusal:
        faults.append(f"{key}: {refusal}")
    return None


def _with_scene(scene: Mapping[str, Any], entry: Mapping[str, Any]) -> dict[str, Any]:
    """A case with the keys of a scene's file that it does not replace.

    A way to give the strike replaces the others.
    """
    strike = entry.get("strike", {})
    ways = set(entry.keys() & {"drop_height", "strike_angle_deg"})
    if isinstance(strike, Mapping):
        ways |= set(strike)
    replaced = {*ways, *replaced_ways(ways)}
    of_file = scene.get("strike", {})
    kept = {key: value for key, value in of_file.items() if key not in replaced}
    return _replaced({**scene, "strike": kept}, entry)


def _replaced(table: Mapping[str, Any], by: Mapping[str, Any]) -> dict[str, Any]:
    """A table with the values of another one in place of those given, in tables within it too."""
    # Of patterns of joints the last one applies, so what is replaced comes last.
    result = {key: value for key, value in table.items() if key not in by}
    for key, value in by.items():
        inner = table.get(key)
        if isinstance(value, Mapping) and isinstance(inner, Mapping):
            value = _replaced(inner, value)
        result[key] = value
    return result


def _budget(entry: Mapping[str, Any], key: str, faults: list[str]) -> Budget | None:
    """A budget; None where something is wrong with it."""
    # A list of its own, because a record is made only where no fault was found before.
    own_faults: list[str] = []
    budget: Budget | None = None
    try:
        budget = converted(entry, Budget, key, own_faults)
    except ShockError as refusal:
        own_faults.append(f"{key}: {refusal}")
    faults += own_faults
    return budget


def _entries(value: Any, key: str, faults: list[str]) -> list[Mapping[str, Any]]:
    """A list of tables; empty where it is none."""
    if isinstance(value, list) and all(isinstance(entry, Mapping) for entry in value):
        return value
    faults.append(f"{key} has to be a list of tables, each begun with [[{key}]]")
    return []


def _table(value: Any, name: str) -> Mapping[str, Any]:
    """A table. Raises StudyError if it is none."""
    if isinstance(value, Mapping):
        return value
    state = "missing" if value is None else "not a table"
    raise StudyError(f"{name} is {state}; it has to hold [[tool.shockpc.case]] and so on")


def _lines(text: str, key: str) -> tuple[int, ...]:
    """The numbers of the lines at which the tables of an array begin."""
    parts = map(re.escape, key.split("."))
    header = re.compile(r"\s*\[\[\s*" + r"\s*\.\s*".join(parts) + r"\s*\]\]")
    return tuple(k for k, line in enumerate(text.splitlines(), 1) if header.match(line))
