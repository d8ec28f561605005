"""The cases: families of landings that one parameter makes harder.

They are on known robots, and on lists of links that are loaded as URDF.
"""

import functools
import math
import os
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from shockpc import Closure, Contact, Joints, LoopEnd, Posture, Robot, Scene, Strike, load_robot
from shockpc.core.spatial import Array
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.robot.catalogue import SETS
from shockpc.robot.feet_and_sensors import each_foot

BEND = (0.7, -0.9, 0.5, -0.3, 0.8, -0.6)
OBLIQUE = Strike(velocity=(0.4, 0.1, -0.9))
X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)
STICKING = ("x", "y", "z")

ANYMAL_FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")

ENDS = {
    f"struck {struck}, rooted {root}": (struck == root, root == "light")
    for struck in ("heavy", "light")
    for root in ("light", "heavy")
}
LIMBS = {"ankle": (3.0, None, 0.5), "toe": (3.0, 1.0, None), "arm": (3.0, 1.0, 0.5, None)}
BASES = {
    "free base": ("free", STICKING),
    "fixed base": ("fixed", STICKING),
    "fixed base, foot slides": ("fixed", ("z",)),
}
Built = tuple[Robot, Scene]
Build = Callable[[Any, Any], Built]


class Link(NamedTuple):
    """A body and the joint that carries it.

    Attributes:
        parent: index of the link that carries the joint; −1 for the root, whose joint is the free
            base.
        kind: "revolute", "continuous" or "prismatic"; not used for the root.
        origin: (3,) of the joint in the parent's frame [m].
        axis: (3,) unit vector of the joint; the axes of parent and link are parallel at q = 0.
        mass: [kg]
        com: (3,) in the link's frame [m].
        inertia: (3, 3) about the centre of mass [kg m²].
    """

    parent: int
    kind: str
    origin: Array
    axis: Array
    mass: float
    com: Array
    inertia: Array


class Trial(NamedTuple):
    """A landing of a family.

    It has the names of family and variant, the value of the parameter, and what builds robot and
    scene.
    """

    family: str
    variant: str
    value: str
    build: Callable[[], Built]


class Family(NamedTuple):
    """Cases that differ in one parameter.

    Attributes:
        name: short.
        about: what lands, and why it is hard.
        parameter: what its cases differ in, with its unit.
        variants: of the landing, each with the first argument of `build`.
        values: of the parameter: numbers, or names of robots.
        build: variant and value → robot and scene.
    """

    name: str
    about: str
    parameter: str
    variants: dict[str, Any]
    values: tuple[Any, ...]
    build: Build

    def cases(self) -> Iterator[Trial]:
        """Its cases, variant by variant."""
        for variant, first in self.variants.items():
            for value in self.values:
                text = value if isinstance(value, str) else f"{value:g}"
                yield Trial(self.name, variant, text, functools.partial(self.build, first, value))


FAMILIES: dict[str, Family] = {}
"""All families by name."""


def _rod(mass: float, along: Array) -> tuple[Array, Array]:
    """Centre of mass (3,) and inertia (3, 3) of a rod from the link's origin to `along`.

    It is as thick as a fiftieth of its length.
    """
    length = float(np.linalg.norm(along))
    u = along / length
    # I = m l² (1/12 + r²/4) (1 − u uᵀ) + m l² r²/2 u uᵀ, with r = 1/50 of the length l.
    uu = np.outer(u, u)
    across = mass * length**2 * (1.0 / 12.0 + 1.0 / 10000.0)
    inertia = across * (np.eye(3) - uu) + mass * length**2 / 5000.0 * uu
    return 0.5 * along, inertia


def box_inertia(mass: float, sides: tuple[float, float, float]) -> Array:
    """Inertia (3, 3) of a box about its centre [kg m²]. Args: sides [m]."""
    squares = np.square(sides)
    return np.asarray(mass / 12.0 * np.diag(squares.sum() - squares))


def known_robot(name: str) -> Robot:
    """A robot by its name, loaded once."""
    return robot_of(Scene(robot=name))


