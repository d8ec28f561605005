"""The wings, subjects in folders of `shockpc/wings` that can be deleted, and what they add.

The rest of the package finds a wing by its folder. What the wing adds stands behind doors: modules
of the wing that its file `wing.py` names.
"""

import functools
import importlib
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

FOLDER = Path(__file__).resolve().parent.parent / "wings"


class Wing(NamedTuple):
    """The doors of a wing: the module behind each, in the wing's folder; empty where there is none.

    A module has what it adds under the names below, and may leave out what it does not add. One
    that is opened at import is light: records and tables.

    Attributes:
        formats: `FORMATS` of robot files, as of `robot.files.reading`; opened at import.
        options: `OPTIONS` of a scene, type and `landing.scenes.scene_fields.option` by name; opened
            at import.
        landing: `check_options(scene, constraints)` and `check_landing(landing)`, which refuse what
            has no meaning; `landing_motion(landing, until)`, a landing that lasts as a
            `LandingMotion` of `impact.landing_motion`, or None; `robot_texts(scene)`, texts of the
            robot for headers.
        quantities: `QUANTITIES`, records of the table of quantities; opened at import.
        checks: `CHECKS`, each from a profile to diagnostics; `SHARED`, those of which studies of
            many landings show the worst, by kind and subject.
        variations: `KINDS` of what studies vary, as of `evaluation.variations.variation`; opened
            at import.
        inputs: `INPUTS`, what the wing's studies read, as of `cli.study_inputs`.
        report: what reports of a landing have besides: `TITLES` of columns and `SHOCKS`, as of
            `studies.analyze.sheets`; `tables(profile)`, makers by name;
            `views(profile)`, each a `View` of `studies.analyze.view`, by name; `lines(profile)`
            below the tables; `pictures(profile, spectrum)`; `document(profile, spectrum)`, keys of
            the JSON document; `charts(profile)` of a page; `overlay(profile)`, lines of the figure
            in the plane with a note; and `beyond_report()`, what the rigid answer of the paper is
            off by.
        sliders: `posture_of(landing, surfaces, joints)`, those of a page for the posture: a
            `PostureSliders` of `show.html.posture`.
    """

    formats: str = ""
    options: str = ""
    landing: str = ""
    quantities: str = ""
    checks: str = ""
    variations: str = ""
    inputs: str = ""
    report: str = ""
    sliders: str = ""


@functools.cache
def is_here(wing: str) -> bool:
    """True if the package has a wing; always for the core, whose name is empty."""
    return not wing or (FOLDER / wing / "wing.py").is_file()


def from_wings(door: str, name: str) -> list[Any]:
    """The values of `name` in the modules behind a door that have it, in the order of the wings."""
    return [getattr(module, name) for module in doors(door) if hasattr(module, name)]


@functools.cache
def doors(name: str) -> tuple[ModuleType, ...]:
    """The modules behind a door, of all wings that have it, in the order of their names."""
    modules = []
    for path in sorted(FOLDER.glob("*/wing.py")):
        package = f"shockpc.wings.{path.parent.name}"
        module = getattr(importlib.import_module(f"{package}.wing").WING, name)
        if module:
            modules.append(importlib.import_module(f"{package}.{module}"))
    return tuple(modules)
