"""Headings of logs."""

import itertools
import time

import numpy as np

from shockpc.wings.recordings.tables.column_meaning import named_columns


def test_the_time_of_a_heading_is_linear_in_its_length():
    """A heading of 200 kB that repeats a part of those of ROS is read in a moment; the square of
    its length would take minutes.
    """
    start = time.process_time()
    for part, end in itertools.product(
        ("joint_states/", "joint_state/", "pose/orientation/", "pose/"),
        ("/position", "/x", "velocity/x"),
    ):
        heading = part * (200_000 // len(part)) + end
        assert len(named_columns({heading: np.zeros(1)}, {})) == 1
    assert time.process_time() - start < 2.0
