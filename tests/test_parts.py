"""Parts and their ratings: the damage boundary, margins of landings, torques of joints, and where
they are given.
"""

import csv
import json
import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from commands import STICK_WITH_IMU, document, good, run, says
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import BOX, COLUMN
from test_escaping import NAMES, SUFFIXES, check_text, read

from shockpc import (
    Contact,
    Joints,
    Part,
    Posture,
    Scene,
    Strike,
    compare,
    resolve,
    sensitivity,
    shock_profile,
    sweep,
)
from shockpc.core.pulse import SHAPES, Pulse, velocity_change
from shockpc.core.spectrum import amplification
from shockpc.evaluation.designs import Design
from shockpc.landing.ratings import strength
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.text.errors import SceneError, StudyError, UnknownName

K = 1e5
RATING = "half-sine 1500 g 0.5 ms"


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a box, two masses on a slide, and a body on a shin."""
    monkeypatch.chdir(tmp_path)
    for name, text in {"box": BOX, "column": COLUMN, "stick": STICK_WITH_IMU}.items():
        (tmp_path / f"{name}.urdf").write_text(text)
    return tmp_path


# The damage boundary


@pytest.mark.parametrize(
    ("g", "ms", "change"), [(10000, 0.1, 6.2), (1500, 0.5, 4.7), (50, 11, 3.4)]
)
def test_velocity_change_of_a_half_sine(g, ms, change):
    """2AT/π, and ratings as data sheets give them."""
    found = strength(Part(name="p", at="x", rating=f"half-sine {g} g {ms} ms"))
    assert found.velocity_change == pytest.approx(
        2.0 * g * GRAVITY * ms * 1e-3 / math.pi, rel=1e-15
    )
    assert round(found.velocity_change, 1) == change
    assert (found.acceleration, found.both) == (g / 2.0, True)
    assert says(found.basis, "2AT/π", "lower bound")


@pytest.mark.parametrize("x", [0.01, 0.2, 0.4, 0.8, 1.3, 7.7])
def test_response_of_one_mass(x):
    """A half-sine and a rectangle in closed form, and the velocity change alone for short pulses of
    every shape (f T → 0).
    """
    residual = abs(4.0 * x * math.cos(math.pi * x) / (1.0 - 4.0 * x * x))
    during = [
        2.0 * x / (2.0 * x - 1.0) * math.sin(2.0 * math.pi * m / (2.0 * x + 1.0))
        for m in range(1, int(x + 0.5) + 1)
    ]
    assert amplification("half-sine", x) == pytest.approx(max([residual, *during]), rel=1e-3)
    assert amplification("rectangle", x) == pytest.approx(
        2.0 * math.sin(math.pi * min(x, 0.5)), rel=1e-3
    )
    for shape, ratio in SHAPES.items():
        assert amplification(shape, 1e-3) == pytest.approx(2.0 * math.pi * 1e-3 / ratio, rel=1e-5)


@pytest.mark.slow
def test_largest_response_to_a_half_sine():
    """1.77 A near f T = 0.8."""
    x = np.linspace(0.3, 3.0, 271)
    values = [amplification("half-sine", one) for one in x.tolist()]
    assert max(values) == pytest.approx(1.768, abs=1e-3)
    assert x[np.argmax(values)] == pytest.approx(0.8, abs=0.02)


LENGTHS = st.floats(-3.0, 1.2).map(lambda power: 10.0**power)
PULSES = st.tuples(
    st.sampled_from(list(SHAPES)), LENGTHS, st.floats(-3.0, 3.0).map(lambda power: 10.0**power)
)


@given(PULSES, PULSES, st.booleans())
def test_no_pulse_below_the_boundary_exceeds_the_response_survived(test, landing, measured):
    """With a natural frequency of 1 Hz: a pulse with a smaller velocity change, or a smaller peak,
    than the critical one.
    """
    shape, length, peak = test
    known = (
        {"critical_velocity_change": peak}
        if measured
        else {"rating": f"{shape} {peak!r} g {length!r} s"}
    )
    found = strength(Part(name="p", at="x", natural_frequency=1.0, **known))
    survived = 2.0 * math.pi * peak / GRAVITY if measured else peak * amplification(shape, length)
    assert found.velocity_change * 2.0 * math.pi == pytest.approx(survived * GRAVITY)
    assert found.acceleration == pytest.approx(survived / 2.0)
    other, time, size = landing
    if (
        velocity_change(size * GRAVITY, Pulse(other, time)) <= found.velocity_change
        or size <= found.acceleration
    ):
        assert size * amplification(other, time) <= survived * (1.0 + 1e-6)


@given(PULSES, st.floats(1.0, 30.0), st.floats(0.01, 1.0))
def test_longer_pulses_with_a_smaller_velocity_change_are_survived(test, longer, share):
    """Whatever the natural frequency, here 1 Hz with any length: why 2AT/π is a lower bound for
    impacts that last longer.
    """
    shape, length, peak = test
    if longer * length <= 16.0:
        size = share * peak / longer
        assert size * amplification(shape, longer * length) <= peak * amplification(
            shape, length
        ) * (1.0 + 1e-4)


@pytest.mark.parametrize("micro", ["u", "\u00b5", "\u03bc"])
def test_microseconds_are_written_with_either_mu(micro):
    """500 µs are 0.5 ms with the letter u, the micro sign and the Greek letter."""
    written = Part(name="imu", at="trunk", rating=f"half-sine 1500 g 500 {micro}s")
    assert strength(written) == strength(replace(written, rating=RATING))


def test_a_rating_adds_nothing_to_a_critical_velocity_change_without_a_frequency():
    found = strength(
        Part(name="p", at="x", rating="half-sine 50 g 11 ms", critical_velocity_change=2.0)
    )
    assert (found.velocity_change, math.isnan(found.acceleration)) == (2.0, True)
    assert "with a natural_frequency" in found.basis


# Margins


@pytest.mark.parametrize(
    ("part", "margin", "by"),
    [
        ({"rating": RATING}, 2.0 * 1500 * GRAVITY * 0.5e-3 / math.pi / 3.0, "velocity change"),
        (
            {"rating": "half-sine 50 g 30 ms"},
            25.0 * GRAVITY / (3.0 * math.sqrt(K / 2.0)),
            "acceleration",
        ),
        ({"critical_velocity_change": 2.0}, 2.0 / 3.0, "velocity change"),
        (
            {"critical_velocity_change": 2.0, "natural_frequency": 500},
            math.pi * 500 * 2.0 / (3.0 * math.sqrt(K / 2.0)),
            "acceleration",
        ),
    ],
    ids=["pulse", "long pulse", "critical", "stiff part"],
)
def test_a_point_mass_on_a_spring(here, part, margin, by):
    """Δv = v and a peak of v √(k/m): below both bounds of a survived pulse, or below one of the
    critical values.
    """
    scene = Scene(
        robot="box.urdf",
        contact="box",
        strike=Strike(speed=3.0),
        contact_stiffness=K,
        gravity=False,
        part=(Part(name="p", at="box", **part),),
    )
    profile = shock_profile(scene)
    (found,) = profile.parts
    assert found.peak_g == pytest.approx(3.0 * math.sqrt(K / 2.0) / GRAVITY, rel=1e-9)
    assert (found.part_margin, found.governed_by) == (pytest.approx(margin, rel=1e-9), by)
    warned = [warning.text for warning in profile.health.warnings if warning.kind == "part"]
    assert warned == (
        [f"p may be damaged: its margin by {by} is {margin:.3g}, below 1"] if margin < 1.0 else []
    )


def test_margins_for_a_pulse_and_without_one(here):
    """A peak of π Δv / (2T); without a length of the impact the velocity change alone counts."""
    part = Part(name="p", at="box", rating="half-sine 50 g 11 ms")
    scene = Scene(robot="box.urdf", contact="box", part=(part,), pulse="half-sine:1ms")
    (found,) = shock_profile(scene).parts
    assert found.acceleration_margin == pytest.approx(
        25.0 * GRAVITY / (math.pi / 2.0 / 1e-3), rel=1e-12
    )
    assert (found.part_margin, found.governed_by) == (found.acceleration_margin, "acceleration")
    (found,) = shock_profile(Scene(robot="box.urdf", contact="box", part=(part,))).parts
    assert (found.peak_g, found.acceleration_margin, found.governed_by) == (
        None,
        None,
        "velocity change",
    )
    assert found.part_margin == pytest.approx(strength(part).velocity_change, rel=1e-15)


def test_a_part_that_does_not_move_has_no_bound(here):
    """On a fixed body nothing happens, so its margin is infinite, which is null in the document."""
    contact, posture = Contact(frame="foot", directions=("z",)), Posture(joints_deg={"knee": 60.0})
    part = (Part(name="p", at="body", rating=RATING),)
    scene = Scene(robot="stick.urdf", contact=contact, posture=posture, base="fixed", part=part)
    (found,) = shock_profile(scene).parts
    assert (found.velocity_margin, found.part_margin) == (math.inf, math.inf)


@pytest.mark.parametrize(
    ("words", "part", "torque", "limit", "said"),
    [
        (("--contact-stiffness", K, "--no-gravity"), {}, None, 50.0, "of the torque limit"),
        (
            ("--contact-stiffness", K, "--no-gravity"),
            {"momentary_torque": 200.0},
            None,
            200.0,
            "of the torque limit",
        ),
        (
            ("--pulse", "half-sine:5ms"),
            {},
            math.pi / 2.0 / 5e-3,
            50.0,
            "peak of a torque that has the pulse half-sine:5ms",
        ),
        (
            (),
            {"torque_duration": 0.02},
            1.0 / 0.02,
            50.0,
            "over the duration for which the joint withstands its torque, a mean",
        ),
    ],
    ids=["stiffness", "momentary torque", "pulse", "duration"],
)
def test_share_of_the_momentary_torque(capfd, here, words, part, torque, limit, said):
    """The peak on the contacts' stiffness, else the impulse of the upper mass over a length; of the
    effort limit by default.
    """
    keys = "".join(f"{key} = {value}\n" for key, value in part.items())
    scene = (
        'robot = "column.urdf"\njoints = { model = "locked" }\n[[contact]]\nframe = '
        '"foot"\ndirections = ["z"]\nrestitution = 1\n'
    )
    (here / "s.toml").write_text(
        scene + (f'[[part]]\nname = "gear"\njoint = "*"\n{keys}' if part else "")
    )
    (joint,) = document(capfd, "s.toml", *words)["tables"]["joints"]
    peak = 3.0 * math.sqrt(K / 3.5) if torque is None else 6.0 * torque
    assert joint["joint_torque_share"] == pytest.approx(peak / limit, rel=1e-9)
    assert said in good(capfd, "analyze", "s.toml", *words)


def test_a_torque_is_rated_for_a_time(capfd, here):
    """An impact that lasts longer is a warning, and so is a torque beyond the rating."""
    part = (
        '[[part]]\nname = "gear"\njoint = "slide"\nmomentary_torque = 10\ntorque_duration = 0.001\n'
    )
    scene = (
        'robot = "column.urdf"\npulse = "half-sine:5ms"\njoints = { model = "locked" '
        '}\n[[contact]]\nframe = "foot"\n'
    )
    (here / "s.toml").write_text(scene + part)
    warned = [
        one["text"]
        for one in document(capfd, "s.toml")["health"]["warnings"]
        if one["kind"] == "part"
    ]
    assert warned[0].startswith("slide carries 94.2 times its momentary torque")
    assert says(warned[1], "5 ms", "torque of slide", "1 ms")


def test_joints_without_a_limit_or_a_time_have_no_share(here):
    """Nothing is assumed in silence; and redundant contacts leave the impulse through a joint
    undetermined.
    """
    share = shock_profile(Scene(robot="column.urdf", contact="foot")).value(
        "joint_torque_share", "joint"
    )
    assert np.isnan(share).all()
    twice = (
        Contact(frame="foot"),
        Contact(frame="foot", offset=(0.1, 0, 0)),
        Contact(frame="foot", offset=(0.2, 0, 0)),
    )
    profile = shock_profile(Scene(robot="column.urdf", contact=twice, pulse="half-sine:5ms"))
    assert profile.redundant
    assert np.isnan(profile.value("joint_torque_share", "joint")).all()


# Parts of joints


def landed(**scene):
    """A column of 0.5 and 3 kg on a locked slide of at most 50 N, at 1 m/s with restitution 1: the
    slide carries 6 N s.
    """
    contact = Contact(frame="foot", directions=("z",), restitution=1.0)
    return shock_profile(
        Scene(robot="column.urdf", contact=contact, joints=Joints(model="locked"), **scene)
    )


@pytest.mark.parametrize(
    ("scene", "part", "torque"),
    [
        ({"contact_stiffness": K, "gravity": False}, {}, 3.0 * math.sqrt(K / 3.5)),
        ({"pulse": "half-sine:5ms"}, {"momentary_torque": 200.0}, 6.0 * math.pi / 2.0 / 5e-3),
        ({}, {"momentary_torque": 200.0, "torque_duration": 0.02}, 6.0 / 0.02),
    ],
    ids=["stiffness", "pulse", "duration"],
)
def test_a_part_of_a_joint_has_a_margin(here, scene, part, torque):
    """Its momentary torque, or the effort limit of the file, over the peak or the mean of the
    impulse along its axis.
    """
    profile = landed(part=(Part(name="gear", joint="slide", **part),), **scene)
    (found,) = profile.parts
    limit = part.get("momentary_torque", 50.0)
    assert (found.part, found.joint, found.body) == ("gear", "slide", "body")
    assert (abs(found.along), found.torque) == (
        pytest.approx(6.0, rel=1e-12),
        pytest.approx(torque, rel=1e-9),
    )
    assert found.part_margin == pytest.approx(limit / torque, rel=1e-9)
    assert (found.governed_by, found.missing, found.shock, found.delta_v) == (
        "torque",
        "",
        None,
        None,
    )
    (warned,) = [one for one in profile.health.warnings if one.kind == "part"]
    what = "momentary torque" if part else "effort limit"
    assert warned.text == f"slide carries {torque / limit:.3g} times its {what}"


def test_a_part_of_a_joint_that_cannot_be_judged_says_why(capfd, here):
    """No time; and no torque, where the file has no limit: a row of the table, a warning, and null
    in the document.
    """
    words = ("column.urdf", "--contact", "foot", "--part", "slide=50N", "--part", f"body={RATING}")
    text = good(capfd, "analyze", *words)
    assert "needs a pulse, stiffness or duration" in text
    parts = {part["part"]: part for part in document(capfd, *words)["tables"]["parts"]}
    assert parts["slide"]["part_margin"] is None
    assert parts["slide"]["missing"] == "needs a pulse, stiffness or duration"
    assert parts["body"]["missing"] is None
    (here / "weak.urdf").write_text(COLUMN.replace('effort="50"', 'effort="0"'))
    part = Part(name="gear", joint="slide")
    profile = shock_profile(
        Scene(robot="weak.urdf", contact="foot", pulse="half-sine:5ms", part=(part,))
    )
    (warning,) = (one.text for one in profile.health.warnings if one.kind == "part")
    assert says(warning, "gear is not judged", "momentary_torque", "no effort limit")


@pytest.mark.parametrize("scene", [{"contact_stiffness": K}, {"pulse": "half-sine:5ms"}])
@pytest.mark.parametrize(
    ("rotor", "missing"),
    [(None, "needs the rotor of its spring"), (1e-3, "needs a contact stiffness")],
)
def test_a_joint_behind_a_spring_has_no_torque_of_zero(here, scene, rotor, missing):
    """The spring of a series elastic joint carries nothing in the instant of an impact, but a
    torque afterwards.
    """
    inertia = "" if rotor is None else f"armature = {rotor}\n"
    (here / "d.toml").write_text(
        f'[[drive]]\njoint = ["slide"]\ndrive_stiffness = 1e4\n{inertia}status = '
        f'"published"\nsource = "s"\n'
    )
    part = (Part(name="gear", joint="slide", momentary_torque=300.0),)
    profile = shock_profile(
        Scene(
            robot="column.urdf", contact="foot", joints=Joints(drives="d.toml"), part=part, **scene
        )
    )
    (found,) = profile.parts
    judged = rotor is not None and "contact_stiffness" in scene
    assert (found.part_margin is None, found.torque is None, found.missing) == (
        not judged,
        not judged,
        "" if judged else missing,
    )
    if judged:
        assert found.torque > 0.0


def test_a_torque_on_the_command_line(capfd, here):
    """TORQUE, and TORQUE DURATION; in the unit of the joint, and of a joint that exists."""
    words = (
        "column.urdf",
        "--contact",
        "foot",
        "--part",
        "sl*=50 N 20 ms",
        "--save-scene",
        "s.toml",
    )
    document(capfd, *words)
    (part,) = tomllib.loads((here / "s.toml").read_text())["part"]
    assert part == {
        "name": "sl*",
        "joint": "sl*",
        "momentary_torque": 50.0,
        "torque_duration": 0.02,
    }
    for text, fault in (
        ("slide=50 N m", 'joint "slide" is in N, and'),
        ("slid=50 N", '"slide"'),
        ("slide=-5 N", "above zero"),
    ):
        outcome = run(capfd, "analyze", *words[:4], text)
        assert (outcome.code, fault in outcome.err) == (2, True), outcome.err


def test_budgets_count_gears(capfd, here):
    """A margin of a part of joints is a budget as others are, and one that cannot be judged has no
    verdict.
    """
    case = (
        '[[case]]\nname = "a"\nrobot = "column.urdf"\njoints = { model = "locked" '
        '}\n[[case.contact]]\nframe = "foot"\n'
    )
    part = '[[part]]\nname = "gear"\njoint = "slide"\nmomentary_torque = 100\n'
    budget = '[[budget]]\nmetric = "part_margin"\nmin = 1.0\n'
    for time, code in (("", 3), ("torque_duration = 0.02\n", 1), ("torque_duration = 1.0\n", 0)):
        (here / "budgets.toml").write_text(case + part + time + budget)
        assert run(capfd, "check").code == code


# Refusals


@pytest.mark.parametrize(
    ("keys", "texts"),
    [
        (
            {"rating": "1500 g"},
            ["half-sine, saw-tooth, haversine, rectangle", '"half-sine 1500 g 0.5 ms"'],
        ),
        ({"rating": "triangle 50 g 11 ms"}, ['"triangle 50 g 11 ms" cannot be read']),
        ({"rating": "half-sine -50 g 11 ms"}, ["above zero"]),
        ({"rating": "half-sine 50 g 0 ms"}, ["above zero"]),
        ({"rating": "half-sine nan g 1 ms"}, ["cannot be read"]),
        ({"rating": "half-sine 1e400 g 1 ms"}, ["cannot be read"]),
        (
            {"rating": RATING, "natural_frequency": -1.0},
            ['part "p": natural_frequency is -1, and it has to be above zero'],
        ),
        ({"critical_velocity_change": 0.0}, ["critical_velocity_change is 0"]),
        ({"natural_frequency": 100.0}, ["has no strength"]),
        ({"rating": RATING, "joint": "knee"}, ["needs a place"]),
        ({"rating": RATING, "momentary_torque": 3.0}, ["a part at a frame takes rating"]),
        ({"at": None, "joint": "knee", "momentary_torque": -3.0}, ["momentary_torque is -3"]),
        (
            {"at": None, "joint": "knee", "rating": RATING},
            ["a part that is a joint takes momentary_torque"],
        ),
        ({"at": "body:1,2", "rating": RATING}, ["is not a point"]),
    ],
)
def test_refusals(here, keys, texts):
    """What was found, and what would be valid."""
    part = Part(**({"name": "p", "at": "body"} | keys))
    with pytest.raises(SceneError) as refusal:
        resolve_stick(part)
    assert all(text in str(refusal.value) for text in texts)


def resolve_stick(*parts):
    scene = Scene(robot="stick.urdf", contact="foot", part=parts)
    return shock_profile(scene)


def test_names_that_are_not_known(here):
    """A frame and a joint that the robot does not have, with the nearest; and two parts of one
    name.
    """
    with pytest.raises(UnknownName, match=r'no frame "imu_lnk".*nearest: "imu_link"'):
        resolve_stick(Part(name="p", at="imu_lnk", rating=RATING))
    with pytest.raises(UnknownName, match=r'no joint "kne".*nearest: "knee"'):
        resolve_stick(Part(name="p", joint="kne"))
    with pytest.raises(SceneError, match='two parts are called "p"'):
        resolve_stick(*[Part(name="p", at="body", rating=RATING)] * 2)


# Where they are given, and where they go


def test_a_part_on_the_command_line_is_saved(capfd, here):
    """`--part FRAME=RATING`, and the scene that is written computes the same."""
    words = ("stick.urdf", "--contact", "foot", "--part", f"imu_link:0,0,0.01={RATING}")
    first = document(capfd, *words, "--save-scene", "s.toml")
    assert tomllib.loads((here / "s.toml").read_text())["part"] == [
        {"name": "imu_link:0,0,0.01", "at": "imu_link:0,0,0.01", "rating": RATING}
    ]
    assert document(capfd, "s.toml")["tables"]["parts"] == first["tables"]["parts"] != []


def test_files_of_a_landing_with_parts(capfd, here):
    """Tables of parts and joints with all digits, and the figure."""
    words = (
        "stick.urdf",
        "--contact",
        "foot",
        "--part",
        f"imu_link={RATING}",
        "--pulse",
        "half-sine:5ms",
    )
    good(capfd, "analyze", *words, "--out", "out")
    (row,) = csv.DictReader((here / "out" / "joints.csv").read_text().splitlines())
    profile = shock_profile(Scene(robot="stick.urdf", contact="foot", pulse="half-sine:5ms"))
    assert float(row["of the torque limit [-]"]) == profile.value("joint_torque_share", "joint")[0]
    assert (
        (here / "out" / "parts.csv")
        .read_text()
        .startswith("part,body,joint,|Δv| [m/s],critical [m/s],critical peak [g],both,")
    )
    figure = (here / "out" / "damage_boundary.svg").read_text()
    assert all(
        text in figure
        for text in ("Damage boundary", "imu_link", "landing on foot", "peak acceleration [g]")
    )
    good(capfd, "analyze", *words[:3], "--out", "out")
    assert not {"damage_boundary.svg", "damage_boundary.png", "parts.csv"} & {
        path.name for path in (here / "out").iterdir()
    }


def test_budgets_of_parts(capfd, here):
    """Parts of a file are those of all of its cases, besides their own; the metrics are the numbers
    of an analysis.
    """
    case = (
        '[[case]]\nname = "a"\nrobot = "stick.urdf"\npulse = '
        '"half-sine:5ms"\n[[case.contact]]\nframe = "foot"\n'
    )
    part_text = '[[case.part]]\nname = "camera"\nat = "shin"\ncritical_velocity_change = 1e-3\n'
    shared = f'[[part]]\nname = "IMU"\nat = "imu_link"\nrating = "{RATING}"\n'
    budget = (
        '[[budget]]\nmetric = "part_margin"\nmin = 1.5\n[[budget]]\nmetric = '
        '"joint_torque_share"\nat = "knee"\nmax = 1e6\n'
    )
    (here / "budgets.toml").write_text(case + part_text + shared + budget)
    outcome = run(capfd, "check", "--format", "json")
    assert (outcome.code, outcome.err) == (1, "")
    status = {
        one["at"]: (one["metric"], one["status"])
        for one in json.loads(outcome.out)["tables"]["check"]
    }
    assert status == {
        "camera": ("part_margin", "exceeded"),
        "IMU": ("part_margin", "passed"),
        "knee": ("joint_torque_share", "passed"),
    }
    for text, proven in (
        (case, True),
        (case.replace('pulse = "half-sine:5ms"', "contact_stiffness = 1e5"), False),
    ):
        (here / "budgets.toml").write_text(text + part_text + shared + budget)
        assert (
            "in double precision: part_margin, joint_torque_share" not in run(capfd, "check").out
        ) == proven
    (here / "budgets.toml").write_text(case + '[[part]]\nname = 3\nrange = "1"\n' + budget)
    assert "part[0].name has to be text" in run(capfd, "check").err
    (here / "budgets.toml").write_text(case + budget)
    assert "part_margin is of parts, and the scene has none" in run(capfd, "check").err


def test_margins_are_columns_of_studies(here):
    """A sweep over speed, and a comparison: the margin by velocity change falls as the speed rises."""
    part = Part(name="IMU", at="imu_link", rating=RATING)
    geared = Joints(armature={"*": 0.01})
    scene = Scene(
        robot="stick.urdf", contact="foot", part=(part,), pulse="half-sine:5ms", joints=geared
    )
    columns = ("velocity_margin@IMU", "part_margin@IMU", "joint_torque_share@knee")
    values = sweep(scene, {"speed": "1,2"}, quantities=columns).chunk(0).columns
    profile = shock_profile(scene)
    for name in columns:
        key = name.partition("@")[0]
        expected = float(profile.value(key, "joint" if key.startswith("joint") else "part")[0])
        factor = 2.0 if key.startswith("joint") else 0.5
        np.testing.assert_allclose(values[name], [expected, factor * expected], rtol=1e-12)
    designs = [Design(label, scene, resolve(scene, profile.robot).robot) for label in "ab"]
    found = next(
        one
        for one in compare(designs, ["part_margin"]).quantities
        if one.selection.name == "part_margin"
    )
    assert found.rows[0].values == (profile.parts[0].part_margin,) * 2


def test_shock_and_peaks_of_parts_are_columns_of_studies(here):
    """The shock of a part is that of its point; its peak is known on contacts of finite stiffness
    as it is for a pulse.
    """
    scene = Scene(
        robot="stick.urdf", contact="foot", part=(Part(name="IMU", at="imu_link", rating=RATING),)
    )
    of_shock = sweep(scene, {"speed": "1,2"}, quantities=("part.shock@IMU", "shock@imu_link"))
    values = of_shock.table.columns
    assert values["part.shock@IMU"].tolist() == values["shock@imu_link"].tolist()
    assert np.nanmax(values["double_error"]) < 1e-12
    stiff = replace(scene, contact_stiffness=K, gravity=False)
    peaks = sweep(stiff, {"speed": "1,2"}, quantities=("part.peak_g@IMU",)).table.columns[
        "part.peak_g@IMU"
    ]
    np.testing.assert_allclose(
        peaks, shock_profile(stiff).parts[0].peak_g * np.array([1.0, 2.0]), rtol=1e-6
    )
    with pytest.raises(StudyError, match=r"peak_g.*duration"):
        sweep(scene, {"speed": "1,2"}, quantities=("part.peak_g@IMU",))


def test_the_margin_changes_as_the_shock_does(here):
    """It is a constant over |Δv|, so that relative changes by every parameter are opposite."""
    scene = Scene(
        robot="stick.urdf", contact="foot", part=(Part(name="IMU", at="imu_link", rating=RATING),)
    )
    margin, shock = (
        sensitivity(scene, target) for target in ("velocity_margin@IMU", "shock@imu_link")
    )
    changes = [
        np.array([effect.derivatives[0] for effect in one.effects]) / one.values[0]
        for one in (margin, shock)
    ]
    np.testing.assert_allclose(
        changes[0], -changes[1], rtol=1e-8, atol=1e-8 * np.nanmax(np.abs(changes[1]))
    )


@pytest.mark.slow
def test_names_of_parts(capfd, here):
    """Names that would be commands, markup or formulas are text in every output."""
    parts = "".join(
        f'[[part]]\nname = {json.dumps(name)}\nat = "imu_link"\nrating = "{RATING}"\n'
        for name in NAMES
    )
    (here / "s.toml").write_text(
        f'robot = "stick.urdf"\n[strike]\nspeed = 1e4\n[[contact]]\nframe = "foot"\n{parts}'
    )
    outcome = run(capfd, "analyze", "s.toml", "--out", "out")
    assert outcome.code == 0, outcome.err
    check_text(outcome.out)
    for path in (here / "out").iterdir():
        if path.suffix in SUFFIXES:
            check_text(read(path))
            SUFFIXES[path.suffix](read(path))
