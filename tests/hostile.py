"""Hostile inputs for the fuzzer: files of a small robot, what can be wrong in them, and the commands that read them.

Case i is a function of i alone. Each case is a folder of files, valid at first, of which some are changed, and a command line.
"""

import contextlib
import copy
import os
import random
import re
import struct
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from commands import STICK

ElementTree.register_namespace("xacro", "http://www.ros.org/wiki/xacro")
ElementTree.register_namespace("", "http://www.collada.org/2005/11/COLLADASchema")

TOKEN = "CANARY-8153"
"""In the files outside the open folders; the output must never hold it."""

_MESH = (
    '<visual><geometry><mesh filename="{}"/></geometry></visual><collision><geometry><mesh filename="{}"/></geometry></collision>'
)
_CORNERS = [(0, 0, 0), (0.1, 0, 0), (0, 0.2, 0), (0, 0, -0.3)]
_FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def _stl() -> bytes:
    rows = (struct.pack("<12fH", *[0.0] * 3, *[x for corner in face for x in _CORNERS[corner]], 0) for face in _FACES)
    return b"\0" * 80 + struct.pack("<I", len(_FACES)) + b"".join(rows)


_OBJ = (
    "mtllib part.mtl\n"
    + "".join(f"v {x} {y} {z}\n" for x, y, z in _CORNERS)
    + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in _FACES)
)
_PLY = (
    "ply\nformat ascii 1.0\ncomment TextureFile part.png\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
    + "".join(f"{x} {y} {z} 255\n" for x, y, z in _CORNERS)
    + "".join(f"3 {a} {b} {c}\n" for a, b, c in _FACES)
)
_DAE = f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="i"><init_from>file:///etc/hostname</init_from></image></library_images>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="12">{" ".join(f"{x}" for c in _CORNERS for x in c)}</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{" ".join(str(k) for face in _FACES for k in face)}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
_URDF = STICK.replace("</robot>", "").replace(
    '<link name="shin">', '<link name="shin">' + _MESH.format("part.stl", "package://stick/part.obj")
) + (
    '<link name="arm"><inertial><origin xyz="0 0.1 0" rpy="0 0.1 0"/><mass value="0.3"/>'
    '<inertia ixx="0.003" ixy="0" ixz="0" iyy="0.003" iyz="0" izz="0.0002"/></inertial>'
    + _MESH.format("part.dae", "part.ply")
    + '<collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>'
    '<joint name="shoulder" type="continuous"><origin xyz="0 0.1 0.1" rpy="0.1 0 0"/><parent link="body"/><child link="arm"/>'
    '<axis xyz="1 0 0"/><mimic joint="knee" multiplier="0.5" offset="0.1"/></joint></robot>'
)
_XACRO = """<robot name="stick" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="mass" default="2"/><xacro:property name="length" value="${0.1 + 0.1 * len('abc')}"/>
<xacro:property name="values" value="${xacro.load_yaml('values.yaml')}"/><xacro:include filename="$(find stick)/macros.xacro"/>
<link name="body"><inertial><mass value="$(arg mass)"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/></inertial></link>
<xacro:if value="${values['leg']['mass'] > 0}"><xacro:leg name="shin" z="${-length}"/></xacro:if><link name="foot"/>
<joint name="ankle" type="fixed"><origin xyz="0 0 $(eval -2 * 0.2)"/><parent link="shin"/><child link="foot"/></joint></robot>
"""
_MACROS = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="leg" params="name z:=0 *extra:='' ">
<link name="${name}"><inertial><origin xyz="0 0 ${z}"/><mass value="${values['leg']['mass']}"/>
<inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0002"/></inertial></link>
<joint name="knee" type="continuous"><parent link="body"/><child link="${name}"/><axis xyz="0 1 0"/></joint></xacro:macro></robot>
""".replace(" *extra:=''", "")
_MJCF = """<mujoco model="stick"><compiler angle="radian" autolimits="true"/>
<default><geom density="900"/><default class="leg"><joint axis="0 1 0" armature="0.01" damping="0.1"/></default></default>
<asset><mesh name="part" file="part.stl" scale="1 1 1"/><mesh name="inline" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1"/>
<texture name="t" type="2d" file="part.png"/><material name="m" texture="t" rgba="1 0 0 1"/></asset>
<worldbody><light pos="0 0 3"/><geom name="floor" type="plane" size="1 1 .1"/><body name="body" pos="0 0 1"><freejoint name="root"/>
<inertial pos=".01 0 .05" mass="2" diaginertia=".02 .03 .01"/><geom name="box" type="box" size=".1 .1 .1" material="m"/>
<body name="shin" euler="0 .1 0"><joint name="knee" class="leg" range="-2 2"/><geom type="mesh" mesh="part"/>
<geom name="foot" type="sphere" size=".02" pos="0 0 -.4" rgba="1 1 1 1"/><site name="toe" pos="0 0 -.42"/></body>
<body name="arm" pos="0 .1 .1"><joint name="shoulder" axis="1 0 0" type="hinge"/><geom type="mesh" mesh="inline"/>
<geom type="capsule" size=".02 .1" fromto="0 0 0 0 .2 0"/></body></body></worldbody><include file="more.xml"/></mujoco>
"""
_MORE = """<mujocoinclude><equality><joint joint1="shoulder" joint2="knee" polycoef="0 .5 0 0 0"/></equality>
<tendon><fixed name="cord"><joint joint="knee" coef="1"/></fixed></tendon><actuator><motor name="drive" joint="knee" gear="5"/></actuator>
<keyframe><key name="stand" qpos="0 0 1 1 0 0 0 0.1 0.2"/></keyframe></mujocoinclude>
"""
_SRDF = """<?xml version="1.0"?><robot name="stick"><group name="leg"><joint name="knee"/></group>
<group_state name="standing" group="leg"><joint name="knee" value="0.3"/></group_state><rotor_params><joint name="knee" mass="1" gear_ratio="5"/></rotor_params></robot>
"""
_SCENE = """robot = "robot.urdf"
plane = "xz"
v_in = "contact"
pulse = "half-sine:5ms"
range_g = 16
stance = []

