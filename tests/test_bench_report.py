"""The bench as a whole: a small plan from clock to report, broken off and taken up again, and its command line."""

import csv
import itertools
import json
import math

import numpy as np
import pytest
from commands import run

from shockpc.bench.build import Link, box, robot_of
from shockpc.bench.cases import family
from shockpc.bench.cases.robots import FOOTED
from shockpc.bench.compliant import compliant, compliant_sheet
from shockpc.bench.measure import CaseResult, measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.percussion import radii
from shockpc.bench.run import Plan, plan_of, run_bench
from shockpc.bench.saving import measure_saving
from shockpc.bench.store import Store, fingerprint
from shockpc.bench.throughput import WORK
from shockpc.bench.timing import timed
from shockpc.errors import SceneError, SolveError
from shockpc.model.contact import Contact
from shockpc.robot.robot import load_robot
from shockpc.scene import Scene, Strike
from shockpc.show.tables.text import as_text

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
        "parts", "report.md", "summary.md", "bench.json", "cases.csv", "work.csv", "throughput.csv", "saving.csv", "percussion.csv",
        "error-against-run-time.svg",
    }  # fmt: skip
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    work = (tmp_path / "error-against-run-time.svg").read_text(encoding="utf-8")
    for word in ("sticking: 4", "failed", "unsuited", "simulated on ABA, 10 steps in the shortest τ"):
        assert word in work
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


def test_rank_and_rows_count_the_same():
    """Followers are tied by rows in the reference: they count in the rank, and so among the rows; without an answer none do."""
    found = measure(family("robots").case("one foot", FOOTED.index("talos_full")), DIRECT[:1], budget=0.0)
    assert found.rank == found.rows == 3 + len(load_robot("talos_full").mimics)
    nothing_resists = measure(family("robots").case("one foot", FOOTED.index("romeo")), DIRECT[:1], budget=0.0)
    assert (nothing_resists.answer, nothing_resists.rank, nothing_resists.rows) == (False, 0, 0)


@pytest.mark.parametrize("variant", family("through the centre").variants)
def test_radii_of_percussion_lose_digits_as_they_grow(variant):
    """RoPc and CoPc are quotients by a rotation as small as the distance, which is known to a few roundings of the whole motion."""
    for value in family("through the centre").values:
        for found in radii(family("through the centre").case(variant, value)):
            assert (found.ropc is None) == (found.copc is None)
            if value >= 1e-6:
                assert found.ropc is not None
            if found.ropc is not None:
                assert max(found.ropc, found.copc) < 10.0 * 2.0**-53 * (1.0 + 1.0 / value)
            assert found.exact * value > 0.1 if value else found.exact == math.inf


def test_leaving_out_saves():
    """With everything forced on a process takes more memory, for the same answer."""
    needed, everything = measure_saving("anymal_b")
    assert (needed.parts, everything.parts) == ("needed", "everything")
    assert everything.memory > needed.memory


def test_a_part_that_fails_says_why():
    with pytest.raises(SolveError, match=r"^the bench's own process failed \(.*needed nothing\): KeyError"):
        measure_saving("nothing")


def landing(speed=1.0, restitution=0.0, feet=("LF_FOOT",)):
    contacts = tuple(Contact(frame=foot, restitution=restitution) for foot in feet)
    return compliant(Scene(robot="anymal_b", contact=contacts, strike=Strike(speed=speed)), load_robot("anymal_b"))


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_the_rigid_answer_holds_from_some_stiffness_on(restitution):
    """The error falls with the pulse's length, bounce or not; a tenth is reached before a hundredth."""
    found = landing(restitution=restitution, feet=("LF_FOOT", "RH_FOOT"))
    errors = [ground.error for ground in found.grounds]
    assert errors[-1] < 1e-3 < errors[-2]
    hard = [ground for ground in found.grounds if ground.error < 0.1]
    for softer, harder in itertools.pairwise(hard):
        assert harder.error / softer.error == pytest.approx(harder.pulse / softer.pulse, rel=0.1)
    assert found.grounds[0].stiffness <= found.tenth < found.hundredth < hard[-1].stiffness


def test_thresholds_are_the_ground_s_and_not_the_simulation_s(monkeypatch):
    """Half as long steps change them little; a slower landing, whose limbs turn less meanwhile, is no worse."""
    found, slow = landing(), landing(speed=0.01)
    for one, other in zip(found.grounds, slow.grounds, strict=False):
        assert other.error <= one.error
    assert slow.grounds[0].gravity == pytest.approx(100.0 * found.grounds[0].gravity)
    monkeypatch.setattr("shockpc.bench.compliant.STEPS", 400)
    finer = landing()
    assert (finer.tenth, finer.hundredth) == pytest.approx((found.tenth, found.hundredth), rel=0.01)


@pytest.mark.parametrize("e", [0.0, 0.01, 0.3, 1.0])
def test_the_ground_gives_back_what_the_restitution_says(e):
    """A box struck through its centre does not turn, so that the softest ground is right already, and the pulse is half a swing."""
    box_on_edge = robot_of([Link(-1, "", np.zeros(3), np.eye(3)[1], 3.0, np.zeros(3), box(3.0, (0.4, 0.2, 0.1)))])
    found = compliant(Scene(robot="box", contact=(Contact(frame="link0", restitution=e),), strike=Strike(speed=2.0)), box_on_edge)
    (ground,) = found.grounds
    assert ground.error < 1e-3
    swing = math.sqrt(found.mass / ground.stiffness)
    assert found.mass == pytest.approx(3.0)
    assert ground.pulse == pytest.approx(0.5 * math.pi * (1.0 + e) * swing)
    assert ground.travel == pytest.approx(2.0 * swing, rel=0.01)
    assert found.tenth == found.hundredth == ground.stiffness
    assert "right to 10 % on the softest ground that was tried already" in as_text(compliant_sheet(found))


def test_one_ground_bounces_in_one_way():
    robot = load_robot("anymal_b")
    contacts = (Contact(frame="LF_FOOT", restitution=0.5), Contact(frame="RH_FOOT"))
    with pytest.raises(SceneError, match=r"^contacts that bounce differently"):
        compliant(Scene(robot="anymal_b", contact=contacts), robot)


def test_compliant_on_the_command_line(capfd, tmp_path):
    (tmp_path / "landing.toml").write_text('robot = "anymal_b"\n\n[[contact]]\nframe = "LF_FOOT"\n')
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
