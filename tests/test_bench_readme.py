"""The README's benchmark section comes from a bench and nowhere else."""

from pathlib import Path

import pytest

from shockpc.bench.readme import BEGIN, END, with_summary
from shockpc.errors import OutputError


def test_the_summary_takes_the_place_between_the_marks():
    """What stood there goes, what stands around it stays."""
    readme = f"before\n{BEGIN}\nold\n{END}\nafter\n"
    assert with_summary(readme, "new\n") == f"before\n{BEGIN}\n\nnew\n\n{END}\nafter\n"
    assert with_summary(with_summary(readme, "new"), "newer") == with_summary(readme, "newer")


def test_a_readme_without_a_place_is_refused():
    with pytest.raises(OutputError, match="has no place for the bench's summary"):
        with_summary("nothing here", "new")


def test_the_readme_has_such_a_section():
    """With the tables that a bench writes."""
    text = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    assert with_summary(text, text.split(BEGIN)[1].split(END)[0]) == text
    for title in ("The promise of the error estimate", "Outcomes over the suite", "What leaving out saves", "Many postures"):
        assert f"### {title}" in text