[posture]
reference = "neutral"
base_rpy_deg = [0, 5, 0]
joints_deg = { knee = 20 }

[strike]
speed = 1.0
strike_angle_deg = 10

[joints]
model = "geared"
armature = { knee = 0.05 }

[[contact]]
frame = "foot"
offset = [0, 0, -0.02]
restitution = 0.1

[[point]]
frame = "body"
offset = [0.1, 0, 0]
"""
_BUDGETS = """[[case]]
name = "land"
scene = "scene.toml"
strike_angle_deg = [0, 10]

[[budget]]
case = "*"
at = "body"
metric = "shock"
max = 5
baseline_tolerance = "5%"

[[budget]]
at = "knee"
metric = "joint_impulse"
max = 100
severity = "warning"
"""
_BASELINE = '{"schema": "shockpc.baseline/1", "shockpc": "1", "cases": {"land": {"robot": "stick"}}, "values": [{"case": "land", "strike_angle_deg": 0, "at": "body", "metric": "shock", "value": 0.5}]}'
_PACKAGE = '<?xml version="1.0"?><package format="2"><name>stick</name><version>1.0.0</version></package>'

FILES: dict[str, str | bytes] = {
    "robot.urdf": _URDF, "robot.urdf.xacro": _XACRO, "macros.xacro": _MACROS, "values.yaml": "leg: {mass: 0.5, name: [a, b]}\n",
    "robot.xml": _MJCF, "more.xml": _MORE, "robot.srdf": _SRDF, "package.xml": _PACKAGE, "scene.toml": _SCENE,
    "budgets.toml": _BUDGETS, "baseline.json": _BASELINE, "part.stl": _stl(), "part.obj": _OBJ, "part.ply": _PLY, "part.dae": _DAE,
    "part.gltf": '{"asset":{"version":"2.0"},"buffers":[{"uri":"../outside/secret.stl","byteLength":36}],"meshes":[]}',
    "part.lws": "LWSC\n3\n\nLoadObjectLayer 1 ../outside/secret.obj\n", "part.mtl": "newmtl m\nmap_Kd ../outside/secret.obj\n",
    "part.irr": '<irr_scene><node type="mesh"><attributes><string name="Mesh" value="../outside/secret.obj"/></attributes></node></irr_scene>',
    "part.msh": struct.pack("<4i12f12i", 4, 0, 0, 4, *[x for c in _CORNERS for x in c], *[k for f in _FACES for k in f]),
}  # fmt: skip
"""A valid robot in three formats, with all that goes with it."""

SECRETS: dict[str, str | bytes] = {
    "secret.xml": f'<robot name="{TOKEN}"><link name="{TOKEN}"/></robot>', "secret.srdf": _SRDF.replace("standing", TOKEN),
    "secret.yaml": f"leg: {{mass: 1, name: {TOKEN}}}\n", "secret.stl": f"solid {TOKEN}\nendsolid\n", "secret.obj": f"o {TOKEN}\n{_OBJ}",
}  # fmt: skip
"""Files that nothing may read."""

NUMBERS = (
    "1e308 -1e308 1e400 nan -nan inf -Infinity 0 -0 -0.0 1e-320 1e-300 1e-20 1e-15 1e-9 1e9 1e15 1e24 1e25 1e77 -1 1 2 0.5 90 255 256 1e3 2147483648 "
    "18446744073709551616 0x10 1_0 ١ 1,5 1e 1e+ .5. -- + NaN(1) true 1;2 0,0,0 1|2|3"
).split() + [
    "",
    " ",
    "0 0 0",
    "1 2",
    "1 2 3 4",
    "1e308 1e308 1e308",
    "nan nan nan",
    "0 0 1e20",
    "1e-30 1e-30 1e-30",
    "9" * 5000,
    "1 " * 3000,
    "1\n2",
]
NAMES = [
    "universe", "world", "root_joint", "", " ", "foot", "body", "knee", "shin", "arm", "base_link", "\x1b[31mred", "\u202eright", "a\nb", "a\tb",
    "a\rb", "\u2066x\u2069", "\u200b", "\ufeff", "x" * 300, "x" * 70_000, "=1+1", "@x", "-x", "+x", "<b>&amp;</b>", "|a|", "$x^2$", "$\\frac{$", "$",
    "\\", "{0.__class__}", "{}", "%s%n", "`id`", "${1}", "é", "足", "😀", "\u2028", "*", "[", "[a-", "foot+body", "foot:0,0,0", "a/b", "../x", "-",
    "--help", "#", '"', "'", "__proto__", "None", "nan", "1", "\x7f", "\x85", "\ue000", "\U000e0001",
]  # fmt: skip
PATHS = [
    "../outside/secret.xml", "../outside/secret.stl", "../outside/secret.yaml", "link", "link.stl", "link.yaml", "pipe", "pipe.stl", "endless", "endless.stl",
    "/dev/zero", "/dev/stdin", "/dev/fd/0", "/proc/self/environ", "/proc/self/mem", "/etc/hostname", "package://stick/../outside/secret.stl",
    "package://outside/secret.stl", "package://../outside/secret.stl", "package://stick/part.stl", "package:///part.stl", "package://", "file:///etc/hostname",
    "file://part.stl", "file://%2e%2e/outside/secret.stl", "http://localhost/x.stl", "ftp://x", "model://stick/part.obj", "data:,x", "", ".", "..", "/", "//",
    "./part.stl", "x" * 300, "x" * 300 + ".stl", "a/" * 2500 + "x.stl", "~nouser/x.stl", "~/x.stl", "$HOME/x", "part.stl/x", "loop", "loop.stl", "part.gltf",
    "part.lws", "part.irr", "part.msh", "part.STL", "part.obj", "part.ply", "part.dae", "robot.urdf", "robot.xml", "more.xml", "package.xml", "big.stl",
]  # fmt: skip
EXPRESSIONS = [
    "${10**10**10}", "$(eval 10**10**8)", "${'x' * 10**10}", "${'{:>4000000000}'.format(1)}", "${'{0.__class__.__mro__}'.format(1)}", "${[0] * 10**10}",
    "${__import__('os')}", "${open('/etc/hostname').read()}", "${xacro.load_yaml('../outside/secret.yaml')}", "${xacro.load_yaml('pipe')}", "${1/0}",
    "${undefined}", "${().__class__}", "${list(range(10**9))}", "${sum(range(10**10))}", "$(env HOME)", "$(optenv HOME x)", "$(find outside)", "$(find ../x)",
    "$(arg nothing)", "$(dirname)", "${'a' 'b'}", "${", "$(", "$$", "${values}", "${length.real}", "${values.leg.mass}", "${values['no']}", "${-length**0.5}",
    "${float('nan')}", "${1e308*10}", "${math.factorial(10**6)}", "${2**100000}", "${hex(2**64)}", "${'\\x1b[31m'}", "${xacro.message('x\\ny')}",
    "${xacro.fatal('no')}", "${'%2000000000d' % 1}", "${max('')}", "${(lambda f: f(f))(lambda f: f(f))}", "${[x for x in ().__class__.__base__.__subclasses__()]}",
]  # fmt: skip
ELEMENTS = [
    '<gazebo><sensor:camera/></gazebo>', '<xacro:left_over/>', '<link name="lost"/>', '<joint name="lost" type="fixed"/>', "<mimic joint='knee'/>",
    '<transmission name="t"/>', "<!-- -- -->", "<![CDATA[x]]>", "<?php x?>", "&x;", "&#0;", "&#x1b;", "<a:b c:d='1'/>", "<include file='more.xml'/>",
    "<include file='robot.xml'/>", "<include file='pipe'/>", "<include file='../outside/secret.xml'/>", '<material name="m"><color rgba="300 -1 nan 1e308"/></material>',
    "<xacro:include filename='pipe'/>", "<xacro:include filename='robot.urdf.xacro'/>", "<xacro:include filename='../outside/secret.xml'/>",
    "<xacro:include filename='*.xacro'/>", "<xacro:macro name='d' params=''><xacro:d/><xacro:d/></xacro:macro><xacro:d/>", "<xacro:insert_block name='x'/>",
    "<xacro:property name='x' value='${x}'/><link name='${x}'/>", "<xacro:if value='maybe'/>", "<xacro:call macro='leg'/>", "<xacro:element xacro:name=''/>",
    '<asset><hfield name="h" file="part.png" size="1 1 1 1"/></asset>', '<asset><model name="n" file="../outside/secret.xml"/></asset>',
    '<asset><mesh name="u" vertex="1e77 0 0 0 1e77 0 0 0 1e77 1 1 1"/></asset>', '<asset><mesh name="w" file="part.obj" scale="1 1"/></asset>',
    '<worldbody><body name="stray"><freejoint/><geom size="1"/></body></worldbody>', '<worldbody><body><joint name="universe"/><geom size=".1"/></body></worldbody>',
    '<worldbody><composite type="cable" count="9 1 1"><geom size=".01"/></composite></worldbody>', '<extension><plugin plugin="mujoco.elasticity.cable"/></extension>',
    '<worldbody><replicate count="100000" offset=".1 0 0"><geom size=".01"/></replicate></worldbody>', '<worldbody><flexcomp name="f" type="grid" count="3 3 3"/></worldbody>',
    '<worldbody><frame euler="nan 0 0"><body><joint type="ball"/><geom size=".1"/></body></frame></worldbody>', '<size memory="1E" nstack="99999999"/>',
    '<equality><connect body1="shin" body2="arm" anchor="0 0 0"/></equality>', '<equality><weld body1="shin" body2="body"/></equality>', "<option timestep='nan'/>",
    '<compiler meshdir="/etc" settotalmass="1e300" inertiafromgeom="true"/>', '<compiler angle="x" eulerseq="abc" strippath="maybe" coordinate="global"/>',
    '<keyframe><key qpos="nan"/><key qpos="1 2 3"/></keyframe>', '<group_state name="lie" group="leg"><joint name="knee" value="nan"/></group_state>',
]  # fmt: skip
LINES = [
    "x = " + "[" * 2000 + "]" * 2000, "x = " + "9" * 5000, "robot = 'pipe'", "robot = 1", "[[contact]]\nframe = 'foot'", "[[contact]]", "[contact]", "a.b.c = 1",
    '"\\u0000" = 1', "x = 1979-05-27T07:32:00", "[[closure]]\nframes = ['foot', 'arm']", "stance = ['body', 'body']", "[packages]\nstick = '/dev'", "[xacro]\nmass = 'x'",
    "srdf = 'pipe'", "srdf = '../outside/secret.srdf'", "srdf = 'robot.srdf'", "joints.rotor = { knee = { inertia = 1e12, gear_ratio = 1e12 } }", "plane = [0, 0, 0]",
    "a: &a [x, x]\nb: &b [*a, *a, *a, *a]\nc: &c [*b, *b, *b, *b]\nd: &d [*c, *c, *c, *c]\ne: &e [*d, *d, *d, *d]\nf: [*e, *e, *e, *e]", "!!python/object/apply:os.system [id]",
    "a: " + "[" * 3000, "<<: *nothing", "a: !!binary x", "? [a, b]\n: c", "---\n...\n---", "a: 2001-99-99", "\t: x", "a: !!float x",
]  # fmt: skip
JUNK = [
    b"\0",
    b"\x1b[2J",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\xe2\x80\xae",
    b"\r",
    b"<",
    b"&",
    b'"',
    b"]]>",
    b"<!DOCTYPE r [<!ENTITY x 'y'>]>",
    b"\xf0\x9f",
    b"A" * 100_000,
]
STARTS = [
    b"\xef\xbb\xbf", b"\xef\xbb\xbf" * 2, b"\xef\xbb\xbf" * 3 + b"<!DOCTYPE robot [<!ENTITY x SYSTEM '../outside/secret.xml'>]>", b"\n\n", b"\xfe\xff", b" " * 70_000,
    b"<!DOCTYPE robot SYSTEM '../outside/secret.xml'>", b'<?xml version="1.0" encoding="iso-8859-1"?>', b'<?xml version="1.0" encoding="utf-16"?>',
    b'<?xml version="1.0" encoding="utf-7"?>', b'<?xml version="1.1"?>', b'<?xml version="1.0" encoding="idna"?>', b'<?xml version="1.0" standalone="no"?>', b"#!/bin/sh\n", b"\0\0",
]  # fmt: skip
OPTIONS = (
    "--contact --point --bodies --set --lock --armature --joint-velocity --stance --srdf --xacro --package --speed --strike-angle --velocity --drop-height --offset "
    "--restitution --plane --pulse --range-g --base-rpy --posture --assemble --v-in --base --joints --contact-point --format --out --save-scene --angular-velocity"
).split()
EXTRAS = [
    "--contact-point lowest", "--joints locked", "--joints geared --armature *=0.05", "--slide", "--bodies *", "--point body:0,0,0.1", "--pulse half-sine:5ms --range-g 4",
    "--velocity 0.3,0.2,-1", "--base fixed", "--base planar", "--set knee=30", "--stance arm", "--srdf robot.srdf", "--explain", "--plane yz", "--angular-velocity 0,1,0",
    "--lock knee", "--contact arm", "--contact shin+arm", "--together --contact *", "--srdf pipe", "--srdf link", "--srdf /dev/zero", "--v-in com", "--posture standing",
    "--package stick=.", "--package other=/dev --package outside=.", "--xacro mass:=3", "--xacro mass:=nan", "--save-scene saved.toml",
]  # fmt: skip


class Case(NamedTuple):
    """A case: files by path below the case's folder, and the words of the command line, which runs in the folder `stick`."""

    files: dict[str, bytes]
    words: list[str]


