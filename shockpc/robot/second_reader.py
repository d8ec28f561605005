"""The same URDF read by another library, yourdfpy: two readers that see one robot are a reason to believe both."""

import io
import math

import numpy as np
import pinocchio as pin

from shockpc.robot.build import build_model
from shockpc.robot.couplings import mimics_of
from shockpc.robot.source import RobotSource

__all__ = ["disagreement"]

ALIKE = 1e-9
"""Places and masses that differ by less are the same [m, 1, relative]."""


def disagreement(source: RobotSource) -> str:
    """What the second reader sees differently: the total mass, or the place of a link with every joint at zero.

    Args:
        source: a URDF as read.

    Returns: one line, empty if both see the same robot.
    """
    import yourdfpy

    model = build_model(source)
    try:
        other = yourdfpy.URDF.load(
            io.BytesIO(source.xml.encode()),
            build_scene_graph=True,
            build_collision_scene_graph=False,
            load_meshes=False,
            load_collision_meshes=False,
            filename_handler=lambda name: name,
        )
    except (ValueError, TypeError, KeyError, AttributeError, IndexError) as refusal:
        return f"yourdfpy cannot read the file that Pinocchio reads ({type(refusal).__name__}: {refusal})"
    ours = sum(float(inertia.mass) for inertia in model.inertias)
    theirs = sum(float(link.inertial.mass or 0.0) for link in other.link_map.values() if link.inertial)
    if abs(ours - theirs) > ALIKE * max(ours, theirs):
        return f"Pinocchio reads a mass of {ours:.6g} kg, yourdfpy {theirs:.6g} kg; look for inertials that one of them passes over"
    data = model.createData()
    q = pin.neutral(model)
    value: dict[str, float] = {}
    for mimic in mimics_of(source, model):
        joint = model.joints[model.getJointId(mimic.joint)]
        value[mimic.joint] = angle = mimic.multiplier * value.get(mimic.leader, 0.0) + mimic.offset
        q[joint.idx_q : joint.idx_q + joint.nq] = (math.cos(angle), math.sin(angle)) if joint.nq == 2 else angle
    pin.framesForwardKinematics(model, data, q)
    base = data.oMf[model.getFrameId(other.base_link, pin.FrameType.BODY)].inverse()
    for name in other.link_map:
        if model.existFrame(name, pin.FrameType.BODY):
            place = (base * data.oMf[model.getFrameId(name, pin.FrameType.BODY)]).homogeneous
            apart = float(np.abs(place - other.get_transform(name)).max())
            if apart > ALIKE:
                return f'Pinocchio and yourdfpy place link "{name}" {apart:.3g} apart with every joint at zero; look at its joint'
    return ""
