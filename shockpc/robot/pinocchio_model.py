"""The robot of a Pinocchio model that a program built, with the shapes of its geometry model."""

import re
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.robot.files.reading import OpenFolders
from shockpc.robot.pinocchio_joints import has_free_base
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.tolerances import refuse_number
from shockpc.text.errors import RobotError

_JOINTS = re.compile(
    r"JointModel(FreeFlyer|Spherical|Planar|Composite|[RP][XYZ]|RUB[XYZ]|(Revolute|RevoluteUnbounded|Prismatic)Unaligned)"
)
_UNLIMITED = 1e300  # Pinocchio writes the largest double for a joint without limits


def build_pinocchio(source: pin.Model, label: str, geometry: pin.GeometryModel | None) -> Robot:
    """Build the robot of a Pinocchio model, which stays as it is.

    Commands and messages call it by the label.

    The base is free if the first joint is a free flyer. Armature is the model's, or rotorInertia ·
    rotorGearRatio² where that is zero; limits that are both zero are none; reference configurations
    become postures. A joint without a frame of type BODY gets one of the joint's name. Mimic joints
    that the model does not hold (Pinocchio reads them with mimic=True only) are independent.

    Raises:
        RobotError: the model has no joint, one of a type that is not computed, or numbers that no
            robot has.
    """
    model = pin.Model(source)
    _check_joints(model)
    _complete_frames(model)
    _check_inertias(model)
    _read_limits(model)
    _read_armature(model)
    postures, notes = _reference_postures(model)
    return Robot(
        _source(source, label, geometry),
        model,
        read_only(pin.neutral(model)),
        postures,
        (),
        (),
        notes,
        gear_ratios=_ratios_without_inertia(model),
    )


def _check_joints(model: pin.Model) -> None:
    """Refuse what is not computed, and name the parts of composite joints."""
    if model.njoints < 2:
        raise RobotError(
            "the model has no joint, so nothing moves; a floating base is a "
            "pinocchio.JointModelFreeFlyer"
        )
    if has_free_base(model) and not model.jointPlacements[1].isIdentity(0.0):
        raise RobotError(
            f'free flyer "{model.names[1]}" has a placement; make it the identity, and put the '
            f"base there by its q",
            joints=[model.names[1]],
        )
    for k, name in enumerate(model.names.tolist()[1:], start=1):
        joint = model.joints[k]
        parts: list[pin.JointModel] = []
        if joint.shortname() == "JointModelComposite":
            parts = list(joint.extract().joints)
        for part in (joint, *parts):
            if not _JOINTS.fullmatch(part.shortname()):
                remedy = ""
                if "Mimic" in part.shortname():
                    remedy = "; load the URDF file itself; its mimic joints are read"
                raise RobotError(
                    f'joint "{name}" is a {part.shortname()}, which is not computed{remedy}',
                    joints=[name],
                )
        if parts and "+" in name:
            raise RobotError(
                f'composite joint "{name}" has a + in its name, which separates the names of its '
                f"parts here; rename it",
                joints=[name],
            )
        if parts:
            model.names[k] = "+".join(f"{name}_{number}" for number in range(1, len(parts) + 1))


def _complete_frames(model: pin.Model) -> None:
    """Give each joint a frame of type BODY.

    Make the inertias of each joint's frames sum to that of the joint.
    """
    for k in range(1, model.njoints):
        if not any(frame.type == pin.FrameType.BODY for frame in _frames_at(model, k)):
            name = model.names[k]
            while model.existFrame(name, pin.FrameType.BODY):
                name += "_"
            model.addFrame(pin.Frame(name, k, 0, pin.SE3.Identity(), pin.FrameType.BODY), False)
        frames = _frames_at(model, k)
        joint_inertia = model.inertias[k]
        total = pin.Inertia.Zero()
        for frame in frames:
            total += frame.placement.act(frame.inertia)
        if not total.isApprox(joint_inertia, 1e-9):
            for frame in frames:
                frame.inertia = pin.Inertia.Zero()
            body = next(frame for frame in frames if frame.type == pin.FrameType.BODY)
            body.inertia = body.placement.actInv(joint_inertia)


def _frames_at(model: pin.Model, joint: int) -> list[pin.Frame]:
    """The frames that a joint carries."""
    return [frame for frame in model.frames if frame.parentJoint == joint]


