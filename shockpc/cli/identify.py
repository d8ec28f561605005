"""`shockpc identify`: what measured landings say about drives, friction, restitution, stiffness and masses."""

import datetime
from pathlib import Path
from typing import Any

from shockpc.cli.declare import argument, command
from shockpc.cli.options import ROBOT, OutputOptions, SceneOptions
from shockpc.cli.output import emit
from shockpc.cli.parse import path
from shockpc.cli.scenes import table_and_scene
from shockpc.cli.study import asked, given, help_of
from shockpc.show.reports.identify import identify_report
from shockpc.studies.identify import identify as study


@command(**help_of(study))
def identify(
    *,
    table: Path = argument("A table of landings: .csv, .parquet or .npz.", "TABLE", path, default=...),
    robot: str = ROBOT,
    typed: Any = asked(study),
    options: SceneOptions,
    output: OutputOptions,
) -> None:
    columns, loaded, scene = table_and_scene(table, robot, options)
    found = study(columns, scene, robot=loaded, **given(study, typed))
    emit(identify_report(found, table.name, datetime.date.today().isoformat(), output.out or Path.cwd()), output)
