"""Inputs of the studies of recordings: a table of landings, or a log."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from shockpc.cli.declared import argument
from shockpc.cli.options import ROBOT, SceneOptions
from shockpc.cli.parse import path
from shockpc.cli.scenes import scenes_from
from shockpc.cli.study_inputs import CommandLine, Input
from shockpc.landing.scenes.scene import Contact
from shockpc.robot.robot import Robot
from shockpc.wings.recordings.recorded_table import refuse_overridden, table_and_scene
from shockpc.wings.recordings.tables.column_meaning import StateColumns

_LOG = "A time series: .csv, .parquet, .npz, .bag, .mcap, .db3, or the folder of a bag."
_TABLE = "A table of landings: .csv, .parquet or .npz."


def _table(line: CommandLine) -> tuple[Robot, dict[str, Any]]:
    file, robot_or_scene = line.inputs
    rename = dict(line.study["rename"] or ())
    columns, robot, scene = table_and_scene(file, robot_or_scene, line.options, rename)
    return robot, {"table": columns, "scene": scene, "robot": robot}


def _log(line: CommandLine) -> tuple[Robot, dict[str, Any]]:
    log, robot_or_scene = line.inputs
    robot, scenes = scenes_from(robot_or_scene, line.options)
    # Single feet come last where all land together, and stand in the robot's order.
    contacts: dict[str, Contact] = {}
    for scene in sorted(scenes, key=lambda scene: len(scene.contact)):
        contacts |= {contact.frame: contact for contact in scene.contact}
    watched = {"contacts": tuple(contacts)} if line.options.contact else {}
    scene = dataclasses.replace(scenes[0], contact=tuple(contacts.values()))
    return robot, {"log": log, "scene": scene, "robot": robot, **watched}


def _refuse_overridden(options: SceneOptions, arguments: Mapping[str, Any], result: Any) -> None:
    """Refuse options that have no effect, because the log gives what they say."""
    columns = StateColumns(result.log.positions, {}, {})
    refuse_overridden(options, arguments["scene"], arguments["robot"], columns)


INPUTS = {
    "table": Input(
        {"table": (Path, argument(_TABLE, "TABLE", path, default=...)), "scene": (str, ROBOT)},
        _table,
        file=True,
    ),
    "log": Input(
        {"log": (Path, argument(_LOG, "LOG", path)), "scene": (str, ROBOT)},
        _log,
        file=True,
        check=_refuse_overridden,
    ),
}
"""Inputs as in `cli.study_inputs`: a table or a log, each with its landing.

A table has columns and a landing that gives what these lack; a log has a path and one landing on
all contacts.
"""
