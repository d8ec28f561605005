"""`shockpc bench` as a command: what it refuses, in words."""

import importlib.util
import os
import signal
import subprocess
import sys
import time

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


UNHEEDED = {
    ("landing.toml", "--compliant", "--soak", "3"): "--compliant lands one scene and does not heed --soak; leave --soak out",
    ("landing.toml", "--compliant", "--suite", "full"): "--compliant lands one scene and does not heed --suite; leave --suite out",
    ("--soak", "3", "--suite", "quick"): "--soak tries random trees and does not heed --suite; leave --suite out",
    ("--seed", "0", "--workers", "2"): (
        "the suite measures hard cases and does not heed --seed and --workers; leave --seed and --workers out, or add --soak N"
    ),
}


@pytest.mark.parametrize("words", UNHEEDED, ids=" ".join)
def test_what_would_do_nothing_is_refused(capsys, words):
    assert refusal(capsys, "bench", *words) == f"shockpc: {UNHEEDED[words]}\n"


SOAK = """
import shockpc.bench.soak as soak
soak.BLOCK = 1
from shockpc.cli.entry import entry
import sys
sys.argv[1:] = ["bench", "--soak", "5000", "--workers", "2", "--out", {out!r}]
entry()
"""


def test_an_interrupted_soak_ends_in_one_line(tmp_path):
    """Ctrl-C goes to all processes of a terminal; one of them answers."""
    command = [sys.executable, "-c", SOAK.format(out=str(tmp_path))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True) as soak:
        while not any(tmp_path.iterdir()) and soak.poll() is None:
            time.sleep(0.05)
        os.killpg(soak.pid, signal.SIGINT)
        out, err = soak.communicate()
    assert (soak.returncode, out, err) == (130, "", "shockpc: interrupted; no file was left half-written\n")


@pytest.mark.parametrize("words", [("--compliant",), ("landing.toml",)])
def test_a_scene_and_compliant_go_together(capsys, words):
    assert refusal(capsys, "bench", *words) == (
        "shockpc: --compliant needs a scene file, and a scene file needs --compliant: shockpc bench landing.toml --compliant\n"
    )
