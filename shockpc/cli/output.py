"""The output of a command: standard output, files, scenes."""

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from shockpc.cli.options import OutputOptions
from shockpc.cli.process import command, print_error
from shockpc.cli.progress import shown_trace
from shockpc.cli.scenes import file_names
from shockpc.landing.scenes.scene import Scene
from shockpc.show.files import destination, write_file
from shockpc.text.errors import DefectError, OutputError, SolveError
from shockpc.text.printed import visible

if TYPE_CHECKING:
    from shockpc.show.report import Report

RUN = {"--out": True, "--jobs": True, "--cluster": True, "--resume": False, "--wait": False}
"""Options that say how results are computed and where they are written, which do not change them;
and whether a value follows.
"""

SCENE = "scene file"


def scene_files(scenes: list[Scene], path: Path, force: bool) -> list[Path]:
    """The files that --save-scene writes.

    It is the file itself for one landing, else a file each, named after the contact.

    Raises:
        OutputError: one of them is there already and may not be replaced, or none can be written
            there.
    """
    files = [path]
    if len(scenes) != 1:
        files = [path.with_stem(f"{path.stem}.{name}") for name in file_names(scenes)]
    present = [file for file in files if os.path.lexists(file)]
    if present and not force:
        raise OutputError(
            f'"{present[0]}" exists already; replace it with --force, or name another file with '
            f"--save-scene"
        )
    for file in files:
        destination(file, SCENE)
    return files


def exit_code(failed: int, rows: int, strict: bool, defects: Sequence[str] = ()) -> int:
    """The exit code of a study of many landings, after its results are given.

    The number that failed is printed on standard error.

    Args:
        failed: number of landings that could not be computed.
        rows: number of all.
        strict: whether one that failed is no verdict for the whole.
        defects: descriptions of unexpected exceptions, which are errors in shockpc itself.
    """
    if defects:
        sys.stderr.write(visible("".join(dict.fromkeys(defects)), "\n"))
        print_error(
            "this is an error in shockpc itself, not in your input; please report the lines above"
        )
        return DefectError.exit_code
    if failed:
        print_error(f"{failed} of {rows} landings could not be computed; the results name them")
    return SolveError.exit_code if failed and (strict or failed == rows) else 0


def emit(
    report: "Report", output: OutputOptions, scenes: Mapping[Path, str] = MappingProxyType({})
) -> None:
    """Write the files of a report into a folder, if one is asked for, and print it.

    What CSV cannot hold is printed on standard error.

    Args:
        report: what is printed. Where it has no verdict, nothing is written.
        output: where and how.
        scenes: texts of scene files by path, of `scene_files`, which are written too.

    Raises:
        OutputError: PDF is asked for without a folder or of a result without a figure, or a file
            cannot be written.
    """
    pdf = output.format == "pdf"
    if pdf and not report.has_figures():
        raise OutputError("this result has no figure to write as PDF; leave --format pdf out")
    if pdf and output.out is None:
        raise OutputError("--format pdf writes figures into a folder; name it with --out DIR")
    text = report.text("table" if pdf else output.format)
    if output.out is not None:
        write_report(report, output.out, pdf)
    for file, content in scenes.items():
        write_file(file, content, replaceable=SCENE)
    sys.stdout.write(text)
    if output.format == "csv":
        warnings: dict[str, None] = {}
        for part in (*report.parts.values(), report):
            warnings |= dict.fromkeys(part.warnings)
        for warning in warnings:
            print_error(warning)


def write_report(report: "Report", folder: Path, pdf: bool = False) -> None:
    """Write the files of a report; a line on standard error says what report.html would need.

    Args:
        report: the result.
        folder: for the files.
        pdf: whether its figures are written as PDF too.
    """
    from shockpc.show.figure import leave_out_documentation

    leave_out_documentation()
    from shockpc.show.folder import write_report_folder
    from shockpc.show.html import INSTALL, plotly

    with shown_trace().stage("figures and files"):
        write_report_folder(folder, report, _command(), print_error, pdf)
    if report.landings and plotly() is None:
        print_error(INSTALL)


def _command() -> str:
    """The command line of the results, the same after an interruption."""
    import shlex

    words, shown = iter(command), list[str]()
    for word in words:
        name, equals, _ = word.partition("=")
        if name not in RUN:
            shown.append(word)
        elif RUN[name] and not equals:
            next(words)
    return shlex.join(shown)
