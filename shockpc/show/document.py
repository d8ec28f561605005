"""A result as a JSON document: its head, and values as JSON holds them.

`null` where a thing does not exist; so a number that is not finite, and a list of such numbers.
Numbers are the shortest that give the same double.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

import shockpc
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import scene_table
from shockpc.method.dynamics import PINOCCHIO


def headed(name: str, content: dict[str, Any], version: int = 1) -> dict[str, Any]:
    """A document: its schema, what computed it, and what was found, as JSON holds it."""
    return {
        "schema": f"shockpc.{name}/{version}",
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        **_plain(content),
    }


def record(instance: object, *keys: str) -> dict[str, Any]:
    """Some attributes of a record."""
    return {key: getattr(instance, key) for key in keys}


def _plain(value: Any) -> Any:
    """A value as JSON holds it: named tuples are objects, a scene its table; no -0.0."""
    match value:
        case None | str() | int():
            return value
        case float():
            return value + 0.0 if math.isfinite(value) else None
        case np.ndarray() if value.dtype.kind == "f" and np.isfinite(value).all():
            return (value + 0.0).tolist()
        case np.ndarray() | np.generic():
            return _plain(value.tolist())
        case Mapping():
            return {key: _plain(part) for key, part in value.items()}
        case list():
            parts = [_plain(part) for part in value]
            nothing = bool(parts) and all(part is None for part in parts)
            return None if nothing else parts
        case tuple() if hasattr(value, "_asdict"):
            return _plain(value._asdict())
        case tuple():
            return [_plain(part) for part in value]
        case Scene():
            return scene_table(value)
        case _:
            return str(value)
