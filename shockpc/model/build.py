"""A robot's checked text becomes a Pinocchio model, with a free base for a URDF and the file's own base for an MJCF."""

import tempfile
from pathlib import Path

import pinocchio as pin

from shockpc.errors import RobotError
from shockpc.model.source import RobotSource

__all__ = ["build_model"]


def build_model(source: RobotSource) -> pin.Model:
    """Build the Pinocchio model of a robot.

    Args:
        source: the robot as read; its text is used, not its file, because includes and defaults are written out in it.

    Returns:
        The model. Mimic joints are independent joints in it.

    Raises:
        RobotError: Pinocchio refuses the text.
    """
    try:
        if source.kind == "urdf":
            return pin.buildModelFromXML(source.xml, pin.JointModelFreeFlyer())
        with tempfile.TemporaryDirectory() as folder:
            # Pinocchio reads MJCF from files only, and tells them by this suffix.
            copy = Path(folder) / "robot.xml"
            copy.write_text(source.xml, encoding="utf-8")
            return pin.buildModelFromMJCF(str(copy))
    except (ValueError, RuntimeError, IndexError) as refusal:
        said = " ".join(str(refusal).split())
        raise RobotError(f"{source.path.name}: Pinocchio cannot read it: {said}") from None
