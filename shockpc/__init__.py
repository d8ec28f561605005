"""Mechanical shock of a landing, body by body, from the rigid-body model alone.

    profile = shockpc.shock_profile(shockpc.Scene(robot="anymal_b", contact="LF_FOOT"))
    print(profile.bodies, profile.shock_com, profile.ropc)

One landing: `Scene`, `shock_profile`. Many: `sweep`, `landings`, `batch`. Decisions: `compare`, `limits`, `place`, `sensitivity`,
`improve`, `check_budgets`, `assert_shock`. Falls and logs: `fall`, `touchdowns`, `identify`. `shockpc guide` prints the guide.
"""

import lazy_loader

__version__ = "0.1.0"

# The stub beside this file lists what the package offers; each module is imported when one of its names is first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
