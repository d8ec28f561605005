"""Hostile inputs for the fuzzer: files of a small robot, what can be wrong in them, and the commands that read them.

Case i is a function of i alone. Each case is a folder of files, valid at first, of which some are changed, and a command line.
"""

import contextlib
import copy
import io
import json
import os
import random
import re
import struct
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pyarrow.parquet
from commands import ROBOTS

ElementTree.register_namespace("xacro", "http://www.ros.org/wiki/xacro")
ElementTree.register_namespace("", "http://www.collada.org/2005/11/COLLADASchema")

TOKEN = "CANARY-8153"
"""In the files outside the open folders; the output must never hold it."""

LANDINGS: dict[str, np.ndarray] = {
    "name": np.array(["a", "b", "c"]),
    "contact": np.array(["foot", "foot", "arm"]),
    "friction": np.array([0.3, 0.5, 0.7]),
    "q_knee": np.array([0.1, 0.2, -0.3]),
    "before_knee": np.array([0.0, 1.0, -1.0]),
    **{f"q{axis}": np.array([float(axis == "w")] * 3) for axis in "wxyz"},
    "vx": np.array([0.1, 0.0, -0.2]),
    "vz": np.array([-1.0, -0.5, -2.0]),
    "after_knee": np.array([0.5, 1.5, -1.0]),
    "after6ms_vz": np.array([-0.1, -0.2, -0.3]),
}
"""Recorded landings of that robot."""

ARRAYS = {
    "qpos": np.array([[0.0, 0, 1, 1, 0, 0, 0, 0.1, 0.05]] * 2),
    "qvel": np.array([[0.0, 0, -1, 0, 0, 0, 0.1, 0.05]] * 2),
    "position": np.array([[0.1], [0.2]]),
    "velocity": np.array([[0.1], [0.2]]),
}
"""Arrays as MuJoCo and ROS record them."""


def packed(kind: str, columns: dict[str, Any]) -> bytes:
    """A table as a file: npz or parquet."""
    file = io.BytesIO()
    if kind == "npz":
        np.savez(file, **columns)
    else:
        pyarrow.parquet.write_table(pyarrow.table({name: pyarrow.array(list(values)) for name, values in columns.items()}), file)
    return file.getvalue()


FILES = {path.name: path.read_bytes() for path in sorted((ROBOTS / "stick").iterdir())}
FILES |= {f"landings.{kind}": packed(kind, LANDINGS) for kind in ("npz", "parquet")}
_ROWS = zip(*(map(str, values) for values in LANDINGS.values()), strict=True)
FILES["landings.csv"] = "\n".join([",".join(LANDINGS), *map(",".join, _ROWS)]).encode()
"""A robot as URDF, xacro, MJCF and SDFormat, with all that goes with it, and recorded landings."""

SECRETS = {f"secret.{kind}": f"{kind} {TOKEN}\n".encode() for kind in ("obj", "stl", "yaml")} | {
    f"secret.{kind}": f'<robot name="{TOKEN}"><link name="{TOKEN}"/><group_state name="{TOKEN}"/></robot>'.encode()
    for kind in ("xml", "srdf")
}
"""Files that nothing may read."""


def _table(text: str, *more: str) -> list[str]:
    """The entries of a table, between bars, and some more."""
    return [*re.split("[ \n]*¦[ \n]*", text.strip(" \n")), *more]


