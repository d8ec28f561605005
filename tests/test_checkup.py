"""The check-up: each fault of a robot file is reported by name with its consequence, and a sound file has none."""

from pathlib import Path

import numpy as np
import pytest
from robot_texts import BODY, HINGE, INERTIA, LIMIT, arm, body, floating, joint, link, loaded, mjcf, urdf

from shockpc.robot.checkup import Finding, check_robot
from shockpc.robot.robot import load_robot

FREE = Finding(
    "note",
    "every joint",
    "zero armature (URDF has no place for it): joints are computed without the inertia of their motors; "
    "with geared or locked joints the shock is different",
)


def findings(folder: Path, text: str, name: str = "dog.urdf") -> tuple[Finding, ...]:
    """What the check-up says of a file with this text, but for the armature that no URDF has."""
    return tuple(finding for finding in check_robot(loaded(folder, text, name)) if finding != FREE)


def inertia(xx: str, yy: str, zz: str, xy: str = "0", xz: str = "0", yz: str = "0") -> str:
    """An inertia of a URDF."""
    return f'<inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>'


@pytest.mark.parametrize("name", ["beam", "leg", "quadruped", "solo12", "bolt", "g1"])
def test_sound_robots_have_no_finding_but_the_armature(name: str):
    """The project's own models and some real ones: nothing but the zero armature of every URDF."""
    assert check_robot(load_robot(name)) == (FREE,)


# The inertia of a link: what the check-up says of it, and the principal moments that an analysis warns of.
IMPOSSIBLE = {
    inertia("0.1", "0.1", "0.3"): (
        "the principal moments are 0.1, 0.1 and 0.3 kg m², and no body has one above the sum of the other two",
        "0.1, 0.1, 0.3",
    ),
    inertia("1", "1", "1", xy="2"): ("the principal moments are -1, 1 and 3 kg m², and no body has a negative one", "-1, 1, 3"),
    inertia(*["1e-6"] * 6): (
        "all six entries of the inertia are 1e-06 kg m², which no body has; they look like a placeholder",
        "0, 0, 3e-06",
    ),
    inertia("0", "0", "0"): ("the inertia is zero, that of a point", "0, 0, 0"),
    inertia("-5e-20", "0", "1e-20"): ("the inertia is zero, that of a point", "0, 0, 0"),
}


def inertia_warning(path: str, listed: str, name: str = "") -> tuple[str, ...]:
    """What an analysis says of bodies with such moments."""
    return (
        f"{path.rpartition('/')[2]}: no body has such principal moments: {listed}. None can be negative or above the sum of the "
        "other two, and not all can be zero; shock is computed from them all the same. Correct the file; the links at fault: "
        f"shockpc robots {name or path}",
    )


@pytest.mark.parametrize("text", IMPOSSIBLE)
def test_impossible_inertias_are_found(text: str, tmp_path: Path):
    """A tensor that no distribution of mass has: the check-up names the link, and the loaded robot warns of the moving body."""
    fault, moments = IMPOSSIBLE[text]
    found = findings(tmp_path, arm(tip=link("tip", inertia=text)))
    assert found == (Finding("warning", 'link "tip"', f"{fault}; shock is computed from it all the same"),)
    path = str(tmp_path / "dog.urdf")
    assert load_robot(path).warnings == inertia_warning(path, f'"tip" ({moments} kg m²)')


def test_many_such_bodies_are_one_warning_and_one_finding(tmp_path: Path):
    """Some by name, in the order of the tree, and how many more."""
    parts = [link("base")]
    for name in "abcdef":
        parts += [link(name, inertia=inertia("0.1", "0.1", "0.3")), joint(f"to_{name}", "base", name)]
    (found,) = findings(tmp_path, urdf(*parts))
    assert found.where == 'links "a", "b", "c" and 3 more'
    path, listed = str(tmp_path / "dog.urdf"), ", ".join(f'"{name}" (0.1, 0.1, 0.3 kg m²)' for name in "abcd")
    assert load_robot(path).warnings == inertia_warning(path, f"{listed} and 2 more")


