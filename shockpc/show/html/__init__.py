"""The report as a page: an HTML file that needs no network and no server.

It shows landings in three dimensions.
"""

import importlib.util
from pathlib import Path

INSTALL = "report.html is not written, because it needs Plotly; install it with: pip install plotly"


def plotly() -> Path | None:
    """The file of Plotly's script, which is not imported; None if it is not installed."""
    spec = importlib.util.find_spec("plotly")
    if spec is None or spec.origin is None:
        return None
    script = Path(spec.origin).parent / "package_data" / "plotly.min.js"
    return script if script.is_file() else None