NUMBERS = _table(
    """
1e308 ¦ -1e308 ¦ 1e400 ¦ nan ¦ -nan ¦ inf ¦ -Infinity ¦ 0 ¦ -0 ¦ -0.0 ¦ 1e-320 ¦ 1e-300 ¦ 1e-20 ¦ 1e-15 ¦ 1e-9 ¦ 1e9 ¦ 1e15 ¦
1e24 ¦ 1e25 ¦ 1e77 ¦ -1 ¦ 1 ¦ 2 ¦ 0.5 ¦ 90 ¦ 255 ¦ 256 ¦ 1e3 ¦ 2147483648 ¦ 18446744073709551616 ¦ 0x10 ¦ 1_0 ¦ ١ ¦ 1,5 ¦ 1e ¦
1e+ ¦ .5. ¦ -- ¦ + ¦ NaN(1) ¦ true ¦ 1;2 ¦ 0,0,0 ¦ 1|2|3 ¦ 0 0 0 ¦ 1 2 ¦ 1 2 3 4 ¦ 1e308 1e308 1e308 ¦ nan nan nan ¦ 0 0 1e20 ¦
1e-30 1e-30 1e-30
""",
    "",
    " ",
    "9" * 5000,
    "1 " * 3000,
    "1\n2",
)
"""What may stand where a number does."""

NAMES = _table(
    """
universe ¦ world ¦ root_joint ¦ foot ¦ body ¦ knee ¦ shin ¦ arm ¦ base_link ¦ \x1b[31mred ¦ \u202eright ¦ a\nb ¦ a\tb ¦ a\rb ¦
\u2066x\u2069 ¦ \u200b ¦ \ufeff ¦ =1+1 ¦ @x ¦ -x ¦ +x ¦ <b>&amp;</b> ¦ |a| ¦ $x^2$ ¦ $\\frac{$ ¦ $ ¦ \\ ¦ {0.__class__} ¦ {} ¦
%s%n ¦ `id` ¦ ${1} ¦ é ¦ 足 ¦ 😀 ¦ \u2028 ¦ * ¦ [ ¦ [a- ¦ foot+body ¦ foot:0,0,0 ¦ a/b ¦ ../x ¦ - ¦ --help ¦ # ¦ " ¦ ' ¦
__proto__ ¦ None ¦ nan ¦ 1 ¦ \x7f ¦ \x85 ¦ \ue000 ¦ \U000e0001
""",
    "",
    " ",
    "x" * 300,
    "x" * 70_000,
)
"""What may stand where a name does."""

PATHS = _table(
    """
../outside/secret.xml ¦ ../outside/secret.stl ¦ ../outside/secret.yaml ¦ link ¦ link.stl ¦ link.yaml ¦ pipe ¦ pipe.stl ¦
endless ¦ endless.stl ¦ /dev/zero ¦ /dev/stdin ¦ /dev/fd/0 ¦ /proc/self/environ ¦ /proc/self/mem ¦ /etc/hostname ¦
package://stick/../outside/secret.stl ¦ package://outside/secret.stl ¦ package://../outside/secret.stl ¦
package://stick/part.stl ¦ package:///part.stl ¦ package:// ¦ file:///etc/hostname ¦ file://part.stl ¦
file://%2e%2e/outside/secret.stl ¦ http://localhost/x.stl ¦ ftp://x ¦ model://stick/part.obj ¦ data:,x ¦ . ¦ .. ¦ / ¦ // ¦
./part.stl ¦ ~nouser/x.stl ¦ ~/x.stl ¦ $HOME/x ¦ part.stl/x ¦ loop ¦ loop.stl ¦ part.gltf ¦ part.lws ¦ part.irr ¦ part.msh ¦
part.STL ¦ part.obj ¦ part.ply ¦ part.dae ¦ robot.urdf ¦ robot.xml ¦ more.xml ¦ package.xml ¦ big.stl
""",
    "",
    "x" * 300,
    "x" * 300 + ".stl",
    "a/" * 2500 + "x.stl",
)
"""What may stand where a path does."""

