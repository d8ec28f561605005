"""The entry point of the `shockpc` command: prepares the process, runs the command line, ends with its exit code."""

import gc
import os
import sys
import warnings

from shockpc.cli.main import main
from shockpc.cli.signals import listen
from shockpc.cli.streams import prepare_streams

__all__ = ["entry"]


def entry() -> None:
    """Run the command line and end the process with its exit code."""
    listen()
    # Threads of the linear algebra library take a third of a short run, and small matrices gain nothing from them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Imports make many objects and no garbage; to search them for it takes a twentieth of a short run.
    gc.set_threshold(100_000)
    prepare_streams()
    # A result that is not finite is refused or reported where it arises; NumPy's lines about it help nobody.
    warnings.simplefilter("ignore")
    code: object = None
    try:
        main()
    except SystemExit as end:
        code = end.code
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.flush()
    # All output is written. Finalising the libraries would take a seventh of a short run, and can change the exit code.
    os._exit(code if isinstance(code, int) else 0)
