"""The benchmark section of the README, put there from a bench's summary: `python -m shockpc.bench.readme SUMMARY README`."""

import sys
from pathlib import Path

from shockpc.errors import OutputError
from shockpc.show.files import write_text

__all__ = ["with_summary"]

BEGIN, END = "<!-- begin of the bench's summary -->", "<!-- end of the bench's summary -->"


def with_summary(readme: str, summary: str) -> str:
    """The README with the text between its two marks replaced.

    Raises:
        OutputError: the marks are not there.
    """
    before, begin, rest = readme.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise OutputError(f"the README has no place for the bench's summary; put the lines {BEGIN} and {END} into it")
    return f"{before}{BEGIN}\n\n{summary.strip()}\n\n{END}{after}"


if __name__ == "__main__":
    summary, readme = (Path(name) for name in sys.argv[1:3])
    write_text(readme, with_summary(readme.read_text(encoding="utf-8"), summary.read_text(encoding="utf-8")))