def test_inertia_of_a_body_includes_what_is_fixed_to_it(tmp_path: Path):
    """A sensor with an impossible inertia on a heavy body is a finding of the check-up, and no warning of an analysis."""
    sensor = link("sensor", "0.01", inertia("0.001", "0.001", "0.003")) + joint("screws", "tip", "sensor", "fixed")
    robot = loaded(tmp_path, arm().replace("</robot>", f"{sensor}</robot>"))
    assert [finding.where for finding in check_robot(robot) if finding.level == "warning"] == ['link "sensor"']
    assert robot.warnings == ()


def test_real_robots_with_impossible_inertias():
    """Four of the robots known by name are told of; what others have wrong is too small to matter, or sound with what it is on."""
    odd = {
        "romeo_small": '"RShoulderYawLink" (0.000662, 0.000679, 0.00657 kg m²), "RElbowYawLink" (0.000211, 0.000347, 0.00213 kg m²)'
    }
    for name in ("romeo_small", "anymal_b", "hyq", "tiago", "pr2", "talos", "baxter", "panda"):
        robot = load_robot(name)
        found = tuple(warning for warning in robot.warnings if "principal moments" in warning)
        assert found == (inertia_warning(str(robot.source.path), odd[name], name) if name in odd else ())
    for name, count in (("icub", 10), ("icub_reduced", 7), ("romeo_laas_small", 4)):
        (found_,) = (warning for warning in load_robot(name).warnings if "principal moments" in warning)
        assert found_.count(" kg m²)") == 4
        assert (f" and {count - 4} more. None" in found_) == (count > 4)


@pytest.mark.parametrize(
    ("mass", "text"),
    [
        *(
            ("1", text)
            for text in (inertia("0.1", "0.1", "0.2"), inertia("0.1", "0.1", "0"), inertia("0.1", "0.1", "0.2012"), INERTIA)
        ),
        ("1e-6", inertia("1e-15", "1e-15", "1e-15")),
    ],
)
def test_possible_inertias_are_accepted(mass: str, text: str, tmp_path: Path):
    """A flat plate, a rod, numbers rounded to two digits, a grain of sand: all right."""
    assert findings(tmp_path, arm(base=link("base", mass, text), tip=link("tip", mass, text))) == ()
    assert load_robot(str(tmp_path / "dog.urdf")).warnings == ()


def test_massless_bodies(tmp_path: Path):
    """A moving body without mass beyond it makes the model singular; one that carries mass does not."""
    chain = urdf(
        link("base"), '<link name="cross"/>', link("tip"), '<link name="finger"/>', '<link name="nail"/>',
        joint("j", "base", "cross"), joint("k", "cross", "tip"),
        joint("l", "base", "finger"), joint("m", "finger", "nail", "fixed"),
    )  # fmt: skip
    assert findings(tmp_path, chain) == (
        Finding(
            "error",
            'body "finger"',
            "no mass here nor on what hangs there, so the inertia matrix cannot be inverted; give mass, or make the joint fixed",
        ),
        Finding("note", 'body "cross"', "no mass here; the shock follows from what hangs on the joints beyond"),
    )


def test_masses_out_of_range(tmp_path: Path):
    """Grams read as kilograms, and a stand-in next to nothing, stand out."""
    heavy = arm(base=link("base", mass="2"), tip=link("tip", mass="1500"))
    assert findings(tmp_path, heavy) == (
        Finding("warning", 'body "tip"', "1500 kg is 750 times the next heaviest; if it is meant in grams, every shock is wrong"),
    )
    light = arm(base=link("base", mass="2"), tip=link("tip", mass="0.01")).replace(
        "</robot>", f"{link('dust', mass='1e-7')}{joint('k', 'base', 'dust')}</robot>"
    )
    assert findings(tmp_path, light) == (
        Finding(
            "warning",
            'body "dust"',
            "1e-07 kg is less than a millionth of the robot's 2.01 kg; if it is a placeholder, its shock has no meaning",
        ),
    )


def test_shapes_without_mass(tmp_path: Path):
    """A link that can be seen and weighs nothing is noted; a bare frame is not."""
    shape = '<link name="shell"><visual><geometry><sphere radius="1"/></geometry></visual></link><link name="frame"/>'
    text = arm().replace("</robot>", f"{shape}{joint('s', 'tip', 'shell', 'fixed')}{joint('f', 'tip', 'frame', 'fixed')}</robot>")
    assert findings(tmp_path, text) == (Finding("note", 'link "shell"', "shapes but no <inertial>, which counts as no mass"),)


