"""Arguments of studies: another type, or a value beyond its bounds, is one message that says what
is valid.
"""

import dataclasses
import functools
import inspect
from collections.abc import Mapping, Sequence
from typing import get_args, get_origin

import numpy as np
import pytest
from typer.main import get_command

import shockpc
from shockpc.cli.app import COMMANDS, app_for
from shockpc.cli.options import RECORDS
from shockpc.core.number import number_from
from shockpc.evaluation.declare import declaration
from shockpc.quantities.maps import doubles
from shockpc.text.arguments import is_numeric
from shockpc.text.toml import converted

STUDIES = [
    getattr(shockpc, name)
    for name in shockpc.__all__
    if "study" in getattr(getattr(shockpc, name), "__dict__", ())
]
SCENE = shockpc.Scene(robot="go2", contact="FL_foot")
VALID = {
    "scene": SCENE,
    "landings": {"": SCENE},
    "postures": SCENE,
    "joint": "a",
    "target": "a",
    "designs": (),
    "robots": (),
}
VALID |= {"table": {}, "log": {}, "unknown": {}}


def filled(kind, number):
    """A value of the type, with this number wherever it has one."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Mapping:
        return {"a": filled(parts[1], number)}
    if parts and origin in (tuple, Sequence):
        return (
            (filled(parts[0], number),)
            if parts[1:] in ((), (...,))
            else tuple(filled(part, number) for part in parts)
        )
    return (
        next(filled(part, number) for part in parts if part is not type(None)) if parts else number
    )


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.__name__)
def test_arguments_of_another_type_or_beyond_their_bounds_are_refused(study):
    """Each parameter by its name: an object of no use, a text for a sequence, True for a number."""
    parameters, options = inspect.signature(study).parameters, declaration(study).parameters
    given = {
        name: VALID[name]
        for name, parameter in parameters.items()
        if parameter.default is inspect.Parameter.empty
    }
    for name, parameter in parameters.items():
        kind = parameter.annotation
        values = [
            object(),
            *(["a"] if get_origin(kind) is Sequence else []),
            *([True] if kind in (int, float, float | None) else []),
        ]
        for value in values:
            with pytest.raises(shockpc.StudyError, match=f"^{name} is .* it has to be "):
                study(**given | {name: value})
        option = options[name].option if name in options else None
        for number in (1e13, -1e13, float("nan"), 10**400) if option and is_numeric(kind) else ():
            with pytest.raises(
                shockpc.StudyError, match=f"^{name} must be |^{name} is .* it has to be "
            ):
                study(**given | {name: filled(kind, number)})
        assert option is None or kind not in (int, int | None) or option.greatest is not None
        for bound, sign in (
            ((option.least, -1), (option.above, 0), (option.greatest, 1)) if option else ()
        ):
            if bound is not None:
                with pytest.raises(shockpc.StudyError, match=f"^{name} must be "):
                    study(**given | {name: filled(kind, int(bound + sign))})


def test_every_number_of_a_scene_has_a_range():
    """Those of its options, and those that stand in tables."""
    for record in RECORDS:
        for part in dataclasses.fields(record):
            if is_numeric(part.type):
                for number in (1e13, -1e13, float("nan")):
                    faults: list[str] = []
                    converted({part.name: filled(part.type, number)}, record, "", faults)
                    assert [fault for fault in faults if part.name in fault], part.name


def test_every_number_of_a_command_has_a_range():
    """Options whose type alone reads a number have none; those of studies and scenes are checked
    when these are called.
    """
    for name in COMMANDS:
        for option in get_command(app_for([name])).commands[name].params:
            of_study = (
                vars(getattr(shockpc, name)).get("study") if name in shockpc.__all__ else None
            )
            assert (of_study and option.name in of_study.parameters) or option.type.name not in (
                "integer",
                "float",
            ), (
                name,
                option.name,
            )


def test_a_list_of_times_has_a_length():
    with pytest.raises(shockpc.StudyError, match="after must have at most 100 values, got 5000"):
        shockpc.touchdowns({}, SCENE, after=tuple(range(1, 5001)))


@pytest.mark.parametrize(
    "vary", ["lf_kfe_joint=-70:-60", ["lf_kfe_joint"], [(1, "2:3")], [("a", "b", "c")], 3]
)
def test_ranges_of_another_type_are_refused(vary):
    for study in (shockpc.sweep, shockpc.fall, shockpc.improve):
        with pytest.raises(shockpc.StudyError, match="vary is "):
            study(SCENE, vary=vary)
    with pytest.raises(shockpc.StudyError, match="variables is "):
        shockpc.ShockCost({"": SCENE}, "shock@imu", vary)


def test_numbers_of_numpy_and_other_collections_are_taken():
    """They pass the check, and what follows says what is wrong with the values."""
    with pytest.raises(shockpc.UnknownName, match="a"):
        shockpc.limits(SCENE, "a", "b", np.float64(0.1), joint_range=np.array([0.0, 1.0]), step=1)
    with pytest.raises(shockpc.UnknownName, match="a"):
        shockpc.sweep(SCENE, {"strike-angle": (0, 1)}, seed=np.int64(1), bodies={"a"})


@pytest.mark.parametrize(
    "values",
    [
        [1, "a"],
        [[1, 2], [3]],
        b"1:2:3",
        [b"1"],
        [None],
        True,
        [True, False],
        1j,
        {"a": 1},
        np.array(["a"]),
        "6 0,70",
        "1_0",
        "\u0663",
        np.array([1.0 + 2.0j]),
        np.complex128(1.0 + 2.0j),
        np.datetime64("2026-01-01"),
    ],
)
def test_values_of_another_type_are_refused(values):
    for study in (
        shockpc.sweep,
        shockpc.fall,
        functools.partial(shockpc.sensitivity, target="shock@imu"),
    ):
        with pytest.raises(shockpc.StudyError, match=r"FL_calf_joint: .* is not a finite number"):
            study(SCENE, vary={"FL_calf_joint": values})


@pytest.mark.parametrize(
    "values",
    [
        [1.0 + 2.0j],
        np.array([1.0 + 2.0j]),
        np.array(["2026-01-01"], dtype="M8[D]"),
        ["1.0"],
        [None],
    ],
)
def test_arrays_of_what_is_no_real_number_are_refused(values):
    """`shock_maps`, and landings in symbols, read configurations and strikes so; nothing of a
    complex number is dropped.
    """
    with pytest.raises(
        shockpc.ShockError, match="Q holds a number that is not finite, or something else"
    ):
        doubles("Q", values)


NUMBERS = {"674": 674.0, " +6.5e-1 ": 0.65, ".5": 0.5, "1.": 1.0}
NO_NUMBERS = "6 74", "", "1_0", "\u0663", "1e999", "nan", "inf", "0x1", "1,0", "--1", "1e", "5 ms"


@pytest.mark.parametrize("text", [*NUMBERS, *NO_NUMBERS])
def test_a_number_in_a_text(text):
    """Digits, a point, an exponent and a unit that is asked for; no blank within, and nothing that
    Python alone reads.
    """
    if text in NUMBERS:
        assert number_from(text) == NUMBERS[text]
        assert number_from(f"{text.strip()} ms", {"ms": 1e-3}) == NUMBERS[text] * 1e-3
    else:
        with pytest.raises(ValueError, match="is not a number"):
            number_from(text)
    with pytest.raises(ValueError, match="is not a number"):
        number_from(f"{text}ms", {"s": 1.0})


@pytest.mark.parametrize(
    "values", [-70, np.int64(-70), np.array(-70.0), np.array([-70]), ["-70"], iter([-70.0])]
)
def test_values_of_numpy_and_other_collections_are_taken(values):
    assert shockpc.sweep(SCENE, {"FL_calf_joint": values}).landings.axes[0].values == (-70.0,)


def test_a_quantity_that_is_given_twice_is_refused_by_every_study():
    """Also where two patterns match the same joint: a landing would be named by both values and
    computed with one of them.
    """
    target = {"target": "shock@imu"}
    landings = {"": SCENE}
    for study, given in (
        (shockpc.sweep, {"scene": SCENE}),
        (shockpc.fall, {"postures": SCENE}),
        (shockpc.sensitivity, {"landings": landings} | target),
        (shockpc.place, {"landings": landings}),
    ):
        for second in ("FL_calf_joint", "F*_calf_joint"):
            with pytest.raises(shockpc.StudyError, match=r"FL_calf_joint.* is varied twice"):
                study(**given, vary=[("FL_calf_joint", "-80:-60:3"), (second, "-80:-50:2")])


@pytest.mark.parametrize(
    ("call", "wrong"),
    [
        (lambda robot: shockpc.batch([]), "no robot is given"),
        (lambda robot: shockpc.place({}), "no landing is given"),
        (lambda robot: shockpc.place({}, robot), "no landing is given"),
        (lambda robot: shockpc.sensitivity({}, "shock@imu", robot), "no landing is given"),
        (lambda robot: shockpc.fall({}, robot), "no landing is given"),
        (lambda robot: shockpc.fall(SCENE, headings=()), "no heading is given"),
        (lambda robot: shockpc.compare([]), "cannot be compared"),
        (lambda robot: shockpc.recorded({}, SCENE), "no rows"),
        (lambda robot: shockpc.check_budgets("missing.toml"), "missing.toml"),
    ],
)
def test_a_study_of_nothing_is_refused(call, wrong):
    with pytest.raises(shockpc.StudyError, match=wrong):
        call(shockpc.load_robot("go2"))


def _designs(scene):
    robot = shockpc.load_robot("go2")
    return [shockpc.Design(name, scene, robot) for name in "ab"]


GROUND = {
    "sweep": (
        lambda scene, key: shockpc.sweep(scene, {"speed": [1.0]}, quantities=key),
        {"contact_stiffness"},
    ),
    "compare": (lambda scene, key: shockpc.compare(_designs(scene), key), {"contact_stiffness"}),
    "batch": (
        lambda scene, key: _first_failure(
            shockpc.batch(["go2"], lambda name: (shockpc.load_robot(name), [scene]), quantities=key)
        ),
        {"contact_stiffness"},
    ),
    "fall": (
        lambda scene, key: shockpc.fall(
            dataclasses.replace(scene, contact=()), headings=["front"], quantities=key
        ),
        set(),  # by its torques joints are judged
    ),
    "recorded": (
        lambda scene, key: shockpc.recorded({"vz": np.array([-1.0])}, scene, key or ["shock@imu"]),
        {"friction", "contact_stiffness"},
    ),
    "sensitivity": (
        lambda scene, key: shockpc.sensitivity(scene, (key or ["shock"])[0] + "@imu"),
        {"friction", "contact_stiffness"},
    ),
    "limits": (
        lambda scene, key: shockpc.limits(
            scene, "FL_calf_joint", (key or ["shock"])[0] + "@imu", 0.1
        ),
        {"contact_stiffness"},
    ),
    "place": (lambda scene, key: shockpc.place(scene, alternatives=0), {"contact_stiffness"}),
}
"""Studies with further quantities, and what of the ground has no effect without these; friction
decides what is feasible.
"""


def _first_failure(batch):
    if batch.failures:
        raise shockpc.StudyError(batch.failures[0].reason)


@pytest.mark.slow
@pytest.mark.parametrize("study", GROUND)
@pytest.mark.parametrize(("option", "value"), [("friction", 0.3), ("contact_stiffness", 1e5)])
def test_what_is_said_of_the_ground_has_an_effect_or_is_refused(study, option, value):
    """Numbers of contacts that stick and are rigid would be taken for those of the ground that is
    given.
    """
    call, ignored = GROUND[study]
    scene = dataclasses.replace(SCENE, **{option: value})
    if option in ignored:
        with pytest.raises(shockpc.StudyError, match="which would change nothing here"):
            call(scene, [])
    # of which these take long
    if study != "place" and (option == "friction" or study not in ("limits", "sensitivity")):
        call(
            scene,
            [{"friction": "shock_friction", "contact_stiffness": "peak_acceleration"}[option]],
        )


def test_a_budget_of_numbers_that_do_not_depend_on_the_friction_is_refused(tmp_path):
    text = (
        '[[case]]\nname = "a"\nrobot = "go2"\ncontact = "FL_foot"\nfriction = 0.2\n[[budget]]\nat '
        '= "imu"\nmax = 9\nmetric = '
    )
    (tmp_path / "budgets.toml").write_text(f'{text}"shock"\n')
    with pytest.raises(shockpc.StudyError, match=r'case "a".*friction'):
        shockpc.check_budgets(tmp_path / "budgets.toml")
    (tmp_path / "budgets.toml").write_text(f'{text}"shock_friction"\n')
    assert shockpc.check_budgets(tmp_path / "budgets.toml").exit_code == 0


def test_a_study_of_landings_takes_one_scene_too():
    """The place of a sensor is the same, whether the only landing has a name or not."""
    single, named = (
        shockpc.place(SCENE, alternatives=0),
        shockpc.place({"one": SCENE}, alternatives=0),
    )
    assert single.places[0].position.tolist() == named.places[0].position.tolist()


def test_budgets_are_read_from_a_path(tmp_path):
    """As the command does; so a program needs no other name of the package."""
    (tmp_path / "budgets.toml").write_text(
        '[[case]]\nname = "a"\nrobot = "go2"\ncontact = "FL_foot"\n'
        '[[budget]]\ncase = "a"\nat = "imu"\nmetric = "shock"\nmax = 0.1\n'
    )
    check = shockpc.check_budgets(tmp_path / "budgets.toml")
    assert [outcome.value for outcome in check.outcomes] == [
        shockpc.shock_profile(SCENE).points[0].shock
    ]


@pytest.mark.parametrize(
    "call",
    [
        lambda robot: shockpc.read_scene(5),
        lambda robot: shockpc.resolve(robot, SCENE),
        lambda robot: shockpc.assert_shock(SCENE, at="imu", max="a"),
        lambda robot: shockpc.select(5),
        lambda robot: shockpc.load_robot("go2", srdf=5),
        lambda robot: shockpc.load_robot("go2", packages="a"),
        lambda robot: shockpc.load_robot("go2", xacro=5),
        lambda robot: shockpc.load_robot("go2", frames="FL_foot"),
        lambda robot: shockpc.load_robot(robot.model, geometry=5),
        lambda robot: shockpc.shock_maps(5, robot.start[None]),
        lambda robot: shockpc.shock_maps(SCENE, "a"),
        lambda robot: shockpc.configuration(5),
        lambda robot: shockpc.configuration(robot, 5),
        lambda robot: shockpc.configuration(robot, joints=[1]),
        lambda robot: shockpc.configuration(robot, joints={5: 1.0}),
        lambda robot: shockpc.configuration_from_mujoco(5, [0.0]),
        lambda robot: shockpc.limits(
            SCENE, "FL_calf_joint", "shock@imu", 0.1, joint_range=np.array(1.0)
        ),
    ],
)
def test_arguments_of_other_functions_are_checked_too(call):
    with pytest.raises(shockpc.StudyError, match="has to be"):
        call(shockpc.load_robot("go2"))


def test_a_range_is_refused_by_its_own_numbers():
    with pytest.raises(shockpc.StudyError, match="joint_range must be finite, got nan"):
        shockpc.limits(SCENE, "FL_calf_joint", "shock@imu", 0.1, joint_range=(np.nan, 1.0))


def test_arrays_and_paths_are_arguments_too(tmp_path):
    """As texts and sequences are: arrays of two numbers, or without an axis."""
    robot = shockpc.load_robot("go2", packages={"a": tmp_path})
    q = shockpc.configuration(robot, joints={"FL_calf_joint": np.array(-1.4)}, base=np.zeros(3))
    assert robot.joint("FL_calf_joint").value(q) == -1.4
    ends = np.array([-1.5, -1.4])
    limits = shockpc.limits(
        SCENE, "FL_calf_joint", "shock@imu", 0.1, joint_range=ends, strikes=np.zeros(2), step=0.05
    )
    assert limits.range == (-1.5, -1.4)
    assert limits.strikes == (0.0, 0.0)


def test_cells_without_a_number_are_named():
    """None is an empty cell; any other object is shown."""
    columns = {"FL_calf_joint": [-1.4, None, object()], "vz": [-1.0, -1.0, -1.0]}
    messages = shockpc.recorded(columns, SCENE).table.messages
    assert messages[1] == "column FL_calf_joint is empty"
    assert "is not a finite number" in messages[2]


def test_quantities_of_a_profile_that_do_not_exist_are_named():
    with pytest.raises(shockpc.UnknownName, match=r'no quantity "point.shok"'):
        shockpc.shock_profile(SCENE).value("shok", "point")


def test_places_of_an_unknown_kind_are_refused():
    with pytest.raises(shockpc.UnknownName, match='no kind of place "pint"; nearest: "point"'):
        shockpc.shock_profile(SCENE).places("pint")
