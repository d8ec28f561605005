"""Files: complete or not at all, as readable as any other, without those of an earlier run, in a
folder that was checked before.
"""

import csv
import errno
import hashlib
import io
import json
import os
import stat
import subprocess
from pathlib import Path

import pytest
from commands import ROBOTS, good, run

from shockpc import Contact, OutputError, Scene, shock_profile
from shockpc.show.files import check_folder, write_file, write_folder
from shockpc.show.folder import write_report_folder
from shockpc.studies.analyze.report import analyze_report, landing_report
from shockpc.studies.analyze.report import document as document_of
from shockpc.text.cache import cached
from shockpc.text.paths import read_file
from shockpc.text.printed import json_text


def failure(code: int) -> OSError:
    return OSError(code, os.strerror(code))


def test_text_is_written_as_it_is(tmp_path):
    """UTF-8, and no line ending is touched."""
    write_file(tmp_path / "a.txt", "Δω\r\n\n")
    assert (tmp_path / "a.txt").read_bytes() == b"\xce\x94\xcf\x89\r\n\n"


def test_file_is_as_readable_as_any_other(tmp_path):
    """A result gets the rights that the user's other new files get, not those of a temporary one."""
    before = os.umask(0o027)
    try:
        write_file(tmp_path / "a.txt", "a")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o640
    assert os.umask(before) == before


@pytest.mark.parametrize(
    "stop", [failure(errno.ENOSPC), KeyboardInterrupt(), ValueError("a bug")], ids=repr
)
def test_nothing_is_left_of_a_file_that_fails(tmp_path, monkeypatch, stop):
    """A full disk, Ctrl-C or a bug before the new file gets its name: the old one is as it was, and
    nothing lies beside it.
    """
    path = tmp_path / "a.txt"
    path.write_text("old")

    def refuse(part, _):
        assert (part.parent, part.name[0], part.suffix) == (path.parent, ".", ".txt")
        assert part.read_text() == "new"
        raise stop

    monkeypatch.setattr(Path, "replace", refuse)
    expected = OutputError if isinstance(stop, OSError) else type(stop)
    with pytest.raises(expected) as refusal:
        write_file(path, "new")
    if isinstance(stop, OSError):
        assert str(refusal.value) == f'"{path}" cannot be written: No space left on device'
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


ODD = "a pipe, a device or a link to itself"
REFUSED = [
    (lambda: check_folder(Path("file"), "--out"), ("file", "Not a directory")),
    (lambda: check_folder(Path("file/a/b"), "--out"), ("file/a/b", "Not a directory")),
    (lambda: write_file(Path("b.csv"), "b"), ("b.csv", "a folder")),
    (lambda: write_file(Path("pipe"), "b"), ("pipe", ODD)),
    (lambda: write_file(Path("to_pipe"), "b"), ("to_pipe", ODD)),
    (lambda: write_file(Path("loop"), "b"), ("loop", ODD)),
    (lambda: write_file(Path("file/d.txt"), "d"), ("file/d.txt", "File exists")),
    (lambda: write_folder(Path(), {"a.csv": "1", "b.csv": "2"}, "check"), ("b.csv", "a folder")),
    (lambda: write_folder(Path(), {"a.csv": "1", "pipe": "2"}, "check"), ("pipe", ODD)),
    (
        lambda: write_folder(Path(), {"a.csv": "1", "to_file": "2"}, "check"),
        ("to_file", "out of its folder"),
    ),
    (
        lambda: write_folder(Path(), {"a.csv": "1", "to_folder/c": "2"}, "check"),
        ("to_folder/c", "out of its folder"),
    ),
]


def _state(path):
    """What writing would change; not the time of the last access, which reading a link sets."""
    found = path.lstat()
    return found.st_mode, found.st_ino, found.st_size, found.st_mtime_ns


