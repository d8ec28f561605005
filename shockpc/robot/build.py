"""A robot's checked text becomes a Pinocchio model, with a free base for a URDF and the file's own base for an MJCF."""

import math
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin

from shockpc.errors import RobotError
from shockpc.robot.markup import parse_markup
from shockpc.robot.source import RobotSource
from shockpc.robot.urdf_numbers import vector

__all__ = ["FREE_FLYER", "build_model"]


FREE_FLYER = "JointModelFreeFlyer"


def build_model(source: RobotSource) -> pin.Model:
    """Build the Pinocchio model of a robot.

    Args:
        source: the robot as read; its text is used, not its file, because includes and defaults are written out in it.

    Returns:
        The model, in which mimic joints are independent.

    Raises:
        RobotError: Pinocchio refuses the text.
    """
    try:
        if source.kind == "urdf":
            return _square_up(pin.buildModelFromXML(source.xml, pin.JointModelFreeFlyer()))
        with tempfile.TemporaryDirectory() as folder:
            # Pinocchio reads MJCF from files only, and tells them by this suffix.
            copy = Path(folder) / "robot.xml"
            copy.write_text(source.xml, encoding="utf-8")
            model = pin.buildModelFromMJCF(str(copy))
    except (ValueError, RuntimeError, IndexError) as refusal:
        said = " ".join(str(refusal).split())
        raise RobotError(f"{source.path.name}: Pinocchio cannot read it: {said}") from None
    if model.njoints > 1 and model.joints[1].shortname() == FREE_FLYER:
        # qpos places a free body in the world; its pos and quat in the file are only where it starts.
        model.jointPlacements[1] = pin.SE3.Identity()
    _undo_degrees(source, model)
    _place_sites(source, model)
    return _square_up(model)


def _square_up(model: pin.Model) -> pin.Model:
    """Make rotations of the joint placements as good as doubles allow: Newton's iteration R ← R (3 − RᵀR) / 2, once.

    Pinocchio leaves those of an MJCF off by as much as 1e-14, which a chain of bodies multiplies up.
    """
    for place in model.jointPlacements:
        R = place.rotation
        place.rotation = 0.5 * R @ (3.0 * np.eye(3) - R.T @ R)
    return model


def _undo_degrees(source: RobotSource, model: pin.Model) -> None:
    """Give sliding joints their limits back: Pinocchio turns them into radians with all the others, but they are lengths."""
    compiler = parse_markup(source.xml, source.path.name).find("compiler")
    if compiler is not None and compiler.get("angle") == "radian":
        return
    for joint in model.joints[1:]:
        if joint.nv == 1 and joint.shortname().startswith("JointModelP"):
            model.lowerPositionLimit[joint.idx_q] *= 180.0 / math.pi
            model.upperPositionLimit[joint.idx_q] *= 180.0 / math.pi


def _place_sites(source: RobotSource, model: pin.Model) -> None:
    """Put sites where they belong: Pinocchio misplaces those of bodies without joints, and drops the world's."""
    root = parse_markup(source.xml, source.path.name)
    for body in (*root.iter("worldbody"), *root.iter("body")):
        index = model.getFrameId(body.get("name", ""), pin.FrameType.BODY) if body.tag == "body" else 0
        frame = model.frames[index]
        for site in body.findall("site[@name]"):
            name, quaternion = site.get("name", ""), vector(site.get("quat"), 4) or (1.0, 0.0, 0.0, 0.0)
            offset = np.array(vector(site.get("pos"), 3) or (0.0, 0.0, 0.0))
            place = frame.placement * pin.SE3(pin.Quaternion(*quaternion).matrix(), offset)
            if model.existFrame(name, pin.FrameType.OP_FRAME):
                model.frames[model.getFrameId(name, pin.FrameType.OP_FRAME)].placement = place
            else:
                model.addFrame(pin.Frame(name, frame.parentJoint, index, place, pin.FrameType.OP_FRAME))