JOINTS = {
    joint("elbow", "base", "tip", more='<limit lower="1" upper="-1" effort="1" velocity="1"/>'): (
        "warning", "its lower limit 1 is above its upper limit -1, so every posture is outside them",
    ),
    joint("elbow", "base", "tip", more='<limit effort="1" velocity="1"/>'): (
        "note", "both its limits are 0, so every other posture is outside them; it is computed all the same",
    ),
    joint("elbow", "base", "tip", axis="0 2 0"): ("note", "its axis 0 2 0 is 2 long, not 1; only its direction is used"),
}  # fmt: skip


@pytest.mark.parametrize("elbow", JOINTS)
def test_joints(elbow: str, tmp_path: Path):
    """Limits the wrong way round, limits left at zero, an axis that is not a unit vector."""
    level, text = JOINTS[elbow]
    assert findings(tmp_path, arm(elbow=elbow)) == (Finding(level, 'joint "elbow"', text),)


def test_axis_is_read_by_its_direction_alone(tmp_path: Path):
    """What the note on long axes says is so: twice the axis is the same joint."""
    robots = [loaded(tmp_path, arm(elbow=joint("elbow", "base", "tip", axis=axis))) for axis in ("0 1 1", "0 2 2")]
    np.testing.assert_allclose(*(robot.joint("elbow").axis for robot in robots), atol=1e-15)


def test_mimic_is_listed(tmp_path: Path):
    """A follower is listed with its rule."""
    text = arm(elbow=joint("elbow", "base", "tip", more=f'{LIMIT}<mimic joint="lead" multiplier="-2" offset="0.1"/>'))
    text = text.replace("</robot>", f"{link('third')}{joint('lead', 'base', 'third')}</robot>")
    assert findings(tmp_path, text) == (
        Finding("note", 'joint "elbow"', 'mimics joint "lead" with multiplier -2 and offset 0.1; it adds no freedom of its own'),
    )


def test_meshes_that_do_not_resolve(tmp_path: Path):
    """Lost meshes are one line: how many of how many, the first three by name, and what to do."""
    (tmp_path / "here.stl").write_text("solid")
    names = ("here.stl", "package://dog/a.stl", "../b.stl", "c.stl", "d.stl", "d.stl")
    meshes = "".join(f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in names)
    assert findings(tmp_path, arm(tip=link("tip", more=meshes))) == (
        Finding(
            "warning",
            "4 of 5 meshes",
            'missing, or outside the folders that may be read: "a.stl", "b.stl", "c.stl" and 1 more; figures draw boxes of '
            "equal inertia instead, no number changes. If they lie in a package, say where: --package NAME=DIR",
        ),
    )


def test_mjcf(tmp_path: Path):
    """An MJCF is checked alike: meshes and armature. Inertias that no body has are MuJoCo's to refuse."""
    text = mjcf(
        floating(body("b", BODY, HINGE)),
        '<compiler meshdir="meshes"/><asset><mesh name="m" file="a.stl"/></asset>',
    )
    lost = Finding(
        "warning",
        "1 of 1 meshes",
        'missing, or outside the folders that may be read: "a.stl"; figures draw boxes of equal inertia instead, no number '
        "changes. If they lie in a package, say where: --package NAME=DIR",
    )
    free = FREE._replace(text=FREE.text.replace("URDF has no place for it", "no joint gives one"))
    assert findings(tmp_path, text, "dog.xml") == (lost, free)
    geared = text.replace(HINGE, HINGE.replace("/>", ' armature="0.1"/>'))
    assert findings(tmp_path, geared, "dog.xml") == (lost,)


def test_known_faults_of_real_robots_are_found():
    """ANYmal B's base, HyQ's feet and romeo's fingers are found by name."""
    found = {name: check_robot(load_robot(name)) for name in ("anymal_b", "hyq", "romeo")}
    stand_in = (
        "all six entries of the inertia are 1e-06 kg m², which no body has; they look like a placeholder; "
        "shock is computed from it all the same"
    )
    assert Finding("warning", 'link "base"', stand_in) in found["anymal_b"]
    assert any(finding.text == stand_in and "and 2 more" in finding.where for finding in found["hyq"])
    assert [finding.where for finding in found["romeo"] if finding.level == "error"] == [
        'bodies "LFinger21Link", "LFinger22Link", "LFinger23Link" and 21 more'
    ]