EXPRESSIONS = _table("""
${10**10**10} ¦ $(eval 10**10**8) ¦ ${'x' * 10**10} ¦ ${'{:>4000000000}'.format(1)} ¦ ${'{0.__class__.__mro__}'.format(1)} ¦
${[0] * 10**10} ¦ ${__import__('os')} ¦ ${open('/etc/hostname').read()} ¦ ${xacro.load_yaml('../outside/secret.yaml')} ¦
${xacro.load_yaml('pipe')} ¦ ${1/0} ¦ ${undefined} ¦ ${().__class__} ¦ ${list(range(10**9))} ¦ ${sum(range(10**10))} ¦
$(env HOME) ¦ $(optenv HOME x) ¦ $(find outside) ¦ $(find ../x) ¦ $(arg nothing) ¦ $(dirname) ¦ ${'a' 'b'} ¦ ${ ¦ $( ¦ $$ ¦
${values} ¦ ${length.real} ¦ ${values.leg.mass} ¦ ${values['no']} ¦ ${-length**0.5} ¦ ${float('nan')} ¦ ${1e308*10} ¦
${math.factorial(10**6)} ¦ ${2**100000} ¦ ${hex(2**64)} ¦ ${'\\x1b[31m'} ¦ ${xacro.message('x\\ny')} ¦ ${xacro.fatal('no')} ¦
${'%2000000000d' % 1} ¦ ${max('')} ¦ ${(lambda f: f(f))(lambda f: f(f))} ¦
${[x for x in ().__class__.__base__.__subclasses__()]}
""")
"""What xacro may be asked to compute."""

ELEMENTS = _table("""
<gazebo><sensor:camera/></gazebo> ¦ <xacro:left_over/> ¦ <link name="lost"/> ¦ <joint name="lost" type="fixed"/> ¦
<mimic joint='knee'/> ¦ <transmission name="t"/> ¦ <!-- -- --> ¦ <![CDATA[x]]> ¦ <?php x?> ¦ &x; ¦ &#0; ¦ &#x1b; ¦
<a:b c:d='1'/> ¦ <include file='more.xml'/> ¦ <include file='robot.xml'/> ¦ <include file='pipe'/> ¦
<include file='../outside/secret.xml'/> ¦ <material name="m"><color rgba="300 -1 nan 1e308"/></material> ¦
<xacro:include filename='pipe'/> ¦ <xacro:include filename='robot.urdf.xacro'/> ¦
<xacro:include filename='../outside/secret.xml'/> ¦ <xacro:include filename='*.xacro'/> ¦
<xacro:macro name='d' params=''><xacro:d/><xacro:d/></xacro:macro><xacro:d/> ¦ <xacro:insert_block name='x'/> ¦
<xacro:property name='x' value='${x}'/><link name='${x}'/> ¦ <xacro:if value='maybe'/> ¦ <xacro:call macro='leg'/> ¦
<xacro:element xacro:name=''/> ¦ <asset><hfield name="h" file="part.png" size="1 1 1 1"/></asset> ¦
<asset><model name="n" file="../outside/secret.xml"/></asset> ¦
<asset><mesh name="u" vertex="1e77 0 0 0 1e77 0 0 0 1e77 1 1 1"/></asset> ¦
<asset><mesh name="w" file="part.obj" scale="1 1"/></asset> ¦
<worldbody><body name="stray"><freejoint/><geom size="1"/></body></worldbody> ¦
<worldbody><body><joint name="universe"/><geom size=".1"/></body></worldbody> ¦
<worldbody><composite type="cable" count="9 1 1"><geom size=".01"/></composite></worldbody> ¦
<extension><plugin plugin="mujoco.elasticity.cable"/></extension> ¦
<worldbody><replicate count="100000" offset=".1 0 0"><geom size=".01"/></replicate></worldbody> ¦
<worldbody><flexcomp name="f" type="grid" count="3 3 3"/></worldbody> ¦
<worldbody><frame euler="nan 0 0"><body><joint type="ball"/><geom size=".1"/></body></frame></worldbody> ¦
<size memory="1E" nstack="99999999"/> ¦ <equality><connect body1="shin" body2="arm" anchor="0 0 0"/></equality> ¦
<equality><weld body1="shin" body2="body"/></equality> ¦ <option timestep='nan'/> ¦
<compiler meshdir="/etc" settotalmass="1e300" inertiafromgeom="true"/> ¦
<compiler angle="x" eulerseq="abc" strippath="maybe" coordinate="global"/> ¦
<keyframe><key qpos="nan"/><key qpos="1 2 3"/></keyframe> ¦
<group_state name="lie" group="leg"><joint name="knee" value="nan"/></group_state>
""")
"""Elements that may stand anywhere."""