def robot_from_links(links: list[Link], name: str = "tree") -> Robot:
    """Write the links as a file and load it.

    Link i is called "link<i>" and its joint "joint<i>"; the first link is the root.

    Raises:
        RobotError: the links are not a robot.
    """
    lines = [f'<robot name="{name}">']
    for i, link in enumerate(links):
        lines.append(_link_element(link, i))
    for i, link in enumerate(links[1:], start=1):
        lines.append(_joint_element(link, i))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text("\n".join([*lines, "</robot>"]), encoding="utf-8")
        return load_robot(os.fspath(path))


def _link_element(link: Link, i: int) -> str:
    """The element of link i in a URDF."""
    moments = []
    for r, c in zip(*np.triu_indices(3), strict=True):
        moments.append(f'i{"xyz"[r]}{"xyz"[c]}="{float(link.inertia[r, c])!r}"')
    return (
        f'<link name="link{i}"><inertial><origin xyz="{_numbers(link.com)}"/>'
        f'<mass value="{float(link.mass)!r}"/><inertia {" ".join(moments)}/></inertial></link>'
    )


def _joint_element(link: Link, i: int) -> str:
    """The element of the joint that carries link i in a URDF."""
    limit = '<limit lower="-100" upper="100" effort="1" velocity="1"/>'
    if link.kind == "continuous":
        limit = ""
    return (
        f'<joint name="joint{i}" type="{link.kind}"><parent link="link{link.parent}"/>'
        f'<child link="link{i}"/><origin xyz="{_numbers(link.origin)}"/>'
        f'<axis xyz="{_numbers(link.axis)}"/>{limit}</joint>'
    )


def _numbers(values: Array) -> str:
    """Numbers with all digits."""
    return " ".join(repr(float(value)) for value in values)


def chain(masses: Array, lengths: Array) -> Robot:
    """A chain of rods, each hinged to the end of the last.

    Hinges turn about y, and every third about x.
    """
    origins = [ORIGIN, *(length * Z for length in lengths[:-1])]
    links = []
    for i, (mass, length, origin) in enumerate(zip(masses, lengths, origins, strict=True)):
        axis = X if i % 3 == 2 else Y
        links.append(Link(i - 1, "revolute", origin, axis, mass, *_rod(mass, length * Z)))
    return robot_from_links(links, "chain")


def bent(robot: Robot, scale: float = 1.0) -> Posture:
    """A chain that is bent at every joint, by angles that repeat."""
    joints = {name: scale * BEND[i % len(BEND)] for i, name in enumerate(robot.joint_names)}
    return Posture(base_rpy_deg=(0.0, 25.0, 0.0), joints=joints)


def landing(
    robot: Robot, *contacts: Contact | str, strike: Strike = OBLIQUE, **parts: Any
) -> Built:
    """A robot, and its landing on contacts or on the origins of frames.

    Other parts of the scene are given by name. The base is free unless the scene says otherwise; by
    default a chain would be fixed, as an arm is. Rotors add to the diagonal of the inertia alone,
    as in the other methods that are measured.
    """
    parts.setdefault("base", "free")
    parts["joints"] = replace(parts.get("joints", Joints()), carried=False)
    placed = []
    for contact in contacts:
        if isinstance(contact, str):
            contact = Contact(frame=contact, at="frame", kind="point")
        placed.append(contact)
    return robot, Scene(robot=robot.name, strike=strike, contact=tuple(placed), **parts)


def _family(
    about: str, parameter: str, variants: dict[str, Any], values: tuple[Any, ...]
) -> Callable[[Build], Build]:
    """Make a function that builds landings a family, which has the function's name.

    Arguments are those of `Family`.
    """

    def add(build: Build) -> Build:
        name = build.__name__.strip("_").replace("_", " ")
        FAMILIES[name] = Family(name, about, parameter, variants, values, build)
        return build

    return add


@_family(
    "Robots of example-robot-data, with links without mass (romeo, human) and condition numbers up "
    "to 9e18 (icub)",
    "robot",
    {"one foot": 1, "all feet": None},
    (*SETS["quadrupeds"], *SETS["bipeds"], "human"),
)
def _robots(feet: int | None, name: str) -> Built:
    robot = known_robot(name)
    return landing(robot, *each_foot(robot)[:feet])


