"""The output of a batch: table, Markdown, CSV, JSON (schema `shockpc.batch/1`), and the files of a folder."""

import json
from typing import Any

import shockpc
from shockpc.model.dynamics import PINOCCHIO
from shockpc.printed import printable
from shockpc.scene import scene_table
from shockpc.show.document import plain
from shockpc.show.tables.batch import batch_sheet, failure_lines
from shockpc.show.tables.text import as_csv, as_markdown, as_text, markdown_list
from shockpc.studies.batch import Batch

__all__ = ["SCHEMA", "batch_document", "batch_files", "batch_text"]

SCHEMA = "shockpc.batch/1"

ROW = (
    "robot",
    "contact",
    "mass",
    "trunk",
    "ropc",
    "shock_max",
    "shock_com",
    "shock_free",
    "shock_locked",
    "joint_model",
    "sensors",
    "effective_mass",
    "friction_needed",
    "error_bound",
    "warnings",
)


def batch_text(batch: Batch, format_: str) -> str:
    """What goes to standard output. Args: format_, "table", "markdown", "csv" or "json"."""
    if format_ == "json":
        return json.dumps(batch_document(batch), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    if format_ == "csv":
        return as_csv(batch_sheet(batch, fold=False))
    if format_ == "markdown":
        return _report(batch)
    failed = [f"not computed: {printable(line)}" for line in failure_lines(batch)]
    return "\n".join([as_text(batch_sheet(batch)), *failed]) + ("\n" if failed else "")


def batch_document(batch: Batch) -> dict[str, Any]:
    """The batch as JSON; `null` where a number does not exist or is infinite."""
    return {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        "rows": [{**{key: plain(getattr(row, key)) for key in ROW}, "scene": scene_table(row.scene)} for row in batch.rows],
        "failures": [{"robot": one.robot, "contact": one.contact, "reason": one.reason} for one in batch.failures],
    }


def batch_files(batch: Batch) -> dict[str, str | bytes]:
    """The files of a batch by name; the contact sheet where the batch has pictures."""
    files: dict[str, str | bytes] = {f"batch.{suffix}": batch_text(batch, suffix) for suffix in ("csv", "json")}
    figure = None
    if any(row.picture is not None for row in batch.rows):
        from shockpc.show.figure.contact_sheet import contact_sheet

        files |= contact_sheet(batch)
        figure = "sheet.svg"
    return files | {"report.md": _report(batch, figure)}


def _report(batch: Batch, figure: str | None = None) -> str:
    """The batch as Markdown, with the warnings of its landings."""
    blocks = [as_markdown(batch_sheet(batch))]
    if figure is not None:
        blocks.append(f"![the landings, the greatest shock of the trunk first]({figure})\n")
    if batch.failures:
        blocks.append("### Not computed\n\n" + markdown_list(failure_lines(batch)))
    warned = dict.fromkeys(f"{row.robot}: {warning}" for row in batch.rows for warning in row.warnings)
    if warned:
        blocks.append("### Warnings\n\n" + markdown_list(warned))
    return "\n".join(blocks)
