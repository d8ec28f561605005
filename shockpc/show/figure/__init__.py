"""Figures: the only importer of matplotlib, whose global state stays as it is."""

import contextlib
import importlib
import importlib.util
import logging
import os
import sys
from pathlib import Path

# Figures need no backend, and matplotlib refuses to be imported if the environment names an unknown one.
_BACKEND = os.environ.pop("MPLBACKEND", None)
# Without a handler, Python would print what matplotlib logs about the user's settings and fonts.
logging.getLogger("matplotlib").addHandler(logging.NullHandler())
if "matplotlib" not in sys.modules:
    # It reads a matplotlibrc of the current folder before any other, and the one beside its fonts is the default.
    _SPEC = importlib.util.find_spec("matplotlib")
    assert _SPEC is not None
    with contextlib.chdir(Path(str(_SPEC.origin)).with_name("mpl-data")):
        importlib.import_module("matplotlib")
if _BACKEND is not None:
    os.environ["MPLBACKEND"] = _BACKEND