LINES = _table(
    """
robot = 'pipe' ¦ robot = 1 ¦ [[contact]]\nframe = 'foot' ¦ [[contact]] ¦ [contact] ¦ a.b.c = 1 ¦ "\\u0000" = 1 ¦
x = 1979-05-27T07:32:00 ¦ [[closure]]\nframes = ['foot', 'arm'] ¦ stance = ['body', 'body'] ¦ [packages]\nstick = '/dev' ¦
[xacro]\nmass = 'x' ¦ srdf = 'pipe' ¦ srdf = '../outside/secret.srdf' ¦ srdf = 'robot.srdf' ¦
joints.rotor = { knee = { inertia = 1e12, gear_ratio = 1e12 } } ¦ plane = [0, 0, 0] ¦
a: &a [x, x]\nb: &b [*a, *a, *a, *a]\nc: &c [*b, *b, *b, *b]\nd: &d [*c, *c, *c, *c]\ne: &e [*d, *d, *d, *d]\nf: [*e, *e, *e, *e] ¦
!!python/object/apply:os.system [id] ¦ <<: *nothing ¦ a: !!binary x ¦ ? [a, b]\n: c ¦ ---\n...\n--- ¦ a: 2001-99-99 ¦ \t: x ¦
a: !!float x
""",
    "x = " + "[" * 2000 + "]" * 2000,
    "x = " + "9" * 5000,
    "a: " + "[" * 3000,
)
"""Lines of TOML and YAML that may stand anywhere."""

JUNK = _table(
    """
\0 ¦ \x1b[2J ¦ \xff ¦ \xef\xbb\xbf ¦ \xe2\x80\xae ¦ \r ¦ < ¦ & ¦ " ¦ ]]> ¦ <!DOCTYPE r [<!ENTITY x 'y'>]> ¦ \xf0\x9f
""",
    "A" * 100_000,
)
"""Bytes that may stand anywhere."""

STARTS = _table(
    """
\xef\xbb\xbf ¦ \xef\xbb\xbf\xef\xbb\xbf ¦ \xef\xbb\xbf\xef\xbb\xbf<!DOCTYPE robot [<!ENTITY x SYSTEM '../outside/secret.xml'>]> ¦
\r\n\r\n ¦ \xfe\xff ¦ <!DOCTYPE robot SYSTEM '../outside/secret.xml'> ¦ <?xml version="1.0" encoding="iso-8859-1"?> ¦
<?xml version="1.0" encoding="utf-16"?> ¦ <?xml version="1.0" encoding="utf-7"?> ¦ <?xml version="1.0" encoding="idna"?> ¦
<?xml version="1.1"?> ¦ <?xml version="1.0" standalone="no"?> ¦ #!/bin/sh ¦ \0\0
""",
    " " * 70_000,
)
"""Bytes before a file's."""

OTHER_COLUMNS = [
    np.array(values, dtype=kind)
    for values, kind in (
        ([1, 2, 3], "int8"), ([True, False, True], bool), ([1j, 2, 3], complex), ([0.1, 0.2, 0.3], "float16"), ([1e300] * 3, float),
        (["0.1", "x", ""], str), ([b"a", b"\xff", b""], bytes), (["2020-01-01", "NaT", "2021-01-01"], "datetime64[D]"),
        ([1, 2, 3], "timedelta64[s]"), ([2**63] * 3, "uint64"), (["\x1b[31m", "\u202e", "=1+1"], str), (["x" * 70_000] * 3, str),
        ([["foot"], ["arm"], ["body"]], str),
    )
]  # fmt: skip
"""What may stand where a column of a table does."""

