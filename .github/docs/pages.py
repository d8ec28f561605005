"""Build the site of the documentation: `python .github/docs/pages.py OUT`.

Copies the pages of the guide as they are, writes the pages that follow from the package (API
reference, quantities, gallery) beside them, and runs Sphinx, for which a warning is an error.
"""

import inspect
import itertools
import json
import pkgutil
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

import shockpc

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
COPIED = (
    "README.md",
    "shockpc/LICENSE",
    "shockpc/guide",
    "shockpc/wings/*/*.md",
    "shockpc/wings/*/*.ipynb",
    "robots",
    ".github/actions/check/action.yml",
)
"""What the site holds as it is, as patterns; links between these work as in the repository."""

GUIDE = (
    ("Begin", ("first-robot", "humanoid", "designer", "ci", "vary", "changes")),
    ("Method", ("method", "notation", "glossary")),
    ("Reference", ("python", "reference", "citation")),
)
"""Captions of the contents, and the pages of the guide under each."""

PAPER = (1, 2, 3, 5)
"""Figures of the paper that are drawn here."""
DOI = "https://doi.org/10.3389/fmech.2020.601922"

ROOMS = {
    "landing": "Scenes and landings",
    "robot": "Robots",
    "profile": "One landing",
    "quantities": "Results of a landing",
    "studies": "Studies",
    "evaluation": "Many landings",
    "fall": "Falls",
    "recordings": "Recorded landings",
    "symbols": "Landings as expressions",
    "testing": "Tests",
    "text": "Errors and warnings",
}
"""Headings of the API reference, by the room or the wing in which a name is defined."""


def main(out: Path) -> int:
    """Build the site in a folder, and return the exit code of Sphinx."""
    from sphinx.cmd.build import build_main

    source = out.parent / f"{out.name}-source"
    shutil.rmtree(source, ignore_errors=True)
    copy_to(source)
    (source / "index.md").write_text(index_page(source), encoding="utf-8")
    (source / "README.md").unlink()
    (source / "api.md").write_text(api_page(), encoding="utf-8")
    (source / "internals.md").write_text(internals_page(), encoding="utf-8")
    (source / "quantities.md").write_text(quantities_page(), encoding="utf-8")
    (source / "gallery.md").write_text(gallery_page(beside_the_paper()), encoding="utf-8")
    words = ["-W", "--keep-going", "-q", "-b", "html", "-c", str(HERE), str(source), str(out)]
    return build_main(words)


def copy_to(source: Path) -> None:
    """Copy the files and folders of `COPIED` to the same places in another folder."""
    for path in itertools.chain.from_iterable(map(ROOT.glob, COPIED)):
        target = source / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            shutil.copytree(path, target)
        else:
            shutil.copy(path, target)


def index_page(source: Path) -> str:
    """The README with the contents of the site.

    A page of the guide that `GUIDE` does not name is listed under the first caption, and those of
    wings are listed after the method.
    """
    contents = {caption: [f"shockpc/guide/{page}" for page in pages] for caption, pages in GUIDE}
    named = [page for pages in contents.values() for page in pages]
    others = (page for page in listed(source, "shockpc/guide/*.md") if page not in named)
    contents["Begin"].extend(others)
    contents["Method"].extend(listed(source, "shockpc/wings/*/*.md"))
    contents["Lecture and tutorials"] = listed(source, "shockpc/**/*.ipynb")
    contents["Reference"].extend(["quantities", "api", "internals"])
    contents["More"] = ["gallery", *listed(source, "robots/**/README.md")]
    trees = [
        "\n".join(["```{toctree}", ":hidden:", f":caption: {caption}", "", *pages, "```"])
        for caption, pages in contents.items()
    ]
    return "\n\n".join([(source / "README.md").read_text(encoding="utf-8"), *trees])


def listed(source: Path, pattern: str) -> list[str]:
    """The pages of the site that match a pattern, in alphabetical order and without endings."""
    return sorted(str(path.relative_to(source).with_suffix("")) for path in source.glob(pattern))


def documented(name: str, thing: object) -> str:
    """The directive that documents a thing."""
    kind = "class" if inspect.isclass(thing) else "function"
    kind = kind if callable(thing) else "data"
    return f".. auto{kind}:: {name}"


