"""Mechanical shock of a landing, body by body, from the rigid-body model alone."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shockpc.errors import OutputError, RobotError, SceneError, ShockError, SolveError, StudyError, UnknownName
    from shockpc.landing import Landing, resolve
    from shockpc.model.closure import Closure, Place
    from shockpc.model.contact import Contact
    from shockpc.model.joint_model import Joints, Rotor
    from shockpc.model.posture import Posture
    from shockpc.profile import shock_maps, shock_profile
    from shockpc.result import ShockMaps, ShockProfile
    from shockpc.results.accuracy import Health
    from shockpc.results.bracket import Bracket
    from shockpc.results.contacts import ContactImpulse
    from shockpc.results.loads import JointLoad
    from shockpc.results.points import PointShock
    from shockpc.robot.robot import Robot, load_robot
    from shockpc.scene import Point, Scene, Strike, read_scene
    from shockpc.studies.batch import batch
    from shockpc.studies.compare import Design, compare
    from shockpc.studies.place.study import PlaceStudy, place
    from shockpc.studies.sweep.rows import Chunk
    from shockpc.studies.sweep.study import sweep
    from shockpc.testing import assert_shock

__version__ = "0.1.0"

_HOMES = {
    "Bracket": "results.bracket",
    "Chunk": "studies.sweep.rows",
    "Closure": "model.closure",
    "Contact": "model.contact",
    "ContactImpulse": "results.contacts",
    "Design": "studies.compare",
    "Health": "results.accuracy",
    "JointLoad": "results.loads",
    "Joints": "model.joint_model",
    "Landing": "landing",
    "OutputError": "errors",
    "Place": "model.closure",
    "Point": "scene",
    "PlaceStudy": "studies.place.study",
    "PointShock": "results.points",
    "Posture": "model.posture",
    "Robot": "robot.robot",
    "RobotError": "errors",
    "Rotor": "model.joint_model",
    "Scene": "scene",
    "SceneError": "errors",
    "ShockError": "errors",
    "ShockMaps": "result",
    "ShockProfile": "result",
    "SolveError": "errors",
    "StudyError": "errors",
    "Strike": "scene",
    "UnknownName": "errors",
    "assert_shock": "testing",
    "batch": "studies.batch",
    "compare": "studies.compare",
    "load_robot": "robot.robot",
    "place": "studies.place.study",
    "read_scene": "scene",
    "resolve": "landing",
    "shock_maps": "profile",
    "shock_profile": "profile",
    "sweep": "studies.sweep.study",
}

__all__ = [
    "Bracket",
    "Chunk",
    "Closure",
    "Contact",
    "ContactImpulse",
    "Design",
    "Health",
    "JointLoad",
    "Joints",
    "Landing",
    "OutputError",
    "Place",
    "PlaceStudy",
    "Point",
    "PointShock",
    "Posture",
    "Robot",
    "RobotError",
    "Rotor",
    "Scene",
    "SceneError",
    "ShockError",
    "ShockMaps",
    "ShockProfile",
    "SolveError",
    "Strike",
    "StudyError",
    "UnknownName",
    "assert_shock",
    "batch",
    "compare",
    "load_robot",
    "place",
    "read_scene",
    "resolve",
    "shock_maps",
    "shock_profile",
    "sweep",
]


def __getattr__(name: str) -> Any:
    # The command line answers --help in a moment because nothing heavy is imported before it is used.
    if name not in _HOMES:
        raise AttributeError(f"module 'shockpc' has no attribute {name!r}")
    return getattr(importlib.import_module(f"shockpc.{_HOMES[name]}"), name)
