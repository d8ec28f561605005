"""MJCF: what would be read otherwise than MuJoCo reads it is refused by name, with a remedy that works."""

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import BODY, body, floating, mjcf

from shockpc.errors import RobotError
from shockpc.robot.build import build_model
from shockpc.robot.source import read_source


@pytest.fixture(autouse=True)
def logs_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """MuJoCo writes its warnings into a file in the current folder."""
    monkeypatch.chdir(tmp_path)


MESH = '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'


def refusal(folder: Path, text: str) -> str:
    """The text of the error that reading it raises."""
    (folder / "dog.xml").write_text(text)
    with pytest.raises(RobotError) as caught:
        read_source(str(folder / "dog.xml"))
    return str(caught.value)


SAVE = (
    'Have MuJoCo work it out: compile the file once with <compiler saveinertial="true"/> and give what mujoco.mj_saveLastXML writes'
)
PAIR = mjcf(floating(body("b"), body("c", joints='<joint name="k"/>')))


def among(text: str, section: str) -> str:
    """The pair of bodies with a section after them."""
    return text.replace("</mujoco>", f"{section}</mujoco>")


LED, HELD = '<joint joint1="k" joint2="j"/>', '<joint joint1="k" polycoef="0.1 0 0 0 0"/>'
TO_ITSELF = "to itself, which closes no loop; name two, or take it out"
SAYS_NOTHING = "does not say what it holds; give it site1 and site2 and nothing else"
OF_THE_WORLD = "with body2 unless that is the world"
FREE = mjcf(floating(body("b")).replace('<freejoint name="root"/>', '<joint name="root" type="free"/>'))

