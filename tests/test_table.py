"""Tables of landings as tables of other libraries: the same columns, and nothing where there is no number or no message."""

import numpy as np
import pytest

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
    pytest.importorskip("pyarrow")
    assert table.to_arrow().to_pydict() == {
        "contact": ["LF_FOOT", "LF_FOOT", "LH_FOOT"],
        "row": [3, 5, 8],
        "shock@imu_link": [0.125, None, 2.0],
        "proven": [True, False, False],
        "message": [None, "no impact", None],
    }


def test_the_interchange_protocol_gives_the_same_table(table):
    """As pandas, polars and others read it; here by pyarrow, column by column."""
    pytest.importorskip("pyarrow")
    from pyarrow.interchange import from_dataframe

    frame = table.__dataframe__()
    assert (frame.num_rows(), list(frame.column_names())) == (3, [*COLUMNS, "message"])
    assert [frame.get_column_by_name(name).null_count for name in frame.column_names()] == [0, 0, 1, 0, 2]
    assert from_dataframe(table).to_pydict() == table.to_arrow().to_pydict()


def test_pandas_has_the_columns(table):
    pandas = pytest.importorskip("pandas")
    frame = table.to_pandas()
    assert list(frame.columns) == [*COLUMNS, "message"]
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(frame[name].to_numpy(), values)
    assert frame["message"].notna().tolist() == [False, True, False]
    assert frame["message"][1] == "no impact"
    assert pandas.api.types.is_float_dtype(frame["shock@imu_link"])


def test_polars_has_the_columns(table):
    polars = pytest.importorskip("polars")
    frame = table.to_polars()
    assert frame.columns == [*COLUMNS, "message"]
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(frame[name].to_numpy(), values)
    assert frame["message"].to_list() == [None, "no impact", None]
    assert frame.schema["shock@imu_link"] == polars.Float64
