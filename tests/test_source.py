"""Reading a robot file: what is accepted, and the whole text of every refusal."""

import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest
from commands import says
from robot_texts import (
    arm,
    body,
    floating,
    link,
    loaded,
    mjcf,
    read,
    refusal,
    refused,
    urdf,
    written,
)

from shockpc import RobotError, UnknownName, load_robot
from shockpc.robot.catalogue import catalogue
from shockpc.robot.formats import read_source

# files of the data package that hold none
NOT_ROBOTS = {"ur3_empty", "hector_macro", "hector_xacro"}
SRDF = '<robot name="r"><group_state name="standing" group="all"/></robot>'


@pytest.mark.parametrize(
    "name", [entry.name for entry in catalogue() if entry.name not in NOT_ROBOTS]
)
def test_every_known_robot_loads(name: str, capfd: pytest.CaptureFixture[str]):
    """Every robot known by name has mass, and the C++ parser prints nothing."""
    robot = load_robot(name)
    assert robot.label == name
    assert robot.mass > 0
    assert capfd.readouterr() == ("", "")


def test_what_is_read(tmp_path: Path):
    """A plain URDF comes through as it is, with its name, folder and SRDF, whatever the file is
    called, and again.
    """
    (tmp_path / "dog.srdf").write_text(SRDF)
    for name in ("dog.urdf", "dog.xml", "dog.urdf"):
        source = read(tmp_path, arm(), name)
        assert (source.path, source.name, source.kind, source.xml) == (
            tmp_path / name,
            None,
            "urdf",
            arm(),
        )
        assert (source.robot_name, source.srdf, source.warnings) == ("r", tmp_path / "dog.srdf", ())
        assert (source.folders.packages, source.folders.allowed) == ({}, (tmp_path.parent,))
    assert loaded(tmp_path, urdf(link("beam"))).model.nv == 6  # one body without a joint is a robot


NO_XML = "; the file is not well-formed XML, so nothing of it is used"
FILES: dict[str | bytes, str] = {
    "": (
        " is empty; a robot file begins with <robot> (URDF, xacro) or <mujoco> (MJCF) or <sdf> "
        "(SDFormat)"
    ),
    " \n": (
        " is empty; a robot file begins with <robot> (URDF, xacro) or <mujoco> (MJCF) or <sdf> "
        "(SDFormat)"
    ),
    b'<robot name="r">\n\xff</robot>': ": line 2: byte 0xff is not UTF-8; save the file as UTF-8 text",
    '<robot name="r"/>'.encode(
        "utf-16-be"
    ): " holds NUL characters, as text in UTF-16 does; save the file as UTF-8 text",
    '<robot name="r">\n  <link></robot>': f": line 2, column 11: mismatched tag{NO_XML}",
    "hello": f": line 1, column 1: syntax error{NO_XML}",
    "<robot>&dog;</robot>": f": line 1, column 8: undefined entity{NO_XML}",
    '<?xml version="1.0"?>\n<!DOCTYPE robot [<!ENTITY a SYSTEM '
    '"file:///etc/passwd">]>\n<robot>&a;</robot>': (
        ": line 2: a DOCTYPE can define entities, and those are never expanded here"
    ),
    '<?xml version="1.0" encoding="EBCDIC"?><robot name="ß"/>'.encode(
        "iso-8859-1"
    ): ": line 1: byte 0xdf is not UTF-8",
    f"{arm()}<robot/>": NO_XML,
    f"{arm()}</robot> more": NO_XML,
    "<robot>" * 900: ": line 1: elements are nested more than 490 deep",
    "<robot>"
    + "<a b='1'/>" * 250_000
    + "</robot>": ": line 1: up to 500000 elements and attributes are read, and there are more",
    "<html></html>": " begins with <html>: a web page",
    "<note/>": (
        " begins with <note>: no kind of robot known here. Robots begin with <robot> (URDF, xacro) "
        "or <mujoco> (MJCF)"
    ),
    SRDF: (
        ": it has no <link>, so there is no robot in it; give the file that uses its macros or, "
        "for an SRDF"
    ),
}


@pytest.mark.parametrize("text", FILES, ids=range(len(FILES)))
def test_not_a_robot_file(text: str | bytes, tmp_path: Path):
    """What is no robot file says what it is, and where it breaks."""
    message = refusal(tmp_path, text)
    assert message.startswith("dog.urdf")
    assert FILES[text] in message


