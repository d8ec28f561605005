"""Reading a robot file: what is accepted, and the whole text of every refusal."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from robot_texts import arm, body, floating, link, mjcf, urdf

from shockpc.errors import RobotError, UnknownName
from shockpc.robot.build import build_model
from shockpc.robot.catalogue import catalogue
from shockpc.robot.source import read_source

NOT_ROBOTS = {"ur3_empty", "hector_macro", "hector_xacro"}  # files of the data package that hold none


def refusal(tmp_path: Path, text: str | bytes, name: str = "dog.urdf") -> str:
    """The text of the error that reading this file raises."""
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(RobotError) as caught:
        read_source(str(path))
    return str(caught.value)


@pytest.mark.parametrize("name", [entry.name for entry in catalogue() if entry.name not in NOT_ROBOTS])
def test_every_known_robot_reads_and_builds(name: str, capfd: pytest.CaptureFixture[str]):
    """Every robot known by name is read, builds and has mass, and the C++ parser prints nothing."""
    source = read_source(name)
    model = build_model(source)
    assert source.name == name
    assert sum(inertia.mass for inertia in model.inertias) > 0
    assert capfd.readouterr() == ("", "")


def test_what_is_read(tmp_path: Path):
    """A plain URDF comes through as it is, with its name, folder and SRDF."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm())
    (tmp_path / "dog.srdf").write_text('<robot name="r"><group_state name="standing" group="all"/></robot>')
    source = read_source(str(path))
    assert (source.path, source.name, source.kind, source.xml, source.robot_name) == (path, None, "urdf", arm(), "r")
    assert (source.srdf, source.packages, source.folders, source.warnings) == (tmp_path / "dog.srdf", {}, (tmp_path,), ())


def test_format_is_found_by_content(tmp_path: Path):
    """A URDF is a URDF whatever its file is called."""
    path = tmp_path / "dog.xml"
    path.write_text(arm())
    assert read_source(str(path)).kind == "urdf"


def test_one_free_body_is_a_robot(tmp_path: Path):
    """A single link with mass and no joint can be struck."""
    path = tmp_path / "beam.urdf"
    path.write_text(urdf(link("beam")))
    assert build_model(read_source(str(path))).nv == 6


FILES: dict[str | bytes, str] = {
    "": "dog.urdf is empty; a robot file begins with <robot> (URDF, xacro) or <mujoco> (MJCF)",
    " \n": "dog.urdf is empty; a robot file begins with <robot> (URDF, xacro) or <mujoco> (MJCF)",
    b'<robot name="r">\n\xff</robot>': "dog.urdf: line 2: byte 0xff is not UTF-8; save the file as UTF-8 text",
    '<robot name="r">\n  <link></robot>': (
        "dog.urdf: line 2, column 11: mismatched tag; the file is not well-formed XML, so nothing of it is used"
    ),
    "hello": "dog.urdf: line 1, column 1: syntax error; the file is not well-formed XML, so nothing of it is used",
    "<robot>&dog;</robot>": (
        "dog.urdf: line 1, column 8: undefined entity; the file is not well-formed XML, so nothing of it is used"
    ),
    '<?xml version="1.0"?>\n<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]>\n<robot>&a;</robot>': (
        "dog.urdf: line 2: a DOCTYPE can define entities, and those are never expanded here; "
        "delete the DOCTYPE and write out what its entities stand for"
    ),
    "<robot>" * 900: "dog.urdf: line 1: elements are nested more than 800 deep",
    '<sdf version="1.7"/>': (
        "dog.urdf begins with <sdf>: an SDF file, which Pinocchio's wheel cannot read; convert it to URDF. "
        "Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)"
    ),
    "<html></html>": (
        "dog.urdf begins with <html>: a web page; download the file itself (on GitHub: the raw file). "
        "Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)"
    ),
    "<note/>": (
        "dog.urdf begins with <note>: no kind of robot known here. Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)"
    ),
    '<robot name="r"><group_state name="standing" group="all"/></robot>': (
        "dog.urdf is an SRDF: it names postures of a robot and holds none itself. Give the URDF, and this file with --srdf dog.urdf"
    ),
}


@pytest.mark.parametrize("text", FILES)
def test_not_a_robot_file(text: str | bytes, tmp_path: Path):
    """What is no robot file says what it is, and where it breaks."""
    assert refusal(tmp_path, text) == FILES[text]


def test_folder_instead_of_a_file(tmp_path: Path):
    """A folder is not a file."""
    with pytest.raises(RobotError) as caught:
        read_source(f"{tmp_path}/")
    assert str(caught.value) == f'"{tmp_path}" is a folder; give the robot file in it'


