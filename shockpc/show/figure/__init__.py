"""Figures: the only importer of matplotlib, whose global state stays as it is."""

import logging

from shockpc.text.errors import OutputError

# Without a handler, Python would print what matplotlib logs about the user's settings and fonts.
logging.getLogger("matplotlib").addHandler(logging.NullHandler())
try:
    import matplotlib  # noqa: F401
except ValueError as refusal:  # of settings, which figures do not need, but matplotlib reads
    raise OutputError(
        f"matplotlib, which draws the figures, refuses the settings of this user: {refusal}; "
        f"correct or remove the variable "
        "MPLBACKEND, or the file matplotlibrc in the current folder or among the user's settings"
    ) from None


def leave_out_documentation() -> None:
    """Keep matplotlib from writing documentation of the properties of all its classes.

    That takes a fifth of its import.
    """
    import matplotlib.artist

    matplotlib.artist.kwdoc = lambda artist: ""
