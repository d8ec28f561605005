"""The display of results: in a line, and in a notebook by the report of their command.

The report is imported when it is shown.
"""

import pkgutil
from collections.abc import Callable
from typing import Any


def brief(result: Any, *parts: str) -> str:
    """The `repr` of a result: its class, and in a few words what it is."""
    return f"{type(result).__name__}({'; '.join(filter(None, parts))})"


def shown_by(report: str, *before: Any) -> Callable[[Any], str]:
    """The method `_repr_html_` of a result.

    Args:
        report: what makes its report, "module:function", the module without `shockpc.`.
        before: arguments of that before the result.
    """

    def fragment(result: Any) -> str:
        html: str = pkgutil.resolve_name("shockpc.show.html.page:fragment")(
            pkgutil.resolve_name(f"shockpc.{report}")(*before, result)
        )
        return html

    return fragment


def show_page(report: str, result: Any) -> None:
    """Show the page of a report: in the cell of a notebook, else in a browser.

    Args: report, as above; result, that it is of.
    """
    pkgutil.resolve_name("shockpc.show.notebook:show")(
        pkgutil.resolve_name(f"shockpc.{report}")(result)
    )