def test_only_files_of_some_size_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What may not be read says so, for root is refused nothing by permissions."""
    with open(tmp_path / "large.urdf", "wb") as file:
        file.truncate(65 * 2**20)
    said = {
        f"{tmp_path}/": (f'"{tmp_path}"', "folder"),
        f"{tmp_path}/large.urdf": (f'"{tmp_path}/large.urdf"', "65 MB", "64 MB"),
    }
    for path, parts in said.items():
        refused(RobotError, parts, read_source, path)
    path = written(tmp_path, arm())
    monkeypatch.setattr(os, "open", Mock(side_effect=PermissionError(13, "Permission denied")))
    refused(RobotError, (f'"{path}"', "Permission denied"), read_source, path)


@pytest.mark.parametrize(
    "before", [b"\xef\xbb\xbf", b"\xef\xbb\xbf\xef\xbb\xbf", b"\n", b"\r\n \xef\xbb\xbf\n"]
)
def test_marks_and_blanks_before_a_document(before: bytes, tmp_path: Path):
    """Byte-order marks and blank lines; a DOCTYPE behind them is found all the same."""
    assert (
        loaded(
            tmp_path, before + b'<?xml version="1.0" encoding="utf-8"?>' + arm().encode()
        ).model.nv
        == 7
    )
    assert "a DOCTYPE can define entities" in refusal(
        tmp_path, before + b"<!DOCTYPE robot><robot/>"
    )


@pytest.mark.parametrize(
    "encoding",
    [
        "ISO-8859-1",
        "utf-16",
        "utf-16-be",
        "utf-32-le",
        "cp500",
        "shift_jis",
        "iso-2022-jp",
        "utf-7",
    ],
)
def test_declared_encodings_and_closing_tags_left_over(encoding: str, tmp_path: Path):
    """A file in any encoding keeps its names; a file that closes its root element twice is read."""
    foot = "Fuß" if encoding in ("ISO-8859-1", "cp500") else "足"
    text = f'<?xml version="1.0" encoding="{encoding}"?>{arm().replace("tip", foot)}'
    for name, rest in (("dog.urdf", "\n</robot> </a>\n"), ("dog.xacro", "")):
        assert loaded(tmp_path, (text + rest).encode(encoding), name).model.existFrame(foot)


@pytest.mark.parametrize("encoding", ["utf-16", "us-ascii", "punycode", "hex", "nothing"])
def test_a_file_in_another_encoding_than_it_declares_is_read_as_utf_8(
    encoding: str, tmp_path: Path
):
    text = f'<?xml version="1.0" encoding="{encoding}"?>{arm().replace("tip", "Fuß")}'
    assert loaded(tmp_path, text.encode()).model.existFrame("Fuß")


def test_srdf(tmp_path: Path):
    """A given SRDF wins over the one beside the robot, and has to be one; a symbolic link that
    leads elsewhere is not followed.
    """
    (tmp_path / "away.srdf").write_text(SRDF)
    folder = tmp_path / "dog"
    folder.mkdir()
    (folder / "package.xml").touch()
    (folder / "dog.srdf").symlink_to(tmp_path / "away.srdf")
    assert read(folder, arm()).srdf is None
    given = written(folder, SRDF, "poses.xml")
    assert read(folder, arm(), srdf=given).srdf == folder / "poses.xml"
    assert "dog.urdf: other.urdf is not an SRDF" in refusal(
        folder, arm(), srdf=written(folder, arm(), "other.urdf")
    )
    assert (
        refusal(folder, arm(), srdf=str(folder / "none.srdf"))
        == f'dog.urdf: no SRDF file "{folder / "none.srdf"}"'
    )


def test_arguments_without_effect_are_refused(tmp_path: Path):
    """Arguments of xacro for a plain URDF; an SRDF for an MJCF, beside which one is ignored."""
    assert says(
        refusal(tmp_path, arm(), xacro={"payload": "1"}),
        "dog.urdf is not a xacro file",
        "--xacro payload=…",
    )
    srdf = written(tmp_path, SRDF, "dog.srdf")
    robot = mjcf(floating(body("b")))
    assert read(tmp_path, robot, "dog.xml").srdf is None
    assert says(
        refusal(tmp_path, robot, "dog.xml", srdf=srdf),
        "dog.xml is an MJCF",
        "dog.srdf",
        "<keyframe>",
    )


SLOW = ("numpy", "pinocchio", "matplotlib", "scipy", "trimesh", "xacro", "importlib.metadata")


def test_import_of_the_catalogue_is_light():
    """Completion of robots' names needs the standard library alone."""
    code = f"import sys, shockpc.robot.catalogue; print([m for m in {SLOW!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "given",
    ["none/dog.urdf", "~nobody_by_this_name/dog.urdf", "x" * 5000 + ".urdf", "loop/dog.urdf"],
)
def test_paths_that_lead_nowhere(given: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """No such folder, an unknown home, a name beyond the file system's limit, a link to itself: a
    missing file, not a crash.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    with pytest.raises(RobotError, match=r"^no file "):
        read_source(given)
    with pytest.raises(UnknownName):
        read_source("no_such_robot")
