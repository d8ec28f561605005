"""`shockpc guide`: how to use shockpc, by topic."""

import json
import sys
from pathlib import Path

from shockpc.cli.declared import argument, command
from shockpc.text.errors import UnknownName

FOLDER = Path(__file__).resolve().parents[2] / "guide"
"""A page in Markdown, or a notebook, for each topic."""


@command(examples=("shockpc guide", "shockpc guide first-robot"))
def guide(
    *, topic: str | None = argument("A topic; without one, the list of topics.", "TOPIC")
) -> None:
    pages = sorted(FOLDER.glob("*.md"))
    notebooks = sorted(FOLDER.glob("*.ipynb"))
    texts = {path.stem: path.read_text(encoding="utf-8") for path in pages}
    texts |= {path.stem: notebook_text(path) for path in notebooks}
    if topic is None:
        sys.stdout.write(topics(texts, [path.stem for path in notebooks]))
    elif topic in texts:
        sys.stdout.write(texts[topic])
    else:
        raise UnknownName("topic", topic, texts, "the guide", "shockpc guide")


def topics(texts: dict[str, str], notebooks: list[str]) -> str:
    """The list of topics with their titles, pages before notebooks."""
    lines = {}
    for name, text in texts.items():
        title, _, _ = text.partition("\n")
        lines[name] = f"{name:14}{title.removeprefix('# ')}\n"
    pages = "".join(line for name, line in lines.items() if name not in notebooks)
    tutorials = "".join(lines[name] for name in notebooks)
    how = "Notebooks with exercises (shockpc guide NAME prints one, and how to open it):"
    return f"{pages}\n{how}\n\n{tutorials}"


def notebook_text(path: Path) -> str:
    """A notebook as a page in Markdown; under its title is where the file is."""
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
    title, _, rest = "\n\n".join(parts).partition("\n")
    where = f"This is a notebook. To run it: pip install jupyterlab; jupyter lab '{path}'"
    return f"{title}\n\n{where}\n{rest}\n"
