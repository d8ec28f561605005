"""Links, pipes, devices and huge files for every reader, and long headings: one message, soon, in
little memory.
"""

import os
import resource
import shutil
import signal
import time
from pathlib import Path

import hostile
import pytest
from commands import ROBOTS, Outcome, run

LAND, LOWEST = ("--contact", "foot"), ("--contact-point", "lowest")
URDF, XACRO, MJCF, SDF = (
    ("analyze", f"robot.{kind}", *LAND) for kind in ("urdf", "urdf.xacro", "xml", "sdf")
)
LOGS = ("log.csv", "log.bag", "log.mcap", "bag/log.mcap", "bag/metadata.yaml")
PARTS = {
    "macros.xacro": XACRO,
    "values.yaml": XACRO,
    "more.xml": MJCF,
    "part.stl": MJCF,
    "part.obj": ("analyze", "robot.urdf", "--contact", "shin", *LOWEST),
}
"""Files that another file names, which have to lie in its folder, and a command that reads each."""

READERS = PARTS | {
    "robot.urdf": URDF,
    "robot.urdf.xacro": XACRO,
    "robot.xml": MJCF,
    "robot.sdf": SDF,
    "robot.srdf": ("analyze", "srdf.toml"),
    "scene.toml": ("analyze", "scene.toml"),
    "stick": ("analyze", "./stick", *LAND),
    "drives.toml": (*URDF, "--drives", "drives.toml"),
    "budgets.toml": ("check", "budgets.toml"),
    "baseline.json": ("check", "budgets.toml", "--baseline", "baseline.json"),
    "landings.csv": ("recorded", "landings.csv", "robot.urdf"),
    "landings.npz": ("identify", "landings.npz", "robot.urdf", "--unknown", "armature:knee=0.01:1"),
    "landings.parquet": ("recorded", "landings.parquet", "robot.urdf"),
    **{log: ("touchdowns", log.split("/")[0], "robot.urdf", *LAND) for log in LOGS},
}
"""Every file that a command reads; what is read of the folder of a study, test_sweep_files.py has.
"""


@pytest.fixture
def stick(tmp_path, monkeypatch):
    """A folder with the stick's files."""
    folder = Path(shutil.copytree(ROBOTS / "stick", tmp_path / "stick"))
    scene = 'robot = "robot.urdf"\nsrdf = "robot.srdf"\ncontact = [{ frame = "foot" }]\n'
    (folder / "srdf.toml").write_text(scene)
    for name in ("landings.npz", "landings.parquet"):
        (folder / name).write_bytes(hostile.FILES[name])
    monkeypatch.chdir(folder)
    return folder


def refused(capfd, name, put):
    """Run the command that reads a file, after another one was put in its place; its message."""
    path = Path(name)
    path.parent.mkdir(exist_ok=True)
    path.unlink(missing_ok=True)
    put(path)
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail(f"{name} is waited for"))
    signal.alarm(100)
    start, memory = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    outcome = run(capfd, *READERS[name])
    signal.alarm(0)
    assert outcome._replace(err="") == Outcome(2, "", ""), outcome
    assert (outcome.err.startswith("shockpc: "), outcome.err.count("\n")) == (True, 1), outcome
    assert time.process_time() - start < 5.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 2**18  # kB
    return outcome.err


@pytest.mark.parametrize("name", READERS)
def test_links(capfd, stick, name):
    """A link to itself leads to no file; one to a file elsewhere is followed only where the user
    named it.
    """
    refused(capfd, name, lambda path: path.symlink_to(path.name))
    if name in PARTS:
        shutil.copytree(ROBOTS / "stick", stick.parent / "away")
        message = refused(capfd, name, lambda path: path.symlink_to(f"../away/{path}"))
        assert name == "part.obj" or "outside the folders" in message


@pytest.mark.parametrize("name", READERS)
def test_pipes_and_devices(capfd, stick, name):
    """A pipe would be waited for, and a device has no end."""
    for put in (os.mkfifo, lambda path: path.symlink_to("/dev/zero")):
        message = refused(capfd, name, put)
        assert name in PARTS or "pipe or a device" in message


@pytest.mark.parametrize("name", READERS)
def test_huge_files(capfd, stick, name):
    """A terabyte, of which the disk holds nothing."""

    def put(path):
        path.touch()
        os.truncate(path, 2**40)

    refused(capfd, name, put)
