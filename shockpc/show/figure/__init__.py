"""Figures: the only importer of matplotlib, whose global state stays as it is."""

import importlib
import os

__all__: list[str] = []


def _import_matplotlib() -> None:
    """Import matplotlib without the backend that the environment may name: figures need none, and an unknown name is an error."""
    backend = os.environ.pop("MPLBACKEND", None)
    try:
        importlib.import_module("matplotlib")
    finally:
        if backend is not None:
            os.environ["MPLBACKEND"] = backend


_import_matplotlib()
