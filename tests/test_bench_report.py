"""The bench as a whole: a small plan from clock to report, broken off and taken up again, and its command line."""

import csv
import itertools
import json
import math

import pytest
from commands import STICK, run

from shockpc.bench.cases import family
from shockpc.bench.compliant import compliant
from shockpc.bench.measure import CaseResult, measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.run import Plan, plan_of, run_bench
from shockpc.bench.saving import measure_saving
from shockpc.bench.store import Store, fingerprint
from shockpc.bench.throughput import WORK
from shockpc.bench.timing import timed
from shockpc.errors import SceneError, SolveError
from shockpc.model.contact import Contact
from shockpc.model.robot import load_robot
from shockpc.scene import Scene, Strike

SMALL = Plan(
    "small",
    (*family("corners").cases(quick=True), *family("knee").cases(quick=True)),
    (family("corners").case("sticking", 4),),
    (),
    ((WORK[0], 4),),
    0.0,
)


def test_the_clock_counts_what_it_runs():
    """One run without a budget; with one, at least three besides the first."""
    count = itertools.count()
    result, timing = timed(lambda: next(count), budget=0.0)
    assert (result, timing.runs) == (0, 1)
    result, timing = timed(lambda: next(count), budget=1e-9)
    assert (result, timing.runs) == (4, 3)
    assert timing.low <= timing.median <= timing.high
    assert timed(lambda: next(count), budget=60.0, most=5)[1].runs == 5


def test_a_store_gives_back_what_it_kept_and_nothing_stale(tmp_path):
    """Parts of another version, of other settings, or half written, are done again."""
    store = Store(tmp_path / "parts", fingerprint("a"))
    assert store.get("one / two") is None
    store.put("one / two", {"x": [1, None, math.inf]})
    assert store.get("one / two") == {"x": [1, None, math.inf]}
    assert Store(tmp_path / "parts", fingerprint("b")).get("one / two") is None
    next((tmp_path / "parts").glob("one*")).write_text('{"mark": "')
    assert store.get("one / two") is None


def test_a_result_survives_its_file():
    result = measure(family("corners").case("sticking", 4), DIRECT, budget=0.0)
    again = CaseResult.from_table(json.loads(json.dumps(result.table())))
    assert again == result


