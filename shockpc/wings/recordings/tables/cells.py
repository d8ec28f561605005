"""Cells of a table of recorded landings as numbers, and why a row is no landing."""

from collections.abc import Callable
from numbers import Real
from typing import Any

import numpy as np

from shockpc.core.number import NUMERIC
from shockpc.core.spatial import Array
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.tables.table_files import parsed_number

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
    texts = []
    for cell in cells.ravel().tolist():
        texts.append(cell.strip().casefold() if isinstance(cell, str) else "")
    return np.isin(texts, ("", "nan", "none", "null", "na", "n/a")).reshape(cells.shape)


def numeric_column(
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
    cells = values.reshape(len(values), -1)
    if values.dtype.kind in "UO":
        numbers = np.array([_number(cell) for cell in values.ravel().tolist()])
    else:
        numbers = values.astype(float)
    numbers = numbers.reshape(cells.shape)
    # An empty cell that may be missing is known to be NaN; infinity never is a number here.
    known = np.isfinite(numbers)
    if missing:
        known |= np.isnan(numbers) & empty_cells(cells)
    # A message is written only for rows that are refused.
    messages.refuse(
        ~known.all(axis=1),
        lambda i: f"column {name}{_no_number(cells[i, int(np.argmin(known[i]))], advice)}",
    )
    # Such a number is a mistake in any unit.
    far = np.abs(numbers) > LARGEST_NUMBER
    messages.refuse(
        (known & far).any(axis=1),
        lambda i: (
            f"column {name}: {np.abs(numbers[i]).max():g} is beyond {LARGEST_NUMBER:g}, whatever "
            f"the unit"
        ),
    )
    return np.asarray(np.where(known & ~far, numbers, 0.0).reshape(values.shape))


def _no_number(cell: Any, advice: str) -> str:
    """The end of the message about a cell without a number.

    Args: advice, what to do about an empty cell.
    """
    if cell is None or (isinstance(cell, str) and not cell):
        return f" is empty{advice}"
    if isinstance(cell, str):
        return f': "{cell}" is not a number'
    text = f": {cell} is not a finite number"
    if isinstance(cell, float | np.floating) and np.isnan(cell):
        text += EMPTY + advice
    return text


def _number(cell: Any) -> float:
    """The number in a cell; NaN where there is none."""
    try:
        if isinstance(cell, str):
            return parsed_number(cell)
        return float(cell) if isinstance(cell, Real) else np.nan
    except ValueError:
        return np.nan


def unit_quaternions(name: str, quaternions: Array, messages: RowMessages) -> Array:
    """Quaternions (n, 4) of length 1; where one is none, the row is refused.

    Args: name, theirs in messages.
    """
    length = np.linalg.norm(quaternions, axis=1)
    wrong = np.abs(length - 1.0) > UNIT_LENGTH
    messages.refuse(
        wrong, lambda i: f"{name} has length {length[i]:.6g}; a rotation's quaternion has length 1"
    )
    return np.where(
        wrong[:, None],
        np.array([0.0, 0.0, 0.0, 1.0]),
        quaternions / np.where(wrong, 1.0, length)[:, None],
    )