REFUSED = {
    "<mujoco/>": "dog.xml has no <body> in a <worldbody>, so there is no robot in it; is it a part for another file?",
    mjcf('<geom size=".1"/>'): "dog.xml has no <body> in a <worldbody>, so there is no robot in it; is it a part for another file?",
    mjcf(floating('<frame><site pos="0 0 1" fromto="0 0 0 1 0 0"/></frame>')): (
        'dog.xml: body "base": a <site> has both pos and fromto; keep one of them'
    ),
    mjcf(floating(), '<compiler inertiafromgeom="yes"/>'): (
        'dog.xml: <compiler> has inertiafromgeom="yes" or an inertiagrouprange that MJCF does not know'
    ),
    mjcf(floating(), '<compiler settotalmass="10"/>'): (
        f'dog.xml: <compiler settotalmass="10"> scales all masses, which Pinocchio does not. {SAVE}'
    ),
    mjcf(floating(), '<compiler balanceinertia="true"/>'): (
        f'dog.xml: <compiler balanceinertia="true"> changes inertias that are not physical, which Pinocchio does not. {SAVE}'
    ),
    mjcf(floating(), '<compiler coordinate="global"/>'): (
        f'dog.xml: <compiler coordinate="global"> reads positions in the world\'s frame, which Pinocchio does not. {SAVE}'
    ),
    mjcf(floating(), '<compiler eulerseq="xyq"/>'): ('dog.xml: <compiler eulerseq="xyq"> has to name three axes, such as "xyz"'),
    mjcf(floating(body("b", at='zaxis="0 0 0"'))): 'dog.xml: body "b": the orientation of its <body> has no direction',
    mjcf(floating(body("b", at='xyaxes="1 0 0 2 0 0"'))): 'dog.xml: body "b": the orientation of its <body> has no direction',
    mjcf(floating(body("b", '<inertial mass="1" diaginertia="1 1 1" pos="0 0 0" quat="0 0 0 0"/>'))): (
        'dog.xml: body "b": the orientation of its <inertial> has no direction'
    ),
    **{
        mjcf(floating(f"<{tag}/>")): (
            f"dog.xml: there is a <{tag}> among the bodies, and Pinocchio passes over what it stands for. {SAVE}"
        )
        for tag in ("replicate", "composite", "flexcomp", "attach")
    },
    among(PAIR, '<equality><joint joint1="j" joint2="k" polycoef="0 1 0.5 0 0"/></equality>'): (
        "dog.xml: the equality joint couples joints by a curve, polycoef 0 1 0.5 0 0; only proportion can be computed: "
        "give it as a0 a1 0 0 0, the slope at the posture of interest"
    ),
    among(PAIR, '<equality><tendon name="belt" tendon1="t"/></equality>'): (
        'dog.xml: the equality tendon "belt" couples bodies in a way that is not computed, and without it the numbers would be '
        'wrong; valid are connect, weld and joint; set active="false" to do without it on purpose'
    ),
    **{
        among(PAIR, f'<equality><weld {words} body1="b" body2="c"/></equality>'): (
            f'dog.xml: the equality weld{name} has torquescale="0", so it holds a point and no orientation; give it as a connect'
        )
        for name, words in (("", 'torquescale="0"'), (' "w"', 'name="w" torquescale="0.0"'))
    },
    **{
        among(PAIR, f"<equality>{first}{second}</equality>"): (
            'dog.xml: two equalities have joint1="k", and a joint can follow only once; turn one of them round (joint1 and joint2 '
            'exchanged, polycoef="-a0/a1 1/a1 0 0 0"), or set active="false" to do without it'
        )
        for first, second in ((LED, HELD), (HELD, LED), (LED, LED))
    },
    among(PAIR, '<equality><joint name="belt" joint2="k"/></equality>'): (
        'dog.xml: the equality joint "belt" names no joint1, so nothing follows; name the joint that does'
    ),
    **{
        among(PAIR, f"<equality><{tie}/></equality>"): f"dog.xml: the equality {told}"
        for tie, told in (
            ('connect body1="b" body2="b" anchor="0 0 1"', f'connect holds body "b" {TO_ITSELF}'),
            ('connect body1="world" anchor="0 0 1"', f'connect holds body "world" {TO_ITSELF}'),
            ('weld name="w" site1="s" site2="s"', f'weld "w" holds site "s" {TO_ITSELF}'),
            ('connect body1="b" body2="c"', f"connect {SAYS_NOTHING}, or body1 and anchor, {OF_THE_WORLD}"),
            ('connect body2="c" anchor="0 0 1"', f"connect {SAYS_NOTHING}, or body1 and anchor, {OF_THE_WORLD}"),
            ('connect site1="s" body2="c"', f"connect {SAYS_NOTHING}, or body1 and anchor, {OF_THE_WORLD}"),
            ('connect site1="s" site2="t" anchor="0 0 1"', f"connect {SAYS_NOTHING}, or body1 and anchor, {OF_THE_WORLD}"),
            ('weld body2="c"', f"weld {SAYS_NOTHING}, or body1, {OF_THE_WORLD}"),
            ('connect body1="b" anchor="0 0"', 'connect: anchor is "0 0"; it has to be 3 finite numbers'),
            ('weld body1="b" relpose="0 0 1"', 'weld: relpose is "0 0 1"; it has to be 7 finite numbers'),
        )
    },
    **{
        text: (
            f'dog.xml: body "base": joint "root" is free and has armature {value}, its own or its default class\'s: MuJoCo adds '
            'that to the mass and the inertia of the whole robot, but a free base has no drive; set armature="0" there, or make it '
            "a <freejoint/>, which takes no defaults"
        )
        for text, value in (
            (FREE.replace('type="free"', 'type="free" armature="0.50"'), "0.5"),
            (FREE.replace("<worldbody>", '<default><joint armature="0.2"/></default><worldbody>'), "0.2"),
        )
    },
    among(PAIR, '<tendon><fixed armature="0.5"><joint joint="j" coef="1"/></fixed></tendon>'): (
        "dog.xml: <fixed> has armature 0.5, which Pinocchio reads at joints only; give the joint that armature, "
        "times gear² for an actuator"
    ),
    among(PAIR, '<actuator><motor joint="j" armature="0.1"/></actuator>'): (
        "dog.xml: <motor> has armature 0.1, which Pinocchio reads at joints only; give the joint that armature, "
        "times gear² for an actuator"
    ),
    mjcf(floating(), "<default><motor armature='.1'/></default>"): (
        "dog.xml: <motor> has armature .1, which Pinocchio reads at joints only; give the joint that armature, "
        "times gear² for an actuator"
    ),
    mjcf(floating(body("b", '<geom type="mesh" mesh="m"/>')), MESH): (
        'dog.xml: body "b" takes its mass from a mesh, and meshes are not weighed here; give it an <inertial>. ' + SAVE
    ),
    mjcf(floating(body("b", '<geom type="box" size="1 1 1" shellinertia="true"/>'))): (
        f'dog.xml: body "b": a geom asks for the inertia of a shell, which Pinocchio does not compute. {SAVE}'
    ),
    mjcf(floating(body("b"), body("b", joints='<joint name="k"/>'))): 'dog.xml: two body elements are called "b"; rename one',
    mjcf(floating(body("b"), body("c"))): 'dog.xml: two joint elements are called "j"; rename one',
    mjcf(floating() + floating().replace("base", "other")): (
        'dog.xml holds 2 separate moving bodies, "base", "other"; keep one robot in the file'
    ),
    mjcf(body("b", joints="")): "dog.xml: no body in it has a joint, so nothing moves; give the robot's base a <freejoint/>",
    mjcf(floating(body("b", joints='<joint class="leg"/>')), '<default><default class="arm"/></default>'): (
        'dog.xml: default class "leg" is used but not defined; there are "arm", "main"'
    ),
    mjcf(floating(body("b", '<inertial pos="0 0 0" mass="nan" diaginertia="1 1 1"/>'))): (
        'dog.xml: body "b": inertial mass is "nan"; it has to be 1 finite number'
    ),
    mjcf(floating(body("b", '<inertial pos="0 0 0" mass="1" diaginertia="1 x 1"/>'))): (
        'dog.xml: body "b": inertial diaginertia is "1 x 1"; it has to be 3 finite numbers'
    ),
    mjcf(floating(body("b", '<inertial pos="0 0 0" mass="-1" diaginertia="1 1 1"/>'))): (
        'dog.xml: body "b": mass -1 kg with moments (1.0, 1.0, 1.0) kg m² is negative somewhere; no body has that'
    ),
    mjcf(floating(body("b", '<inertial pos="0 0 0" mass="1"/>'))): (
        'dog.xml: body "b": its <inertial> has no diaginertia or fullinertia; add it, '
        "or drop the <inertial> to take it from the geoms"
    ),
    mjcf(floating(body("b", BODY + BODY))): 'dog.xml: body "b" has 2 <inertial> elements; keep one',
    mjcf(floating(body("b", '<geom size=".1" mass="-1"/>'))): (
        'dog.xml: body "b": a geom has negative mass or density; no body has that'
    ),
    mjcf(floating(body("b", joints='<joint name="j" type="screw"/>'))): (
        'dog.xml: body "b": joint "j" is of type "screw", which MJCF does not have; it has free, ball, slide, hinge'
    ),
    mjcf(floating(body("b", joints='<joint name="j" axis="0 0 0"/>'))): (
        'dog.xml: body "b": joint "j": its axis is 0 0 0, so it has no direction to move in; give it one'
    ),
    mjcf(floating(body("b", joints='<joint name="j" armature="-0.1"/>'))): (
        'dog.xml: body "b": joint "j": armature -0.1 is negative; no rotor has that'
    ),
    mjcf('<body name="a"><freejoint/></body>'): (
        "dog.xml: no body has mass, so nothing in it can be struck; give the bodies <inertial> or geoms with mass"
    ),
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_would_be_read_wrongly_is_refused(text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """Where Pinocchio and MuJoCo would differ, the file is refused with what to change."""
    assert refusal(tmp_path, text) == REFUSED[text]
    assert capfd.readouterr() == ("", "")


def test_the_armature_of_a_free_base_can_be_taken_out(tmp_path: Path):
    """Both remedies: none of its own, or a <freejoint/>, to which MuJoCo gives no default either."""
    default = '<default><joint armature="0.2"/></default><worldbody>'
    for text in (FREE.replace('type="free"', 'type="free" armature="0"'), mjcf(floating(body("b")))):
        path = tmp_path / "dog.xml"
        path.write_text(text.replace("<worldbody>", default))
        expected = mujoco.MjModel.from_xml_path(str(path)).dof_armature
        assert not expected[:6].any()
        np.testing.assert_array_equal(build_model(read_source(str(path))).armature, expected)


def test_includes_stay_inside(tmp_path: Path):
    """A missing, repeated or outlying part is refused by name."""
    (tmp_path / "dog").mkdir()
    (tmp_path / "secret.xml").write_text("<mujocoinclude/>")
    (tmp_path / "dog" / "a.xml").write_text('<mujocoinclude><include file="a.xml"/></mujocoinclude>')
    folder = tmp_path / "dog"
    assert refusal(folder, mjcf(floating(), '<include file="none.xml"/>')) == 'dog.xml includes "none.xml", which does not exist'
    assert refusal(folder, mjcf(floating(), '<include file="a.xml"/>')) == (
        'dog.xml includes "a.xml" twice; MuJoCo allows a file once, so save it under two names'
    )
    assert refusal(folder, mjcf(floating(), '<include file="../secret.xml"/>')) == (
        f'dog.xml: "../secret.xml" leads to "{tmp_path / "secret.xml"}", outside the folders that may be read ("{folder}"). '
        "If it belongs to the robot, name the folder that holds it: --package NAME=DIR"
    )


TO_COMPILE = {
    "replicate": mjcf(floating(f'<replicate count="3" offset="1 0 0" euler="0 0 10">{body("b")}</replicate>')),
    "settotalmass": mjcf(floating(body("b")), "<compiler settotalmass='10'/>"),
    "balanceinertia": mjcf(
        floating(body("b", '<inertial pos="0 0 0" mass="1" diaginertia=".1 .2 .9"/>')), "<compiler balanceinertia='true'/>"
    ),
    "mesh": mjcf(floating(body("b", '<geom type="mesh" mesh="m"/>')), MESH),
    "shell": mjcf(floating(body("b", '<geom type="box" size="1 1 1" shellinertia="true"/>'))),
}


@pytest.mark.parametrize("name", TO_COMPILE)
def test_the_remedy_works(name: str, tmp_path: Path):
    """What a refusal says to do makes the file readable, and its mass and diagonal MuJoCo's."""
    text = TO_COMPILE[name]
    assert refusal(tmp_path, text).endswith(SAVE)
    theirs = mujoco.MjModel.from_xml_string(text.replace("<worldbody>", '<compiler saveinertial="true"/><worldbody>'))
    mujoco.mj_saveLastXML(str(tmp_path / "saved.xml"), theirs)
    model = build_model(read_source(str(tmp_path / "saved.xml")))
    state = mujoco.MjData(theirs)
    mujoco.mj_forward(theirs, state)
    inertia = np.zeros((theirs.nv, theirs.nv))
    mujoco.mj_fullM(theirs, state, inertia)
    ours = pin.crba(model, model.createData(), pin.neutral(model))
    np.testing.assert_allclose(np.diag(ours), np.diag(inertia), rtol=1e-5)  # files are saved with 6 digits