def test_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A file that may not be read says so; reading itself refuses, for root is refused nothing by permissions."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm())

    def refuse(*_: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(RobotError) as caught:
        read_source(str(path))
    assert str(caught.value) == f'"{path}" cannot be read: Permission denied; check its permissions'


def test_only_regular_files_of_some_size_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A pipe would be waited for, a device has no end."""
    os.mkfifo(tmp_path / "pipe.urdf")
    for path in (tmp_path / "pipe.urdf", Path("/dev/zero")):
        with pytest.raises(RobotError, match=r"is a pipe or a device; save what it gives in a file$"):
            read_source(str(path))
    with open(tmp_path / "large.urdf", "wb") as file:
        file.truncate(65 * 2**20)
    with pytest.raises(RobotError, match=r"has 65 MB; files of up to 64 MB are read$"):
        read_source(str(tmp_path / "large.urdf"))


BEFORE = (b"\xef\xbb\xbf", b"\xef\xbb\xbf\xef\xbb\xbf", b"\n", b"\r\n \xef\xbb\xbf\n")


@pytest.mark.parametrize("before", BEFORE)
def test_marks_and_blanks_before_a_document(before: bytes, tmp_path: Path):
    """Byte-order marks and blank lines; a DOCTYPE behind them is found all the same."""
    path = tmp_path / "dog.urdf"
    path.write_bytes(before + b'<?xml version="1.0" encoding="utf-8"?>' + arm().encode())
    assert read_source(str(path)).robot_name == "r"
    assert build_model(read_source(str(path))).nv == 7
    assert "a DOCTYPE can define entities" in refusal(tmp_path, before + b"<!DOCTYPE robot><robot/>")


def test_declared_encodings(tmp_path: Path):
    """A Latin-1 file keeps its names; an encoding that is not known is refused."""
    text = f'<?xml version="1.0" encoding="ISO-8859-1"?>{arm().replace("tip", "Fuß")}'
    path = tmp_path / "dog.urdf"
    path.write_bytes(text.encode("iso-8859-1"))
    assert build_model(read_source(str(path))).existFrame("Fuß")
    (tmp_path / "dog.xacro").write_bytes(text.encode("iso-8859-1"))
    assert 'link name="Fuß"' in read_source(str(tmp_path / "dog.xacro")).xml
    assert refusal(tmp_path, text.replace("ISO-8859-1", "EBCDIC")) == (
        "dog.urdf is in the encoding EBCDIC, which is not read; save the file as UTF-8 text"
    )


def test_srdf_beside_the_robot_has_to_be_inside(tmp_path: Path):
    """One that a symbolic link leads to elsewhere is not read."""
    (tmp_path / "away.srdf").write_text('<robot name="r"><group_state name="standing" group="all"/></robot>')
    (tmp_path / "dog").mkdir()
    path = tmp_path / "dog" / "dog.urdf"
    path.write_text(arm())
    (tmp_path / "dog" / "dog.srdf").symlink_to(tmp_path / "away.srdf")
    assert read_source(str(path)).srdf is None


def test_names_and_paths_that_are_not_there(tmp_path: Path):
    """Unknown names and missing files keep their own errors."""
    with pytest.raises(UnknownName):
        read_source("no_such_robot")
    with pytest.raises(RobotError, match=r"^no file "):
        read_source(str(tmp_path / "dog.urdf"))


def test_xacro_arguments_for_a_plain_urdf(tmp_path: Path):
    """Arguments that have no effect are refused."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm())
    with pytest.raises(RobotError) as caught:
        read_source(str(path), xacro={"payload": "1"})
    assert str(caught.value) == "dog.urdf is not a xacro file, so --xacro payload=… has no effect; leave it out"


def test_given_srdf(tmp_path: Path):
    """A given SRDF wins over the one beside the robot, and has to be one."""
    path, postures = tmp_path / "dog.urdf", tmp_path / "poses.xml"
    path.write_text(arm())
    postures.write_text('<robot name="r"><group_state name="standing" group="all"/></robot>')
    assert read_source(str(path), srdf=postures).srdf == postures
    with pytest.raises(RobotError) as caught:
        read_source(str(path), srdf=path)
    assert str(caught.value) == ("dog.urdf is not an SRDF: an SRDF begins with <robot> and holds <group_state> postures, no links")
    with pytest.raises(RobotError) as caught:
        read_source(str(path), srdf=tmp_path / "none.srdf")
    assert str(caught.value) == f'no file "{tmp_path / "none.srdf"}"'


def test_srdf_for_an_mjcf(tmp_path: Path):
    """It would have no effect, so it is refused; one that lies beside the file is ignored."""
    path = tmp_path / "dog.xml"
    path.write_text(mjcf(floating(body("b"))))
    postures = tmp_path / "dog.srdf"
    postures.write_text('<robot name="m"><group_state name="standing" group="all"/></robot>')
    assert read_source(str(path)).srdf is None
    with pytest.raises(RobotError) as caught:
        read_source(str(path), srdf=postures)
    assert str(caught.value) == (
        "dog.xml is an MJCF, whose postures are its keyframes, so the SRDF dog.srdf has no effect; leave it out, or write "
        "its postures as <key> elements of a <keyframe>"
    )


SLOW = ("numpy", "pinocchio", "matplotlib", "scipy", "trimesh", "xacro", "importlib.metadata")


@pytest.mark.parametrize("module", ["catalogue", "source"])
def test_import_is_light(module: str):
    """Reading a file needs the standard library alone."""
    # The package's own __init__ is not under test here, so the module's own imports are counted from an empty package.
    code = f"import sys, shockpc.robot.{module}; print([m for m in {SLOW!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_reading_is_repeatable(tmp_path: Path):
    """Reading changes nothing that a second reading would notice."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm())
    assert vars(read_source(str(path))) == vars(read_source(str(path)))


@pytest.mark.parametrize("given", ["~nobody_by_this_name/dog.urdf", "x" * 5000 + ".urdf", "loop/dog.urdf"])
def test_paths_that_break_the_file_system(given: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """An unknown home, a name beyond the file system's limit, a link to itself: a missing file, not a crash."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    with pytest.raises(RobotError, match=r"^no file "):
        read_source(given)