def _check_inertias(model: pin.Model) -> None:
    """Refuse numbers that no robot has; later they would give NaN or a result without meaning."""
    # Joint 0 is the world.
    for k in range(1, model.njoints):
        subject = f'joint "{model.names[k]}"'
        inertia = model.inertias[k]
        placement = model.jointPlacements[k]
        if not inertia.mass >= 0.0:
            raise RobotError(
                f"{subject}: mass {inertia.mass:g} kg is negative or not finite; give the mass "
                f"that the body has, or 0"
            )
        for quantity, values, unit in (
            ("mass", inertia.mass, "kg"),
            ("centre of mass", inertia.lever, "m"),
            ("inertia", inertia.inertia, "kg m²"),
            ("placement", placement.translation, "m"),
            ("rotation", placement.rotation, "1"),
        ):
            refuse_number(subject, quantity, float(np.abs(values).max()), unit)
    if not any(inertia.mass for inertia in model.inertias):
        raise RobotError(
            "no joint carries mass, so the robot has no mass; give at least one body an inertia"
        )


def _read_limits(model: pin.Model) -> None:
    """Make limits infinite that are not given, or are the largest double."""
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    # Pinocchio writes zeros for a joint of whose limits a URDF says nothing; none is meant that
    # cannot move.
    unknown = (lower == 0.0) & (upper == 0.0)
    model.lowerPositionLimit = np.where(unknown | (lower < -_UNLIMITED), -np.inf, lower)
    model.upperPositionLimit = np.where(unknown | (upper > _UNLIMITED), np.inf, upper)


def _read_armature(model: pin.Model) -> None:
    """Set armature that is zero to n² I_rotor, which a rotor reflects through its gear.

    Source: shock paper, section 3.1.2.
    """
    reflected = model.rotorInertia * model.rotorGearRatio**2
    armature = np.where(model.armature != 0.0, model.armature, reflected)
    base_has_armature = has_free_base(model) and armature[:6].any()
    if not np.isfinite(armature).all() or armature.min() < 0.0 or base_has_armature:
        raise RobotError(
            "armature has to be finite and not negative, and zero for the free flyer; correct "
            "model.armature"
        )
    model.armature = armature


def _reference_postures(model: pin.Model) -> tuple[dict[str, Array], tuple[str, ...]]:
    """The reference configurations (nq,) by name, and notes about those that cannot be read."""
    postures: dict[str, Array] = {}
    notes: tuple[str, ...] = ()
    for entry in model.referenceConfigurations:
        q = np.array(entry.data(), dtype=float)
        if q.shape == (model.nq,) and np.isfinite(q).all():
            postures[entry.key()] = read_only(q)
        else:
            notes += (
                f'reference configuration "{entry.key()}" does not hold {model.nq} finite numbers; '
                f"it is left out",
            )
    return postures, notes


def _ratios_without_inertia(model: pin.Model) -> dict[str, float]:
    """The gear ratios of joints that have a motor whose rotor is not known."""
    ratios: dict[str, float] = {}
    for k in range(1, model.njoints):
        v = model.idx_vs[k]
        if model.nvs[k] == 1 and model.rotorGearRatio[v] and not model.armature[v]:
            ratios[model.names[k]] = float(model.rotorGearRatio[v])
    return ratios


def _source(model: pin.Model, label: str, geometry: pin.GeometryModel | None) -> RobotSource:
    """The source in place of a file.

    It is the model as Pinocchio serialises it, and the geometry as the links of a URDF.
    """
    root = Element("robot", name=model.name)
    SubElement(root, "pinocchio").text = model.saveToString()
    folders: dict[Path, None] = {}
    for item in () if geometry is None else geometry.geometryObjects:
        frame, shape = model.frames[item.parentFrame], item.geometry
        placement = frame.placement.actInv(item.placement)
        link = SubElement(root, "link", name=frame.name)
        SubElement(link, "inertial")  # without one the check-up would say that the link has no mass
        collision = SubElement(link, "collision")
        SubElement(
            collision,
            "origin",
            xyz=_text(placement.translation),
            rpy=_text(pin.rpy.matrixToRpy(placement.rotation)),
        )
        match kind := type(shape).__name__:
            case "Box":
                sizes = {"size": _text(2.0 * shape.halfSide)}
            case "Sphere":
                sizes = {"radius": _text([shape.radius])}
            case "Cylinder" | "Capsule":
                sizes = {"radius": _text([shape.radius]), "length": _text([2.0 * shape.halfLength])}
            case _ if item.meshPath and Path(item.meshPath).is_absolute():
                kind, sizes = "mesh", {"filename": item.meshPath, "scale": _text(item.meshScale)}
                folders[Path(item.meshPath).resolve().parent] = None
            case _:
                sizes = {}  # reported as a shape that cannot be read, like any other
        SubElement(SubElement(collision, "geometry"), kind.lower(), sizes)
    opened = OpenFolders(Path(label), {}, tuple(folders), {})
    return RobotSource(
        label, "pinocchio", tostring(root, encoding="unicode"), model.name, None, opened, ()
    )


def _text(values: Array | list[float]) -> str:
    """Numbers with all digits, as attributes hold them."""
    return " ".join(repr(float(value)) for value in values)
