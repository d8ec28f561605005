"""`shockpc guide`: how to use shockpc, by topic."""

import json
import sys
from collections.abc import Mapping
from pathlib import Path

from shockpc.cli.declared import argument, command
from shockpc.text.errors import UnknownName

PACKAGE = Path(__file__).resolve().parents[2]


@command(examples=("shockpc guide", "shockpc guide first-robot"))
def guide(
    *, topic: str | None = argument("A topic; without one, the list of topics.", "TOPIC")
) -> None:
    pages, notebooks = files_of("md"), files_of("ipynb")
    texts = {name: path.read_text(encoding="utf-8") for name, path in pages.items()}
    texts |= {name: notebook_text(path) for name, path in notebooks.items()}
    if topic is None:
        sys.stdout.write(topics(texts, notebooks))
    elif topic in texts:
        sys.stdout.write(texts[topic])
    else:
        raise UnknownName("topic", topic, texts, "the guide", "shockpc guide")


def files_of(ending: str) -> dict[str, Path]:
    """The files of the guide and of the wings with an ending, by topic in alphabetical order."""
    paths = [*PACKAGE.glob(f"guide/*.{ending}"), *PACKAGE.glob(f"wings/*/*.{ending}")]
    return {path.stem: path for path in sorted(paths, key=lambda path: path.stem)}


def topics(texts: Mapping[str, str], notebooks: Mapping[str, Path]) -> str:
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
