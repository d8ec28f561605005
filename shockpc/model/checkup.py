"""The check-up of a robot file: all that is odd in it but does not stop it from being computed, each with its consequence.

What stops it is refused while it is read. Nothing is corrected here.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.model.bodywork import Bodywork, bodywork_of
from shockpc.model.inertias import inertia_faults
from shockpc.model.markup import parse_markup
from shockpc.model.source import RobotSource, resolve_asset
from shockpc.model.urdf_numbers import vector
from typing import Literal

__all__ = ["Finding", "check_robot"]

_HEAVY = 20.0  # times all the other bodies together: grams written as kilograms stand out like this
_LIGHT = 1e-6  # of the whole robot: below this, its motion is lost in the rounding of the rest


class Finding(NamedTuple):
    """One thing worth knowing about a robot file.

    Attributes:
        level: "error" where some strikes cannot be computed, "warning" where numbers may mislead, "note" otherwise.
        where: the link, body or joint, or the file.
        text: what was found, and its consequence.
    """

    level: Literal["error", "warning", "note"]
    where: str
    text: str


def check_robot(source: RobotSource) -> tuple[Finding, ...]:
    """Check a robot file for what may mislead.

    Args:
        source: the robot as read.

    Returns:
        What was found, errors first, then warnings, then notes; empty if there is nothing.
    """
    root = parse_markup(source.xml, source.path.name)
    work = bodywork_of(root, source.kind)
    found = [
        *_inertia_findings(work),
        *_mass_findings(work),
        *_armature_findings(root, source.kind),
        *_joint_findings(root, source.kind),
        *_mesh_findings(source, root),
    ]
    order = ("error", "warning", "note")
    return tuple(sorted(found, key=lambda finding: order.index(finding.level)))


def _inertia_findings(work: Bodywork) -> Iterator[Finding]:
    """Inertias that no body has."""
    for link, mass, matrix in work.inertias:
        fault = inertia_faults(mass, matrix)
        if fault is not None:
            yield Finding("warning", f'link "{link}"', f"{fault}; shock of its body is computed from these numbers all the same")
    if work.unweighed:
        yield Finding(
            "note",
            _named("link", work.unweighed),
            f"no <inertial>, though there is something to see or to hit; counted as {'without' if work.unweighed else ''} mass",
        )


def _mass_findings(work: Bodywork) -> Iterator[Finding]:
    """Bodies without mass, and masses far from all others."""
    idle = [body for body in work.masses if work.masses[body] == 0 and work.masses_beyond[body] == 0]
    carrying = [body for body in work.masses if work.masses[body] == 0 and work.masses_beyond[body] > 0]
    if idle:
        yield Finding(
            "error",
            _named("body", idle),
            "moves, and neither it nor what hangs on it has mass, so the inertia matrix is singular; "
            "give it mass, make its joint fixed, or lock the joint",
        )
    if carrying:
        yield Finding(
            "note", _named("body", carrying), "moves and has no mass of its own; what hangs on it decides how it is shocked"
        )
    total = sum(work.masses.values())
    for body, mass in work.masses.items():
        if len(work.masses) > 2 and mass > _HEAVY * (total - mass):
            yield Finding(
                "warning",
                f'body "{body}"',
                f"{mass:g} kg is {mass / (total - mass):.0f} times all other bodies together; if it is meant in grams, "
                "every shock is wrong",
            )
        elif 0 < mass < _LIGHT * total:
            yield Finding(
                "warning",
                f'body "{body}"',
                f"{mass:g} kg is less than a millionth of the robot's {total:g} kg; if it is a stand-in for none, its own "
                "shock means little",
            )


def _armature_findings(root: Element, kind: str) -> Iterator[Finding]:
    """Rotors that nobody wrote down."""
    if any(joint.get("armature", "0") not in ("0", "0.0") for joint in root.iter("joint")):
        return
    why = "URDF has no place for it" if kind == "urdf" else "no joint gives one"
    yield Finding(
        "note",
        "every joint",
        f"has zero armature ({why}), so joints count as free of their motors; with geared or locked joints the shock is another",
    )


def _joint_findings(root: Element, kind: str) -> Iterator[Finding]:
    """Followers, limits and axes of a URDF's joints."""
    if kind != "urdf":
        return
    for joint in root.findall("joint"):
        where, limit = f'joint "{joint.get("name")}"', joint.find("limit")
        for mimic in joint.findall("mimic"):
            multiplier, offset = mimic.get("multiplier", "1"), mimic.get("offset", "0")
            yield Finding(
                "note",
                where,
                f'mimics "{mimic.get("joint")}" with multiplier {multiplier} and offset {offset}; it adds no freedom of its own',
            )
        if joint.get("type") in ("revolute", "prismatic") and limit is not None:
            lower, upper = (float(limit.get(key, "0")) for key in ("lower", "upper"))
            if lower > upper:
                yield Finding(
                    "warning", where, f"its lower limit {lower:g} exceeds its upper limit {upper:g}; every posture is outside them"
                )
            elif lower == upper:
                yield Finding(
                    "note", where, f"both its limits are {lower:g}; any other value draws a warning and is computed all the same"
                )
        axis = vector(joint.findtext("axis") or (joint.find("axis").get("xyz") if joint.find("axis") is not None else None), 3)
        if axis is not None and abs(sum(value * value for value in axis) - 1) > 1e-3:
            yield Finding("note", where, f"its axis {' '.join(f'{v:g}' for v in axis)} is not of length 1; its direction is what counts")


def _mesh_findings(source: RobotSource, root: Element) -> Iterator[Finding]:
    """Meshes that cannot be had."""
    if source.kind == "urdf":
        uris = [mesh.get("filename", "") for mesh in root.iter("mesh")]
    else:
        compiler = root.find("compiler")
        folder = (compiler.get("meshdir") or compiler.get("assetdir") or ".") if compiler is not None else "."
        uris = [f"{folder}/{mesh.get('file')}" for mesh in root.findall("asset/mesh") if mesh.get("file")]
    uris = list(dict.fromkeys(uris))
    lost = []
    for uri in uris:
        try:
            resolve_asset(source, uri)
        except RobotError:
            lost.append(uri)
    if lost:
        yield Finding(
            "warning",
            f"{len(lost)} of {len(uris)} meshes",
            f"cannot be found or lie outside the open folders: {_listed(lost)}; figures draw the inertia's box instead. "
            "If they lie in a package, say where: --package NAME=DIR",
        )


def _named(kind: str, names: Iterable[str]) -> str:
    """One name or a few, as the subject of a finding."""
    names = list(names)
    plural = {"body": "bodies"}.get(kind, kind + "s")
    return f"{plural if len(names) > 1 else kind} {_listed(names)}"


def _listed(names: list[str], most: int = 3) -> str:
    """The first few names, and how many more there are."""
    shown = ", ".join(f'"{name}"' for name in names[:most])
    return shown + (f" and {len(names) - most} more" if len(names) > most else "")
