"""The check-up: each fault of a robot file is reported by name with its consequence, and a sound
file has none.
"""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from commands import says
from robot_texts import (
    BODY,
    HINGE,
    INERTIA,
    LIMIT,
    arm,
    body,
    floating,
    joint,
    link,
    loaded,
    mjcf,
    refused,
    urdf,
)
from trees import robot_from

from shockpc import Contact, Robot, Scene, SolveError, load_robot, shock_profile
from shockpc.robot.checkup import Finding, check_robot
from shockpc.studies.sweep.study import sweep

FREE = Finding(
    "note",
    "every joint",
    "zero armature (none is read: no armature or rotor_inertia of <dynamics>, no rotor inertia of "
    "a <transmission>, no rotor_params): joints are computed without the inertia of their motors; "
    "with it, or with locked joints, the shock is different",
)


def inertia(xx: str, yy: str, zz: str, xy: str = "0", xz: str = "0", yz: str = "0") -> str:
    """An inertia of a URDF."""
    return f'<inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>'


@pytest.mark.parametrize("name", ["beam", "leg", "quadruped", "solo12", "bolt", "g1"])
def test_sound_robots_have_no_finding_but_the_armature(name: str):
    """The project's models and some real ones: nothing but the zero armature of every URDF."""
    robot = load_robot(name)
    (finding,) = check_robot(robot)
    if robot.default_drives is None:
        assert finding == FREE
    else:
        assert finding.text.startswith(
            f"no reflected inertia is read from the file: drives of {name}, "
        )


PLATE = inertia("0.1", "0.1", "0.3")
IMPOSSIBLE = {
    PLATE: (
        "the principal moments are 0.1, 0.1 and 0.3 kg m², and no body has one above the sum of "
        "the other two",
        "0.1, 0.1, 0.3",
    ),
    inertia("1", "1", "1", xy="2"): (
        "the principal moments are -1, 1 and 3 kg m², and no body has a negative one",
        "-1, 1, 3",
    ),
    inertia(*["1e-6"] * 6): (
        "all six entries of the inertia are 1e-06 kg m², which no body has; they look like",
        "0, 0, 3e-06",
    ),
    inertia("0", "0", "0"): ("the inertia is zero, that of a point", "0, 0, 0"),
    inertia("-5e-20", "0", "1e-20"): ("the inertia is zero, that of a point", "0, 0, 0"),
}
"""The inertia of a link: what the check-up says of it, and the principal moments that an analysis
warns of.
"""

BEYOND = (
    "; none can be negative or above the sum of the other two, and not all can be zero. Correct "
    "the file; "
)


def moments(robot: Robot) -> list[str]:
    """The bodies, with moments, of which an analysis says that no body has such an inertia."""
    said = [text for text in robot.warnings if "principal moments" in text]
    assert all(
        BEYOND in text and text.endswith(f"shockpc robots {robot.label} lists the links")
        for text in said
    )
    return [
        text.partition(": no body has such principal moments: ")[2].partition("; none")[0]
        for text in said
    ]


@pytest.mark.parametrize("text", IMPOSSIBLE)
def test_impossible_inertias_are_found(text: str, tmp_path: Path):
    """A tensor that no distribution of mass has: the check-up names the link, and the loaded robot
    warns of the moving body.
    """
    fault, listed = IMPOSSIBLE[text]
    robot = loaded(tmp_path, arm(tip=link("tip", inertia=text)))
    (found,) = set(check_robot(robot)) - {FREE}
    assert found[:2] == ("warning", 'link "tip"')
    assert found.text.startswith(fault)
    exception = (
        ", except where the inertia matrix is not positive definite"
        if listed.startswith("-")
        else ""
    )
    assert found.text.endswith(f"; shock is computed from it all the same{exception}")
    assert moments(robot) == [f'"tip" ({listed} kg m²)']