def api_page() -> str:
    """The public names of the package, by room."""
    stub = (ROOT / "shockpc" / "__init__.pyi").read_text(encoding="utf-8")
    rooms: dict[str, list[str]] = {}
    for module, name in re.findall(r"^from \.([\w.]+) import \w+ as (\w+)$", stub, re.MULTILINE):
        parts = module.split(".")
        room = parts[1] if parts[0] == "wings" else parts[0]
        rooms.setdefault(room, []).append(name)
    parts = ["# Python: API reference", "Every name is an attribute of `shockpc`."]
    for room in sorted(rooms, key=lambda room: [*ROOMS, room].index(room)):
        parts.append(f"## {ROOMS.get(room, room.capitalize())}")
        directives = [documented(f"shockpc.{name}", getattr(shockpc, name)) for name in rooms[room]]
        parts.append(restructured(directives))
    return "\n\n".join(parts)


def restructured(directives: list[str]) -> str:
    """Directives of reStructuredText in a page of Markdown."""
    return "\n".join(["```{eval-rst}", "\n\n".join(directives), "```"])


def equation_modules() -> Iterator[str]:
    """The modules of the method: of its room, and of the mathematics that it stands on."""
    for room in ("method", "core"):
        folder = ROOT / "shockpc" / room
        if folder.is_dir():
            found = pkgutil.walk_packages([str(folder)], f"shockpc.{room}.")
            yield from sorted(module.name for module in found)


def internals_page() -> str:
    """The functions that implement the equations, as the table of the guide names them."""
    method = (ROOT / "shockpc" / "guide" / "method.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([\d, ]+) \| ([^|]*) \| ([^|]*) \| [^|]* \|$", method, re.MULTILINE)
    formulas = tomllib.loads((HERE / "paper.toml").read_text(encoding="utf-8"))["paper"]
    parts = [
        "# The equations and the method",
        "The functions that implement the equations of the paper "
        f"([doi 10.3389/fmech.2020.601922]({DOI})), and the "
        "modules in which they stand. These names are no public interface.",
    ]
    for numbers, says, places in rows:
        names = [name.replace(":", ".") for name in re.findall(r"`([\w.]+:\w+)`", places)]
        things = {f"shockpc.{name}": pkgutil.resolve_name(f"shockpc.{name}") for name in names}
        parts.append(f"## Eq. {numbers}: {says}")
        parts.append(f"```{{math}}\n{formulas[numbers]}\n```")
        parts.append(
            restructured(
                [documented(name, thing) + "\n   :no-index:" for name, thing in things.items()]
            )
        )
    for module in equation_modules():
        if not module.startswith("shockpc.method"):
            continue
        parts.append(f"## {module}\n\n{restructured([f'.. automodule:: {module}'])}")
    return "\n\n".join(parts)


def quantities_page() -> str:
    """The table of quantities, each with its unit, and its equation or definition.

    Raises:
        ValueError: an equation of a quantity that does not exist, or with a bar, which ends a cell.
    """
    equations = tomllib.loads((HERE / "equations.toml").read_text(encoding="utf-8"))
    kinds = {quantity.of: None for quantity in shockpc.QUANTITIES}
    known = {(quantity.of, quantity.key) for quantity in shockpc.QUANTITIES}
    for kind, keys in equations.items():
        for key, (latex, _) in keys.items():
            if (kind, key) not in known or "|" in latex:
                raise ValueError(f"equations.toml: {kind}.{key} is no quantity, or has a bar")
    parts = [
        "# Quantities of a landing",
        "`shockpc quantities` prints this table. Symbols are those of the "
        "[notation](shockpc/guide/notation.md), numbers of equations those of the paper "
        f"([doi 10.3389/fmech.2020.601922]({DOI})). The same "
        "equations hold for quantities whose key ends in `_friction`, `_compressed` or "
        "`_separated`, with the jumps of that impact.",
    ]
    for kind in kinds:
        rows = [
            f"| `{one.key}` | {cell(one.title)} | {cell(one.unit)} | "
            f"{formula(equations, kind, one.key)} |"
            for one in shockpc.QUANTITIES
            if one.of == kind
        ]
        head = ["| key | what it is | unit | equation, or definition |", "|---|---|---|---|"]
        parts.append(f"## Of a {kind}\n\n" + "\n".join([*head, *rows]))
    return "\n\n".join(parts)


