"""Former keys of quantities, which are valid until the next release."""

import re
import warnings
from typing import Any

CURRENT = {
    "mass_sticking": "effective_mass_sticking",
    "mass_frictionless": "effective_mass_frictionless",
    "energy_made": "energy_gained",
    "needs_tilt": "feasible_if_tilted",
    "pull": "tensile_impulse",
    "depth": "depth_below_contacts",
    "off_plane": "out_of_plane_share",
    "pitch": "screw_pitch",
}
"""The key of each quantity by its former key."""

_TEXT = re.compile(r"(?P<kind>(?:point|body|joint|contact|robot)\.)?(?P<key>\w+)(?P<rest>.*)", re.S)


class RenamedQuantity(FutureWarning):
    """A quantity is named by its former key."""


def current_name(text: str) -> str:
    """A text that names a quantity, [KIND.]KEY and what follows, with the current key.

    A former key is a `RenamedQuantity` warning.
    """
    parts = _TEXT.fullmatch(text)
    if parts is None or parts["key"] not in CURRENT:
        return text
    former = parts["key"]
    current = CURRENT[former]
    warnings.warn(
        f'the quantity "{former}" is now "{current}"; the old name works until the next release',
        RenamedQuantity,
        stacklevel=3,
    )
    return f"{parts['kind'] or ''}{current}{parts['rest']}"


def renamed_attribute(instance: object, name: str) -> Any:
    """The attribute of a record with the current key of a quantity, for `__getattr__`.

    Raises:
        AttributeError: the name is no former key.
    """
    if name not in CURRENT:
        raise AttributeError(f"{type(instance).__name__!r} object has no attribute {name!r}")
    return getattr(instance, current_name(name))


def former_key(key: str) -> str:
    """The key of a document as it was before, the same if it contains no renamed quantity."""
    for former, current in CURRENT.items():
        if current in key:
            return key.replace(current, former)
    return key
