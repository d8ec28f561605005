"""Budgets: which numbers of which landings have limits.

Read from a TOML file for them or from a pyproject.toml.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple

from shockpc.core.frozen import frozen
from shockpc.core.number import number_from
from shockpc.core.spatial import Array
from shockpc.evaluation.table import percentile
from shockpc.landing.record import CHECKED
from shockpc.landing.scene import Part, Scene
from shockpc.landing.scene_file import read_scene, record_schema, scene_from, scene_table
from shockpc.landing.strike import replaced_ways
from shockpc.quantities.renamed import current_name
from shockpc.quantities.selection import Selection, select, selections
from shockpc.text.errors import SceneError, ShockError, StudyError
from shockpc.text.paths import read_file, usable_path
from shockpc.text.printed import printable
from shockpc.text.toml import converted, reading, unknown_key

STANDARD = ("budgets.toml", "pyproject.toml")
"""Files that are looked for in the current folder."""


LEAST_CHANGE = 1e-3
"""Share of a metric's largest value in the baseline by which a value may always be off where a
tolerance is a share.
"""

DESIGNS, MOST_DESIGNS = 1000.0, 1_000_000
"""Random designs of one landing: by default, and at most."""


@dataclass(frozen=True, kw_only=True)
class DesignVariation:
    """What is not known of a design.

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
    """Landings that are checked: a scene with a name, and with some strike angles or random
    designs.

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
            if (
                getattr(self, name) not in (None, ())
                and getattr(self.strike, name, None) is not None
            ):
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
        """Each strike angle with its scene; the angle is None where the scene gives only the
        strike.
        """
        scene = Scene(**{item.name: getattr(self, item.name) for item in fields(Scene)})
        if self.drop_height is not None:
            scene = replace(scene, strike=replace(scene.strike, drop_height=self.drop_height))
        strikes = {
            angle: replace(scene.strike, strike_angle_deg=angle) for angle in self.strike_angle_deg
        }
        return tuple(
            (angle, replace(scene, strike=strike)) for angle, strike in strikes.items()
        ) or ((None, scene),)


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
        if self.max is None and self.min is None and self.baseline_tolerance is None:
            raise StudyError(
                f"{self.metric} at {printable(self.at)} has no limit; give max, min or "
                f"baseline_tolerance"
            )
        if not all(math.isfinite(limit) for limit in (self.max, self.min) if limit is not None):
            raise StudyError(
                f"{self.metric} at {printable(self.at)}: max and min have to be finite, so that a "
                f"number can exceed them"
            )
        if self.max is not None and self.min is not None and self.min > self.max:
            raise StudyError(
                f"{self.metric} at {printable(self.at)}: min {self.min:g} is above max {self.max:g}"
            )
        if (
            (self.max is None) != (self.min is None)
            and self.selection.signed
            and self.selection.quantity.worse == "greater"
        ):
            raise StudyError(
                f"{self.metric} at {printable(self.at)} may be of either sign; give both min and "
                f"max"
            )
        if self.baseline_tolerance is not None:
            self.margin(1.0)
        if self.percentile is not None:
            if not 50.0 <= self.percentile <= 100.0:
                raise StudyError(
                    f"{self.metric} at {printable(self.at)}: percentile is {self.percentile:g}; it "
                    f"is the share of designs that "
                    "meet the limits, from 50 to 100 %, such as 95"
                )
            if self.baseline_tolerance is not None:
                raise StudyError(
                    f"{self.metric} at {printable(self.at)} has a percentile, but a baseline has "
                    "none; give max or min"
                )

    @cached_property
    def selection(self) -> Selection:
        """The metric."""
        return select(self.metric)

    @property
    def worse(self) -> Literal["greater", "less", "neither"]:
        """Which change against the baseline is for the worse: that towards the only limit, else
        that of the metric.

        Neither means that any change is.
        """
        if (self.max is None) != (self.min is None):
            return "greater" if self.min is None else "less"
        return "neither" if self.selection.signed else self.selection.quantity.worse

    def representative(self, values: Array) -> float:
        """Of the values (n,) of random designs, the one that says whether enough of them meet the
        limits.
        """
        upper, lower = (
            float(percentile(values, self.percentile)),
            -float(percentile(-values, self.percentile)),
        )
        if self.max is None or (self.min is not None and self.min - lower > upper - self.max):
            return lower
        return upper

    def margin(self, baseline: float, largest: float = 0.0) -> float:
        """How far from a baseline the value may be.

        An infinite radius has no share; no finite one is near it.

        Args:
            baseline: the value there.
            largest: magnitude of the metric's largest finite value there.
        """
        share, comma, change = (
            part.strip() for part in (self.baseline_tolerance or "").partition(",")
        )
        unit = self.selection.quantity.unit.replace("1", "-")
        relative = share.endswith("%")
        try:
            size = number_from(share, {"%" if relative or comma else unit: 1.0})
            least = number_from(change, {unit: 1.0, "": 1.0}) if comma else 0.0
        except ValueError:
            size = least = -1.0
        if size < 0.0 or least < 0.0:
            raise StudyError(
                f'baseline_tolerance "{printable(self.baseline_tolerance or "")}" is not valid; '
                f'give a share such as "5%", a '
                f'number with the unit of {self.metric}, such as "0.01 {unit}", or a share and at '
                f'least a change: "5%, 0.01 {unit}"'
            )
        if not relative:
            return size
        part_of = size / 100.0
        least = least if comma else min(LEAST_CHANGE, part_of) * largest
        return max(part_of * (abs(baseline) if math.isfinite(baseline) else 1.0), least)


class Budgets(NamedTuple):
    """What a file of budgets holds.

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
    """The file of budgets in a folder: budgets.toml, or a pyproject.toml with a table
    [tool.shockpc].

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
    other = (
        ", and the pyproject.toml there has no table [tool.shockpc]"
        if project.exists()
        else ", and no pyproject.toml"
    )
    raise StudyError(
        f'there is no budgets.toml in "{folder}"{other}; name the file: shockpc check FILE'
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
    nested = path.name == STANDARD[1]
    with reading(path, "budgets", StudyError) as document:
        prefix, table = "", _table(document, "the file")
        if nested:
            table = _table(_table(table.get("tool", {}), "tool").get("shockpc"), "[tool.shockpc]")
            prefix = "tool.shockpc."
        keys = ("case", "budget", "part", "baseline")
        faults = [unknown_key(f"{prefix}{key}", key, keys) for key in table if key not in keys]
        parts = converted(table.get("part", []), tuple[Part, ...], f"{prefix}part", faults)
        parts = () if faults else parts
        entries = {
            key: _entries(table.get(key, []), f"{prefix}{key}", faults)
            for key in ("case", "budget")
        }
        folder = path.resolve().parent
        baseline = converted(table.get("baseline"), str | None, f"{prefix}baseline", faults)
        cases = [
            _case(entry, parts, folder, f"{prefix}case[{k}]", faults)
            for k, entry in enumerate(entries["case"])
        ]
        budgets = [
            _budget(entry, f"{prefix}budget[{k}]", faults)
            for k, entry in enumerate(entries["budget"])
        ]
        if faults:
            raise StudyError("; ".join(faults))
        names = [case.name for case in cases if case is not None]
        for missing, kind in ((names, "case"), (budgets, "budget")):
            if not missing:
                raise StudyError(f"there is no {kind}; begin each with [[{prefix}{kind}]]")
        for k, name in enumerate(names):
            if name in names[:k]:
                raise StudyError(f'two cases have the name "{printable(name)}"; rename one of them')
        lines = _lines(
            read_file(path, "budgets file", StudyError).decode("utf-8-sig"), f"{prefix}budget"
        )
        known = tuple(budget for budget in budgets if budget is not None)
        return Budgets(
            path,
            tuple(case for case in cases if case is not None),
            known,
            lines if len(lines) == len(known) else (),
            None if baseline is None else folder / usable_path(baseline),
        )


def _case(
    entry: Mapping[str, Any], parts: tuple[Part, ...], folder: Path, key: str, faults: list[str]
) -> Case | None:
    """A case; its keys replace those of the scene's file, and the parts of all cases are added to
    those of the file.
    """
    if "scene" not in entry and "robot" not in entry:
        faults.append(
            f"{key} has neither a scene nor a robot; give the path of a scene file, or a robot and "
            f"its contact"
        )
        return None
    try:
        if isinstance(file := entry.get("scene"), str):
            scene, strike = (
                scene_table(read_scene(folder / usable_path(file))),
                entry.get("strike", {}),
            )
            given = {
                *(strike if isinstance(strike, Mapping) else ()),
                *entry.keys() & {"drop_height", "strike_angle_deg"},
            }
            replaced = {*given, *replaced_ways(given)}
            scene["strike"] = {
                key: value for key, value in scene.get("strike", {}).items() if key not in replaced
            }
            entry = _replaced(scene, entry)
        if parts and isinstance(case_parts := entry.get("part", []), list):
            entry = {**entry, "part": [*case_parts, *parts]}
        return scene_from(Case, entry, folder, key)
    except (SceneError, StudyError, ValueError) as refusal:
        faults.append(str(refusal) if isinstance(refusal, SceneError) else f"{key}: {refusal}")
        return None


def _replaced(table: Mapping[str, Any], by: Mapping[str, Any]) -> dict[str, Any]:
    """A table with the values of another one in place of those given, in tables within it too."""
    inner = {
        key: _replaced(table[key], value)
        for key, value in by.items()
        if isinstance(value, Mapping) and isinstance(table.get(key), Mapping)
    }
    # Of patterns of joints the last one applies, so what is replaced comes last.
    return {key: value for key, value in table.items() if key not in by} | {**by, **inner}


def _budget(entry: Mapping[str, Any], key: str, faults: list[str]) -> Budget | None:
    entry_faults: list[str] = []
    try:
        budget: Budget | None = converted(entry, Budget, key, entry_faults)
    except ShockError as refusal:
        entry_faults.append(f"{key}: {refusal}")
        budget = None
    faults += entry_faults
    return budget


def _entries(value: Any, key: str, faults: list[str]) -> list[Mapping[str, Any]]:
    if isinstance(value, list) and all(isinstance(entry, Mapping) for entry in value):
        return value
    faults.append(f"{key} has to be a list of tables, each begun with [[{key}]]")
    return []


def _table(value: Any, name: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise StudyError(
            f"{name} is {'missing' if value is None else 'not a table'}; it has to hold "
            f"[[tool.shockpc.case]] and so on"
        )
    return value


def _lines(text: str, key: str) -> tuple[int, ...]:
    """The numbers of the lines at which the tables of an array begin."""
    header = re.compile(
        r"\s*\[\[\s*" + r"\s*\.\s*".join(map(re.escape, key.split("."))) + r"\s*\]\]"
    )
    return tuple(k for k, line in enumerate(text.splitlines(), 1) if header.match(line))
