"""`shockpc bench` as a command: what it refuses, in words."""

import importlib.util

import pytest

from shockpc.cli.main import main


def refusal(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """What the command says on standard error when it ends with 2 and prints nothing else."""
    with pytest.raises(SystemExit) as end:
        main(list(words))
    said = capsys.readouterr()
    assert end.value.code == 2
    assert said.out == ""
    return said.err


@pytest.mark.parametrize("words", [(), ("--soak", "3")])
def test_without_its_packages_it_says_how_to_get_them(capsys, monkeypatch, words):
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name == "mpmath" else found(name, *rest))
    assert refusal(capsys, "bench", *words) == (
        'shockpc: the bench needs the package mpmath, which is not installed; install it with: pip install "shockpc[bench]"\n'
    )


@pytest.mark.parametrize("words", [("--compliant",), ("landing.toml",)])
def test_a_scene_and_compliant_go_together(capsys, words):
    assert refusal(capsys, "bench", *words) == (
        "shockpc: --compliant needs a scene file, and a scene file needs --compliant: shockpc bench landing.toml --compliant\n"
    )