OPTIONS = _table("""
--contact ¦ --at ¦ --body ¦ --set ¦ --lock ¦ --armature ¦ --joint-velocity ¦ --stance ¦ --srdf ¦ --xacro ¦ --package ¦
--speed ¦ --strike-angle ¦ --velocity ¦ --drop-height ¦ --offset ¦ --restitution ¦ --plane ¦ --pulse ¦ --range-g ¦ --base-rpy ¦
--posture ¦ --assemble ¦ --v-in ¦ --base ¦ --joints ¦ --contact-point ¦ --format ¦ --out ¦ --save-scene ¦ --angular-velocity
""")
"""Options that take a value."""

EXTRAS = _table("""
--contact-point lowest ¦ --joints locked ¦ --joints geared --armature *=0.05 ¦ --slide ¦ --body * ¦ --at body:0,0,0.1 ¦
--pulse half-sine:5ms --range-g 4 ¦ --velocity 0.3,0.2,-1 ¦ --base fixed ¦ --base planar ¦ --set knee=30 ¦ --stance arm ¦
--srdf robot.srdf ¦ --explain ¦ --plane yz ¦ --angular-velocity 0,1,0 ¦ --lock knee ¦ --contact arm ¦ --contact shin+arm ¦
--together --contact * ¦ --srdf pipe ¦ --srdf /dev/zero ¦ --v-in com ¦ --posture standing ¦ --package stick=. ¦
--package other=/dev --package outside=. ¦ --xacro mass:=3 ¦ --xacro mass:=nan ¦ --save-scene saved.toml ¦ --base free
""")
"""Options of `analyze`."""


SETTINGS = _table("""
--vary knee=-20:20:3 ¦ --vary knee=0 ¦ --vary strike-angle=0:30:2 ¦ --vary mass:*=0.5x:2x ¦ --vary-each mass:*=+-5% ¦
--vary armature:*=0.5x:2x ¦ --vary com-x:body=+-0.01 ¦ --vary inertia:*=1x:2x:log ¦ --vary contact=* ¦ --vary friction=0:1:2 ¦
--vary joint-stiffness:*=0.5x:2x ¦ --vary joint-stiffness:knee=10,100 ¦
--vary base-yaw=0:90:2 ¦ --vary offset-x=0,0.01 ¦ --sample 5 ¦ --sample 3 --lhs ¦ --seed 3 ¦ --prove 2 ¦ --armature *=0.05 ¦
--quantity shock ¦ --quantity joint_impulse@* ¦ --quantity ropc ¦ --joints locked ¦ --slide ¦ --resume ¦ --jobs 2 ¦
--format csv ¦ --format json ¦ --change mass:*=0.9x ¦ --figures --out out ¦ --out out ¦ --at body ¦ --body * ¦ --step 5 ¦ --count 2
""")
"""Options of studies; not every study has each."""

ROWS = _table("""
--rank shock@body ¦ --rank nothing ¦ --rows csv --out out ¦ --rows parquet --out out ¦ --map q_knee=knee ¦ --map *knee=*shoulder ¦
--map after*= ¦ --map vx=vx_body ¦ --command a ¦ --command c ¦ --command row ¦ --prove 0 ¦ --joints free,locked ¦
--contact-stiffness 1e5 ¦ --friction 0.4 ¦ --quantity shock_friction ¦ --jobs 2 ¦ --contact arm ¦ --resume ¦ --out out
""")
"""Options of `recorded`."""

STUDIES = ("sweep", "batch", "compare", "place", "limits", "sensitivity", "recorded")
"""Commands that compute many landings."""

UNFINISHED: dict[str, bytes] = {}
"""The files of the studies below that can be continued; the fuzzer fills them in."""

SWEEP = "sweep robot.urdf --contact foot --vary knee=-20:20:3 --prove 1"
CONTINUED = {
    "parts/csv": f"{SWEEP} --rows csv",
    "parts/parquet": f"{SWEEP} --rows parquet",
    "parts/landings": "recorded landings.csv robot.urdf --rows csv",
}
"""Studies that can be continued, by the folder of their parts."""

