"""The pages of the site that follow from the package. The site itself is built by `make docs`."""

import importlib.util
import re
from pathlib import Path

import pytest

import shockpc
from shockpc.quantities.renamed import CURRENT
from shockpc.studies.guide.command import files_of

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def pages():
    """The module that writes the pages."""
    spec = importlib.util.spec_from_file_location("pages", ROOT / ".github" / "docs" / "pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_public_name_is_in_the_reference(pages):
    named = re.findall(r"^\.\. auto\w+:: shockpc\.(\w+)$", pages.api_page(), re.MULTILINE)
    assert sorted(named) == sorted(shockpc.__all__)


def test_every_quantity_is_in_its_table_with_unit_and_equation(pages):
    """And each equation of the file belongs to one. Numbers of the impact with friction, and of the
    motion on finite stiffness, have the equations of the key without its ending.
    """
    rows = re.findall(
        r"^\| `(\w+)` \| .* \| (.*) \| (.*) \|$", pages.quantities_page(), re.MULTILINE
    )
    assert sorted(key for key, *_ in rows) == sorted(
        quantity.key for quantity in shockpc.QUANTITIES
    )
    assert all(unit for _, unit, _ in rows)
    endings = ("_friction", "_compressed", "_separated")
    assert [key for key, _, text in rows if not text and not key.endswith(endings)] == []


def test_renamed_quantities_are_in_the_glossary():
    glossary = (ROOT / "shockpc" / "guide" / "glossary.md").read_text(encoding="utf-8")
    for key in CURRENT.values():
        assert f"`{key}" in glossary


def test_every_figure_is_in_the_gallery_with_its_command(pages):
    page = pages.gallery_page({})
    shown = re.findall(r"```\nshockpc .* --out out/\w+\n```\n\n!\[.*\]\((.*)\)", page)
    drawn = [f"robots/gallery/{path.name}" for path in (ROOT / "robots" / "gallery").glob("*")]
    assert sorted(shown) == sorted(drawn)


def test_every_page_of_the_guide_is_in_the_contents(pages, tmp_path):
    pages.copy_to(tmp_path)
    page = pages.index_page(tmp_path)
    for path in (*files_of("md").values(), *files_of("ipynb").values()):
        assert f"\n{path.relative_to(ROOT).with_suffix('')}\n" in page
