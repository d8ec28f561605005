"""Files: whole or not at all, as readable as any other, in a folder that was tried before."""

import csv
import errno
import io
import json
import os
import stat
import tempfile
from pathlib import Path

import pytest
from commands import ROBOTS

import shockpc.show.folder
from shockpc import Contact, OutputError, Scene, shock_profile
from shockpc.show.document import to_json
from shockpc.show.files import check_folder, make_folder, write_text, write_whole
from shockpc.show.folder import write_profile
from shockpc.show.tables.text import markdown_report


def failure(code: int) -> OSError:
    return OSError(code, os.strerror(code))


def test_text_is_written_as_it_is(tmp_path):
    """UTF-8, and no line ending is touched."""
    write_text(tmp_path / "a.txt", "Δω\r\n\n")
    assert (tmp_path / "a.txt").read_bytes() == b"\xce\x94\xcf\x89\r\n\n"


def test_file_is_as_readable_as_any_other(tmp_path):
    """A result gets the rights that the user's other new files get, not those of a temporary one."""
    before = os.umask(0o027)
    try:
        write_text(tmp_path / "a.txt", "a")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o640
    assert os.umask(before) == before


def test_file_is_replaced_as_a_whole(tmp_path):
    """While it is written the old one stands; the part lies beside it, hidden, with the same suffix."""
    path = tmp_path / "shock.svg"
    path.write_text("old")

    def fill(part: Path) -> None:
        assert part.parent == path.parent
        assert (part.name[0], part.suffix) == (".", ".svg")
        part.write_text("new")
        assert path.read_text() == "old"

    write_whole(path, fill)
    assert path.read_text() == "new"
    assert [file.name for file in tmp_path.iterdir()] == ["shock.svg"]


@pytest.mark.parametrize("stop", [failure(errno.ENOSPC), KeyboardInterrupt(), ValueError("a bug")], ids=repr)
def test_nothing_is_left_of_a_file_that_fails(tmp_path, stop):
    """Whatever goes wrong: a full disk, Ctrl-C, a fault of our own."""
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fill(part: Path) -> None:
        part.write_text("half of it")
        raise stop

    expected = OutputError if isinstance(stop, OSError) else type(stop)
    with pytest.raises(expected) as refusal:
        write_whole(path, fill)
    if isinstance(stop, OSError):
        assert str(refusal.value) == f'"{path}" cannot be written: No space left on device'
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_rename_that_fails_leaves_nothing(tmp_path):
    """A folder stands where the file should go."""
    (tmp_path / "profile.json").mkdir()
    with pytest.raises(OutputError) as refusal:
        write_text(tmp_path / "profile.json", "{}")
    assert str(refusal.value) == f'"{tmp_path}/profile.json" cannot be written: Is a directory'
    assert [file.name for file in tmp_path.iterdir()] == ["profile.json"]


def test_file_in_no_folder(tmp_path):
    with pytest.raises(OutputError) as refusal:
        write_text(tmp_path / "away" / "a.txt", "a")
    assert str(refusal.value) == f'"{tmp_path}/away/a.txt" cannot be written: No such file or directory'


def test_folder_is_tried_and_left_as_it_was(tmp_path):
    check_folder(tmp_path, "--out")
    check_folder(tmp_path / "a" / "b", "--out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("place", "text"),
    [
        ("file", '"HERE/file" is a file; name a folder with --out'),
        ("file/a/b", '"HERE/file/a/b" would lie in "HERE/file", which is a file; name a folder with --out'),
    ],
)
def test_folder_that_is_a_file(tmp_path, place, text):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError) as refusal:
        check_folder(tmp_path / place, "--out")
    assert str(refusal.value) == text.replace("HERE", str(tmp_path))


@pytest.mark.parametrize("code", [errno.EACCES, errno.EROFS, errno.ENOSPC])
def test_folder_that_cannot_be_written(tmp_path, monkeypatch, code):
    def refuse(**_):
        raise failure(code)

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    with pytest.raises(OutputError) as refusal:
        check_folder(tmp_path / "new", "--out")
    assert str(refusal.value) == (
        f'nothing can be written in folder "{tmp_path}/new": {os.strerror(code)}; '
        "name another with --out, or change its permissions"
    )


