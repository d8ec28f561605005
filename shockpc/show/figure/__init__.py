"""Figures: the only importer of matplotlib, whose global state stays as it is."""

import importlib
import os

# Figures need no backend, and matplotlib refuses to be imported if the environment names an unknown one.
_BACKEND = os.environ.pop("MPLBACKEND", None)
importlib.import_module("matplotlib")
if _BACKEND is not None:
    os.environ["MPLBACKEND"] = _BACKEND
