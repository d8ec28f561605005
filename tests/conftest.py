"""What holds for every test: the same examples on every machine, no clock; and a folder to work in.

To look further than the fixed examples: python -m pytest --hypothesis-profile explore
"""

import os
import signal
import sys

# Threads of small products wait for one another by computing, which takes several times as long
# where others compute as well.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import pytest
from commands import STICK, dog_in
from hypothesis import HealthCheck, settings

from shockpc.show.figure import style
from shockpc.text.paths import inputs

# Tests start hundreds of interpreters; without compiled files each compiles the whole package anew.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

style.DPI = 50  # no test looks at the pixels of a figure

COMMON = {
    "deadline": None,
    "database": None,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large],
}

settings.register_profile("fixed", derandomize=True, max_examples=20, **COMMON)
settings.register_profile("explore", max_examples=200, **COMMON)
settings.load_profile("fixed")

# What a shell starts in the background ignores Ctrl-C, and so would the commands that tests
# interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working folder with a stick.urdf and the dog's package in it."""
    folder = tmp_path.resolve()
    monkeypatch.chdir(folder)
    (folder / "stick.urdf").write_text(STICK)
    dog_in(folder)
    return folder


@pytest.fixture
def no_figures(monkeypatch):
    """Drawing takes longer than all else, in pages as well; the tests of figures and pages look at
    what is drawn.
    """
    monkeypatch.setattr(
        "shockpc.show.figure.style.render",
        lambda name, draw, pdf=False: {f"{name}.svg": b"", f"{name}.png": b""},
    )
    monkeypatch.setattr("shockpc.show.folder.plotly", lambda: None)


@pytest.fixture(autouse=True, scope="session")
def own_cache(tmp_path_factory):
    """A cache folder of the tests alone, also for the commands that they start."""
    os.environ["XDG_CACHE_HOME"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(autouse=True)
def nothing_read_yet():
    """Files that an earlier test read do not count as this one's: a new file may have the inode of
    a removed one.
    """
    inputs.clear()
