"""How much code a landing and a row of a study pass: `python tests/row_path.py` prints the functions
of the package and their files.

Counted are the named functions that are called for a landing, or while a part of a table is
computed, in a second run: what is found once for a robot is not of a row.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, TypeVar
from unittest.mock import patch

import shockpc
from shockpc.evaluation.evaluate import Evaluation
from shockpc.profile import profile_of_scene

PACKAGE = str(Path(shockpc.__file__).parent)

T = TypeVar("T")


def noted(seen: set[CodeType], run: Callable[..., T], *arguments: Any) -> T:
    """The result of a call; the functions that it calls are added to those seen."""

    def note(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        if (
            event == "call"
            and code.co_filename.startswith(PACKAGE)
            and not code.co_name.startswith("<")
        ):
            seen.add(code)

    sys.setprofile(note)
    try:
        return run(*arguments)
    finally:
        sys.setprofile(None)


def passed(landing: Callable[[], Any]) -> set[CodeType]:
    """The functions that are called for a landing."""
    landing()
    seen = set[CodeType]()
    noted(seen, landing)
    return seen


def passed_by_rows(study: Callable[[], Any]) -> set[CodeType]:
    """The functions that are called in `Evaluation.compute` while a study runs."""
    study()
    seen, compute = set[CodeType](), Evaluation.compute
    with patch.object(Evaluation, "compute", lambda *words: noted(seen, compute, *words)):
        study()
    return seen


def report(name: str, functions: set[CodeType]) -> None:
    """Print a line on some functions."""
    files = {code.co_filename for code in functions}
    sys.stdout.write(f"{name} passes {len(functions)} functions in {len(files)} files\n")


def main() -> None:
    """Print a line for each kind of landing, and for each study."""
    robot = shockpc.load_robot("anymal_b")
    scene = shockpc.Scene(robot="anymal_b", contact="LF_FOOT")
    studies = {
        "sweep": lambda: (
            shockpc.sweep(scene, [("LF_KFE", "-90:-60:5")], robot=robot, prove=0).table
        ),
        "sweep with its proof": lambda: (
            shockpc.sweep(scene, [("LF_KFE", "-90:-60:5")], robot=robot).table
        ),
        "limits": lambda: shockpc.limits(scene, "LF_KFE", "shock_com@base", max=0.05, robot=robot),
    }
    report("a landing", passed(lambda: shockpc.shock_profile(scene, robot)))
    report("a landing that is not judged", passed(lambda: profile_of_scene(scene, robot)))
    for name, study in studies.items():
        report(f"a row of {name}", passed_by_rows(study))


if __name__ == "__main__":
    main()
