"""How much code a row of a study passes: `python tests/row_path.py` prints the functions of the
package and their files.

Counted are the named functions that are called while a part of a table is computed, in a second
run: what is found once for a robot is not of a row.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any
from unittest.mock import patch

import shockpc
from shockpc.evaluation.evaluate import Evaluation

PACKAGE = str(Path(shockpc.__file__).parent)


def passed(study: Callable[[], Any]) -> set[CodeType]:
    """The functions that are called in `Evaluation.compute` while a study runs."""
    study()
    seen, compute = set[CodeType](), Evaluation.compute

    def note(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        if (
            event == "call"
            and code.co_filename.startswith(PACKAGE)
            and not code.co_name.startswith("<")
        ):
            seen.add(code)

    def noted(*arguments: Any) -> Any:
        sys.setprofile(note)
        try:
            return compute(*arguments)
        finally:
            sys.setprofile(None)

    with patch.object(Evaluation, "compute", noted):
        study()
    return seen


def main() -> None:
    """Print a line for each study."""
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
    for name, study in studies.items():
        functions = passed(study)
        files = {code.co_filename for code in functions}
        sys.stdout.write(
            f"a row of {name} passes {len(functions)} functions in {len(files)} files\n"
        )


if __name__ == "__main__":
    main()