COMMANDS = {
    "analyze robot.urdf --contact foot": (38, "robot.urdf " * 7 + "robot.srdf package.xml part.stl part.obj part.dae part.ply"),
    "analyze robot.xml --contact foot": (24, "robot.xml " * 5 + "more.xml part.stl"),
    "analyze robot.sdf --contact foot": (6, "robot.sdf " * 5 + "part.stl"),
    "analyze robot.urdf.xacro --contact foot": (5, "robot.urdf.xacro " * 3 + "macros.xacro values.yaml"),
    "analyze scene.toml": (14, "scene.toml " * 5 + "robot.urdf robot.srdf"),
    "analyze robot.urdf --contact arm --contact-point lowest": (6, "part.obj part.ply robot.urdf"),
    "analyze robot.xml --contact shin --contact-point lowest": (2, "robot.xml part.stl"),
    "robots robot.urdf": (4, "robot.urdf package.xml"),
    "robots robot.xml": (2, "robot.xml more.xml"),
    "check budgets.toml": (3, "budgets.toml " * 3 + "scene.toml robot.urdf"),
    "check budgets.toml --baseline baseline.json": (7, "baseline.json " * 8 + "budgets.toml"),
    "check budgets.toml --baseline new.json --update-baseline": (1, "budgets.toml scene.toml robot.urdf"),
    "batch robot.urdf robot.xml --contact foot": (4, "robot.urdf robot.xml part.stl"),
    "compare robot.urdf robot.xml --contact foot": (4, "robot.urdf robot.xml"),
    "place robot.urdf --contact foot --body body --within -0.1:0.1,-0.1:0.1,0:0.1": (3, "robot.urdf part.stl"),
    "limits robot.urdf --contact foot --joint knee --at body --max 0.2": (3, "robot.urdf"),
    "sensitivity robot.urdf --contact foot --at body": (4, "robot.urdf"),
    "recorded landings.csv robot.urdf": (8, "landings.csv " * 7 + "robot.urdf"),
    "recorded landings.csv scene.toml": (2, "landings.csv scene.toml"),
    "recorded landings.npz robot.urdf": (4, "landings.npz"),
    "recorded landings.npz robot.xml": (3, "landings.npz"),
    "recorded landings.parquet robot.urdf": (4, "landings.parquet"),
    "touchdowns log.csv robot.urdf --contact foot": (1, "log.csv " * 3 + "robot.urdf"),
    "identify landings.csv robot.urdf --unknown armature:knee=0.01:1": (0.5, "landings.csv"),
    "improve robot.urdf --contact foot --at body --vary knee=-60:60 --starts 1": (0.5, "robot.urdf"),
    "fall robot.urdf": (1, "robot.urdf part.stl"),
    "export robot.urdf --contact foot --quantity shock@body --lang js --sample 3": (0.5, "robot.urdf"),
    "guide": (0.1, "robot.urdf"),
    "bench robot.urdf --contact foot": (0.2, "robot.urdf"),
    "paper 1": (0.1, "robot.urdf"),
    "quantities": (0.2, "robot.urdf"),
    "schema": (0.2, "robot.urdf"),
    "schema budgets": (0.1, "robot.urdf"),
    **{f"{line} --out {folder}": (1, line.split()[1]) for folder, line in CONTINUED.items()},
    **{f"{line} --out {folder} --resume": (2, f"{folder}/* " * 9 + "robot.urdf") for folder, line in CONTINUED.items()},
}
"""Commands: how often each is run, and the files of which some are changed; FOLDER/* is any in it."""


class Case(NamedTuple):
    """A case: the files of its folder, and the words of the command line."""

    files: dict[str, bytes]
    words: list[str]

    def write(self, folder: Path) -> None:
        """Make the folder; the files that a case may name but not read are in `outside` beside it."""
        folder.mkdir(parents=True)
        for name, data in self.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(data)
        for suffix in ("", ".csv", ".npz", ".parquet", ".stl", ".toml", ".urdf", ".xml"):
            os.mkfifo(folder / f"pipe{suffix}")
        for suffix in ("", ".stl"):
            os.symlink("/dev/zero", folder / f"endless{suffix}")
            os.symlink(f"loop{suffix}", folder / f"loop{suffix}")
        for name, target in {"link": "secret.srdf", "link.stl": "secret.stl", "link.yaml": "secret.yaml"}.items():
            os.symlink(f"../outside/{target}", folder / name)
        for name in ("big.stl", "big.xml"):
            (folder / name).touch()
            os.truncate(folder / name, 2**30)


