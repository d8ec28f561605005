"""Figures: the only importer of matplotlib, whose global state stays as it is."""

import importlib
import logging
import os

# Figures need no backend, and matplotlib refuses to be imported if the environment names an unknown one.
_BACKEND = os.environ.pop("MPLBACKEND", None)
# Without a handler, Python would print what matplotlib logs about the user's settings and fonts.
logging.getLogger("matplotlib").addHandler(logging.NullHandler())
importlib.import_module("matplotlib")
if _BACKEND is not None:
    os.environ["MPLBACKEND"] = _BACKEND
