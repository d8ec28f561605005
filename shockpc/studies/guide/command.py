"""`shockpc guide`: how to use shockpc, by topic."""

import sys
from pathlib import Path

from shockpc.cli.declared import argument, command
from shockpc.text.errors import UnknownName

FOLDER = Path(__file__).resolve().parents[2] / "guide"
"""A page in Markdown for each topic."""


@command(examples=("shockpc guide", "shockpc guide first-robot"))
def guide(
    *, topic: str | None = argument("A topic; without one, the list of topics.", "TOPIC")
) -> None:
    pages = {page.stem: page.read_text(encoding="utf-8") for page in sorted(FOLDER.glob("*.md"))}
    if topic is not None and topic not in pages:
        raise UnknownName("topic", topic, pages, "the guide", "shockpc guide")
    titles = "".join(
        f"{name:14}{text.partition(chr(10))[0].removeprefix('# ')}\n"
        for name, text in pages.items()
    )
    sys.stdout.write(titles if topic is None else pages[topic])