def case(number: int) -> Case:
    """Case `number`."""
    rng = random.Random(f"case {number}")
    files = {name: content.encode() if isinstance(content, str) else content for name, content in FILES.items()}
    kinds = {
        "analyze robot.urdf --contact foot": (38, ["robot.urdf"] * 7 + ["robot.srdf", "package.xml", "part.stl", "part.obj", "part.dae", "part.ply"]),
        "analyze robot.xml --contact foot": (24, ["robot.xml"] * 5 + ["more.xml", "part.stl"]),
        "analyze robot.urdf.xacro --contact foot": (5, ["robot.urdf.xacro"] * 3 + ["macros.xacro", "values.yaml"]),
        "analyze scene.toml": (14, ["scene.toml"] * 5 + ["robot.urdf", "robot.srdf"]),
        "analyze robot.urdf --contact foot --contact-point lowest": (6, ["part.obj", "part.ply", "robot.urdf"]),
        "analyze robot.xml --contact foot --contact-point lowest": (2, ["robot.xml", "part.stl"]),
        "robots robot.urdf": (4, ["robot.urdf", "package.xml"]),
        "robots robot.xml": (2, ["robot.xml", "more.xml"]),
        "check budgets.toml": (3, ["budgets.toml"] * 3 + ["scene.toml", "robot.urdf"]),
        "check budgets.toml --baseline baseline.json": (1, ["baseline.json", "budgets.toml"]),
    }  # fmt: skip
    line = rng.choices(list(kinds), [weight for weight, _ in kinds.values()])[0]
    words = line.split()
    for _ in range(rng.choice((0, 1, 1, 1, 2, 3))):
        name = rng.choice(kinds[line][1])
        files[name] = changed(rng, name, files[name])
    if words[0] == "analyze":
        words += ["--format", rng.choice(("table", "json", "json", "csv", "markdown"))] * (rng.random() < 0.6)
        words += ["--out", "out"] * (rng.random() < 0.03)
        for _ in range(rng.choice((0, 0, 0, 1, 1, 2))):
            words += rng.choice(EXTRAS).split(" ")
    elif words[0] == "check" and rng.random() < 0.5:
        words += ["--format", rng.choice(("json", "junit", "github", "markdown", "json=report.json"))]
    if rng.random() < 0.05:
        words += [rng.choice(OPTIONS), rng.choice((*NUMBERS, *NAMES, *PATHS))]
    if rng.random() < 0.02:
        words[rng.randrange(len(words))] = rng.choice((*NAMES, *PATHS))
    return Case(files, [word.replace("\0", "") for word in words])


