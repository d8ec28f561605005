"""Links between the pages of the repository."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = (*ROOT.glob("shockpc/guide/*.md"), *ROOT.glob("shockpc/wings/*/*.md"))
PAGES = (ROOT / "README.md", *PACKAGE, *ROOT.glob(".github/*.md"), *ROOT.glob("robots/**/*.md"))


def links(page):
    """The file and the heading of each link of a page to a page here."""
    for target in re.findall(r"\]\((?!\w+:)([^)\s]+)", page.read_text(encoding="utf-8")):
        name, _, heading = target.partition("#")
        yield (page.parent / name).resolve() if name else page, heading


def wing_of(file):
    """The folder of the wing in which a file is; None if it is in none."""
    parts = file.relative_to(ROOT).parts
    return ROOT.joinpath(*parts[:3]) if parts[:2] == ("shockpc", "wings") else None


def headings(page):
    """The headings of a page as links name them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return [re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings(page):
    """Links of pages outside the package to a wing that is not there are left out."""
    for file, heading in links(page):
        wing = wing_of(file)
        if wing is None or wing.is_dir():
            assert file.exists(), file
            assert not heading or heading in headings(file), (file, heading)


@pytest.mark.parametrize("page", PACKAGE, ids=lambda page: page.stem)
def test_a_page_of_the_package_links_to_no_other_wing(page):
    """So that it is whole without the wing; it names the page by its command."""
    assert {wing_of(file) for file, _ in links(page)} <= {None, wing_of(page)}
