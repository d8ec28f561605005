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
    from shockpc.robot.load import load_robot
    from shockpc.robot.record import Robot
    from shockpc.scene import Point, Scene, Strike, read_scene
    from shockpc.studies.batch import batch
    from shockpc.studies.compare import Design, compare
    from shockpc.studies.place.study import PlaceStudy, place
    from shockpc.studies.sweep.rows import Chunk
    from shockpc.studies.sweep.study import sweep
    from shockpc.testing import assert_shock

__version__ = "0.1.0"

_HOMES = {
    "errors": ("OutputError", "RobotError", "SceneError", "ShockError", "SolveError", "StudyError", "UnknownName"),
    "landing": ("Landing", "resolve"),
    "model.closure": ("Closure", "Place"),
    "model.contact": ("Contact",),
    "model.joint_model": ("Joints", "Rotor"),
    "model.posture": ("Posture",),
    "profile": ("shock_maps", "shock_profile"),
    "result": ("ShockMaps", "ShockProfile"),
    "accuracy": ("Health",),
    "robot.load": ("load_robot",),
    "robot.record": ("Robot",),
    "scene": ("Point", "Scene", "Strike", "read_scene"),
    "studies.batch": ("batch",),
    "studies.compare": ("Design", "compare"),
    "studies.place.study": ("PlaceStudy", "place"),
    "studies.sweep.rows": ("Chunk",),
    "studies.sweep.study": ("sweep",),
    "testing": ("assert_shock",),
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
    home = next((home for home, names in _HOMES.items() if name in names), None)
    if home is None:
        raise AttributeError(f"module 'shockpc' has no attribute {name!r}")
    return getattr(importlib.import_module(f"shockpc.{home}"), name)