def changed(rng: random.Random, name: str, data: bytes) -> bytes:
    """A file with one thing changed."""
    suffix = name.rpartition(".")[2]
    ways = {"xml": (_tree, _tree, _tree, _tree, _number, _text), "toml": (_line, _line, _line, _number, _text), "stl": (_binary,)}
    kind = (
        "xml" if data.lstrip()[:1] == b"<" else "toml" if suffix in ("toml", "yaml", "json") else "stl" if suffix == "stl" else ""
    )
    with contextlib.suppress(ElementTree.ParseError, ValueError, LookupError, RecursionError):  # it was broken by an earlier change
        return rng.choice(ways.get(kind, (_number, _line, _text)))(rng, data)
    return _text(rng, data)


def _value(rng: random.Random) -> str:
    """A value that does not belong there."""
    return rng.choice(rng.choices((NUMBERS, NAMES, PATHS, EXPRESSIONS), (5, 3, 2, 1))[0])


def _tree(rng: random.Random, data: bytes) -> bytes:
    """XML with its elements or attributes changed."""
    root = ElementTree.fromstring(data)
    elements = [(parent, child) for parent in root.iter() for child in parent]
    if not elements:
        return _text(rng, data)
    parent, child = rng.choice(elements)
    _, other = rng.choice(elements)
    owner = rng.choice([element for element in root.iter() if element.attrib] or [child])
    key = rng.choice(list(owner.attrib) or ["name"])
    match rng.choices(range(11), (3, 2, 2, 2, 14, 2, 2, 1, 5, 0.3, 0.5))[0]:
        case 0:
            parent.remove(child)
        case 1:
            parent.insert(rng.randrange(len(parent) + 1), copy.deepcopy(other))
        case 2:
            child.tag = other.tag
        case 3:
            parent.remove(child)
            root.append(child)
        case 4:
            owner.set(key, rng.choice(PATHS) if ("file" in key or "dir" in key) and rng.random() < 0.7 else _value(rng))
        case 5:
            del owner.attrib[key]
        case 6:
            owner.set(key, other.get(key, "".join(other.attrib.values())))
        case 7:
            depth = rng.choice((10, 590, 790, 5000))
            return ElementTree.tostring(root).replace(b">", b">" + b"<x>" * depth + b"</x>" * depth, 1)
        case 8:
            parent.insert(0, ElementTree.Element("MARK"))
            return ElementTree.tostring(root).replace(b"<MARK />", rng.choice(ELEMENTS).encode())
        case 9:
            return _chain(rng, root.tag)
        case 10:
            parent.extend([child] * rng.choice((3, 100, 3000)))
    return ElementTree.tostring(root, encoding="utf-8")


