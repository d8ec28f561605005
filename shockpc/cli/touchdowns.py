"""`shockpc touchdowns`: from a log to the table of its landings."""

import dataclasses
from pathlib import Path
from typing import Any

from shockpc.cli.declare import argument, command
from shockpc.cli.options import ROBOT, OutputOptions, SceneOptions
from shockpc.cli.output import emit
from shockpc.cli.parse import path
from shockpc.cli.scenes import scenes_from
from shockpc.cli.study import asked, given, help_of
from shockpc.show.reports.touchdowns import touchdowns_report
from shockpc.studies.touchdowns import touchdowns as study


@command(**help_of(study))
def touchdowns(
    *,
    log: Path = argument("A time series: .csv, .parquet, .npz, .bag, .mcap, .db3, or the folder of a bag.", "LOG", path),
    robot: str = ROBOT,
    typed: Any = asked(study),
    options: SceneOptions,
    output: OutputOptions,
) -> None:
    loaded, scenes = scenes_from(robot, options)
    contacts = {contact.frame: contact for scene in scenes for contact in scene.contact}
    scene = dataclasses.replace(scenes[0], contact=tuple(contacts.values()))
    emit(touchdowns_report(str(log), study(log, scene, robot=loaded, **given(study, typed))), output)
