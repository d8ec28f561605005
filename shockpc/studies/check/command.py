"""`shockpc check`: compare landings with budgets, for continuous integration."""

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import typer

from shockpc.cli.declared import argument, command, group
from shockpc.cli.options import in_output
from shockpc.cli.parse import out_folder, path, writable
from shockpc.cli.process import print_error

FORMATS = ("table", "json", "csv", "markdown", "junit", "github")
DOCUMENTS = ("json", "csv", "markdown", "junit")
"""Formats that stand alone on standard output."""

_in_baseline = group("Baseline")

EPILOG = """\b
A file of budgets; in a pyproject.toml its tables are [[tool.shockpc.case]]
and [[tool.shockpc.budget]]:
  baseline = "base.json"          # earlier numbers; --baseline replaces it

\b
  [[case]]
  name = "land-front"
  scene = "landing.toml"          # any key of a scene, such as robot, posture
                                  # or [[case.contact]], replaces the file's
  strike_angle_deg = [0, 15, 30]  # a landing for each

\b
  [[case.vary]]                   # what is not known of the design
  each = "mass:*"                 # or quantity = ..., with one value for all
  values = "±5%"                  # as sweep --vary with --sample takes it

\b
  [[budget]]
  case = "*"                      # name or glob
  at = "imu_link"                 # name or glob of points, bodies, joints or
                                  # contacts; FRAME:x,y,z is a point
  metric = "shock"                # any that shockpc quantities lists
  max = 0.25                      # or min
  baseline_tolerance = "5%"       # how much worse than in the baseline; with
                                  # or without max and min
  severity = "error"              # or "warning", with which the check passes

\b
  [[budget]]
  metric = "shock"
  max = 0.3
  percentile = 95                 # met in 95 % of the case's 1000 random
                                  # designs; designs = N in [[case]] for more

For analyze and other commands, budgets.toml:land-front is the landing of that
case, at the first of its strike angles.

\b
Where a metric is of points, such as shock or peak_g, the name of a body
means its centre of mass. Of a vector the length is taken; delta_v.z is a
component. A number that may be of either sign needs both min and max, and
with only a baseline_tolerance may change in neither direction.

\b
Exit codes: 0 all budgets are met, 1 one of severity error is exceeded,
2 bad arguments or files, 3 a number has no solution, or a budget is
undecided: drives that are not known decide whether it is met.
"""
"""The text under the help of the command."""


def report(text: str) -> tuple[str, Path | None]:
    """FORMAT or FORMAT=FILE; None is standard output."""
    format_, equals, file = text.partition("=")
    if format_ not in FORMATS:
        known = f"valid are {', '.join(FORMATS)}, each also with a file, such as junit=report.xml"
        raise typer.BadParameter(f'"{text}" is not a format; {known}')
    return format_, writable(path(file), "--format") if equals else None


@command(
    examples=("shockpc check budgets.toml --format table --format junit=shock.xml",),
    after=EPILOG,
)
def check(
    *,
    budgets: Path | None = argument(
        "A file of budgets (TOML). [default: budgets.toml here, or tool.shockpc in the "
        "pyproject.toml]",
        "BUDGETS",
        path,
    ),
    baseline: Path | None = _in_baseline(
        "Numbers of an earlier design, to compare with. [default: as the budgets' file names it]",
        "FILE",
        path,
    ),
    update_baseline: bool = _in_baseline(
        "Write the numbers into the baseline's file instead of comparing with it."
    ),
    format_: tuple[tuple[str, Path | None], ...] = in_output(
        "Report: table (default), json, csv, markdown, junit or github (annotations, and a table "
        "in the job's summary); on standard output, or in a file.",
        "FORMAT[=FILE]",
        report,
    ),
    out: Path | None = in_output(
        "Write JSON, CSV, JUnit, Markdown and report.html into this folder.", "DIR", out_folder
    ),
) -> int:
    from shockpc.cli.output import exit_code, write_report
    from shockpc.cli.progress import progress
    from shockpc.evaluation.budgets import budgets_file, read_budgets
    from shockpc.show.files import write_file
    from shockpc.studies.check.baseline import baseline_text
    from shockpc.studies.check.job_summary import append_summary
    from shockpc.studies.check.report import check_report
    from shockpc.studies.check.study import check_budgets
    from shockpc.text.errors import StudyError

    formats = format_ or (("table", None),)
    _refuse_two_documents([name for name, file in formats if file is None])
    to_check = read_budgets(budgets or budgets_file(Path.cwd()))
    baseline = baseline or to_check.baseline
    if update_baseline and baseline is None:
        raise StudyError(
            "--update-baseline needs the file to write; name it with --baseline, such as "
            "--baseline base.json"
        )
    renewed = None
    if update_baseline and baseline is not None:
        renewed, baseline = writable(baseline, "--baseline"), None
    checked = check_budgets(
        to_check, baseline, update_baseline, partial(progress, "landings computed")
    )
    written = [file for _, file in formats if file is not None]
    if renewed is not None:
        written.append(renewed)
    _refuse_twice(written)

    result = check_report(checked)
    if out is not None:
        # before the files, which could replace a mesh that the page has yet to read
        write_report(result, out)
    for name, file in formats:
        if name == "github":
            append_summary(checked)
        if file is None:
            sys.stdout.write(result.text(name))
        else:
            write_file(file, result.text(name))
    if renewed is not None:
        if checked.count("not computed"):
            print_error(f'"{renewed}" is not changed, because a number could not be computed')
        else:
            write_file(renewed, baseline_text(checked.cases, checked.values))
    return exit_code(0, 0, False, checked.defects) or checked.exit_code


def _refuse_two_documents(printed: Sequence[str]) -> None:
    """Refuse several formats on standard output of which one stands alone there."""
    from shockpc.text.errors import OutputError

    if len(printed) > 1 and any(name in DOCUMENTS for name in printed):
        raise OutputError(
            f"standard output holds one document, not {' and '.join(printed)}; write files, such "
            f"as --format {printed[0]}=FILE"
        )


def _refuse_twice(files: Sequence[Path]) -> None:
    """Refuse to write one file twice."""
    from shockpc.show.files import destination
    from shockpc.text.errors import OutputError

    targets = set()
    for file in files:
        target = destination(file)
        if target in targets:
            raise OutputError(f'"{target}" would be written twice; name another file')
        targets.add(target)