def _chain(rng: random.Random, tag: str) -> bytes:
    """A robot of many links, one on the other or side by side."""
    count, kind = rng.choice((50, 120, 601, 2001, 4000)), rng.choice(("fixed", "continuous", "floating", "prismatic"))
    deep = rng.random() < 0.7
    if tag == "mujoco":
        body = '<body name="b{0}"><joint axis="0 1 0"/><geom size=".1" pos=".1 0 0"/>'
        inside = (
            "".join(body.format(k) for k in range(count)) + "</body>" * count
            if deep
            else "".join(body.format(k) + "</body>" for k in range(count))
        )
        return f'<mujoco><worldbody><body name="foot"><freejoint/><geom size=".1"/>{inside}</body></worldbody></mujoco>'.encode()
    inertial = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    links = "".join(f'<link name="{f"b{k}" if k else "foot"}">{inertial}</link>' for k in range(count))
    joints = "".join(
        f'<joint name="j{k}" type="{kind}"><origin xyz="0.1 0 0"/><parent link="{f"b{k - 1}" if deep and k > 1 else "foot"}"/><child link="b{k}"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k in range(1, count)
    )  # fmt: skip
    return f'<robot name="chain">{links}{joints}</robot>'.encode()


def _number(rng: random.Random, data: bytes) -> bytes:
    """Text in which a number is another."""
    found = list(re.finditer(rb"-?\d[\d.]*(e[-+]?\d+)?", data))
    if not found:
        return _text(rng, data)
    place = rng.choice(found)
    return data[: place.start()] + rng.choice(NUMBERS).encode() + data[place.end() :]


