"""The drives of a URDF: reflected inertia, gear ratios and springs of its joints."""

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.urdf_numbers import grouped, vector
from shockpc.text.errors import RobotError

_RATIOS = ("mechanicalReduction", "mechanical_reduction")


class UrdfDrives(NamedTuple):
    """What a URDF says of its drives beside the reflected inertia, which is added to the model.

    Attributes:
        springs: stiffness of the joints with a spring [N m/rad, N/m].
        rest: where these springs are without force, of the joints of which the file says so [rad,
            m].
        gear_ratios: of joints without reflected inertia [1].
        warnings: of what contradicts itself or cannot be read.
    """

    springs: dict[str, float]
    rest: dict[str, float]
    gear_ratios: dict[str, float]
    warnings: tuple[str, ...]


def read_drives(root: Element, joints: dict[str, Element], model: pin.Model) -> UrdfDrives:
    """Add the reflected inertia and the damping of a URDF's joints to the model, and read what else
    it says of their drives.

    Read are <dynamics> of a joint: armature and RaiSim's rotor_inertia, both at the joint, RaiSim's
    stiffness, and spring_stiffness with spring_reference; and transmissions of one joint by one
    actuator, those of <ros2_control> included: rotor inertia and gear ratio of Drake, or
    motorInertia and mechanicalReduction, whose product counts where it stands in the joint and in
    the actuator. Of two values for one joint the first is used.

    Raises:
        RobotError: a number of a drive is negative or not finite.
    """
    springs: dict[str, float] = {}
    rest: dict[str, float] = {}
    ratios: dict[str, float] = {}
    inertias: dict[str, float] = {}
    faults: list[tuple[str, str, str]] = []

    def give(values: dict[str, float], joint: str, what: str, value: float) -> None:
        if abs(values.setdefault(joint, value) - value) > 1e-9 * abs(value):
            faults.append(
                (
                    "joint",
                    joint,
                    f"{what} {values[joint]:g} and {value:g} are given; the first one is used",
                )
            )

    for name, joint in joints.items():
        if (dynamics := joint.find("dynamics")) is None:
            continue
        for key in ("armature", "rotor_inertia"):
            if inertia := _at_least_zero(name, key, dynamics.get(key)):
                give(inertias, name, "reflected inertia", inertia)
        for key in ("stiffness", "spring_stiffness"):
            if stiffness := _at_least_zero(name, key, dynamics.get(key)):
                give(springs, name, "stiffness", stiffness)
        for key in ("spring_reference", "damping"):
            if key not in dynamics.attrib:
                continue
            if (value := vector(dynamics.get(key), 1)) is None:
                faults.append(
                    (
                        "joint",
                        name,
                        f'its {key} is "{dynamics.get(key)}", which is no finite number, so it is '
                        f"not read",
                    )
                )
            elif key == "damping":
                model.damping[_velocities(model, name)] = max(float(value[0]), 0.0)
            else:
                rest[name] = float(value[0])
    for transmission in (*root.findall("transmission"), *root.findall("ros2_control/transmission")):
        ends, actuators = transmission.findall("joint"), transmission.findall("actuator")
        names = [joint.get("name", "") for joint in ends]
        parts = [*transmission, *(part for end in (*actuators, *ends) for part in end)]
        values = {
            part.tag.removeprefix("drake:"): part.get("value", part.text) or ""
            for part in reversed(parts)
        }
        rotor = values.get("rotor_inertia", values.get("motorInertia"))
        if len(names) != 1 or names[0] not in joints or len(actuators) > 1:
            title = transmission.get("name", "")
            if _at_least_zero(title, "rotor inertia", rotor):
                faults.append(
                    (
                        "transmission",
                        title,
                        "has a rotor inertia and not one joint of the file, so it is not read",
                    )
                )
            continue
        inertia = _at_least_zero(names[0], "rotor inertia", rotor)
        written = (
            [values["gear_ratio"]]
            if "gear_ratio" in values
            else list(_reductions(transmission, (*actuators, *ends)))
        )
        factors = [vector(text, 1) for text in written]
        ratio = float(np.prod([factor[0] for factor in factors if factor is not None]))
        if wrong := [text for text, factor in zip(written, factors, strict=True) if factor is None]:
            text = f'the ratio of its transmission is "{wrong[0]}"; it has to be a finite number'
            if inertia:
                raise RobotError(f'joint "{names[0]}": {text}', joints=names)
            faults.append(("joint", names[0], f"{text}, so it is not read"))
        elif inertia:
            give(inertias, names[0], "reflected inertia", inertia * ratio * ratio)
        elif written:
            give(ratios, names[0], "gear ratio", ratio)
    for name, inertia in inertias.items():
        v = _velocities(model, name)
        if v.stop - (v.start or 0) > 1:
            faults.append(
                (
                    "joint",
                    name,
                    "has a reflected inertia and several degrees of freedom, so it is not read",
                )
            )
        else:
            model.armature[v] = inertia
    moving = {
        name
        for name in joints
        if model.existJointName(name) and model.nvs[model.getJointId(name)] == 1
    }
    return UrdfDrives(
        {name: k for name, k in springs.items() if name in moving},
        {name: value for name, value in rest.items() if name in moving and name in springs},
        {
            name: ratio
            for name, ratio in ratios.items()
            if name in moving and not inertias.get(name)
        },
        grouped(faults),
    )


def with_rest(rest: dict[str, float], model: pin.Model, start: Array) -> Array | None:
    """The configuration (nq,) in which the springs of a URDF are without force; None where it says
    of none.
    """
    if not rest:
        return None
    q = np.array(start)
    for name, value in rest.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = (
            value if joint.nq == 1 else (np.cos(value), np.sin(value))
        )
    return q


def _reductions(transmission: Element, ends: tuple[Element, ...]) -> Iterator[str]:
    """The reductions of a transmission as written: of each of its ends as an element or an
    attribute, or its own.
    """
    for owner in (*ends, transmission):
        written = [part.get("value", part.text) or "" for part in owner if part.tag in _RATIOS]
        written += [owner.get(key, "") for key in _RATIOS if key in owner.attrib]
        yield from written[:1]


def _velocities(model: pin.Model, joint: str) -> slice:
    """Where the velocities of a joint are; empty for one that is fixed."""
    if not model.existJointName(joint):
        return slice(0)
    index = model.getJointId(joint)
    return slice(model.idx_vs[index], model.idx_vs[index] + model.nvs[index])


def _at_least_zero(joint: str, what: str, text: str | None) -> float:
    """A number of a drive, zero where none is written; refused if it is empty, negative or not
    finite.
    """
    value = vector("0" if text is None else text, 1)
    if value is None or value[0] < 0.0:
        raise RobotError(
            f'joint "{joint}": its {what} is "{text}"; it has to be one finite number not below '
            f"zero",
            joints=[joint],
        )
    return float(value[0])
