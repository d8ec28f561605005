"""Hostile inputs through the command line, a fixed few; `make fuzz` runs any number of them."""

import subprocess
import sys
from pathlib import Path


def test_hostile_inputs():
    """No traceback, crash, hang, incomplete file or exit code that means something else; in a process of its own, which forks."""
    fuzz = str(Path(__file__).with_name("fuzz.py"))
    done = subprocess.run([sys.executable, fuzz, "60", "--workers", "2"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout + done.stderr