@pytest.mark.parametrize("base", ["0.1", "5"], ids=["light base", "heavy base"])
@pytest.mark.parametrize(
    "text",
    [
        inertia("-0.2", "0.1", "0.1"),
        inertia("0.1", "-0.2", "0.1"),
        inertia("-9e-6", "0.1", "0.1"),
        inertia("0.1", "-9e-6", "0.1"),
        inertia("0.1", "0.1", "0.1", xz="0.3"),
        inertia("1", "1", "1", xy="2"),
    ],
)
def test_negative_moments_are_refused_where_some_motion_would_have_negative_energy(
    text: str, base: str, tmp_path: Path
):
    """However they are written: by the eigenvalues of H of Pinocchio, with the link and its
    moments; else they are warned of.
    """
    robot = loaded(
        tmp_path,
        arm(base=link("base", inertia=inertia(base, base, base)), tip=link("tip", inertia=text)),
    )
    scene = Scene(robot=robot.label, contact=(Contact(frame="tip", offset=(0.0, 0.0, -0.1)),))
    frame = robot.model.frames[robot.model.getFrameId("tip")]
    moments = ", ".join(f"{moment:.3g}" for moment in np.linalg.eigvalsh(frame.inertia.inertia))
    H = pin.crba(robot.model, robot.model.createData(), pin.neutral(robot.model))
    if np.linalg.eigvalsh(H).min() > 0.0:
        assert any(
            f'"tip" ({moments} kg m²)' in str(warning)
            for warning in shock_profile(scene, robot).health.warnings
        )
    else:
        parts = [
            "is not positive definite",
            f'because of the principal moments of "tip" ({moments} kg m²)',
        ]
        refused(SolveError, parts, shock_profile, scene, robot)
        made = sweep(scene, {"strike-angle": [0.0, 20.0]}, robot=robot, prove=0)
        assert all("is not positive definite" in text for text in made.chunk(0).messages.values())
        assert len(made.chunk(0).messages) == 2


def test_real_robots_with_impossible_inertias():
    """Of robots known by name; what others have wrong is too small to matter, or sound with what it
    is on.
    """
    small = (
        '"RShoulderYawLink" (0.000662, 0.000679, 0.00657 kg m²), "RElbowYawLink" (0.000211, '
        "0.000347, 0.00213 kg m²)"
    )
    for name in ("romeo_small", "anymal_b", "hyq", "tiago", "pr2", "talos", "baxter", "panda"):
        assert moments(load_robot(name)) == [small] * (name == "romeo_small")
    for name, count in (("icub", 10), ("icub_reduced", 7), ("romeo_laas_small", 4)):
        (listed,) = moments(load_robot(name))
        assert listed.count(" kg m²)") == 4
        assert listed.endswith(f" and {count - 4} more") == (count > 4)


MESHES = "".join(
    f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    for name in ("here.stl", "package://dog/a.stl", "../b.stl", "c.stl", "d.stl", "d.stl")
)
LOST = (
    "missing, or outside the folders that may be read: {}; contacts on these links are at the "
    "origins of their frames"
)
SHELL = (
    '<link name="shell"><visual><geometry><sphere radius="1"/></geometry></visual></link><link '
    'name="frame"/>'
)
SENSOR = link("sensor", "0.01", inertia("0.001", "0.001", "0.003"))
LOST_MJCF = mjcf(
    floating(body("b", BODY, HINGE)),
    '<compiler meshdir="meshes"/><asset><mesh name="m" file="a.stl"/></asset>',
)


def sound(mass: str, text: str) -> str:
    """Two links of this mass and inertia."""
    return arm(base=link("base", mass, text), tip=link("tip", mass, text))


