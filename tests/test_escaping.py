"""Names that files give, at every exit of every command: terminal, Markdown, CSV, JSON, JUnit and
annotations.
"""

import csv
import json
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from commands import run
from robot_texts import joint, link, urdf

from shockpc.show.html import plotly
from shockpc.show.html.charts import history

NAMES = (
    "::error::x",
    "  ::add-mask::x",
    "##[error]x",
    "##vso[task.complete]x",
    "\x85::error::x",
    "\x9b31mred",
    "\u202eright",
    "\u200b",
    "\ufeffx",
    "a\rb",
    "\r=1+1",
    "\n::error::x",
    "\n=1+1",
    "\u2028x",
    "=1+1",
    " =1+1",
    "+x",
    "-x",
    "@SUM(1)",
    "＝1+1",
    "\t=1",
    "[x]: http://evil.example",
    "](http://evil.example)[",
    "![x](http://evil.example)",
    "<img src=x onerror=alert(1)>",
    "a|b",
    "`x`",
    "*b*",
    "__x__",
    "~~x~~",
    "$x^2$",
    "# x",
    "- x",
    "http://evil.example",
    "www.evil.example",
    "\\",
    '"',
    "a,b;c",
    "%s{}",
)
"""Each would be a command, an escape sequence, a formula, markup, or the end of a line or a cell.
"""


def robot():
    """Chains of links that have the names, with shapes, joints and sensors of the same names."""
    mesh = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    box = f'<collision><geometry><box size=".1 .1 .1"/></geometry></collision>{mesh}'
    parts = [link("base", "5", more=box.format("none.stl"))]
    for k, name in enumerate(map(quoted, NAMES)):
        carrier = "base" if k % 8 == 0 else f"{quoted(NAMES[k - 1])}{k - 1}"
        parts += [
            link(f"{name}{k}", more=box.format(f"{name}.stl")),
            joint(
                f"{name}{k}j",
                carrier,
                f"{name}{k}",
                more='<origin xyz="0 0 -.1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>',
            ),
            f'<link name="{name}{k} imu"/>',
            joint(f"{name}{k} fixed", f"{name}{k}", f"{name}{k} imu", "fixed"),
        ]
    return urdf(*parts, name=quoted("".join(NAMES)))


def quoted(name):
    """A name in an attribute of XML."""
    return "".join(
        f"&#{ord(sign)};" if ord(sign) < 32 or sign in '<&"' or ord(sign) > 126 else sign
        for sign in name
    )


def called(k, more=""):
    """The name of a link, as the reader of XML gives it."""
    return f"{NAMES[k]}{k}{more}".strip()


