"""The drives of a URDF: reflected inertia, gear ratios and springs of its joints."""

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.urdf.numbers import finite_numbers, grouped
from shockpc.text.errors import RobotError

_RATIOS = ("mechanicalReduction", "mechanical_reduction")


class UrdfDrives(NamedTuple):
    """The data of a URDF's drives beside the reflected inertia, which is added to the model.

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
    """Add the reflected inertia and the damping of a URDF's joints to the model.

    Returns what else the file says of their drives.

    Read are <dynamics> of a joint: armature and RaiSim's rotor_inertia, both at the joint, RaiSim's
    stiffness, and spring_stiffness with spring_reference; and transmissions of one joint by one
    actuator, those of <ros2_control> included: rotor inertia and gear ratio of Drake, or
    motorInertia and mechanicalReduction, whose product counts where it stands in the joint and in
    the actuator. Of two values for one joint the first is used.

    Raises:
        RobotError: a number of a drive is negative or not finite.
    """
    data = _Drives()
    for name, joint in joints.items():
        dynamics = joint.find("dynamics")
        if dynamics is not None:
            data.read_dynamics(name, dynamics, model)
    for transmission in (*root.findall("transmission"), *root.findall("ros2_control/transmission")):
        data.read_transmission(transmission, joints)
    data.set_armature(model)

    # Springs and gears of fixed joints, and of those with several degrees of freedom, say nothing.
    moving = [name for name in joints if _is_single(model, name)]
    springs = {name: k for name, k in data.springs.items() if name in moving}
    rest = {name: value for name, value in data.rest.items() if name in springs}
    gears = {name: ratio for name, ratio in data.ratios.items() if name in moving}
    without_inertia = {n: ratio for n, ratio in gears.items() if not data.inertias.get(n)}
    return UrdfDrives(springs, rest, without_inertia, grouped(data.faults))


class _Drives:
    """The data read of the drives of a URDF, by joint.

    Attributes:
        inertias: reflected inertia [kg m², kg].
        springs: stiffness [N m/rad, N/m].
        rest: where springs are without force [rad, m].
        ratios: of gears [1].
        faults: kind of an element, its name, and what is wrong with it.
    """

    def __init__(self) -> None:
        self.inertias: dict[str, float] = {}
        self.springs: dict[str, float] = {}
        self.rest: dict[str, float] = {}
        self.ratios: dict[str, float] = {}
        self.faults: list[tuple[str, str, str]] = []

    def give(self, values: dict[str, float], joint: str, quantity: str, value: float) -> None:
        """Give a joint a value, or note that it has another one already."""
        first = values.setdefault(joint, value)
        if abs(first - value) > 1e-9 * abs(value):
            fault = f"{quantity} {first:g} and {value:g} are given; the first one is used"
            self.faults.append(("joint", joint, fault))

    def read_dynamics(self, name: str, dynamics: Element, model: pin.Model) -> None:
        """Read the <dynamics> of a joint; its damping goes into the model."""
        for key in ("armature", "rotor_inertia"):
            inertia = _at_least_zero(name, key, dynamics.get(key))
            if inertia:
                self.give(self.inertias, name, "reflected inertia", inertia)
        for key in ("stiffness", "spring_stiffness"):
            stiffness = _at_least_zero(name, key, dynamics.get(key))
            if stiffness:
                self.give(self.springs, name, "stiffness", stiffness)
        reference = self._number(name, dynamics, "spring_reference")
        if reference is not None:
            self.rest[name] = reference
        damping = self._number(name, dynamics, "damping")
        if damping is not None:
            model.damping[_velocities(model, name)] = max(damping, 0.0)

    def _number(self, name: str, dynamics: Element, key: str) -> float | None:
        """An attribute of <dynamics>; None where it is not written, or no finite number."""
        text = dynamics.get(key)
        if text is None:
            return None
        value = finite_numbers(text, 1)
        if value is None:
            fault = f'its {key} is "{text}", which is no finite number, so it is not read'
            self.faults.append(("joint", name, fault))
            return None
        return float(value[0])

    def read_transmission(self, transmission: Element, joints: dict[str, Element]) -> None:
        """Read the rotor inertia and the ratio of a transmission."""
        driven = transmission.findall("joint")
        actuators = transmission.findall("actuator")
        values = _values(transmission, [*actuators, *driven])
        rotor = values.get("rotor_inertia", values.get("motorInertia"))
        names = [joint.get("name", "") for joint in driven]
        if len(names) != 1 or names[0] not in joints or len(actuators) > 1:
            title = transmission.get("name", "")
            if _at_least_zero(title, "rotor inertia", rotor):
                fault = "has a rotor inertia and not one joint of the file, so it is not read"
                self.faults.append(("transmission", title, fault))
            return
        name = names[0]
        inertia = _at_least_zero(name, "rotor inertia", rotor)
        if "gear_ratio" in values:
            written = [values["gear_ratio"]]
        else:
            written = list(_reductions(transmission, (*actuators, *driven)))
        ratio = 1.0
        for text in written:
            factor = finite_numbers(text, 1)
            if factor is None:
                fault = f'the ratio of its transmission is "{text}"; it has to be a finite number'
                if inertia:
                    raise RobotError(f'joint "{name}": {fault}', joints=names)
                self.faults.append(("joint", name, f"{fault}, so it is not read"))
                return
            ratio *= float(factor[0])
        if inertia:
            # The rotor turns ratio times as fast as the joint: ratio² times its inertia.
            self.give(self.inertias, name, "reflected inertia", inertia * ratio * ratio)
        elif written:
            self.give(self.ratios, name, "gear ratio", ratio)

    def set_armature(self, model: pin.Model) -> None:
        """Give the model the reflected inertia of joints with one degree of freedom."""
        for name, inertia in self.inertias.items():
            v = _velocities(model, name)
            if v.stop - (v.start or 0) > 1:
                fault = "has a reflected inertia and several degrees of freedom, so it is not read"
                self.faults.append(("joint", name, fault))
            else:
                model.armature[v] = inertia


def _values(transmission: Element, ends: list[Element]) -> dict[str, str]:
    """The texts of the elements in a transmission and in its ends, by tag; the first counts."""
    parts = list(transmission)
    for end in ends:
        parts += list(end)
    values: dict[str, str] = {}
    for part in parts:
        tag = part.tag.removeprefix("drake:")
        values.setdefault(tag, part.get("value", part.text) or "")
    return values


def _is_single(model: pin.Model, joint: str) -> bool:
    """True if a joint has one degree of freedom."""
    return bool(model.existJointName(joint) and model.nvs[model.getJointId(joint)] == 1)


def with_rest(rest: dict[str, float], model: pin.Model, start: Array) -> Array | None:
    """The configuration (nq,) in which the springs of a URDF are without force.

    None where the file says of none.
    """
    if not rest:
        return None
    q = np.array(start)
    for name, value in rest.items():
        joint = model.joints[model.getJointId(name)]
        coordinates: tuple[float, ...] = (value,)
        if joint.nq == 2:  # a continuous joint
            coordinates = (np.cos(value), np.sin(value))
        q[joint.idx_q : joint.idx_q + joint.nq] = coordinates
    return q


def _reductions(transmission: Element, ends: tuple[Element, ...]) -> Iterator[str]:
    """The reductions of a transmission as written.

    They are of each of its ends as an element or an attribute, or its own.
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


def _at_least_zero(joint: str, quantity: str, text: str | None) -> float:
    """A number of a drive, zero where none is written.

    It is refused if it is empty, negative or not finite.
    """
    value = finite_numbers("0" if text is None else text, 1)
    if value is None or value[0] < 0.0:
        raise RobotError(
            f'joint "{joint}": its {quantity} is "{text}"; it has to be one finite number not '
            f"below zero",
            joints=[joint],
        )
    return float(value[0])
