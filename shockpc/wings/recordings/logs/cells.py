"""Cells of a table of recorded landings as numbers, and why a row is no landing."""

from collections.abc import Callable
from numbers import Real
from typing import Any

import numpy as np

from shockpc.core.number import NUMERIC
from shockpc.core.spatial import Array
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.logs.table_files import number

UNIT_LENGTH = 1e-3
"""Largest deviation of a quaternion's length from 1."""

EMPTY = " (as an empty cell, or a row with too few or too many, is read)"


class RowMessages(dict[int, str]):
    """Reasons why rows are no landings, by number of the row; the first reason of a row counts."""

    def refuse(self, wrong: np.ndarray, text: Callable[[int], str]) -> None:
        """Refuse some rows.

        Args: wrong, (n,) which ones; text, the reason of a row by its number.
        """
        for i in np.flatnonzero(wrong).tolist():
            self.setdefault(i, text(i))


def empty_cells(cells: np.ndarray) -> np.ndarray:
    """Mask of the cells that are empty, or say that they hold no number."""
    if cells.dtype.kind not in "UO":
        return np.asarray(np.isnan(cells.astype(float)))
    texts = np.array(
        [
            cell.strip().casefold() if isinstance(cell, str) else ""
            for cell in cells.ravel().tolist()
        ]
    )
    return np.isin(texts, ("", "nan", "none", "null", "na", "n/a")).reshape(cells.shape)


def numbers(
    name: str, values: np.ndarray, messages: RowMessages, missing: bool = False, advice: str = ""
) -> Array:
    """A column of numbers, (n,) or (n, k); zero where there is none, and a row therefore refused.

    Args:
        name: of the column.
        values: its cells.
        messages: get the rows that are refused.
        missing: whether a cell may be empty or NaN, and then is NaN.
        advice: what to do about an empty cell, for its message.

    Raises:
        StudyError: the column holds dates, or complex numbers.
    """
    if values.dtype.kind not in (*NUMERIC, "U", "O"):
        raise StudyError(f"column {name} has to hold numbers")
    found = (
        np.array([_number(cell) for cell in values.ravel().tolist()])
        if values.dtype.kind in "UO"
        else values.astype(float)
    )
    found, cells = found.reshape(len(values), -1), values.reshape(len(values), -1)
    # An empty cell that may be missing is known to be NaN; infinity never is a number here.
    known = np.isfinite(found) | (np.isnan(found) & empty_cells(cells) if missing else False)

    # A message is written only for rows that are refused.
    def reason(i: int) -> str:
        cell = cells[i, int(np.argmin(known[i]))]
        if isinstance(cell, str):
            return (
                f'column {name}: "{cell}" is not a number'
                if cell
                else f"column {name} is empty{advice}"
            )
        if cell is None:
            return f"column {name} is empty{advice}"
        no_number = (cells.dtype.kind != "O" or isinstance(cell, float)) and bool(np.isnan(cell))
        return (
            f"column {name}: {cell} is not a finite number{EMPTY * no_number}{advice * no_number}"
        )

    messages.refuse(~known.all(axis=1), reason)
    # Such a number is a mistake in any unit.
    far = np.abs(found) > LARGEST_NUMBER
    messages.refuse(
        (known & far).any(axis=1),
        lambda i: (
            f"column {name}: {np.abs(found[i]).max():g} is beyond {LARGEST_NUMBER:g}, whatever the "
            f"unit"
        ),
    )
    return np.asarray(np.where(known & ~far, found, 0.0).reshape(values.shape))


def _number(cell: Any) -> float:
    """The number in a cell; NaN where there is none."""
    try:
        if isinstance(cell, str):
            return number(cell)
        return float(cell) if isinstance(cell, Real) else np.nan
    except ValueError:
        return np.nan


def unit_quaternions(what: str, quaternions: Array, messages: RowMessages) -> Array:
    """Quaternions (n, 4) of length 1; where one is none, the row is refused.

    Args: what, their name in messages.
    """
    length = np.linalg.norm(quaternions, axis=1)
    wrong = np.abs(length - 1.0) > UNIT_LENGTH
    messages.refuse(
        wrong, lambda i: f"{what} has length {length[i]:.6g}; a rotation's quaternion has length 1"
    )
    return np.where(
        wrong[:, None],
        np.array([0.0, 0.0, 0.0, 1.0]),
        quaternions / np.where(wrong, 1.0, length)[:, None],
    )
