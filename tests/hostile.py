"""Hostile inputs for the fuzzer: files of a small robot, what can be wrong in them, and the
commands that read them.

Case i is a function of i alone. Each case is a folder of files, valid at first, of which some are
changed, and a command line. Links, pipes, devices and files without end are not among them:
test_odd_files.py gives these to every reader.
"""

import contextlib
import copy
import functools
import io
import json
import random
import re
import struct
import zipfile
import zlib
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pyarrow.parquet
from commands import ROBOTS
from typer.main import get_command

from shockpc.cli.app import app_for

ElementTree.register_namespace("xacro", "http://www.ros.org/wiki/xacro")
ElementTree.register_namespace("", "http://www.collada.org/2005/11/COLLADASchema")

TOKEN = "CANARY-8153"
"""In the files outside the open folders; the output must never hold it."""

MUJOCO = {
    "qpos": np.array([[0.0, 0, 1, 1, 0, 0, 0, 0.1, 0.05]] * 2),
    "qvel": np.array([[0.0, 0, -1, 0, 0, 0, 0.1, 0.05]] * 2),
}
ROS = {
    "name": np.array(["knee"]),
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
        pyarrow.parquet.write_table(
            pyarrow.table({name: pyarrow.array(list(values)) for name, values in columns.items()}),
            file,
        )
    return file.getvalue()


FILES = {path.name: path.read_bytes() for path in sorted((ROBOTS / "stick").iterdir())}
_CSV = np.genfromtxt(
    io.BytesIO(FILES["landings.csv"]), delimiter=",", names=True, dtype=None, encoding="utf-8"
)
FILES |= {
    f"landings.{kind}": packed(kind, {name: _CSV[name] for name in _CSV.dtype.names})
    for kind in ("npz", "parquet")
}
FILES |= {"mujoco.npz": packed("npz", MUJOCO), "ros.npz": packed("npz", ROS)}
"""A robot as URDF, xacro, MJCF and SDFormat, with all that goes with it, and recorded landings."""

OUTSIDE = {
    f"outside/secret.{kind}": f"{kind} {TOKEN}\n".encode() for kind in ("obj", "stl", "yaml")
}
_SECRET = (
    f'<robot name="{TOKEN}"><link name="{TOKEN}"/><group_state name="{TOKEN}"/></robot>'.encode()
)
OUTSIDE |= dict.fromkeys(("outside/secret.xml", "outside/secret.srdf"), _SECRET)
"""Files that nothing may read."""


def _table(text: str, *more: str) -> list[str]:
    """The entries of a table, between bars, and some more."""
    return [*re.split("[ \n]*¦[ \n]*", text.strip(" \n")), *more]


NUMBERS = _table(
    """
1e308 ¦ -1e308 ¦ 1e400 ¦ nan ¦ -nan ¦ inf ¦ -Infinity ¦ 0 ¦ -0 ¦ -0.0 ¦ 1e-320 ¦ 1e-300 ¦ 1e-20 ¦ 1e-15 ¦ 1e-9 ¦ 1e9 ¦ 1e15 ¦ 1e24 ¦
1e25 ¦ 1e77 ¦ -1 ¦ 1 ¦ 2 ¦ 0.5 ¦ 90 ¦ 255 ¦ 256 ¦ 1e3 ¦ 2147483648 ¦ 18446744073709551616 ¦ 0x10 ¦ 1_0 ¦ ١ ¦ 1,5 ¦ 1e ¦ 1e+ ¦ .5. ¦
-- ¦ + ¦ NaN(1) ¦ true ¦ 1;2 ¦ 0,0,0 ¦ 1|2|3 ¦ 0 0 0 ¦ 1 2 ¦ 1 2 3 4 ¦ 1e308 1e308 1e308 ¦ nan nan nan ¦ 0 0 1e20 ¦
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
%s%n ¦ `id` ¦ ${1} ¦ é ¦ 足 ¦ 😀 ¦ \u2028 ¦ * ¦ [ ¦ [a- ¦ foot+body ¦ foot:0,0,0 ¦ a/b ¦ ../x ¦ - ¦ --help ¦ # ¦ " ¦ ' ¦ __proto__ ¦
None ¦ nan ¦ 1 ¦ \x7f ¦ \x85 ¦ \ue000 ¦ \U000e0001
""",
    "",
    " ",
    "x" * 300,
    "x" * 70_000,
)
"""What may stand where a name does."""

PATHS = _table(
    """
../outside/secret.xml ¦ ../outside/secret.stl ¦ ../outside/secret.yaml ¦ /dev/zero ¦ /dev/stdin ¦ /dev/fd/0 ¦ /proc/self/environ ¦
/proc/self/mem ¦ /etc/hostname ¦ package://stick/../outside/secret.stl ¦ package://outside/secret.stl ¦
package://../outside/secret.stl ¦ package://stick/part.stl ¦ package:///part.stl ¦ package:// ¦ file:///etc/hostname ¦
file://part.stl ¦ file://%2e%2e/outside/secret.stl ¦ http://localhost/x.stl ¦ ftp://x ¦ model://stick/part.obj ¦ data:,x ¦ . ¦ .. ¦
/ ¦ // ¦ ./part.stl ¦ ~nouser/x.stl ¦ ~/x.stl ¦ $HOME/x ¦ part.stl/x ¦ part.gltf ¦ part.lws ¦ part.irr ¦ part.msh ¦ part.STL ¦
part.obj ¦ part.ply ¦ part.dae ¦ robot.urdf ¦ robot.xml ¦ more.xml ¦ package.xml
""",
    "",
    "x" * 300,
    "x" * 300 + ".stl",
    "a/" * 2500 + "x.stl",
)
"""What may stand where a path does."""

EXPRESSIONS = _table("""
${10**10**10} ¦ $(eval 10**10**8) ¦ ${'x' * 10**10} ¦ ${'{:>4000000000}'.format(1)} ¦ ${'{0.__class__.__mro__}'.format(1)} ¦
${[0] * 10**10} ¦ ${__import__('os')} ¦ ${open('/etc/hostname').read()} ¦ ${xacro.load_yaml('../outside/secret.yaml')} ¦ ${1/0} ¦
${undefined} ¦ ${().__class__} ¦ ${list(range(10**9))} ¦ ${sum(range(10**10))} ¦ $(env HOME) ¦ $(optenv HOME x) ¦ $(find outside) ¦
$(find ../x) ¦ $(arg nothing) ¦ $(dirname) ¦ ${'a' 'b'} ¦ ${ ¦ $( ¦ $$ ¦ ${values} ¦ ${length.real} ¦ ${values.leg.mass} ¦
${values['no']} ¦ ${-length**0.5} ¦ ${float('nan')} ¦ ${1e308*10} ¦ ${math.factorial(10**6)} ¦ ${2**100000} ¦ ${hex(2**64)} ¦
${'\\x1b[31m'} ¦ ${xacro.message('x\\ny')} ¦ ${xacro.fatal('no')} ¦ ${'%2000000000d' % 1} ¦ ${max('')} ¦
${(lambda f: f(f))(lambda f: f(f))} ¦ ${[x for x in ().__class__.__base__.__subclasses__()]}
""")
"""What xacro may be asked to compute."""

ELEMENTS = _table(
    """
<gazebo><sensor:camera/></gazebo> ¦ <xacro:left_over/> ¦ <link name="lost"/> ¦ <joint name="lost" type="fixed"/> ¦
<mimic joint='knee'/> ¦ <transmission name="t"/> ¦ <!-- -- --> ¦ <![CDATA[x]]> ¦ <?php x?> ¦ &x; ¦ &#0; ¦ &#x1b; ¦ <a:b c:d='1'/> ¦
<include file='more.xml'/> ¦ <include file='robot.xml'/> ¦ <include file='../outside/secret.xml'/> ¦
<material name="m"><color rgba="300 -1 nan 1e308"/></material> ¦ <xacro:include filename='robot.urdf.xacro'/> ¦
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
""",
    "<x>" * 600 + "</x>" * 600,
    "<x>" * 5000 + "</x>" * 5000,
)
"""Elements that may stand anywhere."""

LINES = _table(
    """
robot = 1 ¦ [[contact]]\nframe = 'foot' ¦ [[contact]] ¦ [contact] ¦ a.b.c = 1 ¦ "\\u0000" = 1 ¦ x = 1979-05-27T07:32:00 ¦
[[closure]]\nframes = ['foot', 'arm'] ¦ stance = ['body', 'body'] ¦ [packages]\nstick = '/dev' ¦ [xacro]\nmass = 'x' ¦
srdf = '../outside/secret.srdf' ¦ srdf = 'robot.srdf' ¦ joints.rotor = { knee = { inertia = 1e12, gear_ratio = 1e12 } } ¦
plane = [0, 0, 0] ¦
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
\0 ¦ \x1b[2J ¦ \xff ¦ \xef\xbb\xbf ¦ \xe2\x80\xae ¦ \r ¦ < ¦ & ¦ " ¦ ]]> ¦ <!DOCTYPE r [<!ENTITY x 'y'>]> ¦ \xf0\x9f ¦
\xef\xbb\xbf ¦ \xef\xbb\xbf\xef\xbb\xbf ¦ \xef\xbb\xbf\xef\xbb\xbf<!DOCTYPE robot [<!ENTITY x SYSTEM '../outside/secret.xml'>]> ¦
\r\n\r\n ¦ \xfe\xff ¦ <!DOCTYPE robot SYSTEM '../outside/secret.xml'> ¦ <?xml version="1.0" encoding="iso-8859-1"?> ¦
<?xml version="1.0" encoding="utf-16"?> ¦ <?xml version="1.0" encoding="utf-7"?> ¦ <?xml version="1.0" encoding="idna"?> ¦
<?xml version="1.1"?> ¦ <?xml version="1.0" standalone="no"?> ¦ #!/bin/sh ¦ \0\0
""",
    "A" * 100_000,
    " " * 70_000,
)
"""Bytes that may stand anywhere, or before the others."""

OPTIONS = _table("""
--contact-point lowest ¦ --joints locked ¦ --joints geared --armature *=0.05 ¦ --slide ¦ --body * ¦ --at body:0,0,0.1 ¦ --explain ¦
--pulse half-sine:5ms --range-g 4 ¦ --velocity 0.3,0.2,-1 ¦ --base fixed ¦ --base planar ¦ --base free ¦ --set knee=30 ¦
--lock knee ¦ --stance arm ¦ --plane yz ¦ --angular-velocity 0,1,0 ¦ --contact arm ¦
--contact shin+arm ¦ --contact * ¦ --v-in com ¦ --posture standing ¦ --package stick=. ¦
--package other=/dev --package outside=. ¦ --xacro mass:=3 ¦ --xacro mass:=nan ¦ --save-scene saved.toml ¦ --out out ¦
--figures --out out ¦ --format json ¦ --format csv ¦ --format markdown ¦ --format table ¦ --format junit ¦ --format github ¦
--format json=report.json ¦ --vary knee=-20:20:3 ¦ --vary knee=0 ¦ --vary strike-angle=0:30:2 ¦ --vary mass:*=0.5x:2x ¦
--vary-each mass:*=+-5% ¦ --vary armature:*=0.5x:2x ¦ --vary com-x:body=+-0.01 ¦ --vary inertia:*=1x:2x:log ¦ --vary contact=* ¦
--vary friction=0:1:2 ¦ --vary base-yaw=0:90:2 ¦ --vary joint-stiffness:*=0.5x:2x ¦ --vary joint-stiffness:knee=10,100 ¦
--vary offset-x=0,0.01 ¦ --sample 5 ¦ --sample 3 --lhs ¦ --seed 3 ¦ --prove 2 ¦ --prove 0 ¦ --armature *=0.05 ¦ --quantity shock ¦
--quantity joint_impulse@* ¦ --quantity ropc ¦ --resume ¦ --jobs 2 ¦ --change mass:*=0.9x ¦ --at body ¦ --step 5 ¦
--rank shock@body ¦ --rank nothing ¦ --rows csv --out out ¦ --rows parquet --out out ¦ --map q_knee=knee ¦ --map *knee=*shoulder ¦
--map after*= ¦ --map vx=vx_body ¦ --command a ¦ --command c ¦ --command row ¦ --joints free,locked ¦ --contact-stiffness 1e5 ¦
--friction 0.4 ¦ --quantity shock_friction
""")
"""Options with values that make sense; each command is given some of those that it has."""

STUDIES = ("sweep", "batch", "compare", "place", "limits", "sensitivity", "recorded")
"""Commands that compute many landings."""

UNFINISHED: dict[str, bytes] = {}
"""The files of the studies below that can be continued; the fuzzer fills them in."""

SWEEP = "sweep robot.urdf --contact foot --vary knee=-20:20:3 --prove 1"
CONTINUED = {
    "parts/parquet": f"{SWEEP} --rows parquet",
    "parts/landings": "recorded landings.csv robot.urdf --rows parquet",
}
"""Studies that can be continued, by the folder of their parts."""

COMMANDS = {
    "analyze robot.urdf --contact foot": (
        38,
        "robot.urdf " * 7 + "robot.srdf package.xml part.stl part.obj part.dae part.ply",
    ),
    "analyze robot.xml --contact foot": (24, "robot.xml " * 5 + "more.xml part.stl"),
    "analyze robot.sdf --contact foot": (6, "robot.sdf " * 5 + "part.stl"),
    "analyze robot.urdf.xacro --contact foot": (
        5,
        "robot.urdf.xacro " * 3 + "macros.xacro values.yaml",
    ),
    "analyze scene.toml": (14, "scene.toml " * 5 + "robot.urdf robot.srdf"),
    "analyze robot.urdf --contact arm --contact-point lowest": (6, "part.obj part.ply robot.urdf"),
    "analyze robot.xml --contact shin --contact-point lowest": (2, "robot.xml part.stl"),
    "robots robot.urdf": (4, "robot.urdf package.xml"),
    "robots robot.xml": (2, "robot.xml more.xml"),
    "check budgets.toml": (3, "budgets.toml " * 3 + "scene.toml robot.urdf"),
    "check budgets.toml --baseline baseline.json": (7, "baseline.json " * 8 + "budgets.toml"),
    "check budgets.toml --baseline new.json --update-baseline": (
        1,
        "budgets.toml scene.toml robot.urdf",
    ),
    "batch robot.urdf robot.xml --contact foot": (4, "robot.urdf robot.xml part.stl"),
    "compare robot.urdf robot.xml --contact foot": (4, "robot.urdf robot.xml"),
    "place robot.urdf --contact foot --body body --within -0.1:0.1,-0.1:0.1,0:0.1": (
        3,
        "robot.urdf part.stl",
    ),
    "limits robot.urdf --contact foot --joint knee --at body --max 0.2": (3, "robot.urdf"),
    "sensitivity robot.urdf --contact foot --at body": (4, "robot.urdf"),
    "recorded landings.csv robot.urdf": (8, "landings.csv " * 7 + "robot.urdf"),
    "recorded landings.csv scene.toml": (2, "landings.csv scene.toml"),
    **{
        f"recorded {name} robot.urdf": (4, name)
        for name in ("landings.npz", "landings.parquet", "ros.npz")
    },
    "recorded mujoco.npz robot.xml": (3, "mujoco.npz"),
    "touchdowns log.csv robot.urdf --contact foot": (1, "log.csv " * 3 + "robot.urdf"),
    "identify landings.csv robot.urdf --unknown armature:knee=0.01:1": (0.5, "landings.csv"),
    "improve robot.urdf --contact foot --at body --vary knee=-60:60 --starts 1": (
        0.5,
        "robot.urdf",
    ),
    "fall robot.urdf": (1, "robot.urdf part.stl"),
    "export robot.urdf --contact foot --quantity shock@body --lang js --sample 3": (
        0.5,
        "robot.urdf",
    ),
    "bench robot.urdf --contact foot": (0.2, "robot.urdf"),
    **dict.fromkeys(
        ("guide", "paper 1", "quantities", "schema", "schema budgets"), (0.1, "robot.urdf")
    ),
    **{f"{line} --out {folder}": (1, line.split()[1]) for folder, line in CONTINUED.items()},
    **{
        f"{line} --out {folder} --resume": (2, f"{folder}/* " * 9 + "robot.urdf")
        for folder, line in CONTINUED.items()
    },
}
"""Commands: how often each is run, and the files of which some are changed; FOLDER/* is any in it.
"""


class Case(NamedTuple):
    """A case: the files of its folder, and the words of the command line."""

    files: dict[str, bytes]
    words: list[str]


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
        files[name] = _changed(rng, name, files[name])
        if name in UNFINISHED and rng.random() < 0.1:
            del files[name]
    known = options_of(words[0])
    usable = [
        text.split()
        for text in OPTIONS
        if known.issuperset(word for word in text.split() if word.startswith("--"))
    ]
    for _ in range(rng.choice((0, 0, 1, 1, 2)) if usable else 0):
        words += rng.choice(usable)
    if rng.random() < 0.05:
        words += [rng.choice(sorted(known)), _value(rng)]
    if "--vary" in known and rng.random() < 0.1:
        words += ["--vary", f"{rng.choice((*NAMES, 'knee', 'mass:*'))}={rng.choice(NUMBERS)}"]
    if rng.random() < 0.02:
        words[rng.randrange(len(words))] = _value(rng)
    return Case(files, words)


@functools.cache
def options_of(command: str) -> frozenset[str]:
    """The options that a command has."""
    return frozenset(
        option
        for one in get_command(app_for([command])).commands[command].params
        for option in one.opts
    )


def _value(rng: random.Random, key: Any = "") -> str:
    """A value that does not belong there; `key`: what it is called."""
    tables = (5, 3, 2, 1) if not re.search("file|dir", str(key)) else (1, 1, 6, 1)
    return rng.choice(rng.choices((NUMBERS, NAMES, PATHS, EXPRESSIONS), tables)[0])


def _changed(rng: random.Random, name: str, data: bytes) -> bytes:
    """A file with one thing changed."""
    form = FORMS.get(name.rpartition(".")[2])
    ways = (*(_nested,) * 5 * bool(form), *(_pieces,) * 2 * (b"\0" not in data), _bytes)
    # it was broken by an earlier change, or its format has no place for this one
    with contextlib.suppress(*UNWRITABLE):
        return rng.choice(ways)(rng, name, data)
    return _bytes(rng, name, data)


UNWRITABLE = (
    ElementTree.ParseError,
    ValueError,
    LookupError,
    TypeError,
    RecursionError,
    NotImplementedError,
    EOFError,
)
UNWRITABLE += (
    AttributeError,
    struct.error,
    OSError,
    zlib.error,
    zipfile.BadZipFile,
    pyarrow.ArrowException,
)


def _plain(element: ElementTree.Element) -> list[Any]:
    """An element of XML as a list: tag, attributes, text, and the elements in it."""
    return [element.tag, dict(element.attrib), element.text or "", *map(_plain, element)]


def _element(part: list[Any]) -> ElementTree.Element:
    """The element of such a list."""
    element = ElementTree.Element(
        str(part[0]), {str(key): str(value) for key, value in part[1].items()}
    )
    element.text = str(part[2])
    element.extend(map(_element, part[3:]))
    return element


XML = (
    lambda data: _plain(ElementTree.fromstring(data)),
    lambda part: ElementTree.tostring(_element(part), "utf-8"),
)
FORMS = {
    **dict.fromkeys(("urdf", "xml", "sdf", "srdf", "xacro", "dae"), XML),
    "json": (json.loads, lambda part: json.dumps(part, skipkeys=True).encode()),
    "csv": (
        lambda data: [
            list(column)
            for column in zip(*(row.split(",") for row in data.decode().split("\n")), strict=False)
        ],
        lambda columns: "\n".join(
            ",".join(map(str, row)) for row in zip(*columns, strict=False)
        ).encode(),
    ),
    "npz": (
        lambda data: {key: array.tolist() for key, array in np.load(io.BytesIO(data)).items()},
        lambda part: packed("npz", part),
    ),
    "parquet": (
        lambda data: pyarrow.parquet.read_table(io.BytesIO(data)).to_pydict(),
        lambda part: packed("parquet", part),
    ),
}
"""How a format becomes lists, dictionaries, texts and numbers, and is made of them, by the ends of
names.
"""


def _nested(rng: random.Random, name: str, data: bytes) -> bytes:
    """A document in which a part is missing, stands twice, elsewhere or for another, is of another
    type, or has another key.
    """
    form = name.rpartition(".")[2]
    read, write = FORMS[form]
    parts = [read(data)]
    places: list[tuple[Any, Any]] = []
    for part in parts:  # grows
        keys = list(part) if isinstance(part, dict) else range(len(part))
        places += [(part, key) for key in keys]
        parts += [part[key] for key in keys if isinstance(part[key], dict | list)]
    leaves = [(part, key) for part, key in places if not isinstance(part[key], dict | list)]
    way = rng.choices(range(7), (2, 2, 2, 1, 8, 1, 0.2))[0]
    part, key = rng.choice(leaves if way == 4 and leaves else places)
    source, at = rng.choice(places)
    other = copy.deepcopy(source[at])
    match way:
        case 0:
            del part[key]
        case 1:
            part[key] = other
        case 2 if isinstance(part, list):
            part.insert(key, other)
        case 2 | 3 if isinstance(part, dict):
            part[_value(rng)] = part.pop(key)
        case 3 if form in ("npz", "parquet") or isinstance(part[key], list):
            kind = rng.choice(
                ("int8", "?", "c16", "f2", "f8", "U9", "S9", "M8[D]", "m8[s]", "u8", "O")
            )
            part = part if isinstance(part, dict) else parts[0]
            with np.errstate(all="ignore"):
                part[key] = np.array(part[key]).astype(kind)
        case 6 if isinstance(part, list):
            part[key:key] = [part[key]] * rng.choice((3, 100, 3000))
        case _:
            text = _value(rng, key)
            odd = (
                None,
                True,
                -1,
                1e308,
                np.nan,
                np.inf,
                1e20,
                -1e-320,
                90.0,
                0.0,
                [],
                {},
                [part[key]],
            )
            part[key] = rng.choice((text, text, *odd))
            if form == "json" and rng.random() < 0.5:  # as it is
                raw = rng.choice((text, "[" * 3000, "NaN", "Infinity", '{"a": 1, "a": 2}'))
                part[key] = "HERE"
                return write(parts[0]).replace(b'"HERE"', raw.encode())
    return write(parts[0])


def _pieces(rng: random.Random, name: str, data: bytes) -> bytes:
    """Text in which a line, a word or a value is missing, stands twice, elsewhere, or is another."""
    pieces = re.split(
        rng.choice((rb"(\n)", rb"([\s,]+)", rb"([\s,=<>\"]+)", rb"([^-+.e\d]+)")), data
    )
    k, other = (2 * rng.randrange((len(pieces) + 1) // 2) for _ in range(2))
    text = _value(rng)
    if name.endswith(("toml", "yaml")) and rng.random() < 0.5:
        text = json.dumps(text, ensure_ascii=False)
    match rng.randrange(8):
        case 0:
            del pieces[k : k + 2]
        case 1:
            pieces[k:k] = pieces[k : k + 2]
        case 2:
            pieces[k] = pieces[other]
        case 3 | 4:
            pieces[k] = rng.choice(NUMBERS).encode()
        case 5:
            pieces[k] += rng.choice(ELEMENTS if b"<" in data else LINES).encode()
        case _:
            pieces[k] = text.encode()
    return b"".join(pieces)


def _bytes(rng: random.Random, _: str, data: bytes) -> bytes:
    """Bytes changed anywhere: cut, inserted, replaced, in another encoding, numbers and counts of
    binary files, single bits.
    """
    at = rng.randrange(len(data) + 1)
    match rng.randrange(8):
        case 0:
            return data[:at]
        case 1:
            return data[:at] + rng.choice(JUNK).encode("latin-1") + data[at:]
        case 2:
            return rng.choice(JUNK).encode("latin-1") + (
                data if rng.random() < 0.3 else re.sub(rb"^<\?xml[^>]*>", b"", data)
            )
        case 3:
            return data[:at] + data[rng.randrange(len(data) + 1) :]
        case 4:
            return data.decode(errors="replace").encode(
                rng.choice(("utf-16", "utf-16-be", "utf-32", "latin-1")), "replace"
            )
        case 5:
            at = rng.choice((80, at - at % 2))  # the count of triangles of an STL, or a coordinate
            numbers = [
                struct.pack("<f", number) for number in (3e38, np.nan, np.inf, 1e20, 1e-40, -1e6)
            ]
            return (
                data[:at]
                + rng.choice((*numbers, bytes(4), b"\1\0\0\0", b"\0\0\0\x80", b"\xff" * 4))
                + data[at + 4 :]
            )
    flipped = bytearray(data)
    for k in rng.choices(range(len(data)), k=rng.choice((1, 3, 20))) if data else ():
        flipped[k] ^= 1 << rng.randrange(8)
    return bytes(flipped)
