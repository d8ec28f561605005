"""A log as the file that a command reads."""

import csv


def written(path, columns):
    """Columns of a table or log as CSV; the path."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    return path