FOUND: dict[str, list[tuple[str, str, str]]] = {
    # A flat plate, a rod, numbers rounded to two digits, a grain of sand: all right.
    **{sound("1", inertia("0.1", "0.1", z)): [] for z in ("0.2", "0", "0.2012")},
    sound("1", INERTIA): [],
    sound("1e-6", inertia("1e-15", "1e-15", "1e-15")): [],
    urdf(
        link("base"),
        *(link(name, inertia=PLATE) + joint(f"to_{name}", "base", name) for name in "abcdef"),
    ): [("warning", 'links "a", "b", "c" and 3 more', "the principal moments are")],
    # What is fixed to a body is part of it.
    arm().replace("</robot>", SENSOR + joint("s", "tip", "sensor", "fixed") + "</robot>"): [
        ("warning", 'link "sensor"', "the principal moments are")
    ],
    # A moving body without mass beyond it makes the model singular; one that carries mass does not.
    urdf(
        *map(link, ("base", "tip")),
        *(f'<link name="{name}"/>' for name in ("cross", "finger", "nail")),
        joint("j", "base", "cross"),
        joint("k", "cross", "tip"),
        joint("l", "base", "finger"),
        joint("m", "finger", "nail", "fixed"),
    ): [
        ("error", 'body "finger"', "no mass here nor on the bodies that it carries"),
        ("note", 'body "cross"', "no mass here"),
    ],
    # Grams read as kilograms, and a stand-in next to nothing.
    arm(base=link("base", "2"), tip=link("tip", "1500")): [
        ("warning", 'body "tip"', "1500 kg is 750 times the next heaviest")
    ],
    urdf(
        link("base", "2"),
        link("tip", "0.01"),
        link("dust", "1e-7"),
        joint("j", "base", "tip"),
        joint("k", "base", "dust"),
    ): [
        ("warning", 'body "dust"', "1e-07 kg is less than a millionth of the robot's 2.01 kg"),
        (
            "warning",
            'link "tip"',
            "its moments of inertia have a radius of gyration of 3.16 m, and without shapes",
        ),
        (
            "warning",
            'link "dust"',
            "its moments of inertia have a radius of gyration of 1e+03 m, and without shapes",
        ),
    ],
    # A link that can be seen and weighs nothing is noted; a bare frame is not.
    arm().replace(
        "</robot>",
        f"{SHELL}{joint('s', 'tip', 'shell', 'fixed')}{joint('f', 'tip', 'frame', 'fixed')}</robot>",
    ): [("note", 'link "shell"', "shapes but no <inertial>")],
    arm(
        elbow=joint(
            "elbow", "base", "tip", more='<limit lower="1" upper="-1" effort="1" velocity="1"/>'
        )
    ): [
        (
            "warning",
            'joint "elbow"',
            "its lower limit 1 is above its upper limit -1, so every posture is outside them",
        )
    ],
    arm(
        elbow=joint(
            "elbow", "base", "tip", more='<limit lower="0" upper="0" effort="1" velocity="1"/>'
        )
    ): [
        (
            "note",
            'joint "elbow"',
            "both its limits are 0, so every other posture is outside them",
        )
    ],
    arm(elbow=joint("elbow", "base", "tip", axis="0 2 0")): [
        ("note", 'joint "elbow"', "its axis 0 2 0 is 2 long, not 1")
    ],
    urdf(
        *map(link, "abc"),
        joint("lead", "a", "b"),
        joint("elbow", "a", "c", more=f'{LIMIT}<mimic joint="lead" multiplier="-2" offset="0.1"/>'),
    ): [("note", 'joint "elbow"', "following others (mimic), without a degree of freedom")],
    arm(tip=link("tip", more=MESHES)): [
        ("warning", "4 of 5 meshes", LOST.format('"a.stl", "b.stl", "c.stl" and 1 more'))
    ],
    # What an analysis warns of.
    arm(elbow=joint("elbow", "base", "tip", more=f'{LIMIT}<mimic joint="nobody"/>')): [
        (
            "warning",
            "dog.urdf",
            'joint "elbow": mimics "nobody", which does not exist, so it moves freely',
        )
    ],
    # Inertias that no body has are MuJoCo's to refuse.
    LOST_MJCF: [
        ("warning", "1 of 1 meshes", LOST.format('"a.stl"')),
        (
            "note",
            "every joint",
            "zero armature (no joint and no actuator on a joint has one): joints are",
        ),
    ],
    LOST_MJCF.replace(HINGE, HINGE.replace("/>", ' armature="0.1"/>')): [
        ("warning", "1 of 1 meshes", LOST.format('"a.stl"'))
    ],
}


