"""The door of the `shockpc` command: what its process does before and after a run, so that a run takes no longer than it must."""

import gc
import os
import sys

__all__ = ["entry"]


def entry() -> None:
    """Run the command line and end the process with its exit code."""
    # The matrices are small: threads of a linear algebra library would only wait for one another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Thousands of objects come to stay while libraries are imported; looking among them for garbage costs a tenth of a short run.
    gc.disable()
    code: object = 0
    try:
        from shockpc.cli.main import main

        main()
    except SystemExit as end:
        code = end.code
    except KeyboardInterrupt:
        # While libraries are imported; the command itself has its own answer.
        sys.stderr.write("shockpc: interrupted; no file was left half-written\n")
        code = 130
    # Everything is written by now; taking down the libraries one by one would cost another tenth.
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.flush()
    os._exit(code if isinstance(code, int) else 0)
