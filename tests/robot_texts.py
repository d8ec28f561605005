"""Small robot texts for the tests of readers: written out, so that one slip at a time can be put
into them.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

from shockpc import Robot, RobotError, load_robot
from shockpc.robot.formats import read_source
from shockpc.robot.robot import RobotSource

INERTIA = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def link(name: str, mass: str = "1", inertia: str = INERTIA, more: str = "") -> str:
    """A link with mass."""
    return f'<link name="{name}"><inertial><mass value="{mass}"/>{inertia}</inertial>{more}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    axis: str = "0 1 0",
    more: str = LIMIT,
) -> str:
    """A joint; `more` is what stands in it beside its ends and its axis."""
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}<axis xyz="{axis}"/>{more}</joint>'


def urdf(*parts: str, name: str = "r") -> str:
    """A URDF of these parts."""
    return f'<robot name="{name}">{"".join(parts)}</robot>'


def arm(
    *, base: str = link("base"), tip: str = link("tip"), elbow: str = joint("elbow", "base", "tip")
) -> str:
    """Two links and a joint, each replaceable."""
    return urdf(base, tip, elbow)


def xacro(*parts: str, name: str = "r") -> str:
    """A xacro file of these parts."""
    return (
        f'<robot name="{name}" xmlns:xacro="http://www.ros.org/wiki/xacro">{"".join(parts)}</robot>'
    )


BODY = '<inertial pos="0 0 -.1" mass="1" diaginertia=".1 .2 .25"/>'
HINGE = '<joint name="j" axis="0 1 0"/>'


def body(name: str, inside: str = BODY, joints: str = HINGE, at: str = 'pos="0.3 0.1 -0.2"') -> str:
    """An MJCF body."""
    return f'<body name="{name}" {at}>{joints}{inside}</body>'


def mjcf(bodies: str, before: str = "", after: str = "") -> str:
    """An MJCF with these top-level bodies."""
    return f'<mujoco model="m">{before}<worldbody>{bodies}</worldbody>{after}</mujoco>'


def floating(*children: str, at: str = "") -> str:
    """A free base that carries these bodies."""
    return f'<body name="base" {at}><freejoint name="root"/>{BODY}{"".join(children)}</body>'


def written(folder: Path, text: str | bytes, name: str = "dog.urdf") -> str:
    """The path of a file with this text."""
    (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return str(folder / name)


def read(folder: Path, text: str | bytes, name: str = "dog.urdf", **given: Any) -> RobotSource:
    """What is read of a file with this text."""
    return read_source(written(folder, text, name), **given)


def loaded(folder: Path, text: str | bytes, name: str = "dog.urdf", **given: Any) -> Robot:
    """The robot of a file with this text."""
    return load_robot(written(folder, text, name), **given)


def refused(
    error: type[Exception], parts: Iterable[str], act: Callable[..., object], *given: Any
) -> str:
    """The text of the error that a call raises, which has to have all these parts."""
    with pytest.raises(error) as caught:
        act(*given)
    assert [part for part in parts if part not in str(caught.value)] == [], str(caught.value)
    return str(caught.value)


def refusal(folder: Path, text: str | bytes, name: str = "dog.urdf", **given: Any) -> str:
    """The text of the error that loading this file raises."""
    return refused(RobotError, (), lambda: loaded(folder, text, name, **given))


SOLID = '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/>'
LIMITS = '<limit lower="-2" upper="2" effort="9" velocity="9"/>'

STEPPER = urdf(
    link("body", "3", SOLID),
    *(
        link(side, "0.4", SOLID) + joint(f"{side}_leg", "body", side, "prismatic", "0 0 1", LIMITS)
        for side in ("left", "right")
    ),
    '<link name="left_foot"/>',
    joint("left_ankle", "left", "left_foot", "fixed", more='<origin xyz="0 0.1 -0.5"/>'),
    '<link name="right_foot"/>',
    joint("right_ankle", "right", "right_foot", "fixed", more='<origin xyz="0 -0.1 -0.5"/>'),
    name="stepper",
)
"""A body with two legs that slide along the vertical, so that heights of feet are sums."""

BOX = urdf(link("box", mass="2"), name="box")
"""One body."""

COLUMN = urdf(
    link("foot", mass="0.5"),
    link("body", mass="3"),
    joint("slide", "foot", "body", "prismatic", "0 0 1", '<limit effort="50"/>'),
    name="column",
)
"""Two bodies, one of which slides on the other along the vertical."""
