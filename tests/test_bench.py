"""The benchmark: methods agree where they should, failures are named, and the report says what was
measured.
"""

import csv
import functools
import itertools
import shutil

import numpy as np
import pytest
from commands import good, run

from shockpc.bench.cases import FAMILIES, chain, known_robot, landing
from shockpc.bench.costs import COSTS
from shockpc.bench.many_postures import PEERS, WAYS, in_symbols, many_system, random_postures
from shockpc.bench.measure import OUTCOMES, measure, timed
from shockpc.bench.methods import DIRECT, PROVEN, UnsuitedError, system_of
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.bench.report import suite_report
from shockpc.bench.soft_and_stiff import STIFFNESSES, stiff_contacts
from shockpc.judgement.accuracy import double_error
from shockpc.landing.scenes.scene import Closure, Contact, LoopEnd, Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.profile import shock_profile
from shockpc.show.folder import write_report_folder
from shockpc.show.report import Report
from shockpc.show.tables import Sheet
from shockpc.text.errors import SolveError


def case_of(name, variant, value):
    return FAMILIES[name].build(FAMILIES[name].variants[variant], value)


def on_anymal(*contacts, **parts):
    return landing(known_robot("anymal_b"), *contacts, **parts)


def profile_of(name, variant, value):
    robot, scene = case_of(name, variant, value)
    return shock_profile(scene, robot)


@functools.cache
def proven(where):
    """A regular case, and its proof."""
    system = system_of(*REGULAR[where]())
    return system, shock_profile(system.landing.scene, system.landing.robot).proof


LOOP = Closure(
    a=LoopEnd(frame="LF_FOOT"), b=LoopEnd(frame="RF_FOOT"), directions=("x", (0.0, 1.0, 1.0))
)
REGULAR = {
    "one foot": lambda: case_of("robots", "one foot", "anymal_b"),
    "two feet": lambda: on_anymal("LF_FOOT", "RF_FOOT"),
    "two feet with restitution": lambda: on_anymal(
        *(
            Contact(frame=foot, restitution=0.5, restitution_along="directions")
            for foot in ("LF_FOOT", "RF_FOOT")
        )
    ),
    "one foot with restitution": lambda: on_anymal(
        Contact(frame="LF_FOOT", restitution=0.5, restitution_along="directions"), "RH_FOOT"
    ),
    "drives": lambda: case_of("armature", "one foot", 1e-3),
    "loop": lambda: case_of("flat four bar", "closed in the plane", 1.0),
    "locked joints": lambda: case_of("locked feet", "hips free", 1),
    "fixed base": lambda: case_of("knee", "fixed base, foot slides", 1.0),
    "flat foot and stance": lambda: landing(
        known_robot("talos"),
        Contact(frame="left_sole_link", kind="flat"),
        stance=("right_sole_link",),
    ),
    "closed feet": lambda: on_anymal("LH_FOOT", closure=(LOOP,)),
    "moving joints": lambda: on_anymal(
        "LF_FOOT",
        strike=Strike(
            velocity=(0.1, 0.2, -1.0),
            angular_velocity=(0.1, 0.2, 0.3),
            joint_velocities={"LF_KFE": 0.5},
        ),
    ),
}
SOLVABLE = {
    "partition (Eq. 6)": {"one foot", "drives", "locked joints", "moving joints"},
    "Pinocchio, Jacobian": set(REGULAR)
    - {"one foot with restitution", "locked joints", "fixed base", "flat foot and stance"},
    "Pinocchio, constraints": {
        "one foot",
        "two feet",
        "two feet with restitution",
        "drives",
        "moving joints",
    },
    "Pinocchio, constraints, µ = 1e-6": {
        "one foot",
        "two feet",
        "two feet with restitution",
        "drives",
        "moving joints",
    },
}


def error_of(method, where):
    """The largest error of the bodies' jumps."""
    system, proof = proven(where)
    prepared = (DIRECT | MUJOCO)[method](system)
    return double_error(system.landing, proof, prepared.read(prepared.run()))


@pytest.mark.parametrize("where", REGULAR)
@pytest.mark.parametrize("method", DIRECT)
def test_every_method_agrees_on_regular_cases(method, where):
    """All methods give the same jumps, or say that they cannot take the landing."""
    if where not in SOLVABLE.get(method, REGULAR):
        with pytest.raises(UnsuitedError):
            error_of(method, where)
        return
    # Up to 44 unknowns; damping costs about 14 times its size, relative to the effective mass of a
    # foot.
    assert error_of(method, where) < (1e-4 if "µ" in method else 1e-10)


