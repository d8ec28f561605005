"""A robot's checked text becomes a Pinocchio model, with a free base for a URDF and the file's own base for an MJCF."""

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.robot.couplings import Built, Mimic, leaders_first
from shockpc.robot.files import parse_xml
from shockpc.robot.source import RobotSource
from shockpc.robot.srdf import read_srdf

__all__ = ["FREE_FLYER", "build", "build_model"]

FREE_FLYER = "JointModelFreeFlyer"


def build(source: RobotSource) -> Built:
    """Build the Pinocchio model of a robot, and read what its file holds beside it.

    Raises:
        RobotError: the format's own reader refuses the text.
    """
    if source.kind == "mjcf":
        from shockpc.robot.mjcf_model import build_mjcf

        built = build_mjcf(source)
    else:
        built = _build_urdf(source)
    # Rotations as good as doubles allow, by Newton's iteration R ← R (3 − RᵀR) / 2: a chain of bodies multiplies what is missing.
    for place in built.model.jointPlacements:
        R = place.rotation
        place.rotation = 0.5 * R @ (3.0 * np.eye(3) - R.T @ R)
    return built


def build_model(source: RobotSource) -> pin.Model:
    """Build the Pinocchio model alone. Raises RobotError as `build` does."""
    return build(source).model


def _build_urdf(source: RobotSource) -> Built:
    """The model of a URDF on a free base, with the postures and rotors of its SRDF."""
    try:
        model = pin.buildModelFromXML(source.xml, pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError, IndexError) as refusal:
        raise RobotError(f"{source.path.name}: Pinocchio cannot read it: {' '.join(str(refusal).split())}") from None
    postures: dict[str, Array] = {}
    if source.srdf is not None:
        postures, model.armature = read_srdf(source.srdf, model)
    return Built(model, postures, _mimics(source, model), (), None, ())


def _mimics(source: RobotSource, model: pin.Model) -> tuple[Mimic, ...]:
    """The joints of a URDF that mimic others. A fixed joint follows nothing; one that follows a fixed joint keeps its offset."""
    found: list[Mimic] = []
    for joint in parse_xml(source.xml, source.path.name).iter("joint") if "<mimic" in source.xml else ():
        for mimic in joint.findall("mimic"):
            if model.existJointName(joint.get("name", "")):
                multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
                found.append(Mimic(joint.get("name", ""), mimic.get("joint", ""), multiplier, offset))
    return leaders_first(found, model, source.path.name)
