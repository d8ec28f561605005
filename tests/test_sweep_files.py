"""The files of a sweep are the same bytes whoever computes them, and however often the run was
interrupted.
"""

import contextlib
import csv
import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.dataset
import pyarrow.parquet
import pytest
from commands import STICK, good, run, says

from shockpc import Scene
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.variations import row_scenes
from shockpc.show import row_files
from shockpc.show.row_files import RowFiles
from shockpc.studies.sweep.study import sweep

SMALL = (
    "--contact",
    "foot",
    "--vary",
    "knee=-60:60:5",
    "--vary",
    "strike-angle=0:30:3",
    "--at",
    "body",
)
MANY = (
    "--contact",
    "foot",
    "--sample",
    "60000",
    "--vary",
    "*",
    "--vary",
    "strike-angle=-30:30",
    "--at",
    "body",
    "--prove",
    "4",
)


@pytest.fixture
def stick(tmp_path):
    path = tmp_path / "stick.urdf"
    path.write_text(STICK)
    return path


def command(
    *words: object,
    code="from shockpc.cli.entry import entry; entry()",
    stderr=subprocess.PIPE,
    **options,
):
    """A sweep in a separate process, in its group of processes."""
    return subprocess.Popen(
        [sys.executable, "-c", code, "sweep", *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
        start_new_session=True,
        **options,
    )


def done(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


def files(folder: Path) -> dict[str, bytes]:
    """Everything in a folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def wait_until(condition) -> None:
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def wait_for_parts(folder: Path, count: int, process: subprocess.Popen[str]) -> None:
    def written():
        assert process.poll() is None, process.communicate()
        return len(list((folder / "rows").glob("part-*"))) >= count

    wait_until(written)


def test_parts_are_one_table_with_the_scene_in_its_metadata(capfd, stick, tmp_path):
    """Every row is there, and the metadata say what it is of."""
    text = good(capfd, "sweep", stick, *SMALL, "--out", tmp_path / "out")
    table = pyarrow.dataset.dataset(tmp_path / "out" / "rows").to_table()
    assert table.num_rows == 15
    assert table.column_names[:3] == ["knee [deg]", "strike-angle [deg]", "shock@body"]
    notes = json.loads(table.schema.metadata[b"shockpc"])
    whole = json.loads((tmp_path / "out" / "sweep.json").read_text())
    # whose values the columns hold
    assert notes == {key: value for key, value in whole.items() if key != "vary"}
    assert notes["scene"]["contact"][0]["frame"] == "foot"
    assert set(notes["versions"]) == {"shockpc", "pinocchio", "numpy", "python"}
    assert notes["seed"] == 0
    assert "sweep of stick: 15 landings" in text
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {
        "rows",
        "sweep.json",
        "sweep.svg",
        "sweep.png",
        "summary.md",
        "summary.csv",
    }


def test_path_with_a_colon_is_no_address(capfd, stick, tmp_path, monkeypatch):
    """Parquet's reader takes "a:b" for an address in the file system "a", where a relative path is
    given as text.
    """
    monkeypatch.chdir(tmp_path)
    assert "sweep of stick: 15 landings" in good(
        capfd, "sweep", stick, *SMALL, "--prove", "2", "--out", "foot:0,0,0"
    )
    pyarrow.parquet.write_table(pyarrow.table({"q_knee": [0.1, 0.2]}), tmp_path / "log.parquet")
    (tmp_path / "log.parquet").rename(tmp_path / "log:1.parquet")
    assert "2 landings" in good(capfd, "recorded", "log:1.parquet", stick, "--contact", "foot")


@pytest.mark.slow
def test_csv_holds_the_same_numbers_as_parquet(capfd, stick, tmp_path):
    for format_ in ("parquet", "csv"):
        good(capfd, "sweep", stick, *SMALL, "--out", tmp_path / format_, "--rows", format_)
    table = pyarrow.parquet.read_table(tmp_path / "parquet" / "rows").to_pydict()
    with (tmp_path / "csv" / "rows.csv").open(encoding="utf-8") as file:
        for k, row in enumerate(csv.DictReader(file)):
            assert [name for name in row] == list(table)
            for name, text in row.items():
                value = table[name][k]
                assert text == (
                    ""
                    if value is None
                    else {True: "yes", False: "no"}[value]
                    if isinstance(value, bool)
                    else repr(value)
                )
    assert (tmp_path / "csv" / "summary.csv").read_bytes() == (
        tmp_path / "parquet" / "summary.csv"
    ).read_bytes()


def test_shock_is_the_same_at_every_speed(capfd, stick, tmp_path):
    """It is relative to the strike; the summary says so, and names the quantities that are not."""
    words = (
        "--contact",
        "foot",
        "--vary",
        "speed=1:3:2",
        "--at",
        "body",
        "--quantity",
        "delta_v@body",
        "--out",
        tmp_path / "out",
    )
    text = good(capfd, "sweep", stick, *words)
    rows = pyarrow.dataset.dataset(tmp_path / "out" / "rows").to_table().to_pydict()
    assert rows["shock@body"][1] == pytest.approx(rows["shock@body"][0], rel=1e-14)
    assert rows["delta_v@body"][1] == pytest.approx(3.0 * rows["delta_v@body"][0], rel=1e-14)
    assert "--quantity delta_v@body" in text


def test_springs_that_count_nowhere_are_said(capfd, stick, tmp_path):
    """An impulse does not depend on them; on contacts of finite stiffness the row is that of
    `--joint-stiffness`.
    """
    words = ("--contact", "foot", "--vary", "joint-stiffness:knee=10,20", "--out")
    none = "warning: nothing computed here depends on joint-stiffness:knee"
    assert none in good(capfd, "sweep", stick, *words, tmp_path / "one")
    text = good(
        capfd,
        "sweep",
        stick,
        *words,
        tmp_path / "two",
        "--contact-stiffness",
        1e5,
        "--quantity",
        "peak_torque@knee",
    )
    assert none not in text
    assert re.search(
        r"most severe for peak_torque@knee: --joint-stiffness knee=[12]0\.0$", text, re.MULTILINE
    )


@pytest.mark.parametrize("given", [("--friction", 0.1), ("--vary", "friction=0:0.5:3")])
def test_a_friction_on_which_no_column_depends_is_said(capfd, stick, given):
    words = ("--contact", "foot", "--vary", "strike-angle=0:40:2", *given)
    said = (
        "warning: these numbers are for contacts that stick, and the friction only decides "
        "whether flat ground allows"
    )
    assert said in good(capfd, "sweep", stick, *words)
    assert said not in good(
        capfd, "sweep", stick, *words, "--at", "body", "--quantity", "shock_friction@body"
    )
    assert said not in good(capfd, "sweep", stick, *words[:4])


def test_most_severe_row_is_pasted_into_analyze(capfd, stick, tmp_path):
    """The options in the summary reproduce the largest shock in the table."""
    text = good(capfd, "sweep", stick, *SMALL, "--out", tmp_path / "out")
    line = next(
        line for line in text.splitlines() if line.startswith("most severe for shock@body: ")
    )
    words = line.partition(": ")[2].replace("'", "").split()
    document = json.loads(
        good(
            capfd, "analyze", stick, "--contact", "foot", "--at", "body", *words, "--format", "json"
        )
    )
    found = next(
        point["shock"] for point in document["tables"]["points"] if point["point"] == "body"
    )
    greatest = max(pyarrow.parquet.read_table(tmp_path / "out" / "rows")["shock@body"].to_pylist())
    assert found == pytest.approx(greatest, rel=1e-12)


def test_rows_that_cannot_be_computed_have_a_message_and_their_number_is_said(
    capfd, stick, tmp_path
):
    """The exit code is 3 if none could be computed, or with --strict if one could not."""
    words = ("sweep", stick, "--contact", "foot", "--vary")
    outcome = run(capfd, *words, "strike-angle=0,120", "--out", tmp_path / "out")
    assert (outcome.code, outcome.err.count("\n"), says(outcome.err, "1 of 2 landings")) == (
        0,
        1,
        True,
    )
    assert (
        run(capfd, *words, "strike-angle=0,120", "--out", tmp_path / "strict", "--strict").code == 3
    )
    assert run(capfd, *words, "strike-angle=120", "--out", tmp_path / "none").code == 3
    assert "not computed: 1 of 2 landings\n  row 1: " in outcome.out
    table = pyarrow.parquet.read_table(tmp_path / "out" / "rows").to_pydict()
    assert table["message"][0] is None
    assert says(table["message"][1], '"foot"', "not approach")
    assert table["shock_com@body"][1] is None


@pytest.mark.parametrize("format_", ["csv", "parquet"])
def test_a_defect_is_exit_code_70_after_the_other_rows_are_written(
    capfd, monkeypatch, stick, tmp_path, format_
):
    """The message of its row names it, and the traceback is on standard error."""
    resolved = row_scenes.resolve

    def fail_once(scene, robot):
        if scene.friction == 0.5:
            raise ZeroDivisionError("odd")
        return resolved(scene, robot)

    monkeypatch.setattr(row_scenes, "resolve", fail_once)
    words = (
        "sweep",
        stick,
        "--contact",
        "foot",
        "--vary",
        "friction=0.4,0.5,0.6",
        "--rows",
        format_,
    )
    outcome = run(capfd, *words, "--out", tmp_path / "out")
    assert outcome.code == 70
    assert 'raise ZeroDivisionError("odd")' in outcome.err
    assert "error in shockpc itself" in outcome.err
    path = tmp_path / "out" / ("rows" if format_ == "parquet" else "rows.csv")
    rows = pyarrow.dataset.dataset(path, format=format_).to_table().to_pydict()
    assert list(map(bool, rows["message"])) == [False, True, False]
    assert [value is None for value in rows["shock_com@body"]] == [False, True, False]


def test_without_pyarrow_the_option_that_is_named_writes_the_rows(
    capfd, monkeypatch, stick, tmp_path
):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    words = (
        "sweep",
        stick,
        "--contact",
        "foot",
        "--vary",
        "knee=-40:-20:3",
        "--out",
        tmp_path / "out",
    )
    refused = run(capfd, *words)
    assert refused.code == 2
    assert "pip install pyarrow" in refused.err
    option = re.search("--[a-z]+ csv", refused.err)
    assert run(capfd, *words, *option[0].split()).code == 0
    assert (tmp_path / "out" / "rows.csv").is_file()


@pytest.mark.parametrize("limit", [None, 0])
def test_a_csv_file_is_parsed_once_for_as_many_columns_as_memory_allows(
    monkeypatch, stick, tmp_path, limit
):
    """Files hold the shortest texts that are read as the same numbers, so that all columns are
    equal to those in memory.
    """
    made = sweep(
        Scene(robot=str(stick), contact="foot"),
        {"knee": "-40:-20:3", "contact": "foot"},
        quantities=["ropc@body"],
    )
    files, expected, parsed = RowFiles(made, tmp_path / "out", "csv"), made.table, []
    files.prepare(resume=False)
    assert list(files.write(None)) == [0, 3]
    if limit is not None:
        monkeypatch.setattr(row_files, "BYTES_READ_TOGETHER", limit)
    reader = csv.reader
    monkeypatch.setattr(csv, "reader", lambda file: parsed.append(file) or reader(file))
    read = files.table()
    for name, values in expected.columns.items():
        np.testing.assert_array_equal(read.columns[name], values)
    assert len(parsed) == (1 if limit is None else len(expected.columns) + 1)
    assert read.messages == expected.messages


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A robot, and the folder of an uninterrupted sweep in one process."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "stick.urdf").write_text(STICK)
    assert done(command(folder / "stick.urdf", *MANY, "--out", folder / "out"))[0] == 0
    return folder / "stick.urdf", folder / "out"


@pytest.mark.slow
def test_killed_run_is_resumed_to_the_same_bytes(whole, tmp_path):
    """Kill -9 in mid-run with two processes, then --resume with one: the files of an uninterrupted
    run, and no part twice.
    """
    (stick, whole), killed = whole, tmp_path / "killed"
    process = command(stick, *MANY, "--out", killed, "--jobs", 2)
    wait_for_parts(killed, 2, process)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    (killed / "rows" / ".part-00003.abc.parquet").write_bytes(b"half a part")
    finished = {path: path.stat().st_mtime_ns for path in (killed / "rows").glob("part-*")}
    assert 2 <= len(finished) < len(list((whole / "rows").iterdir()))
    assert done(command(stick, *MANY, "--out", killed, "--resume"))[0] == 0
    assert files(killed) == files(whole)
    assert {path: path.stat().st_mtime_ns for path in finished} == finished


def test_a_part_that_was_cut_off_is_one_message(capfd, stick, tmp_path):
    """A part has its name when it is complete; without it, --resume gives the same bytes."""
    words = ("sweep", stick, *SMALL, "--out", tmp_path / "out")
    good(capfd, *words)
    part, before = tmp_path / "out" / "rows" / "part-00000.parquet", files(tmp_path / "out")
    for content in (part.read_bytes()[:-100], b"", b"PAR1"):
        part.write_bytes(content)
        outcome = run(capfd, *words, "--resume")
        assert (outcome.code, says(outcome.err, f'"{part}" is damaged; delete it')) == (2, True)
    part.unlink()
    good(capfd, *words, "--resume")
    assert files(tmp_path / "out") == before


@pytest.mark.parametrize("name", ["sweep.json", "rows/part-00000.parquet"])
def test_pipes_in_a_folder_are_refused(capfd, stick, tmp_path, name):
    """They would be waited for."""
    words, path = ("sweep", stick, *SMALL, "--out", tmp_path / "out"), tmp_path / "out" / name
    good(capfd, *words)
    path.unlink()
    os.mkfifo(path)
    outcome = run(capfd, *words, "--resume")
    assert (outcome.code, says(outcome.err, f'"{tmp_path / "out"}')) == (2, True)


def test_an_interrupted_csv_file_leaves_nothing_and_is_not_continued(
    capfd, monkeypatch, stick, tmp_path
):
    """It has its name when it is complete, so the same command computes it."""
    words, compute = (
        ("sweep", stick, *SMALL, "--rows", "csv", "--out", tmp_path / "out"),
        Evaluation.compute,
    )

    def interrupt(evaluation, k, data):
        raise KeyboardInterrupt

    resumed = run(capfd, *words, "--resume")
    assert (resumed.code, says(resumed.err, "--resume continues the parts of a Parquet table")) == (
        2,
        True,
    )
    monkeypatch.setattr(Evaluation, "compute", interrupt)
    interrupted = run(capfd, *words)
    assert (interrupted.code, "--resume" in interrupted.err) == (130, False)
    assert list((tmp_path / "out").iterdir()) == []
    monkeypatch.setattr(Evaluation, "compute", compute)
    good(capfd, *words)
    before = files(tmp_path / "out")
    again = run(capfd, *words)
    assert (again.code, says(again.err, "holds a sweep already; name another folder")) == (2, True)
    assert files(tmp_path / "out") == before


@pytest.mark.slow
@pytest.mark.parametrize("format_", ["csv", "parquet"])
def test_landings_that_the_ground_does_not_allow_are_left_out(capfd, stick, tmp_path, format_):
    """The other rows are those of the whole table; the summary counts what is left out, and
    --resume of Parquet keeps the count.
    """
    words = (
        "sweep",
        stick,
        "--contact",
        "foot",
        "--vary",
        "knee=-60:60:40",
        "--vary",
        "strike-angle=0:80:50",
        "--rows",
        format_,
    )
    good(capfd, *words, "--out", tmp_path / "all", "--prove", 0)
    out, rows = tmp_path / "out", "rows" if format_ == "parquet" else "rows.csv"

    def read(folder):
        return pyarrow.dataset.dataset(folder / rows, format=format_).to_table()

    text = good(capfd, *words, "--out", out, "--feasible", "--prove", 0)
    every = read(tmp_path / "all")
    allowed = [k for k, value in enumerate(every["feasible@stick"].to_pylist()) if value == 1.0]
    assert read(out).drop_columns("row") == every.take(allowed)
    assert read(out)["row"].to_pylist() == allowed
    assert 0 < len(allowed) < 2000
    left = 2000 - len(allowed)
    assert says(text, f"not allow {left} of 2000 landings: {left} because", "pulled")
    if format_ == "parquet":
        before = files(out)
        assert good(capfd, *words, "--out", out, "--feasible", "--prove", 0, "--resume") == text
        assert files(out) == before


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_interrupt_keeps_finished_parts(stick, tmp_path, jobs):
    """Ctrl-C ends with code 130 and one message; what was finished remains, and nothing half
    written does.
    """
    process = command(stick, *MANY, "--out", tmp_path / "out", "--jobs", jobs)
    wait_for_parts(tmp_path / "out", 2, process)
    os.killpg(process.pid, signal.SIGINT)
    code, out, err = done(process)
    assert (code, out) == (130, "")
    assert "Traceback" not in err
    assert err.splitlines()[-1] == "shockpc: interrupted; no incomplete file was left"
    assert all(path.name.startswith("part-") for path in (tmp_path / "out" / "rows").iterdir())


@pytest.mark.slow
def test_progress_is_shown_on_a_terminal(stick, tmp_path):
    terminal, end = os.openpty()
    assert (
        done(
            command(
                stick,
                "--contact",
                "foot",
                "--vary",
                "knee=-60:60:20000",
                "--out",
                tmp_path / "out",
                stderr=end,
            )
        )[0]
        == 0
    )
    os.close(end)
    shown = os.read(terminal, 10_000).decode()
    os.close(terminal)
    assert "rows computed: 10000 of 20000" in shown
    assert shown.endswith("\r\x1b[K")


def test_dead_worker_process_is_reported(stick, tmp_path):
    process = command(stick, *MANY, "--out", tmp_path / "out", "--jobs", 2)
    wait_for_parts(tmp_path / "out", 1, process)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    if not children.exists():
        pytest.fail("the system does not list the children of a process")
    workers = [
        pid
        for pid in map(int, children.read_text().split())
        if b"tracker" not in Path(f"/proc/{pid}/cmdline").read_bytes()
    ]
    os.kill(workers[-1], signal.SIGKILL)
    code, _, err = done(process)
    assert code == 2
    assert err.splitlines()[-1].startswith("shockpc: a worker process died")


def test_full_disk_is_one_message(stick, tmp_path):
    """A limit on the size of files stands for it."""
    process = command(
        stick,
        *MANY,
        "--out",
        tmp_path / "out",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)),
    )
    code, _, err = done(process)
    assert code == 2
    assert err.endswith('part-00000.parquet" cannot be written: File too large\n')
    assert list((tmp_path / "out" / "rows").iterdir()) == []


def test_folder_of_another_sweep_is_refused(capfd, stick, tmp_path):
    out = tmp_path / "out"
    good(capfd, "sweep", stick, *SMALL, "--out", out)
    before = files(out)
    again = run(capfd, "sweep", stick, *SMALL, "--out", out)
    assert (again.code, says(again.err, f'"{out}"', "--resume", "--out")) == (2, True)
    other = run(
        capfd,
        "sweep",
        stick,
        *SMALL,
        "--restitution",
        "0.5",
        "--seed",
        "1",
        "--feasible",
        "--prove",
        "2",
        "--out",
        out,
        "--resume",
    )
    assert other.code == 2
    # What differs has the names of options, with which it is mended.
    assert "which differs in scene, seed, feasible, prove," in other.err
    assert files(out) == before
    assert good(capfd, "sweep", stick, *SMALL, "--out", out, "--resume")
    assert files(out) == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--jobs", "0"), "must be ≥ 1 and ≤ 512, got 0"),
        (("--vary", "knee"), "a range is drawn from by --sample N"),
        (("--vary", "=3"), "is not NAME=VALUE"),
        (
            ("--velocity", "0.3,0,-1", "--vary", "speed=1,2"),
            "speed is varied, but the velocity is given",
        ),
        (
            ("--cluster", "tcp://127.0.0.1:9", "--vary", "knee=0:1:2"),
            "no Dask scheduler answers at",
        ),
    ],
)
def test_bad_options_are_one_message_and_leave_nothing(
    capfd, stick, tmp_path, monkeypatch, words, message
):
    monkeypatch.setattr("shockpc.evaluation.executor.PATIENCE", 0.1)
    outcome = run(capfd, "sweep", stick, "--contact", "foot", *words, "--out", tmp_path / "out")
    assert (outcome.code, outcome.out) == (2, "")
    assert message in outcome.err
    assert not (tmp_path / "out").exists()


@contextlib.contextmanager
def dask(*words: object, folder: Path):
    """A process of a Dask cluster."""
    with (folder / f"{words[0]}.log").open("a") as log:
        process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "dask",
                *map(str, words),
                "--no-dashboard",
                "--scheduler-file",
                folder / "scheduler.json",
            ],
            stdout=log,
            stderr=log,
            cwd=folder,
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def scheduler_address(folder: Path):
    """The address of the scheduler of a folder, once it has started."""
    info = folder / "scheduler.json"
    wait_until(lambda: info.exists() and info.read_text().rstrip().endswith("}"))
    return json.loads(info.read_text())["address"]


IMPATIENT = """
import sys
from shockpc.evaluation import executor
from shockpc.cli.entry import entry
executor.ABSENT = 1
entry()
"""
"""Code of a command that waits for half a second until it says that a cluster has no worker."""


@pytest.mark.slow
def test_a_cluster(whole, tmp_path):
    """A scheduler alone, with a worker, with two of which one is killed in mid-run, and with one
    that is killed in mid-run.

    Without workers there is a message, and with --wait the rows once there is one. With the workers
    that are left the files are those of one local process; when the last one is lost there is a
    message.
    """
    (stick, local), one = whole, ("worker", "--nthreads", 1, "--no-nanny", "--host", "127.0.0.1")
    few = (
        "--contact",
        "foot",
        "--vary",
        "knee=-60:60:3",
        "--prove",
        "0",
        "--out",
        tmp_path / "few",
    )

    def clustered(*words: object) -> subprocess.Popen[str]:
        return command(stick, *words, "--cluster", address, code=IMPATIENT)

    with dask("scheduler", "--host", "127.0.0.1", "--port", 0, folder=tmp_path):
        address = scheduler_address(tmp_path)
        code, text, err = done(clustered(*few))
        assert (code, text, err.count("\n")) == (2, "", 1)
        assert "has no worker; start some with: dask worker" in err
        assert not (tmp_path / "few" / "rows").exists()
        waiting = clustered(*few, "--wait")
        assert "has no worker" in waiting.stderr.readline()
        with dask(*one, folder=tmp_path) as last:
            assert done(waiting)[0] == 0
            with dask(*one, folder=tmp_path) as first:
                wait_until(
                    lambda: (tmp_path / "worker.log").read_text().count("Registered to") == 2
                )
                process = clustered(*MANY, "--out", tmp_path / "out")
                wait_for_parts(tmp_path / "out", 1, process)
                first.kill()
                code, _, err = done(process)
            assert (code, err) == (0, "")
            assert files(tmp_path / "out") == files(local)
            process = clustered(*MANY, "--out", tmp_path / "lost")
            wait_for_parts(tmp_path / "lost", 1, process)
            last.kill()
            code, text, err = done(process)
    assert (code, text) == (2, "")
    assert "lost all its workers; start some with: dask worker" in err


def test_numbers_in_double_precision_are_said_to_be_unproven(capfd, tmp_path):
    """And where nothing that is varied has an option of `analyze`, what is varied stands alone."""
    varied = (
        "--vary",
        "mass:base=5:10:2",
        "--friction",
        "0.2",
        "--quantity",
        "slip",
        "--out",
        tmp_path / "out",
    )
    text = good(capfd, "sweep", "go2", "--contact", "FL_foot", *varied)
    assert re.search(r"most severe for slip@FL_foot: mass:base = \d+ kg$", text, re.MULTILINE)
    assert "2 landings\nin double precision: slip@FL_foot" in text
