"""`shockpc identify`: what measured landings say about drives, friction, restitution, stiffness and masses."""

import datetime
from pathlib import Path
from typing import Any

import numpy as np

from shockpc.cli.declare import argument, command
from shockpc.cli.options import ROBOT, OutputOptions, SceneOptions
from shockpc.cli.output import emit
from shockpc.cli.parse import path
from shockpc.cli.scenes import one_scene, with_contact
from shockpc.cli.study import asked, given, help_of
from shockpc.evaluation.table_files import read_table
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
    columns = read_table(table)
    if "contact" in columns:
        options, contacts = with_contact(robot, options, columns["contact"].astype(str).ravel().tolist())
        columns["contact"] = np.reshape(contacts, columns["contact"].shape)
    loaded, scene = one_scene(robot, options)
    found = study(columns, scene, robot=loaded, **given(study, typed))
    emit(identify_report(found, table.name, datetime.date.today().isoformat(), output.out or Path.cwd()), output)
