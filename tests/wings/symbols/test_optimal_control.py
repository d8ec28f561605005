"""The examples of the guide's page on symbols, in which a library searches a landing."""

import importlib.util
import re

import pytest

from shockpc.studies.guide.command import files_of

PAGE = files_of("md")["symbols"].read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("library", ["casadi", "crocoddyl"])
def test_a_library_finds_a_landing_with_a_tenth_of_the_shock(library):
    if importlib.util.find_spec(library) is None:
        pytest.skip(f"{library} is not installed")
    (text,) = re.findall(
        rf"^```python\n(import {library}\n.*?)^```", PAGE, re.MULTILINE | re.DOTALL
    )
    names = {"__name__": "example"}
    exec(compile(text, "symbols.md", "exec"), names)
    assert 0.0 < names["after"] < 0.1 * names["before"]
