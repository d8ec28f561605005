"""The tree of errors: drawn as it is, and every text complete."""

import importlib
import inspect
import pickle
import re
from dataclasses import replace

import pytest
from commands import run

import shockpc
from shockpc import (
    Closure,
    Contact,
    Joints,
    LoopEnd,
    Point,
    Posture,
    Rotor,
    Scene,
    Strike,
    shock_profile,
)
from shockpc.text import errors
from shockpc.text.errors import (
    DefectError,
    OutputError,
    RobotError,
    SceneError,
    ShockError,
    SolveError,
    StudyError,
    UnknownName,
)

CLASSES = {
    name: kind
    for name, kind in vars(errors).items()
    if inspect.isclass(kind) and issubclass(kind, Exception)
}


def test_tree_in_the_docstring_is_the_tree():
    """Every class stands in the drawing under its parent, and is exported; exit codes: 3 no
    solution, 70 a defect, else 2.
    """
    drawn = re.findall(r"^(├── |└── )?([A-Z]\w+) {2,}\S", str(errors.__doc__), re.MULTILINE)
    assert [name for branch, name in drawn if not branch] == ["ShockError"]
    assert sorted(name for branch, name in drawn if branch) == sorted(set(CLASSES) - {"ShockError"})
    assert all(
        kind.__bases__ == (ShockError,) for name, kind in CLASSES.items() if name != "ShockError"
    )
    assert ShockError.__bases__ == (Exception,)
    assert {name: kind.exit_code for name, kind in CLASSES.items()} == dict.fromkeys(CLASSES, 2) | {
        "SolveError": 3,
        "DefectError": 70,
    }
    assert all(
        name in shockpc.__all__ and getattr(shockpc, name) is kind for name, kind in CLASSES.items()
    )