def cell(text: str) -> str:
    """A text in a cell of a table."""
    return text.replace("|", r"\|")


def formula(equations: dict[str, dict[str, list[str]]], kind: str, key: str) -> str:
    """The formula of a quantity and its source, or its definition; empty if it has neither."""
    latex, source = equations.get(kind, {}).get(key, ["", ""])
    large = latex.replace(r"\frac", r"\dfrac")
    return f"{{math}}`{large}` {source}".strip() if latex else source


def beside_the_paper() -> dict[str, str]:
    """What the paper says of its figures beside what is computed here, by figure."""
    texts = {}
    for number in PAPER:
        words = ["-m", "shockpc", "paper", str(number), "--format", "json"]
        done = subprocess.run([sys.executable, *words], check=True, capture_output=True)
        document = json.loads(done.stdout)
        (figure,) = document["figures"]
        panels = ["| panel | what it shows | scene |", "|---|---|---|"]
        for panel in figure["panels"]:
            scene = f"[`{panel['scene']}`](robots/scenes/{panel['scene']}.toml)"
            panels.append(f"| {panel['label']} | {panel['words']} | {scene} |")
        claims = [
            "| what the paper says | where | interpretation | outcome | value, and bound |",
            "|---|---|---|---|---|",
        ]
        for claim in document["tables"]["claims"]:
            says, reading = cell(claim["claim"]), cell(claim["interpretation"])
            value = f"{float(claim['value']):.4g}, {claim['holds_if']}"
            claims.append(
                f"| {says} | {claim['section']} | {reading} | {claim['outcome']} | {value} |"
            )
        link = f"[Figure {number} of the paper]({DOI})"
        texts[f"figure{number}"] = "\n\n".join(
            [f"{link}: {figure['title']}. {figure['note']}", "\n".join(panels), "\n".join(claims)]
        )
    return texts


def gallery_page(beside: Mapping[str, str]) -> str:
    """Every figure with the command that makes it, as the target `gallery` of the Makefile says.

    Args:
        beside: what follows a figure, by its name.
    """
    rules = (ROOT / "Makefile").read_text(encoding="utf-8").replace("\\\n", "")
    rules = re.sub(r"[ \t]{2,}", " ", rules)
    headings = tomllib.loads((HERE / "gallery.toml").read_text(encoding="utf-8"))
    (unknown,) = re.findall(r"^UNKNOWN = (.*)$", rules, re.MULTILINE)
    typed = re.findall(r'@"\$\(BIN\)/shockpc" (.*?) --out (out/\w+)', rules)
    commands = {out: f"shockpc {words} --out {out}" for words, out in typed}
    drawn = figures_copied(rules)
    parts = [
        "# Gallery",
        "`make gallery` draws these figures again, from a clone of the repository. `--format pdf` "
        "and `--format png` write other formats.",
    ]
    for path in sorted((ROOT / "robots" / "gallery").glob("*.svg")):
        command = commands[drawn[path.name]].replace("$(UNKNOWN)", unknown)
        heading = headings[path.stem]
        figure = f"![{heading}](robots/gallery/{path.name})"
        parts.append(f"## {heading}\n\n```\n{command}\n```\n\n{figure}")
        if path.stem in beside:
            parts.append(beside[path.stem])
    return "\n\n".join(parts)


def figures_copied(rules: str) -> dict[str, str]:
    """The folder in which a figure of the gallery was drawn, by the figure's name."""
    folders = {}
    for words in re.findall(r"^\t?@cp (.*)$", rules, re.MULTILINE):
        *sources, target = words.split()
        for source in map(Path, sources):
            if "*" in source.name:
                for path in (ROOT / "robots" / "gallery").glob(source.name):
                    folders[path.name] = str(source.parent)
            else:
                name = Path(target).name if target.endswith(".svg") else source.name
                folders[name] = str(source.parent)
    return folders


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
