"""Mechanical shock of a landing, body by body, from its rigid-body model.

    profile = shockpc.shock_profile(shockpc.Scene(robot="anymal_b", contact="LF_FOOT"))
    print(profile.bodies, profile.shock_com, profile.ropc)

One landing: `Scene`, `shock_profile`. Many: `sweep`, `recorded`, `batch`. Decisions: `compare`,
`limits`, `place`, `sensitivity`, `improve`, `check_budgets`, `assert_shock`. Falls and logs:
`fall`, `touchdowns`, `identify`. `shockpc guide` prints the guide.
"""

import importlib
import re
from pathlib import Path
from typing import Any

__version__ = "0.2.0"


def _modules_of_names() -> dict[str, str]:
    """The module of each public name, as the stub beside this file lists them.

    Names of a subject that is not installed are left out.
    """
    here = Path(__file__)
    text = here.with_suffix(".pyi").read_text(encoding="utf-8")
    imports = re.findall(r"^from \.([\w.]+) import (\w+) as \2$", text, re.MULTILINE)
    modules = dict[str, str]()
    for module, name in imports:
        file = here.parent.joinpath(*module.split(".")).with_suffix(".py")
        if file.is_file():
            modules[name] = f"{__name__}.{module}"
    return modules


_MODULES = _modules_of_names()
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    """What the package offers by this name; its module is imported then."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_MODULES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *__all__]