@_family(
    "Six links with a large ratio of masses: light ones are lost in sums, and small motions are "
    "differences of large ones",
    "mass ratio [-]",
    ENDS,
    (1e10, 1e20),
)
def _mass_ratio(variant: tuple[bool, bool], ratio: float) -> Built:
    at_root, rooted_light = variant
    masses = np.geomspace(ratio**-0.5, ratio**0.5, 6)
    if not rooted_light:
        masses = masses[::-1]
    robot = chain(masses, np.full(6, 0.4))
    contact: Contact | str = "link0"
    if not at_root:
        contact = Contact(frame="link5", offset=(0.0, 0.0, 0.4))
    return landing(robot, contact, posture=bent(robot))


@_family(
    "A knee that straightens, struck along the leg, which cannot move that way then: a fixed base "
    "has no solution or verdict",
    "knee angle [rad]",
    BASES,
    (0.0, 1e-9, 1e-5),
)
def _knee(variant: tuple[Any, Any], angle: float) -> Built:
    base, directions = variant
    posture = Posture(reference="neutral", joints={"hind_hip": -0.5 * angle, "hind_knee": angle})
    foot = Contact(frame="hind_foot", directions=directions)
    return landing(known_robot("quadruped"), foot, strike=Strike(), base=base, posture=posture)


@_family(
    "Chains of equal links: the motion of a distant link is a small difference of long sums",
    "number of links [-]",
    {"struck at the end": 0.0, "struck in the middle": 0.5},
    (10, 50, 200),
)
def _links(where: float, n: int) -> Built:
    robot = chain(np.full(n, 1.0), np.full(n, 0.2))
    # Angles that shrink with the number of links keep a long chain from winding into itself.
    return landing(robot, f"link{int(where * n)}", posture=bent(robot, 1.0 / math.sqrt(n)))


@_family(
    "ANYmal B with drives from free to almost locked: large reflected inertias dominate the "
    "diagonal of H",
    "reflected inertia [kg m²]",
    {"one foot": 1, "four feet": 4},
    (1e-18, 1e-3, 1e12),
)
def _armature(feet: int, inertia: float) -> Built:
    joints = Joints(armature={"*": inertia})
    return landing(known_robot("anymal_b"), *ANYMAL_FEET[:feet], joints=joints)


@_family(
    "A leg with a link of almost no mass, whose motion is a quotient of rounding errors; without "
    "mass it is not determined",
    "mass of the link [kg]",
    LIMBS,
    (0.0, 1e-15, 1e-10),
)
def _light_link(variant: tuple[float | None, ...], light: float) -> Built:
    body = Link(-1, "", ORIGIN, Y, 10.0, 0.1 * Z, box_inertia(10.0, (0.4, 0.3, 0.2)))
    masses = [light if mass is None else mass for mass in variant]
    # Hip, knee, ankle, and an arm on the body: parent, origin, axis, and the rod's end.
    joints = (
        (0, ORIGIN, Y, -0.3 * Z),
        (1, -0.3 * Z, 0.6 * Y + 0.8 * Z, -0.3 * Z),
        (2, -0.3 * Z, Y, -0.3 * Z),
        (0, 0.1 * X + 0.1 * Z, X, 0.3 * Z),
    )
    limbs = []
    for mass, (parent, origin, axis, end) in zip(masses, joints, strict=False):
        limbs.append(Link(parent, "revolute", origin, axis, mass, *_rod(mass, end)))
    foot = Contact(frame="link3", offset=(0.0, 0.0, -0.3))
    posture = Posture(joints={"joint1": 0.4, "joint2": -0.9, "joint3": 0.6})
    return landing(robot_from_links([body, *limbs], "light"), foot, posture=posture)


@_family(
    "One robot in other units of length and mass, which set the condition number of H: it holds "
    "masses and moments of inertia",
    "units of length in one metre [-]",
    {"kg": 1.0, "g": 1e3},
    (1e-3, 1e3, 1e6),
)
def _units(mass: float, length: float) -> Built:
    masses = mass * np.array([8.0, 2.0, 1.0, 3.0, 0.5])
    lengths = length * np.array([0.5, 0.3, 0.2, 0.4, 0.1])
    robot = chain(masses, lengths)
    foot = Contact(frame="link4", offset=(0.0, 0.0, 0.1 * length))
    strike = Strike(velocity=(0.4 * length, 0.1 * length, -0.9 * length))
    return landing(robot, foot, posture=bent(robot), strike=strike)