def _line(rng: random.Random, data: bytes) -> bytes:
    """Text in which one line, or one value, is another."""
    lines = data.split(b"\n")
    k, way = rng.randrange(len(lines)), rng.randrange(6)
    key, equals, _ = lines[k].partition(b"=")
    if way == 0:
        del lines[k]
    elif way == 1:
        lines.insert(k, lines[rng.randrange(len(lines))])
    elif way == 2:
        lines.insert(k, rng.choice(LINES).encode())
    elif equals:
        value = _value(rng)
        text = "".join(f"\\u{ord(sign):04x}" if ord(sign) < 0x20 or sign in '"\\\x7f' else sign for sign in value)
        lines[k] = (
            key
            + b"= "
            + (value.replace("\n", " ") if way == 3 else f'"{text}"' if way == 4 else f"[{value.replace(chr(10), ' ')}]").encode()
        )
    return b"\n".join(lines)


def _text(rng: random.Random, data: bytes) -> bytes:
    """Bytes changed anywhere."""
    at = rng.randrange(len(data) + 1)
    match rng.randrange(7):
        case 0:
            return data[:at]
        case 1:
            return data[:at] + rng.choice(JUNK) + data[at:]
        case 2:
            return rng.choice(STARTS) + (data if rng.random() < 0.3 else re.sub(rb"^<\?xml[^>]*>", b"", data))
        case 3:
            return data[:at] + data[rng.randrange(len(data) + 1) :]
        case 4:
            return data.decode(errors="replace").encode(rng.choice(("utf-16", "utf-16-be", "utf-32", "latin-1")), "replace")
        case 5:
            found = list(re.finditer(rb'"[^"<>]*"', data))
            return (
                data
                if not found
                else data[: (place := rng.choice(found)).start() + 1] + _value(rng).encode() + data[place.end() - 1 :]
            )
    return _flipped(rng, data)


