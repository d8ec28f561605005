"""Tables of landings as tables of other libraries: the same columns, and nothing where there is no
number or no message.
"""

import numpy as np
import pytest
from identify_draws import BLOCKS, blocks
from robot_texts import STEPPER

import shockpc
from shockpc import Design, Scene, load_robot
from shockpc.evaluation.budgets import read_budgets
from shockpc.evaluation.table import Table

COLUMNS = {
    "contact": np.array(["LF_FOOT", "LF_FOOT", "LH_FOOT"]),
    "row": np.array([3, 5, 8]),
    "shock@imu_link": np.array([0.125, np.nan, 2.0]),
    "proven": np.array([True, False, False]),
}


@pytest.fixture
def table():
    return Table((), COLUMNS, {1: "no impact"})


def test_arrow_has_nulls_where_a_number_or_a_message_is_missing(table):
    assert table.to_arrow().to_pydict() == {
        "contact": ["LF_FOOT", "LF_FOOT", "LH_FOOT"],
        "row": [3, 5, 8],
        "shock@imu_link": [0.125, None, 2.0],
        "proven": [True, False, False],
        "message": [None, "no impact", None],
    }


def test_the_interchange_protocol_gives_the_same_table(table):
    """As pandas, polars and others read it; here by pyarrow, column by column."""
    from pyarrow.interchange import from_dataframe

    frame = table.__dataframe__()
    assert (frame.num_rows(), list(frame.column_names())) == (3, [*COLUMNS, "message"])
    assert [frame.get_column_by_name(name).null_count for name in frame.column_names()] == [
        0,
        0,
        1,
        0,
        2,
    ]
    assert from_dataframe(table).to_pydict() == table.to_arrow().to_pydict()


def test_arrow_streams_give_the_same_table(table):
    """As polars, pandas and DuckDB read it; here by pyarrow."""
    import pyarrow

    assert pyarrow.table(table).to_pydict() == table.to_arrow().to_pydict()


def test_pandas_has_the_columns(table):
    import pandas

    frame = table.to_pandas()
    assert list(frame.columns) == [*COLUMNS, "message"]
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(frame[name].to_numpy(), values)
    assert frame["message"].notna().tolist() == [False, True, False]
    assert frame["message"][1] == "no impact"
    assert pandas.api.types.is_float_dtype(frame["shock@imu_link"])


def test_polars_has_the_columns(table):
    import polars

    frame = table.to_polars()
    assert frame.columns == [*COLUMNS, "message"]
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(frame[name].to_numpy(), values)
    assert frame["message"].to_list() == [None, "no impact", None]
    assert frame.schema["shock@imu_link"] == polars.Float64


FOOT = Scene(robot="anymal_b", contact="LF_FOOT")
TOSSED = Scene(robot=str(BLOCKS), contact="elbow_1_corner_1")
BUDGETS = """
[[case]]
name = "drop"
robot = "anymal_b"
contact = "LF_FOOT"
[[budget]]
case = "drop"
at = "imu_link"
metric = "shock"
max = 0.5
"""


def checked(folder):
    (folder / "budgets.toml").write_text(BUDGETS)
    return shockpc.check_budgets(read_budgets(folder / "budgets.toml"))


def fallen(folder):
    """Touchdown of a body on a leg, in a log of the positions of its legs."""
    time = np.arange(0.0, 0.5, 1e-3)
    z = 0.6 - 0.1 * time
    columns = {"time": time, "z": z, "qw": np.ones(len(time))} | dict.fromkeys(
        ("x", "y", "qx", "qy", "qz"), np.zeros(len(time))
    )
    legs = {f"{side}_leg": np.maximum(0.2 - time, 0.0) + 0.5 - z for side in ("left", "right")}
    (folder / "stepper.urdf").write_text(STEPPER)
    return shockpc.touchdowns(
        columns | legs,
        Scene(robot=str(folder / "stepper.urdf"), contact=("left_foot", "right_foot")),
    )