def case(number: int) -> Case:
    """Case `number`."""
    rng, files = random.Random(f"case {number}"), dict(FILES)
    (line,) = rng.choices(list(COMMANDS), [often for often, _ in COMMANDS.values()])
    words = line.split()
    files |= UNFINISHED if "--resume" in words else {}
    for _ in range(rng.choice((0, 1, 1, 1, 2, 3))):
        name = rng.choice(COMMANDS[line][1].split())
        if name.endswith("/*"):
            name = rng.choice([file for file in files if file.startswith(name[:-1])])
        if name.endswith((".npz", ".parquet")) and rng.random() < 0.8:
            files[name] = _columns(rng, name.rpartition(".")[2]) or _flipped(rng, files[name])
        elif name in UNFINISHED and rng.random() < 0.1:
            del files[name]
        else:
            files[name] = _changed(rng, files[name])
    if words[0] == "analyze":
        words += ["--format", rng.choice(("table", "json", "json", "csv", "markdown"))] * (rng.random() < 0.6)
        words += ["--out", "out"] * (rng.random() < 0.03)
        for _ in range(rng.choice((0, 0, 0, 1, 1, 2))):
            words += rng.choice(EXTRAS).split()
    elif words[0] == "recorded":
        for _ in range(rng.choice((0, 0, 1, 2))):
            words += rng.choice(ROWS).split()
    elif words[0] in STUDIES:
        for _ in range(rng.choice((0, 1, 1, 2))):
            words += rng.choice(SETTINGS).split()
        if rng.random() < 0.1:
            words += ["--vary", f"{rng.choice((*NAMES, 'knee', 'mass:*'))}={rng.choice(NUMBERS)}"]
    elif words[0] == "check" and rng.random() < 0.5:
        words += ["--format", rng.choice(("json", "junit", "github", "markdown", "json=report.json"))]
    if rng.random() < 0.05:
        words += [rng.choice(OPTIONS), rng.choice((*NUMBERS, *NAMES, *PATHS))]
    if rng.random() < 0.02:
        words[rng.randrange(len(words))] = rng.choice((*NAMES, *PATHS))
    return Case(files, words)


def _changed(rng: random.Random, data: bytes) -> bytes:
    """A file with one thing changed."""
    xml, binary = data.lstrip()[:1] == b"<", b"\0" in data
    ways = (_tree, _tree, _tree, _tree, _number, _text) if xml else (_binary,) if binary else (_line, _line, _number, _text)
    ways += (_json,) * 4 * (data[:1] == b"{")
    with contextlib.suppress(ElementTree.ParseError, ValueError, LookupError, RecursionError):  # it was broken by an earlier change
        return rng.choice(ways)(rng, data)
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
    count, deep = rng.choice((50, 120, 601, 2001, 4000)), rng.random() < 0.7
    if tag == "mujoco":
        links = [f'<body name="b{k}"><joint axis="0 1 0"/><geom size=".1" pos=".1 0 0"/>' for k in range(count)]
        inside = "".join([*links, "</body>" * count] if deep else [f"{link}</body>" for link in links])
        return f'<mujoco><worldbody><body name="foot"><freejoint/><geom size=".1"/>{inside}</body></worldbody></mujoco>'.encode()
    kind = rng.choice(("fixed", "continuous", "floating", "prismatic"))
    names = ["foot", *(f"b{k}" for k in range(1, count))]
    links = [
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
        "</link>"
        for name in names
    ]
    joints = [
        f'<joint name="to_{name}" type="{kind}"><origin xyz="0.1 0 0"/><parent link="{names[k] if deep else "foot"}"/>'
        f'<child link="{name}"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k, name in enumerate(names[1:])
    ]
    return "".join(['<robot name="chain">', *links, *joints, "</robot>"]).encode()


