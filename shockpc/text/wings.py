"""The wings: subjects in folders of `shockpc/wings`, each of which can be deleted, and what they add.

The rest of the package finds a wing by its folder. What the wing adds stands behind doors: modules
of the wing that its file `wing.py` names.
"""

import functools
import importlib
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

FOLDER = Path(__file__).resolve().parent.parent / "wings"


class Wing(NamedTuple):
    """The doors of a wing: the module behind each, in the wing's folder; empty where there is none.

    A door that is opened at import has a light module behind it, of records and tables.

    Attributes:
        formats: formats of robot files, `FORMATS` as of `robot.reading`; opened at import.
        inputs: what its studies read, `INPUTS` as of `cli.study_command`.
        sliders: those of a page for the posture, `posture_of(landing, surfaces, joints)`, which
            returns a `Posture` of `show.html.posture`.
        beyond: what the rigid answer of the paper is off by: `beyond_report`.
        report: what reports of a landing have besides: `tables(profile)`, makers by name;
            `views(profile)`, each a `View` of `studies.analyze.view`, by name; `lines(profile)`
            below the tables; `pictures(profile, spectrum)`;
            `document(profile, spectrum)`, keys of the JSON document; `histories(profile)`, charts of
            a page; `overlay(profile)`, lines of the figure in the plane with a note.
        landing: `check_scene(scene, constraints)` and `check(landing)`, which refuse what has no
            meaning; `motion(landing, until)`, a landing that lasts as a `Motion` of `impact.motion`,
            or None; `described(scene)`, what headers say of the robot.
        quantities: `QUANTITIES`, records of the table of quantities; opened at import.
        checks: `CHECKS`, each from a profile to diagnostics; `SHARED`, those of which studies of
            many landings show the worst, by kind and subject.
    """

    formats: str = ""
    inputs: str = ""
    sliders: str = ""
    beyond: str = ""
    report: str = ""
    landing: str = ""
    quantities: str = ""
    checks: str = ""


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