@_family(
    "A box with a mast that lands on several corners: from the third on rows are dependent, and "
    "the KKT matrix is singular",
    "corners [-]",
    {"sticking": STICKING, "sliding": ("z",)},
    (1, 4),
)
def _corners(directions: Any, n: int) -> Built:
    body = Link(
        -1, "", ORIGIN, Y, 7.0, np.array([0.02, 0.01, 0.03]), box_inertia(7.0, (0.6, 0.4, 0.2))
    )
    hinge, axis = np.array([0.1, 0.05, 0.1]), 0.6 * X + 0.8 * Y
    mast = Link(0, "revolute", hinge, axis, 1.0, *_rod(1.0, 0.4 * Z))
    corners = (-0.3, -0.2, -0.1), (-0.3, 0.2, -0.1), (0.3, -0.2, -0.1), (0.3, 0.2, -0.1)
    contacts = []
    for corner in corners[:n]:
        contacts.append(Contact(frame="link0", offset=corner, directions=directions))
    return landing(robot_from_links([body, mast], "brick"), *contacts)


@_family(
    "ANYmal B with locked joints on several feet: up to twelve rows on a mechanism with six to ten "
    "degrees of freedom",
    "feet [-]",
    {"locked": Joints(model="locked"), "hips free": Joints(locked=("*HFE", "*KFE"))},
    (1, 2, 4),
)
def _locked_feet(joints: Joints, feet: int) -> Built:
    return landing(known_robot("anymal_b"), *ANYMAL_FEET[:feet], joints=joints)


@_family(
    "A foot of ANYmal B that strikes with two points: they stop a rotation by rows that differ "
    "only by their distance",
    "distance [m]",
    {"with another foot": "RH_FOOT"},
    (1e-8, 1e-5, 1e-2),
)
def _doubled_contact(second_foot: str, apart: float) -> Built:
    beside = Contact(frame="LF_FOOT", offset=(apart, 0.0, 0.0))
    return landing(known_robot("anymal_b"), "LF_FOOT", second_foot, beside)


@_family(
    "A four-bar linkage almost folded into a line, where a closure row vanishes; closed in space, "
    "another row is dependent",
    "height over length [-]",
    {"closed in the plane": ("x", "z"), "closed in space": STICKING},
    (0.0, 1e-10, 1.0),
)
def _flat_four_bar(directions: Any, height: float) -> Built:
    # Drawn closed, so that every angle is zero: ends of crank and coupler, and the rocker's hinge,
    # from the crank's hinge.
    crank = 0.5 * X + height * Z
    coupler = 1.1 * X - 0.7 * height * Z
    rocker = 1.6 * X
    hinge = -0.8 * X - 0.1 * Z
    links = [
        Link(-1, "", ORIGIN, Y, 9.0, 0.03 * X + 0.1 * Z, box_inertia(9.0, (1.6, 0.3, 0.3))),
        Link(0, "revolute", hinge, Y, 0.8, *_rod(0.8, crank)),
        Link(1, "revolute", crank, Y, 0.6, *_rod(0.6, coupler - crank)),
        Link(0, "revolute", hinge + rocker, Y, 0.7, *_rod(0.7, coupler - rocker)),
    ]
    closure = Closure(
        a=LoopEnd(frame="link2", offset=tuple(coupler - crank)),
        b=LoopEnd(frame="link3", offset=tuple(coupler - rocker)),
        directions=directions,
    )
    foot = Contact(frame="link1", offset=(0.2, 0.0, -0.1))
    return landing(robot_from_links(links, "four_bar"), foot, closure=(closure,))


@_family(
    "ANYmal B far from the origin of the world: velocities written there multiply every rotation "
    "by the distance",
    "distance [m]",
    {"one foot": "LF_FOOT"},
    (1e6, 1e9),
)
def _far_from_the_origin(foot: str, away: float) -> Built:
    posture = Posture(base_position=(away, -0.3 * away, 0.5))
    return landing(known_robot("anymal_b"), foot, posture=posture)
