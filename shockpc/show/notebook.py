"""A page shown at once: in the cell of a notebook, else in a browser."""

import html
import importlib
import sys
import tempfile
import webbrowser
from pathlib import Path

from shockpc.show.folder import PAGE, report_files
from shockpc.show.html import INSTALL, plotly
from shockpc.show.report import Report
from shockpc.text.errors import OutputError


def show(report: Report) -> None:
    """Show the page of a report, one file that needs neither a server nor a network.

    Raises:
        OutputError: Plotly is not installed, or no browser is found.
    """
    if report.landings and plotly() is None:
        raise OutputError(INSTALL)
    page = report_files(report)[PAGE]
    text = page if isinstance(page, str) else page.decode()
    ipython = sys.modules.get("IPython")
    if ipython is not None and hasattr(ipython.get_ipython(), "kernel"):
        frame = (
            f'<div><iframe style="width: 100%; height: 900px; border: 0" '
            f'srcdoc="{html.escape(text)}"></iframe></div>'
        )
        display = importlib.import_module("IPython.display")
        display.display(display.HTML(frame))
        return
    path = Path(tempfile.mkdtemp(prefix="shockpc-")) / PAGE
    path.write_text(text, encoding="utf-8")
    if not webbrowser.open(path.as_uri()):
        raise OutputError(f'no browser is found; the page is "{path}"')