def _number(rng: random.Random, data: bytes) -> bytes:
    """Text in which a number is another."""
    found = list(re.finditer(rb"-?\d[\d.]*(e[-+]?\d+)?", data))
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
        lines[k] = key + b"= " + rng.choice((value, f'"{text}"', f"[{value}]")).encode()
    return b"\n".join(lines)


def _json(rng: random.Random, data: bytes) -> bytes:
    """JSON in which a value, a key or a part is another."""
    document = json.loads(data)
    places: list[tuple[Any, Any]] = []
    parts = [document]
    for part in parts:  # grows
        keys = list(part) if isinstance(part, dict) else range(len(part))
        places += [(part, key) for key in keys]
        parts += [part[key] for key in keys if isinstance(part[key], dict | list)]
    part, key = rng.choice(places)
    match rng.randrange(5):
        case 0:
            del part[key]
        case 1 if isinstance(part, list):
            part.append(part[key])
        case 1 | 2 if isinstance(part, dict):
            part[_value(rng)] = part.pop(key)
        case 3:
            part[key] = rng.choice((None, True, -1, 1e308, [], {}, [part[key]], _value(rng), rng.choice(places)[0]))
        case _:
            part[key] = "HERE"
            other = rng.choice((*NUMBERS, "[" * 3000, "NaN", "Infinity", '{"a": 1, "a": 2}'))
            return json.dumps(document, skipkeys=True).replace('"HERE"', other).encode()
    return json.dumps(document).encode()  # ValueError where it holds itself


def _columns(rng: random.Random, kind: str) -> bytes | None:
    """A table of landings with one column, or one value, that is another; None where a file of this kind cannot hold it."""
    columns: dict[str, Any] = {name: values.copy() for name, values in LANDINGS.items()}
    if kind == "npz" and rng.random() < 0.5:
        columns = dict(ARRAYS) if rng.random() < 0.5 else ARRAYS | {"name": np.array(["knee"])}
    name = rng.choice(list(columns))
    match rng.randrange(6):
        case 0:
            del columns[name]
        case 1:
            columns[_value(rng) or "x"] = columns.pop(name)
        case 2:
            columns[name] = columns[rng.choice(list(columns))]
        case 3:
            count = rng.randrange(len(columns[name]) + 1)
            columns |= {each: columns[each][:count] for each in (columns if kind == "parquet" else (name,))}
        case 4 if columns[name].dtype.kind == "f":
            columns[name].flat[rng.randrange(columns[name].size)] = rng.choice((np.nan, np.inf, 1e308, 1e20, -1e-320, 90.0, 0.0))
        case _:
            columns[name] = rng.choice(OTHER_COLUMNS)
    with contextlib.suppress(ValueError, TypeError, NotImplementedError, struct.error):
        return packed(kind, columns)
    return None


def _text(rng: random.Random, data: bytes) -> bytes:
    """Bytes changed anywhere."""
    at = rng.randrange(len(data) + 1)
    match rng.randrange(7):
        case 0:
            return data[:at]
        case 1:
            return data[:at] + rng.choice(JUNK).encode("latin-1") + data[at:]
        case 2:
            return rng.choice(STARTS).encode("latin-1") + (data if rng.random() < 0.3 else re.sub(rb"^<\?xml[^>]*>", b"", data))
        case 3:
            return data[:at] + data[rng.randrange(len(data) + 1) :]
        case 4:
            return data.decode(errors="replace").encode(rng.choice(("utf-16", "utf-16-be", "utf-32", "latin-1")), "replace")
        case 5 if found := list(re.finditer(rb'"[^"<>]*"', data)):
            place = rng.choice(found)
            return data[: place.start() + 1] + _value(rng).encode() + data[place.end() - 1 :]
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