@pytest.mark.parametrize(
    "error",
    [
        ShockError("root"),
        RobotError("dog.urdf: no mass"),
        SceneError("no contact"),
        SolveError("no mass", bodies=["shank"], constraints=["foot"], joints=["knee"]),
        StudyError("no landing"),
        OutputError("disk full"),
        UnknownName("frame", "lf_fot", ("lf_foot", "rf_foot"), 'robot "hyq"', "shockpc robots hyq"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_errors_survive_pickling(error):
    """An error that crosses from one process to another keeps its kind, its text and what it
    carries.
    """
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


FOOT = Contact(frame="hind_foot")
APART = Closure(a=LoopEnd(frame="hind_foot"), b=LoopEnd(frame="torso", offset=(0.0, 0.0, 9.0)))


@pytest.mark.parametrize(
    ("scene", "data"),
    [
        ({"contact": replace(FOOT, normal=(0.0, 0.0, 0.0))}, {"constraints": ("hind_foot",)}),
        ({"contact": replace(FOOT, directions=("x",))}, {"constraints": ("hind_foot",)}),
        ({"contact": (FOOT, FOOT)}, {"constraints": ("hind_foot", "hind_foot")}),
        ({"strike": Strike(strike_angle_deg=120.0)}, {"constraints": ("hind_foot",)}),
        ({"joints": Joints(armature={"hind_knee": -1.0})}, {"joints": ("hind_knee",)}),
        ({"joints": Joints(rotor={"hind_knee": Rotor(inertia=1e-4)})}, {"joints": ("hind_knee",)}),
        (
            {"joints": Joints(locked=("hind_knee",), stiffness={"hind_knee": 1.0})},
            {"joints": ("hind_knee",)},
        ),
        (
            {"closure": (Closure(a=LoopEnd(frame="torso"), b=LoopEnd(frame="torso")),)},
            {"constraints": ("torso–torso",)},
        ),
        (
            {"closure": (APART,)},
            {
                "constraints": ("hind_foot–torso",),
                "joints": ("front_hip", "front_knee", "hind_hip", "hind_knee"),
            },
        ),
        (
            {"base": "fixed", "posture": Posture(reference="neutral")},
            {"constraints": ("hind_foot",), "rows": (2,)},
        ),
    ],
    ids=lambda value: "+".join(value),
)
def test_refusals_carry_what_they_name(scene, data):
    """What a message names can be read without its words: contacts, loops, joints and rows, and all
    that is in quotation marks.
    """
    with pytest.raises(ShockError) as refused:
        shock_profile(Scene(**{"robot": "quadruped", "contact": FOOT, **scene}))
    assert {key: values for key, values in refused.value.data.items() if values} == data
    assert set(refused.value.names) >= {*data.get("joints", ()), *data.get("constraints", ())}


@pytest.mark.parametrize(
    ("known", "where", "text"),
    [
        (
            ("lf_foot", "rf_foot", "trunk"),
            'robot "hyq"',
            'no frame "LF_fot" in robot "hyq"; nearest: "lf_foot", "rf_foot". To list them: '
            "shockpc robots hyq",
        ),
        (
            ("a", "b"),
            "",
            'no frame "LF_fot"; there are: "a", "b". To list them: shockpc robots hyq',
        ),
        (
            tuple("abcdefghijklm"),
            "",
            'no frame "LF_fot"; no name is similar. To list them: shockpc robots hyq',
        ),
        ((), "", 'no frame "LF_fot"; there are none. To list them: shockpc robots hyq'),
    ],
    ids=["near", "few", "many", "none"],
)
def test_unknown_names_help_on(known, where, text):
    """The nearest names; all of them where they are few; and always the command that lists them."""
    assert str(UnknownName("frame", "LF_fot", known, where, "shockpc robots hyq")) == text


def test_a_point_that_is_not_known_is_refused_with_its_scene():
    """Not only where its shock is read."""
    scene = Scene(robot="go2", contact="FL_foot", point=(Point(frame="FL_fot"),))
    with pytest.raises(UnknownName, match='no frame "FL_fot"'):
        shockpc.resolve(scene, shockpc.load_robot("go2"))


def test_names_in_messages_are_printable_and_not_longer_than_a_line():
    """A name from a file may hold anything; a message is one line, and what was asked is recognised
    by its ends.
    """
    error = UnknownName("frame", "a" * 60 + "b" * 60, ("x\x1b[2Jy", "c\nd"), "", "shockpc robots r")
    assert str(error).isprintable()
    assert f'"{"a" * 40}…{"b" * 39}"' in str(error)
    assert r'"x\x1b[2Jy", "c\nd"' in str(error)
    assert error.name == "a" * 60 + "b" * 60


LANDING = Scene(robot="go2", contact="FL_foot")
MEASURED = {
    "FL_calf_joint": [-1.4, -1.5],
    "before_FL_calf_joint": [0.0, 0.0],
    "after_FL_calf_joint": [0.1, 0.2],
}


@pytest.mark.parametrize(
    "study",
    [
        lambda: shockpc.limits(LANDING, "FL_calf_joint", "shock@imu", 0.1),
        lambda: shockpc.sensitivity(LANDING, "shock@imu"),
        lambda: shockpc.identify(MEASURED, LANDING, {"armature:*": "1e-3:1e-1"}),
        lambda: shockpc.improve(
            LANDING, "joint_impulse@FL_calf_joint", vary={"FL_calf_joint": "-120:-60"}
        ),
    ],
    ids=["limits", "sensitivity", "identify", "improve"],
)
def test_an_unexpected_exception_in_a_row_ends_a_study_without_rows(monkeypatch, study):
    """It is an error of shockpc itself, neither a landing that has no result nor one that does not
    count.
    """

    def broken(*_):
        raise ZeroDivisionError("on purpose")

    monkeypatch.setattr("shockpc.evaluation.chunk_rows.columns", broken)
    with pytest.raises(DefectError, match="on purpose"):
        study()


def test_an_unexpected_exception_among_random_designs_is_a_defect_of_the_check(
    monkeypatch, tmp_path
):
    (tmp_path / "budgets.toml").write_text(
        '[[case]]\nname = "a"\nrobot = "go2"\ncontact = "FL_foot"\ndesigns = 20\n'
        '[[case.vary]]\nquantity = "mass:base"\nvalues = "±5%"\n'
        '[[budget]]\nat = "imu"\nmetric = "shock"\nmax = 0.1\npercentile = 95\n'
    )

    def broken(*_):
        raise ZeroDivisionError("on purpose")

    monkeypatch.setattr("shockpc.evaluation.chunk_rows.columns", broken)
    check = shockpc.check_budgets(tmp_path / "budgets.toml")
    assert "ZeroDivisionError: on purpose" in check.defects[0]


LOG = (
    ",".join(MEASURED)
    + "\n"
    + "\n".join(",".join(map(str, row)) for row in zip(*MEASURED.values(), strict=True))
    + "\n"
)


@pytest.mark.parametrize(
    ("where", "words", "shown"),
    [
        (
            "shockpc.evaluation.profiles.profile_of_scene",
            ["analyze", "go2", "--contact=F*_foot", "--format=csv"],
            "FR_foot",
        ),
        (
            "shockpc.evaluation.chunk_rows.columns",
            ["recorded", "log.csv", "go2", "--contact=FL_foot"],
            "shock",
        ),
        ("shockpc.wings.fall.results._trunk", ["fall", "go2", "--heading=front"], "trunk"),
    ],
    ids=["landings that are analyzed", "a comparison with what was measured", "joints of a fall"],
)
def test_an_unexpected_exception_is_exit_code_70_after_the_other_rows_are_given(
    capfd, monkeypatch, tmp_path, where, words, shown
):
    """In the first of the landings that are computed, whatever it is for."""
    module, _, name = where.rpartition(".")
    original, calls = getattr(importlib.import_module(module), name), []

    def broken_once(*args):
        calls.append(args)
        if len(calls) == 1:
            raise ZeroDivisionError("on purpose")
        return original(*args)

    (tmp_path / "log.csv").write_text(LOG)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(where, broken_once)
    code, out, err = run(capfd, *words)
    assert code == 70
    assert "ZeroDivisionError: on purpose" in err
    assert shown in out