def test_folder_is_made_with_those_above_it(tmp_path):
    make_folder(tmp_path / "a" / "b")
    make_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError) as refusal:
        make_folder(tmp_path / "file")
    assert str(refusal.value) == f'folder "{tmp_path}/file" cannot be made: File exists'


# The folder of a landing


@pytest.fixture(scope="module")
def profile():
    dog = ROBOTS / "dog"
    foot = Contact(frame="lf_foot", directions=("z",))
    robot = str(dog / "dog.urdf.xacro")
    return shock_profile(Scene(robot=robot, packages={"dog_description": str(dog)}, contact=(foot,), base="fixed"))


def rows(path: Path) -> list[list[str]]:
    return list(csv.reader(io.StringIO(path.read_text(encoding="utf-8"))))


def test_folder_of_a_landing(tmp_path, profile, monkeypatch):
    """Every file, each with the numbers of the profile; CSV holds all bodies, also those that do not move."""
    drawn = []
    monkeypatch.setattr(shockpc.show.folder, "save_figure", lambda *words: drawn.append(words))
    folder = tmp_path / "new" / "out"
    write_profile(profile, folder)
    assert drawn == [(profile, folder)]
    assert {file.name for file in folder.iterdir()} >= {"profile.json", "bodies.csv", "points.csv", "contacts.csv", "report.md"}
    assert (folder / "profile.json").read_text(encoding="utf-8") == to_json([profile])
    assert (folder / "report.md").read_text(encoding="utf-8") == markdown_report([profile], figure="shock.svg")
    document = json.loads(to_json([profile]))
    bodies = rows(folder / "bodies.csv")
    assert bodies[0][0] == "body"
    assert [row[0] for row in bodies[1:]] == [body["body"] for body in document["bodies"]]
    assert [float(row[bodies[0].index("shock at CoM [-]")]) for row in bodies[1:]] == [b["shock_com"] for b in document["bodies"]]
    points = rows(folder / "points.csv")
    assert [(row[0], row[1], float(row[5])) for row in points[1:]] == [
        (p["frame"], p["body"], p["shock"]) for p in document["points"]
    ]
    contacts = rows(folder / "contacts.csv")
    assert [row[0] for row in contacts[1:]] == ["lf_foot"]


def test_pattern_narrows_the_report_and_its_bodies(tmp_path, profile, monkeypatch):
    """Tables of bodies, for people and for spreadsheets alike; the other files are whole."""
    monkeypatch.setattr(shockpc.show.folder, "save_figure", lambda *_: None)
    write_profile(profile, tmp_path, "lf_*")
    assert (tmp_path / "report.md").read_text(encoding="utf-8") == markdown_report([profile], "lf_*", figure="shock.svg")
    assert (tmp_path / "profile.json").read_text(encoding="utf-8") == to_json([profile])
    narrow = rows(tmp_path / "bodies.csv")
    assert [row[0] for row in narrow] == ["body", "lf_leg"]
    write_profile(profile, tmp_path)
    whole = rows(tmp_path / "bodies.csv")
    assert [row[0] for row in whole] == ["body", *profile.bodies]
    assert narrow == [row for row in whole if row[0] in ("body", "lf_leg")]


def test_figure_is_there(tmp_path, profile):
    """What the report shows is in the folder."""
    write_profile(profile, tmp_path)
    assert "](shock.svg)" in (tmp_path / "report.md").read_text(encoding="utf-8")
    assert (tmp_path / "shock.svg").read_bytes().startswith(b"<?xml")
    assert (tmp_path / "shock.png").read_bytes().startswith(b"\x89PNG\r\n")
    assert not [file for file in tmp_path.iterdir() if file.name.startswith(".")]


@pytest.mark.parametrize(
    "act", [lambda path: check_folder(path, "--out"), make_folder, lambda path: write_text(path / "a.txt", "a")]
)
def test_a_path_with_a_nul_character_is_refused(act):
    """No file system accepts it; the message shows where it is."""
    with pytest.raises(OutputError, match=r'^"a\\0b.* cannot be the path of a file: it holds a NUL character$'):
        act(Path("a\0b"))
