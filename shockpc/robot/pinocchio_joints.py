"""Parts of a Pinocchio model that the readers of URDF and MJCF build alike.

They are joints, and rotations of quaternions.
"""

import functools
from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array


@functools.lru_cache(maxsize=64)  # most joints of a robot have one of a few axes
def axis_joint(kind: str, *axis: float) -> Any:
    """A revolute, continuous or prismatic joint.

    Args: axis, its three components, of any length.
    """
    # By the parser, because a continuous joint about any axis has no constructor in Python.
    axis_and_limit = (
        f'<axis xyz="{" ".join(map(repr, axis))}"/><limit lower="0" upper="0" effort="0" '
        f'velocity="0"/>'
    )
    links, ends = '<link name="a"/><link name="b"/>', '<parent link="a"/><child link="b"/>'
    return pin.buildModelFromXML(
        f'<robot name="r">{links}<joint name="j" '
        f'type="{kind}">{ends}{axis_and_limit}</joint></robot>'
    ).joints[1]


def add_joint(
    model: pin.Model, carrier: int, joint: Any, placement: pin.SE3, name: str, above: int = 0
) -> int:
    """Add a joint and its frame to a model; returns its index.

    Args: above, frame of the link that carries it, if it is known.
    """
    index: int = model.addJoint(carrier, joint, placement, name)
    model.addJointFrame(index, above)
    return index


def has_free_base(model: pin.Model) -> bool:
    """True if the first joint of a model is a free flyer."""
    return bool(model.joints[1].shortname() == "JointModelFreeFlyer")


def rotation(quaternion: Array) -> Array:
    """The rotation (3, 3) of a quaternion (4,) whose scalar part comes first, as MuJoCo has it."""
    w, x, y, z = (float(value) for value in quaternion)
    return np.asarray(pin.Quaternion(w, x, y, z).normalized().matrix())
