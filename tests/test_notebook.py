"""What a notebook shows: the tables and the figure of the report, the page in a cell, and robots by
their names.
"""

import html
import json
import re
import sys
import types
import warnings
import webbrowser
from pathlib import Path
from urllib.parse import urlparse

import matplotlib.pyplot as plt
import pytest
from commands import STICK_WITH_IMU, good

import shockpc
from shockpc import Contact, Scene
from shockpc.show.report import Picture
from shockpc.show.tables import Sheet
from shockpc.studies.analyze.report import landing_report
from shockpc.studies.guide.command import files_of

NOTEBOOKS = tuple(files_of("ipynb").values())
LONG = ("drops", "imu")
"""Notebooks that run for some seconds."""


def cells(path):
    """Of a notebook."""
    return json.loads(path.read_text(encoding="utf-8"))["cells"]


@pytest.fixture
def profile(here):
    (here / "stick.urdf").write_text(STICK_WITH_IMU)
    return shockpc.shock_profile(Scene(robot="stick.urdf", contact="foot"))


def test_a_profile_is_shown_as_its_report(profile):
    shown, body = profile._repr_html_(), list(landing_report(profile).body(True))
    assert all(
        f"<caption>{html.escape(part.title)}</caption>" in shown
        for part in body
        if isinstance(part, Sheet) and part.rows
    )
    assert shown.count("<img ") == sum(isinstance(part, Picture) for part in body) == 1
    assert "<script" not in shown
    assert "knee" in profile.robot._repr_html_()


def test_a_page_opens_in_a_browser(profile, monkeypatch, tmp_path):
    opened = []
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setattr(webbrowser, "open", lambda address: not opened.append(address))
    profile.show()
    (address,) = opened
    text = Path(urlparse(address).path).read_text()
    assert text.startswith("<!doctype html>")
    assert 'id="view"' in text
    monkeypatch.setattr(webbrowser, "open", lambda address: False)
    with pytest.raises(shockpc.OutputError, match=r"report\.html"):
        profile.show()
    monkeypatch.setattr("shockpc.show.notebook.plotly", lambda: None)
    with pytest.raises(shockpc.OutputError, match="pip install plotly"):
        profile.show()


def test_a_page_opens_in_a_cell(profile, monkeypatch):
    shown = []
    monkeypatch.setattr(webbrowser, "open", lambda address: pytest.fail("a browser was opened"))
    kernel = types.SimpleNamespace(get_ipython=lambda: types.SimpleNamespace(kernel=None))
    monkeypatch.setitem(sys.modules, "IPython", kernel)
    monkeypatch.setitem(
        sys.modules, "IPython.display", types.SimpleNamespace(display=shown.append, HTML=str)
    )
    profile.show()
    (cell,) = shown
    assert html.escape('<div id="view">') in cell


@pytest.mark.slow
def test_names_stand_for_scenes(here):
    """The name of a scene file is that scene, every other text a robot without contacts; as a scene
    itself.
    """
    (here / "landing.toml").write_text('robot = "anymal_b"\ncontact = ["LF_FOOT"]\n')
    scene = Scene(robot="anymal_b", contact=Contact(frame="LF_FOOT"))
    profile = shockpc.shock_profile("landing.toml")
    assert profile.scene == shockpc.shock_profile(scene).scene
    assert (
        shockpc.resolve("landing.toml", profile.robot).scene
        == shockpc.resolve(scene, profile.robot).scene
    )
    assert (
        shockpc.shock_maps("landing.toml", profile.q[None]).maps
        == shockpc.shock_maps(scene, profile.q[None]).maps
    ).all()
    varied = {"strike-angle": [0.0, 10.0]}
    values = [
        shockpc.sweep(one, varied, at=["imu_link"]).table.values("shock@imu_link").tolist()
        for one in ("landing.toml", scene)
    ]
    assert values[0] == values[1]
    target = "shock@imu_link"
    for robot in ("anymal_b", {"": "anymal_b"}):
        assert (
            len(shockpc.sensitivity(robot, target).landings)
            == len(shockpc.sensitivity(Scene(robot="anymal_b"), target).landings)
            > 4
        )
    by_name = shockpc.compare(["landing.toml", scene])
    assert by_name.designs[0].label == "landing.toml"
    assert by_name.quantities[0].rows[0].changes == (0.0,)
    with pytest.raises(shockpc.SceneError, match="LF_FOOT"):  # of the contacts that it could have
        shockpc.shock_profile("anymal_b")
    with pytest.raises(shockpc.UnknownName, match="nosuch"):
        shockpc.fall("nosuch")


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] * (path.stem in LONG))
        for path in NOTEBOOKS
    ],
)
def test_a_notebook_of_the_guide_runs(path, capfd):
    """Its cells, which compare with closed forms and check the answers of exercises themselves."""
    plt.switch_backend("agg")
    names = {"__name__": path.stem}
    code = [cell for cell in cells(path) if cell["cell_type"] == "code"]
    assert any("assert " in "".join(cell["source"]) for cell in code)
    with warnings.catch_warnings():
        for cell in code:
            assert cell["outputs"] == []
            exec(compile("".join(cell["source"]), path.name, "exec"), names)
    plt.close("all")
    assert capfd.readouterr().out


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_exercises_have_collapsed_solutions_that_check_the_answer(path):
    """The solution is the last section; JupyterLab folds its heading, the site its code."""
    headings = ["".join(cell["source"]).partition("\n")[0] for cell in cells(path)]
    start = headings.index("## Solution")
    assert any("## Exercise" in "".join(cell["source"]) for cell in cells(path)[:start])
    assert cells(path)[start]["metadata"] == {"jp-MarkdownHeadingCollapsed": True}
    code = [cell for cell in cells(path)[start:] if cell["cell_type"] == "code"]
    assert any("assert " in "".join(cell["source"]) for cell in code)
    assert all(cell["metadata"] == {"tags": ["hide-cell"]} for cell in code)


def test_the_guide_lists_and_prints_notebooks(capfd):
    """Beside the pages; a notebook is printed as text, with all of its cells."""
    listed = good(capfd, "guide")
    for path in NOTEBOOKS:
        title = cells(path)[0]["source"][0].removeprefix("# ").rstrip()
        assert re.search(rf"^{path.stem} +{re.escape(title)}$", listed, re.MULTILINE)
        shown = good(capfd, "guide", path.stem)
        assert str(path) in shown
        assert all("".join(cell["source"]) in shown for cell in cells(path)[1:])