LAST = len(NAMES) - 1
FRAME = json.dumps(called(LAST))
LANDING = ("odd.urdf", "--contact", called(LAST))
SENSORS = [word for k in (0, 1, 2, 5, 6, 14, 21) for word in ("--at", called(k, " imu"))]
COMMANDS = {
    "analyze": (*LANDING, *SENSORS),
    "robots": ("odd.urdf",),
    "batch": ("odd.urdf", "--contact", called(7), "--contact", called(LAST)),
    "compare": ("odd.urdf", "odd.urdf", *LANDING[1:], *SENSORS),
    # straight on, nothing changes it to first order
    "sensitivity": (*LANDING, *SENSORS[:2], "--strike-angle", "20"),
    "limits": (*LANDING, "--joint", called(LAST, "j"), *SENSORS[:2], "--max", "99", "--step", "20"),
    "place": (*LANDING, "--body", called(21), "--alternatives", "0", *SENSORS),
    "sweep": (*LANDING, "--vary", f"joint:{called(0, 'j')}=0:1:2", *SENSORS),
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with the robot, and budgets of a case with such a name."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "odd.urdf").write_text(robot(), encoding="utf-8")
    return tmp_path


def check_text(text, workflow=False):
    """What is printed, or a file as text, holds nothing that a terminal or a CI runner would
    interpret.
    """
    assert [sign for sign in text if not (sign.isprintable() or sign == "\n")] == []
    assert not re.search(r"(?i)##(\[|vso\[)", text)
    commands = [line for line in text.splitlines() if line.lstrip().startswith("::")]
    assert workflow or commands == []
    assert all(re.match("::(error|warning) (file=|title=shockpc)", line) for line in commands)


def check_csv(text):
    """All rows have as many cells, and no spreadsheet computes one of them; a lone "-", the unit of
    1, is text there.
    """
    rows = list(csv.reader(text.splitlines()))
    assert len({len(row) for row in rows}) == 1
    assert [
        cell for row in rows for cell in row if re.match(r"\s*[=+@＝]|\s*-(?![\d.]|$)", cell)
    ] == []


def check_markdown(text):
    """No definition, link, image, HTML or formula comes from a name."""
    without_images = re.sub(r"!\[[^\n]*\]\(\w+\.svg\)\n", "", text)
    for markup in (r"\](?=[(:\[])", "<(?!!)", r"(?<=http):(?=//)", r"(?<=www)\.", r"\$", "`", r"~"):
        assert not re.search(
            r"(?<!\\)" + markup,
            "".join(
                line for line in without_images.splitlines(True) if not line.startswith("    ")
            ),
        )


def check_html(text):
    """No element comes from a name: those of the page are as many as its script and tables need."""
    page = HTMLParser()
    tags, attributes = [], []
    page.handle_starttag = lambda tag, attrs: (tags.append(tag), attributes.extend(attrs))
    page.feed(text)
    # of tables; with landings; with sliders of the posture
    assert tags.count("script") in (1, 5, 7)
    assert not {"a", "iframe", "link", "object", "form", "base"} & set(tags)
    assert all(
        value.startswith("data:image/svg+xml;base64,")
        for name, value in attributes
        if name in ("src", "href")
    )
    assert [name for name, _ in attributes if name.startswith("on")] == []


CHECKS = {
    "markdown": check_markdown,
    "csv": check_csv,
    "json": json.loads,
    "junit": ElementTree.fromstring,
}
SUFFIXES = {
    ".md": check_markdown,
    ".csv": check_csv,
    ".json": json.loads,
    ".svg": ElementTree.fromstring,
    ".xml": ElementTree.fromstring,
    ".html": check_html,
}


def read(path):
    """The text of a file, without Plotly's script."""
    return path.read_text(encoding="utf-8").replace(plotly().read_text(encoding="utf-8"), "")


SLOW = ("compare", "sensitivity", "place", "robots", "limits")
"""Commands whose reports have what those of the others have, in more landings."""


@pytest.mark.parametrize(
    ("command", "format_"),
    [
        *(
            pytest.param(command, "table", marks=[pytest.mark.slow] * (command in SLOW))
            for command in COMMANDS
        ),
        *(("analyze", format_) for format_ in ("markdown", "csv", "json")),
    ],
)
def test_names_of_a_robot(capfd, here, command, format_):
    """Whatever a robot's file calls its parts, every output is what its format says, on both
    streams and in every file.
    """
    formats = () if format_ == "table" else ("--format", format_)
    out = ("--out", "out") if format_ == "table" and command != "robots" else ()
    outcome = run(capfd, command, *COMMANDS[command], *formats, *out)
    assert outcome.code in (0, 3), outcome.err
    check_text(outcome.out)
    check_text(outcome.err)
    CHECKS.get(format_, str)(outcome.out)
    for path in (here / "out").rglob("*"):
        if path.suffix in SUFFIXES:
            text = read(path)
            check_text(text)
            SUFFIXES[path.suffix](text)


def test_names_of_budgets(capfd, here):
    """Cases, places and the file of budgets have such names; all formats are of one run."""
    cases = "".join(
        f'[[case]]\nname = {json.dumps(name)}\nrobot = "odd.urdf"\n[[case.contact]]\nframe = '
        f"{FRAME}\n"
        for name in NAMES[:9]
    )
    budgets = "".join(
        f'[[budget]]\nat = {json.dumps(name)}\nmetric = "shock"\nmax = 1e-30\n'
        for name in SENSORS[1::2]
    )
    (here / "::a\u202e##[b].toml").write_text(cases + budgets, encoding="utf-8")
    formats = ("json", "csv", "markdown", "junit", "github")
    words = [word for format_ in formats for word in ("--format", f"{format_}=printed.{format_}")]
    outcome = run(
        capfd, "check", "::a\u202e##[b].toml", "--format", "table", *words, "--out", "out"
    )
    assert outcome.code == 1, outcome.err
    check_text(outcome.out)
    check_text(outcome.err)
    for format_ in formats:
        text = (here / f"printed.{format_}").read_text(encoding="utf-8")
        check_text(text, format_ == "github")
        CHECKS.get(format_, str)(text)
    for path in (here / "out").rglob("*"):
        check_text(read(path))
        SUFFIXES.get(path.suffix, str)(read(path))


@pytest.mark.parametrize("name", NAMES)
def test_names_in_the_legend_of_a_chart(name):
    """Plotly reads tags, entities and formulas in a legend."""
    (curve,) = history("g", np.zeros(2), [(name, np.zeros(2))])["data"]
    assert curve["name"].isprintable()
    assert not re.search(r"[<>$]|&(?!(lt|gt|amp|#36);)", curve["name"])
