"""Mechanical shock of a landing, body by body, from its rigid-body model.

    profile = shockpc.shock_profile(shockpc.Scene(robot="anymal_b", contact="LF_FOOT"))
    print(profile.bodies, profile.shock_com, profile.ropc)

One landing: `Scene`, `shock_profile`. Many: `sweep`, `recorded`, `batch`. Decisions: `compare`,
`limits`, `place`, `sensitivity`, `improve`, `check_budgets`, `assert_shock`. Falls and logs:
`fall`, `touchdowns`, `identify`. `shockpc guide` prints the guide.
"""

import warnings
from typing import Any

import lazy_loader

__version__ = "0.2.0"

# The stub beside this file lists what the package offers; each module is imported when one of its
# names is first used.
_attribute, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """What the package offers by this name."""
    if name == "landings":
        warnings.warn(
            "shockpc.landings is now shockpc.recorded; the old name will be removed",
            DeprecationWarning,
            stacklevel=2,
        )
        name = "recorded"
    return _attribute(name)