@pytest.mark.parametrize("text", FOUND, ids=range(len(FOUND)))
def test_each_fault_is_found(text: str, tmp_path: Path):
    """By the level, the name and what it means; besides, there is only the armature that no URDF
    has.
    """
    (tmp_path / "here.stl").write_text("solid")
    robot = loaded(tmp_path, text, "dog.xml" if "<mujoco" in text else "dog.urdf")
    found = [finding for finding in check_robot(robot) if finding != FREE]
    assert [finding[:2] for finding in found] == [expected[:2] for expected in FOUND[text]]
    assert all(
        expected[2] in finding.text for finding, expected in zip(found, FOUND[text], strict=True)
    )
    # An analysis warns of inertias of moving bodies alone: the first four by name.
    six = [", ".join(f'"{name}" (0.1, 0.1, 0.3 kg m²)' for name in "abcd") + " and 2 more"]
    assert moments(robot) == (six if found and found[0].where.startswith("links") else [])


def test_axis_is_read_by_its_direction_alone(tmp_path: Path):
    """What the note on long axes says is so: twice the axis is the same joint."""
    robots = [
        loaded(tmp_path, arm(elbow=joint("elbow", "base", "tip", axis=axis)))
        for axis in ("0 1 1", "0 2 2")
    ]
    np.testing.assert_allclose(*(robot.joint("elbow").axis for robot in robots), atol=1e-15)


def test_known_faults_of_real_robots_are_found():
    """ANYmal B's base, HyQ's feet and romeo's fingers are found by name."""
    found = {name: check_robot(load_robot(name)) for name in ("anymal_b", "hyq", "romeo")}
    stand_in = [
        (one.where, name)
        for name in ("anymal_b", "hyq")
        for one in found[name]
        if "look like a placeholder" in one.text
    ]
    assert ('link "base"', "anymal_b") in stand_in
    assert any(name == "hyq" and "and 2 more" in where for where, name in stand_in)
    assert [finding.where for finding in found["romeo"] if finding.level == "error"] == [
        'bodies "LFinger21Link", "LFinger22Link", "LFinger23Link" and 21 more'
    ]


def bars(*, about_origin: bool) -> str:
    """Bars that hang from their origins, with inertias about these or about their centres."""
    links, joints = [link("base")], []
    for k, (mass, length) in enumerate(((1.0, 0.3), (2.0, 0.4), (0.5, 0.2))):
        across = mass * length**2 / (3.0 if about_origin else 12.0)
        inertia = (
            f'<inertia ixx="{across}" iyy="{across}" izz="{1e-3 * across}" ixy="0" ixz="0" '
            f'iyz="0"/>'
        )
        links.append(link(f"bar{k}", str(mass), f'<origin xyz="0 0 {-length / 2}"/>{inertia}'))
        joints.append(joint(f"hinge{k}", "base", f"bar{k}"))
    return urdf(*links, *joints)


def test_inertias_about_the_origin_of_a_link_are_found(tmp_path: Path):
    """One warning for the file, and none where the same bars are given about their centres."""
    for about_origin in (True, False):
        found = [
            one.text
            for one in check_robot(loaded(tmp_path, bars(about_origin=about_origin)))
            if one.level == "warning"
        ]
        assert len(found) == about_origin
        assert all(says(text, '"bar0", "bar1", "bar2"', "origins") for text in found)


def test_ten_joints_that_follow_one_are_one_line():
    """Whatever their multipliers are; the first three are named."""
    arms = [
        f'{LIMIT}<mimic joint="lead" multiplier="{0.1 * k:g}" offset="{k}"/>' for k in range(10)
    ]
    followers = [joint(f"f{k}", "base", f"l{k}", more=more) for k, more in enumerate(arms)]
    robot = robot_from(
        urdf(
            *map(link, ("base", "tip", *(f"l{k}" for k in range(10)))),
            joint("lead", "base", "tip"),
            *followers,
        )
    )
    (line,) = (found for found in check_robot(robot) if "mimic" in found.text)
    assert line.where == 'joints "f0", "f1", "f2" and 7 more'