STUDIES = {
    "batch": (
        lambda _: shockpc.batch(["anymal_b"]),
        lambda found: len(found.rows),
        {"shock_max": "-"},
    ),
    "check_budgets": (
        checked,
        lambda found: len(found.outcomes),
        {"strike_angle_deg": "deg", "value": ""},
    ),
    "compare": (
        lambda _: shockpc.compare(
            [Design("a", FOOT, load_robot("anymal_b"))], changes=["mass:LF_SHANK=0.9x"]
        ),
        lambda found: sum(len(one.rows) for one in found.quantities),
        {"quantity": "", "A": ""},
    ),
    "fall": (
        lambda _: shockpc.fall(Scene(robot=str(BLOCKS)), drop=0.5, attitudes=2),
        lambda found: len(found.results) + len(found.failures),
        {"rotation": "deg", "speed": "m/s", "energy": "J", "struck": ""},
    ),
    "identify": (
        lambda _: shockpc.identify(
            blocks(np.random.default_rng(0), 8), TOSSED, {"friction": "0:1.5"}
        ),
        lambda found: len(found.unknowns),
        {"unknown": "", "value": ""},
    ),
    "improve": (
        lambda _: shockpc.improve(
            FOOT, "shock@imu_link", vary={"LF_KFE": "-80:-60"}, any_ground=True, starts=0
        ),
        lambda found: len(found.variables),
        {"variable": ""},
    ),
    "recorded": (
        lambda _: shockpc.recorded({"q_LF_KFE": [-1.0, -1.2]}, FOOT, ["shock@imu_link"]),
        lambda found: 2,
        {"shock@imu_link": "-"},
    ),
    "limits": (
        lambda _: shockpc.limits(
            FOOT, "LF_KFE", "shock@imu_link", 0.1, joint_range=(-1.5, -1.0), step=0.02
        ),
        lambda found: sum(len(one.intervals) or 1 for one in found.limits),
        {"low [deg]": "deg", "strike from [deg]": "deg", "low end": ""},
    ),
    "place": (
        lambda _: shockpc.place(
            {"down": FOOT, "slanted": Scene(robot="anymal_b", contact="RH_FOOT")}
        ),
        lambda found: len(found.today) + len(found.places),
        {"x [m]": "m", "maximum shock [-]": "-", "in landing": ""},
    ),
    "sensitivity": (
        lambda _: shockpc.sensitivity(FOOT, "shock@imu_link"),
        lambda found: len(found.effects),
        {"parameter": "", "shock [-]": "-"},
    ),
    "sweep": (
        lambda _: shockpc.sweep(FOOT, {"strike-angle": "0,10,20"}, quantities=["ropc@base"]),
        lambda found: 3,
        {"strike-angle [deg]": "deg", "ropc@base": "m"},
    ),
    "touchdowns": (
        fallen,
        lambda found: 1,
        {"time": "s", "q_left_leg": "m", "before_left_leg": "m/s", "contact": ""},
    ),
}


def test_every_study_is_among_these():
    declared = {
        name
        for name in shockpc.__all__
        if "study" in getattr(getattr(shockpc, name), "__dict__", {})
    }
    # the result of an export is code
    assert STUDIES.keys() == declared - {"export"} | {"check_budgets"}


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("name", STUDIES)
def test_every_study_has_a_table_with_units(name, tmp_path):
    compute, rows, units = STUDIES[name]
    found = compute(tmp_path)
    table = found.table
    assert isinstance(table, Table)
    assert len(table) == rows(found) > 0
    assert table.units.keys() == table.columns.keys()
    assert {heading: table.units[heading] for heading in units} == units
    assert {len(values) for values in table.columns.values()} == {len(table)}
    # A notebook shows the study as its report, and its table.
    assert all("<table>" in one._repr_html_() for one in (found, table))
    arrow = table.to_arrow().to_pydict()
    for heading, values in table.columns.items():
        assert [cell is None for cell in arrow[heading]] == [
            cell is None or cell != cell for cell in values.tolist()
        ]
    import pandas

    frame = table.to_pandas()
    assert list(frame.columns) == [*table.columns, "message"]
    for heading, values in table.columns.items():
        missing = pandas.isna(frame[heading]).to_numpy()
        np.testing.assert_array_equal(
            missing, [cell is None or cell != cell for cell in values.tolist()]
        )
        assert frame[heading].to_numpy()[~missing].tolist() == values[~missing].tolist()
    assert frame.attrs["units"] == table.units
    assert frame.attrs["titles"].keys() == {column.name for column in table.computed}


def test_tables_of_batches_and_falls_are_ranked_by_their_quantities():
    """Their columns are of the worst place of each row, so that a heading is a quantity without a
    place.
    """
    batch = shockpc.batch(["anymal_b", "nosuch"])
    table = batch.table
    assert [table.columns["contact"][i] for i in table.worst(len(batch.rows), "shock")] == [
        row.contact for row in batch.rows
    ]
    assert table.ranked("shock_max")[-1] == len(batch.rows)  # the robot that is none
    assert (
        np.diff(table.values("effective_mass_sticking")[table.worst(4, "effective_mass_sticking")])
        <= 0.0
    ).all()
    falls = shockpc.fall(Scene(robot=str(BLOCKS)), drop=0.5, attitudes=4)
    assert falls.table.values("delta_v_max")[falls.table.worst(4, "delta_v_max")].tolist() == [
        one.values["delta_v_max"] for one in falls.results
    ]


@pytest.mark.parametrize(
    "call",
    [
        lambda table: table.worst("a"),
        lambda table: table.worst(2.5),
        lambda table: table.ranked(3),
        lambda table: table.ranked("name"),
        lambda table: table.column(None),
        lambda table: table.values("nosuch"),
        lambda table: table.percentile("shock@imu_link", 200.0),
        lambda table: table.percentile("shock@imu_link", np.nan),
        lambda table: table.percentile("shock@imu_link", "a"),
        lambda table: table.percentile("name", 50.0),
    ],
)
def test_what_a_table_does_not_have_is_refused(call):
    table = shockpc.recorded(
        {"q_LF_KFE": [-1.0, -1.2], "name": ["a", "b"]}, FOOT, ["shock@imu_link"]
    ).table
    assert table.worst(-1, "shock@imu_link") == []
    with pytest.raises(shockpc.StudyError):
        call(Table(table.computed, {**table.columns, "name": np.array(["a", "b"])}, {}))