def test_the_error_of_a_simulation_is_proportional_to_its_time_constant():
    """The limit of a simulated landing on harder and harder ground is the impulsive answer."""
    errors = [error_of(method, "one foot") for method in list(MUJOCO)[1:]]
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 10.0, rtol=0.15)
    assert errors[-1] < 3e-3


def outcomes(name, variant, value):
    (case,) = (one for one in FAMILIES[name].cases() if one[1:3] == (variant, value))
    return {one.method: one.outcome for one in measure(case, DIRECT, budget=0.0)}


def test_dependent_rows_make_textbook_methods_fail():
    found = outcomes("corners", "sticking", "4")
    assert found[PROVEN] == found["null space (Eq. 7)"] == "accurate"
    assert found["Schur complement, Cholesky"] == "exception"
    assert found["partition (Eq. 6)"] == "unsuited"
    assert found["Pinocchio, Jacobian"] == "inaccurate"
    assert found["Pinocchio, constraints"] == "not finite"


def test_numbers_for_a_landing_without_a_solution_are_unfounded():
    """A straight leg on a fixed base does not yield along its axis."""
    found = outcomes("knee", "fixed base", "0")
    assert found[PROVEN] == "refused"
    assert found["null space (Eq. 7)"] == "unfounded"


@pytest.mark.parametrize("name", ["anymal_b", "talos"])
def test_all_peers_do_the_same_work(name):
    """In random postures every peer finds the jumps of the batched path, as often as it runs."""
    system = many_system(name)
    Q = random_postures(system, 5)
    prepared = {peer: prepare(system, Q) for peer, prepare in PEERS.items()}
    found = {peer: one.read(one.run()) for peer, one in prepared.items()}
    (maps,) = (one for peer, one in found.items() if peer.startswith("shockpc"))
    jump = (maps @ system.landing.before.velocity)[..., None]
    for peer, one in prepared.items():
        np.testing.assert_allclose(
            found[peer],
            maps if found[peer].shape[-1] == 3 else jump,
            atol=1e-11 * np.abs(maps).max(),
        )
        np.testing.assert_array_equal(one.read(one.run()), found[peer])


@pytest.mark.slow
def test_symbols_in_numpy_and_in_c_are_the_maps(monkeypatch):
    monkeypatch.setattr("shockpc.bench.many_postures.IN_SYMBOLS", ("anymal_b",))
    monkeypatch.setattr("shockpc.bench.many_postures.BLOCK", 200)
    rows = in_symbols(0.0).rows
    assert [row[1] for row in rows] == list(WAYS)
    assert all(row[4] < 1e-10 for row in rows if row[5] is None)
    assert [row[5] for row in rows if row[5]] == (
        [] if shutil.which("cc") else ["cc is not installed"] * 2
    )


def test_the_clock_counts_its_runs():
    """One run without a budget; with one, at least three besides the first."""
    count = itertools.count()
    for budget, runs in ((0.0, 1), (1e-9, 3), (60.0, 1000)):
        assert len(timed(lambda: next(count), budget)[1]) == runs
    assert next(count) == 1 + 4 + 1001


@pytest.mark.parametrize(("variant", "length"), [("kg", 1e3), ("g", 1.0), ("g", 1e3)])
def test_units_change_no_shock(variant, length):
    """In other units of length and mass the shock is the same everywhere, and the radii are those
    in the other unit.
    """
    one, other = profile_of("units", "kg", 1.0), profile_of("units", variant, length)
    np.testing.assert_allclose(other.shock_com, one.shock_com, rtol=1e-11)
    np.testing.assert_allclose(other.ropc, length * one.ropc, rtol=1e-11)


@pytest.mark.parametrize("rods", [1, 2])
def test_a_strike_near_the_centre_of_mass_tends_to_translation(rods):
    """Upright rods struck from below: RoPc grows as one over the distance from their axis until
    they only translate; shock is 1.
    """
    robot, found = chain(np.ones(rods), np.ones(rods)), []
    distances = [0.0, *(10.0**k for k in range(-16, -5))]
    for distance in distances:
        contact = Contact(frame="link0", offset=(distance, 0.0, 0.0))
        found.append(shock_profile(Scene(robot="chain", contact=(contact,)), robot))
    assert [profile.shock_com[0] for profile in found] == pytest.approx(
        [1.0] * len(found), abs=1e-10
    )
    translating = [bool(profile.translates[0]) for profile in found]
    assert translating[0]
    assert translating == sorted(translating, reverse=True)
    products = [
        p.ropc[0] * distance
        for p, distance in zip(found, distances, strict=True)
        if not p.translates[0]
    ]
    assert products == pytest.approx([products[-1]] * len(products), rel=1e-6)