def test_a_small_bench_from_clock_to_report(tmp_path, monkeypatch):
    """Every file is there, says the same, and a second run measures nothing again."""
    bench = run_bench(SMALL, tmp_path, "shockpc bench")
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "parts", "report.md", "summary.md", "bench.json", "cases.csv", "work.csv", "throughput.csv", "saving.csv",
        "error-against-run-time.svg", "corners.svg", "knee.svg",
    }  # fmt: skip
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    for heading in (
        "## Limits of the method",
        "## 1. Error",
        "## 2. Stiff",
        "## 3. What leaving",
        "## 4. Speed",
        "| command | shockpc bench |",
    ):
        assert heading in report
    rows = list(csv.DictReader((tmp_path / "cases.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == sum(len(case.results) for case in bench.cases)
    document = json.loads((tmp_path / "bench.json").read_text(encoding="utf-8"))
    assert document["schema"] == "shockpc.bench/1"
    assert [case["name"] for case in document["cases"]] == [case.name for case in bench.cases]

    def never(*_):
        raise AssertionError("a finished part was measured again")

    monkeypatch.setattr("shockpc.bench.run.measure", never)
    monkeypatch.setattr("shockpc.bench.run.compete", never)
    again = run_bench(SMALL, tmp_path, "shockpc bench")
    assert (again.cases, again.work, again.peers) == (bench.cases, bench.work, bench.peers)


def test_a_bench_that_was_broken_off_goes_on(tmp_path, monkeypatch):
    """What was finished before an interrupt is kept."""
    done = []

    def until(case, methods, budget):
        if len(done) == 3:
            raise KeyboardInterrupt
        done.append(case.name)
        return measure(case, methods[:1], budget)

    monkeypatch.setattr("shockpc.bench.run.measure", until)
    with pytest.raises(KeyboardInterrupt):
        run_bench(SMALL, tmp_path, "shockpc bench")
    assert len(list((tmp_path / "parts").iterdir())) == 3
    assert not (tmp_path / "report.md").exists()
    monkeypatch.setattr("shockpc.bench.run.measure", lambda case, methods, budget: measure(case, methods[:1], budget))
    bench = run_bench(SMALL._replace(peers=()), tmp_path, "shockpc bench")
    assert [case.name for case in bench.cases][:3] == done


def test_the_suites_are_plans():
    quick, full = plan_of("quick"), plan_of("full")
    assert {case.name for case in quick.cases} < {case.name for case in full.cases}
    assert quick.budget < full.budget
    assert {case.name for case in quick.work} <= {case.name for case in full.cases}


def test_leaving_out_saves():
    """With everything forced on a process takes more memory, for the same answer."""
    needed, everything = measure_saving("anymal_b")
    assert (needed.parts, everything.parts) == ("needed", "everything")
    assert everything.memory > needed.memory


def test_a_part_that_fails_says_why():
    with pytest.raises(SolveError, match=r"^the bench's own process failed \(.*needed nothing\): KeyError"):
        measure_saving("nothing")


def test_the_rigid_answer_holds_from_some_stiffness_on():
    """The error falls with the pulse's length; a tenth is reached before a hundredth."""
    robot = load_robot("anymal_b")
    found = compliant(Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),), strike=Strike(speed=1.0)), robot)
    errors = [ground.error for ground in found.grounds]
    assert errors[-1] < 1e-3 < errors[-2]
    hard = [ground for ground in found.grounds if ground.error < 0.3]
    for softer, harder in itertools.pairwise(hard):
        assert harder.error / softer.error == pytest.approx(harder.pulse / softer.pulse, rel=0.2)
    assert hard[0].stiffness * 0.01 < found.tenth < found.hundredth < hard[-1].stiffness


def test_a_bounce_is_one_factor():
    """With one restitution everywhere the same grounds are as good; with several there is no telling."""
    robot = load_robot("anymal_b")
    feet = [Contact(frame=foot, restitution=e) for foot, e in (("LF_FOOT", 0.5), ("RH_FOOT", 0.5))]
    found = compliant(Scene(robot="anymal_b", contact=tuple(feet)), robot)
    assert found.grounds[-1].error < 1e-3
    with pytest.raises(SceneError, match=r"^contacts that bounce differently"):
        compliant(Scene(robot="anymal_b", contact=(feet[0], Contact(frame="RH_FOOT"))), robot)


def test_compliant_on_the_command_line(capfd, tmp_path):
    (tmp_path / "stick.urdf").write_text(STICK)
    (tmp_path / "landing.toml").write_text('robot = "stick.urdf"\n\n[[contact]]\nframe = "foot"\n')
    done = run(capfd, "bench", str(tmp_path / "landing.toml"), "--compliant", "--out", str(tmp_path / "out"))
    assert done.code == 0, done.err
    assert "the rigid answer is right to 10 % from" in done.out
    assert "the rigid answer is right to 1 % from" in done.out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["compliant.csv", "compliant.md"]


def test_soak_on_the_command_line(capfd):
    """It counts, ends with 0 if no promise is broken, and names the trees if one is."""
    done = run(capfd, "bench", "--soak", "3", "--workers", "1", "--seed", "1")
    assert done.code == 0, done.err
    assert done.out.splitlines()[0].split() == ["random", "trees", "3"]
    assert "violations                                       0" in done.out


@pytest.mark.parametrize("words", [("--compliant",), ("landing.toml",)])
def test_a_scene_and_compliant_go_together(capfd, words):
    done = run(capfd, "bench", *words)
    assert done.code == 2
    assert done.err == (
        "shockpc: --compliant needs a scene file, and a scene file needs --compliant: shockpc bench landing.toml --compliant\n"
    )