def _flipped(rng: random.Random, data: bytes) -> bytes:
    """Bytes in which some bits are others."""
    found = bytearray(data)
    for _ in range(rng.choice((1, 3, 20))):
        if found:
            found[rng.randrange(len(found))] ^= 1 << rng.randrange(8)
    return bytes(found)


def _binary(rng: random.Random, data: bytes) -> bytes:
    """A binary mesh with numbers, counts or bits changed."""
    at = 80 + 4 * rng.randrange(max((len(data) - 80) // 4, 1))
    match rng.randrange(4):
        case 0:
            return data[:at]
        case 1:
            return data[:80] + struct.pack("<I", rng.choice((0, 1, 2**31, 2**32 - 1))) + data[84:]
        case 2:
            return data[:at] + struct.pack("<f", rng.choice((3e38, float("nan"), float("inf"), 1e20, 1e-40, -1e6))) + data[at + 4 :]
    return _flipped(rng, data)


def write(case_: Case, folder: Path) -> None:
    """Make the folder of a case: its files in `stick`, beside it `outside`."""
    place = folder / "stick"
    place.mkdir(parents=True)
    for name, data in case_.files.items():
        (place / name).write_bytes(data)
    for suffix in ("", ".stl"):
        os.mkfifo(place / f"pipe{suffix}")
        os.symlink("/dev/zero", place / f"endless{suffix}")
        os.symlink(f"loop{suffix}", place / f"loop{suffix}")
    for name, target in {"link": "secret.srdf", "link.stl": "secret.stl", "link.yaml": "secret.yaml"}.items():
        os.symlink(f"../outside/{target}", place / name)
    for name in ("big.stl", "big.xml"):
        (place / name).touch()
        os.truncate(place / name, 2**30)