@pytest.mark.parametrize(("act", "parts"), REFUSED, ids=range(len(REFUSED)))
def test_what_cannot_be_written_is_refused_and_nothing_is_left(tmp_path, monkeypatch, act, parts):
    """What is no file in the place of a file, or a file in that of a folder, stops before anything
    is written.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    (tmp_path / "b.csv").mkdir()
    os.mkfifo(tmp_path / "pipe")
    for name, target in {
        "to_pipe": "pipe",
        "loop": "loop",
        "to_file": "file",
        "to_folder": "/",
    }.items():
        (tmp_path / name).symlink_to(target)
    before = {path.name: _state(path) for path in tmp_path.iterdir()}
    with pytest.raises(OutputError) as refusal:
        act()
    assert [part for part in parts if part not in str(refusal.value)] == []
    assert {path.name: _state(path) for path in tmp_path.iterdir()} == before


def test_a_link_remains_and_its_target_is_written(tmp_path):
    """The file of an option may be a link, also to a file that does not exist yet."""
    (tmp_path / "there").mkdir()
    (tmp_path / "link.txt").symlink_to("there/a.txt")
    for text in ("old", "new"):
        write_file(tmp_path / "link.txt", text)
        assert (tmp_path / "link.txt").readlink() == Path("there/a.txt")
        assert [(path.name, path.read_text()) for path in (tmp_path / "there").iterdir()] == [
            ("a.txt", text)
        ]


def test_what_a_command_reads_it_does_not_replace(tmp_path):
    """Neither under the name by which it was read nor under another of the same file."""
    path = tmp_path / "robot.urdf"
    path.write_text("mine")
    os.link(path, tmp_path / "other.json")
    read_file(path, "robot file", OutputError)
    for name in ("robot.urdf", "other.json"):
        with pytest.raises(OutputError, match="read by the same command"):
            write_file(tmp_path / name, "x")
    write_file(path, "x", replaceable="robot file")
    assert (path.read_text(), (tmp_path / "other.json").read_text()) == ("x", "mine")


@pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="needs Linux")
def test_a_file_that_fails_while_it_is_read_is_a_message():
    """Opening it succeeds; a damaged disk does the same."""
    with pytest.raises(OutputError, match='"/proc/self/mem" cannot be read: Input/output error'):
        read_file(Path("/proc/self/mem"), "table", OutputError)


def test_folders_are_tried_and_left_as_they_were_and_made_with_a_file(tmp_path):
    for folder in (tmp_path, tmp_path / "a" / "b"):
        check_folder(folder, "--out")
    assert list(tmp_path.iterdir()) == []
    write_file(tmp_path / "a" / "b" / "c.txt", "c")
    assert (tmp_path / "a" / "b" / "c.txt").read_text() == "c"


# A folder of results


def listing(folder: Path) -> set[str]:
    """The files in a folder."""
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_files_of_the_last_run_are_replaced_or_removed_and_no_others(tmp_path):
    """What the last run of the same kind left does not stay beside the new files, unless somebody
    changed it; all else does.
    """
    out = tmp_path / "out"
    write_folder(out, {"check.csv": "1"}, "check")
    write_folder(
        out, {"shock.svg": "1", "joints.csv": "2", "time.svg": "3", "lf/joints.csv": "4"}, "profile"
    )
    (out / "mine.txt").write_text("mine")
    (out / "time.svg").write_text("edited")
    assert (
        subprocess.run(["sha256sum", "--check", "--quiet", ".check.sha256"], cwd=out).returncode
        == 0
    )
    write_folder(out, {"shock.svg": "5"}, "profile")
    left = {
        "shock.svg": "5",
        "check.csv": "1",
        "time.svg": "edited",
        "mine.txt": "mine",
        "lf/joints.csv": "4",
    }
    manifests = {".check.sha256", ".profile.sha256"}
    assert {name: (out / name).read_text() for name in listing(out) - manifests} == left
    # which knows the landing of the run before the last
    write_folder(out, {"shock.svg": "5", "lf/bodies.csv": "6"}, "profile")
    assert listing(out) - manifests == (left.keys() - {"lf/joints.csv"}) | {"lf/bodies.csv"}


def test_only_files_of_the_folder_that_were_not_read_are_removed(tmp_path):
    """Neither what lies behind a link, nor a folder or a pipe, nor an input of the command;
    whatever the list says.
    """
    kept = [tmp_path / "shock.svg", tmp_path / "out/read.csv", tmp_path / "out/folder/a"]
    (tmp_path / "out/folder").mkdir(parents=True)
    for path in kept:
        path.write_text("mine")
    os.mkfifo(tmp_path / "out/pipe")
    (tmp_path / "out/behind").symlink_to(tmp_path)
    (tmp_path / "out/link.svg").symlink_to(kept[0])
    read_file(kept[1], "table", OutputError)
    names = (
        "../shock.svg",
        str(kept[0]),
        "behind/shock.svg",
        "link.svg",
        "read.csv",
        "pipe",
        "folder",
        "",
        ".",
        "lost.csv",
    )
    digest = hashlib.sha256(b"mine").hexdigest()
    (tmp_path / "out/.limits.sha256").write_text(
        "".join(f"{digest}  {name}\n" for name in names) + "no line of a list\n\xff"
    )
    write_folder(tmp_path / "out", {"limits.csv": "1"}, "limits")
    assert all(path.read_text() == "mine" for path in kept)
    assert (tmp_path / "out/link.svg").is_symlink()
    assert (tmp_path / "out/pipe").is_fifo()


# The folder of a landing


@pytest.fixture(scope="module")
def profile():
    dog = ROBOTS / "dog"
    foot = Contact(frame="lf_foot", directions=("z",))
    robot = str(dog / "dog.urdf.xacro")
    return shock_profile(
        Scene(robot=robot, packages={"dog_description": str(dog)}, contact=(foot,), base="fixed")
    )


def rows(path: Path) -> list[list[str]]:
    return list(csv.reader(io.StringIO(path.read_text(encoding="utf-8"))))


FILES = {
    "profile.json",
    "bodies.csv",
    "points.csv",
    "contacts.csv",
    "joints.csv",
    "shocks.csv",
    "landing.csv",
    "directions.csv",
    "report.html",
    "report.md",
    "shock.svg",
    "shock.png",
}


def test_folder_of_a_landing(tmp_path, profile):
    """Every file, each with the numbers of the profile; CSV holds all bodies, also those that do
    not move.
    """
    folder = tmp_path / "new" / "out"
    write_report_folder(folder, analyze_report({"lf_foot": profile}))
    assert listing(folder) == FILES | {".profile.sha256"}
    assert (folder / "profile.json").read_text(encoding="utf-8") == json_text(document_of(profile))
    assert (folder / "report.md").read_text(encoding="utf-8") == landing_report(profile).files()[
        "report.md"
    ]
    assert (folder / "shock.svg").read_bytes().startswith(b"<?xml")
    document = json.loads(json_text(document_of(profile)))
    bodies = rows(folder / "bodies.csv")
    assert [row[1] for row in bodies[1:]] == [body["body"] for body in document["tables"]["bodies"]]
    assert [float(row[bodies[0].index("shock at CoM [-]")]) for row in bodies[1:]] == [
        b["shock_com"] for b in document["tables"]["bodies"]
    ]
    points = rows(folder / "points.csv")
    assert [(row[0], row[1], float(row[5])) for row in points[1:]] == [
        (p["point"], p["body"], p["shock"]) for p in document["tables"]["points"]
    ]
    assert [row[0] for row in rows(folder / "contacts.csv")[1:]] == ["lf_foot"]


@pytest.mark.slow
def test_several_landings_and_then_one(tmp_path, profile):
    """A folder for each and a summary; one landing later, the files of its names are new and the
    others as they were.
    """
    write_report_folder(tmp_path, analyze_report({"a": profile, "b": profile}))
    of_each, shared = (
        FILES - {"report.html"},
        {"report.html", "summary.csv", "landings.csv", "summary.md"},
    )
    several = {f"{name}/{file}" for name in "ab" for file in of_each} | shared | {".summary.sha256"}
    assert listing(tmp_path) == several
    page, summary = ((tmp_path / name).read_bytes() for name in ("report.html", "summary.csv"))
    write_report_folder(tmp_path, analyze_report({"lf_foot": profile}))
    one = several | FILES | {".profile.sha256"}
    assert listing(tmp_path) == one
    assert (tmp_path / "report.html").read_bytes() != page
    assert (tmp_path / "summary.csv").read_bytes() == summary
    write_report_folder(tmp_path, analyze_report({"a": profile, "c": profile}))
    assert listing(tmp_path) == one | {f"c/{file}" for file in of_each}


def test_a_user_without_a_home_gets_one_message_and_no_folder(capfd, monkeypatch, tmp_path):
    """Containers run programs under numbers of users that have no name; nothing is kept there
    between runs.
    """

    def nobody(_):
        raise KeyError("uid not found")

    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    for name in ("getpwuid", "getpwnam"):
        monkeypatch.setattr(f"pwd.{name}", nobody)
    monkeypatch.chdir(tmp_path)
    assert cached("name", lambda: b"made") == b"made"
    for word in (
        "~/r.urdf",
        "go2 --contact FL_foot --drives ~/d.toml",
        "go2 --contact FL_foot --out ~/o",
    ):
        code, out, err = run(capfd, "analyze", *word.split())
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "begins with the home of a user whom this computer does not have" in err
    assert not list(tmp_path.iterdir())


def test_figures_are_also_written_as_pdf(capfd, here):
    """The same bytes every time; without a folder there is nowhere to write them."""
    words = ("analyze", "go2", "--contact", "FL_foot", "--format", "pdf")
    assert "--out DIR" in run(capfd, *words).err
    written = []
    for name in ("a", "b"):
        good(capfd, *words, "--out", name)
        written.append((here / name / "shock.pdf").read_bytes())
    assert written[0].startswith(b"%PDF")
    assert written[0] == written[1]


@pytest.mark.parametrize("words", ["quantities", "robots", "robots go2", "batch go2"])
def test_pdf_needs_a_figure(capfd, here, words):
    """A result without a figure has no PDF, and nothing is written."""
    before = sorted(here.rglob("*"))
    code, out, err = run(capfd, *words.split(), "--format", "pdf", "--out", "folder")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "figure" in err
    assert sorted(here.rglob("*")) == before


def test_a_folder_is_not_named_like_a_pdf(capfd, here):
    """--out is a folder, whatever the format."""
    before = sorted(here.rglob("*"))
    for more in ((), ("--format", "pdf")):
        code, _, err = run(
            capfd, "analyze", "go2", "--contact", "FL_foot", "--out", "go2.pdf", *more
        )
        assert code == 2
        assert "--format pdf --out DIR" in err
    assert sorted(here.rglob("*")) == before