@pytest.mark.slow
def test_a_small_suite_from_clock_to_report(tmp_path, monkeypatch):
    monkeypatch.setitem(COSTS, "costs", lambda budget: Sheet("costs", ("what",), [("a command",)]))
    for measured in (
        "symbols",
        "measured landings",
        "measured tosses",
        "measured steps",
        "touchdowns in logs",
    ):
        monkeypatch.setitem(
            COSTS, measured, lambda budget, title=measured: Sheet(title, ("what",), [])
        )
    monkeypatch.setattr("shockpc.bench.costs.ROWS", 32)
    monkeypatch.setattr("shockpc.bench.many_postures.MANY_POSTURES", 16)
    write_report_folder(tmp_path, suite_report(("corners", "knee"), budget=0.0))
    files = {
        "report.md",
        "report.html",
        *(f"{name}.csv" for name in ("cases", "methods", "corners", "knee")),
        *(f"{name.replace(' ', '_')}.csv" for name in COSTS),
        "bench.json",
        ".bench.sha256",
        "error-against-run-time.svg",
        "error-against-run-time.png",
    }
    assert {path.name for path in tmp_path.iterdir()} == files
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    titles = (
        "### Corners",
        "### Knee",
        "### Costs",
        "### Many postures",
        "### Sweeps",
        "### Measured landings",
        "### Limits",
    )
    for text in (*titles, "| a command |", ", pin 4.", *OUTCOMES, "| 4 | sticking | 1.11e-16 | "):
        assert text in report
    assert "| 1 | sticking | " not in report, "every method solves it"
    rows = list(csv.DictReader((tmp_path / "cases.csv").read_text(encoding="utf-8").splitlines()))
    assert len({tuple(row.values())[:4] for row in rows}) == len(rows), "names of cases are unique"
    assert [row["outcome"] for row in rows if row["method"] == PROVEN] == ["accurate"] * 7 + [
        "refused",
        "refused",
        "accurate",
    ] * 2
    chart = (tmp_path / "error-against-run-time.svg").read_text(encoding="utf-8")
    for name in (PROVEN, "null space (Eq. 7)", "run time [µs]", "simulated in MuJoCo"):
        assert name in chart


@pytest.mark.slow
def test_a_command_that_fails_is_reported(monkeypatch):
    monkeypatch.setattr(
        "shockpc.bench.costs.COMMANDS", {"failing": ("-m", "shockpc", "analyze", "nothing")}
    )
    with pytest.raises(
        SolveError, match=r"^a process of the benchmark failed .*analyze nothing.*: shockpc: "
    ):
        COSTS["costs"](0.0)


def test_bench_of_one_s_own_robot(capfd, tmp_path):
    """`shockpc bench robot --contact foot` prints a row for each method, and writes the table and
    the chart if asked to.
    """
    out = good(capfd, "bench", "solo12", "--contact", "FL_FOOT", "--out", tmp_path)
    assert {line.split("  ")[0] for line in out.splitlines()} >= {
        *DIRECT,
        *MUJOCO,
        "shockpc, all quantities",
    }
    files = {
        "landing.csv",
        "landing.md",
        "landing.json",
        ".landing.sha256",
        "report.html",
        "error-against-run-time.svg",
        "error-against-run-time.png",
    }
    assert {path.name for path in tmp_path.iterdir()} == files


def test_the_suite_needs_no_robot(capfd, tmp_path, monkeypatch):
    report = Report(
        name="bench",
        body=lambda _: [Sheet("costs", ("what",), [("a command",)])],
        sheets={},
        document=dict,
    )
    monkeypatch.setattr("shockpc.bench.report.suite_report", lambda progress: report)
    assert good(capfd, "bench", "--out", tmp_path).endswith(
        f"a command\n\nthe report: {tmp_path / 'report.md'}\n"
    )


def test_a_contact_needs_a_robot(capfd):
    done = run(capfd, "bench", "--contact", "foot")
    assert (done.code, done.out) == (2, "")
    assert (done.err.count("\n"), "shockpc bench robot.urdf --contact foot" in done.err) == (
        1,
        True,
    )


def test_soft_contacts_approach_the_impulse():
    """The error falls with 1/k: rotors behind springs move with the square of the contact's
    duration, which is as 1/√k.
    """
    sheet = stiff_contacts(0.0)
    of_contacts = [row for row in sheet.rows if str(row[0]).startswith("contact")]
    assert len(of_contacts) == len(STIFFNESSES)
    assert all(float(row[2]) == pytest.approx(-1.0, abs=0.01) for row in of_contacts[-4:])
    assert float(of_contacts[-1][1]) < 1e-8
