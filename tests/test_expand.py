"""xacro: expanded without ROS in a child process with limits, which reads nothing outside the open
folders.
"""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import xacro as library
from commands import says
from robot_texts import arm, joint, link, read, refusal, refused, written, xacro

import shockpc.robot.xacro.expand
from shockpc.robot.formats import read_source
from shockpc.robot.xacro.expression import evaluate
from shockpc.text.errors import RobotError

PAYLOAD = xacro('<xacro:arg name="payload" default="1.5"/>', link("base", mass="$(arg payload)"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A package for the robot, with a secret beside it."""
    (tmp_path / "secret.xacro").write_text(xacro(link("secret")))
    (tmp_path / "secret.yaml").write_text("mass: 3\n")
    (tmp_path / "dog").mkdir()
    (tmp_path / "dog" / "package.xml").touch()
    return tmp_path / "dog"


NAME = "dog.urdf.xacro"


def test_arguments_and_their_defaults(folder: Path):
    """An argument given replaces its default."""
    assert '<mass value="1.5"/>' in read(folder, PAYLOAD, NAME).xml
    assert '<mass value="2.5"/>' in read(folder, PAYLOAD, NAME, xacro={"payload": "2.5"}).xml
    assert read(folder, PAYLOAD, NAME).kind == "urdf"


def test_xacro_by_content(tmp_path: Path):
    """A file with expressions is expanded whatever its suffix; a URDF that only declares the
    namespace is left as it is.
    """
    assert '<mass value="1.5"/>' in read(tmp_path, PAYLOAD).xml
    macro = xacro(
        '<xacro:macro name="base">', link("base", mass="2"), "</xacro:macro><xacro:base/>"
    )
    assert '<mass value="2"/>' in read(tmp_path, macro).xml
    assert "xmlns:xacro" in read(tmp_path, xacro(link("base", mass="2"))).xml
    assert read(tmp_path, arm(), NAME).robot_name == "r"


@pytest.mark.parametrize("text", [arm(), xacro(link("base"))], ids=["undeclared", "declared"])
def test_xacro_elements_left_in_a_urdf(text: str, tmp_path: Path):
    """They are ignored with a warning where the links are complete without them."""
    source = read(
        tmp_path,
        text.replace(
            "</robot>", '<xacro:include filename="none.xacro"/><xacro:wheel r="${2*r}"/></robot>'
        ),
    )
    (warning,) = source.warnings
    assert says(warning, "dog.urdf", "<xacro:include>, <xacro:wheel> ignored", ".xacro")


def test_xacro_elements_left_in_a_shape(tmp_path: Path):
    """They are ignored like others, but one that may stand for mass is not."""
    shape = '<visual><geometry><box size="1 1 1"/></geometry><xacro:grey/></visual>'
    source = read(tmp_path, arm(tip=link("tip", more=shape)))
    assert "<xacro:grey> ignored" in source.warnings[0]
    heavy = xacro(link("base"), link("tip", more="<xacro:heavy/>"), joint("elbow", "base", "tip"))
    refused(RobotError, ["xacro:heavy"], read, tmp_path, heavy)


def test_includes_yaml_and_packages(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Includes and YAML are found beside the file, in its package and in a given one, whatever the
    current folder.

    What a file calls optional may be missing, and $(dirname) is the folder of the file that says
    it.
    """
    monkeypatch.chdir(tmp_path)
    (folder / "package.xml").write_text("<package><name>dog_description</name></package>")
    (folder / "parts.xacro").write_text(
        xacro(
            '<xacro:arg name="m" default="2"/>',
            '<xacro:macro name="part" params="n"><link name="${n}"/></xacro:macro>',
        )
    )
    (folder / "numbers.yaml").write_text("mass: 3\n")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "more.xacro").write_text(xacro(joint("j", "base", "hand", "fixed")))
    mesh = '<visual><geometry><mesh filename="package://dog/a.stl"/></geometry></visual>'
    text = xacro(
        '<xacro:include filename="parts.xacro"/>',
        '<xacro:include filename="$(find other)/more.xacro"/>',
        '<xacro:include filename="none.xacro" optional="true"/>',
        '<xacro:property name="again" value="${xacro.load_yaml(\'$(dirname)/numbers.yaml\')}"/>',
        '<xacro:property name="numbers" value="${xacro.load_yaml(\'$(find '
        "dog_description)/numbers.yaml')}\"/>",
        link("base", mass="${numbers.mass * again.mass * $(arg m)}", more=mesh),
        '<xacro:part n="hand"/>',
    )
    source = read(folder, text, NAME, packages={"other": tmp_path / "other"}, xacro={"m": "4"})
    assert '<mass value="36"/>' in source.xml
    assert '<link name="hand"/>' in source.xml
    assert mesh in source.xml  # as its author wrote it, which a figure resolves later


def test_warnings_are_caught(folder: Path, capfd: pytest.CaptureFixture[str]):
    """Messages of xacro become warnings, each once, and nothing is printed."""
    text = PAYLOAD.replace(
        "<link", '<xacro:property name="pi" value="3"/>${xacro.message(\'built for dogs\')}<link', 1
    )
    assert read(folder, text, NAME).warnings == (
        "dog.urdf.xacro: xacro: redefining global symbol: pi",
        "dog.urdf.xacro: xacro: built for dogs",
    )
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("expression", ["1 is 1", "'\\d' and 1"])
def test_what_python_says_of_odd_code_is_no_warning(expression: str, folder: Path):
    """The value of an expression counts, not its style."""
    assert read(folder, xacro(link(f"base_${{{expression}}}")), NAME).warnings == ()


def included(name: str) -> str:
    """A robot that is another file."""
    return xacro(f'<xacro:include filename="{name}"/>')


OUTSIDE = (
    'leads to "{top}/secret.{kind}", outside the folders that may be read ("{dog}"). If it belongs '
    "to the robot, name the folder"
)
CANNOT = "xacro cannot expand it: "
ENDLESS = "xacro does not come to an end; a macro or an include calls itself"
TEXT = "an argument or property holds a text where arithmetic needs a number: "
DOUBLED = "".join(
    f'<xacro:macro name="m{k}" params="n"><xacro:m{k - 1} n="${{n}}a"/><xacro:m{k - 1} '
    f'n="${{n}}b"/></xacro:macro>'
    for k in range(1, 12)
)
REFUSED = {
    xacro(
        link("base", mass="$(arg payload)")
    ): 'xacro argument "payload" has no value; give: --xacro payload:=VALUE',
    xacro(link("base", mass="$(arg payload)"), link("leg", mass="$(arg leg)")): (
        'xacro arguments "payload", "leg" have no value; give: --xacro payload:=VALUE --xacro '
        "leg:=VALUE"
    ),
    # What follows from a missing argument is not the cause.
    xacro(f"<xacro:if value=\"${{xacro.arg('a') * 2}}\"/>{included('../$(arg b)/$(arg c)')}"): (
        'xacro arguments "a", "b", "c" have no value; give: --xacro a:=VALUE --xacro b:=VALUE '
        "--xacro c:=VALUE"
    ),
    **{
        xacro(
            link("base", mass=text)
        ): "contains a NUL character or half of a surrogate pair (\\ud800 to \\udfff)"
        for text in (
            "${'a\\0'}",
            "${'\\ud800'}",
            "${xacro.load_yaml('\\0.yaml')}",
            "${xacro.load_yaml('text.yaml')}",
            "${'%c' % 0}",
        )
    },
    **{
        PAYLOAD.replace("$(arg payload)", f"${{'a' {by}}}" if by[0] != "-" else "${-'a'}"): TEXT
        for by in ("/ 2", "- 1", "** 2", "+ 1")
    },
    # Whose text has an address, another one in every run.
    **{
        xacro(link(f"${{{given}}}")): f"an expression gives <{printed}>, a Python object; call it"
        for given, printed in {
            "load_yaml": "function create_global_symbols.<locals>.deprecate.<locals>.wrapper",
            "xacro.load_yaml": "function load_yaml",
            "[1, str(map(len, []))]": "map object",
            "'leg_%s' % map(len, [])": "map object",
            "xacro.message(xacro.tokenize)": "function tokenize",
            "xacro.load_yaml(str(python.filter(len, [])))": "filter object",
        }.items()
    },
    included("none.xacro"): 'dog.urdf.xacro includes "{dog}/none.xacro", which does not exist',
    included(
        "$(find cat)/a.xacro"
    ): '$(find cat): no package "cat" among those given, in ROS_PACKAGE_PATH or above the file',
    xacro('<xacro:dog legs="4"/>'): CANNOT + "unknown macro name: xacro:dog",
    xacro(link("base", mass="${payload}")): CANNOT
    + "name 'payload' is not defined when evaluating expression 'payload'",
    xacro(link("base", mass="$(eval open)")): CANNOT + "name 'open' is not defined",
    xacro(link("base", mass="${1 +}")): CANNOT
    + "invalid syntax (<expression>, line 1) when evaluating expression '1 +'",
    xacro(link("base", mass="${1 / 0}")): CANNOT
    + "division by zero when evaluating expression '1 / 0'",
    xacro('<xacro:macro name="dog"><xacro:dog/></xacro:macro><xacro:dog/>'): ENDLESS,
    included("dog.urdf.xacro"): ENDLESS,
    xacro("<xacro:if value=\"${xacro.fatal('too many legs')}\"/>"): CANNOT + "too many legs",
    xacro('<xacro:macro name="dog"><link name="base"/></xacro:macro>'): "has no <link>",
    # A macro that doubles itself would give millions.
    xacro(
        '<xacro:macro name="m0" params="n"><link name="${n}"/></xacro:macro>',
        DOUBLED,
        '<xacro:m11 n="l"/>',
    ): (CANNOT + "it has 2048 links, more than 2000"),
    # After some seconds, or when it takes more memory or more text than it may have.
    **{
        xacro(link("base", mass=endless)): "grows without end"
        for endless in (
            "${9**9**9}",
            "${len('ab' * 3 * 10**9)}",
            "${len([0] * 10**9)}",
            "${math.factorial(10**7)}",
            "${list(map(list, [range(10**9)] * 10**6))}",
            "${[xacro.message('a' * 10**6) for n in range(99)]}",
        )
    },
    xacro(link("base", mass="${1 &lt;&lt; 10**9}")): "4300 digits",
    **{
        xacro(link("base", mass=many)): "it has to be one finite number"
        for many in ("${range(10**7)}", "${[0 for a in range(2000) for b in range(200)]}")
    },
    included("broken.xacro"): "broken.xacro: line 2, column 9: mismatched tag",
    included(
        "entity.xacro"
    ): "entity.xacro: line 1: a DOCTYPE can define entities, and those are never expanded here",
    # No include, YAML or glob leads out of the open folders, whether the file exists or not.
    **{
        included(name): f'dog.urdf.xacro: "{called}" {OUTSIDE}'.replace("{kind}", "xacro")
        for name, called in {
            "../secret.xacro": "{dog}/../secret.xacro",
            "{top}/secret.xacro": "{top}/secret.xacro",
            '../secret.xacro" optional="true': "{dog}/../secret.xacro",
        }.items()
    },
    included(
        "../sec*.xacro"
    ): '"{dog}/../sec*.xacro" leads to "{top}", outside the folders that may be read',
    included(
        "/*/*/*/*/*/*/*.xacro"
    ): '"/*/*/*/*/*/*/*.xacro" leads to "/*/*/*/*/*/*", outside the folders that may be read',
    included("../none.xacro"): OUTSIDE.replace("secret.{kind}", "none.xacro"),
    **{
        xacro(f"<link name=\"${{{module}load_yaml('../secret.yaml')}}\"/>"): OUTSIDE.replace(
            "{kind}", "yaml"
        )
        for module in ("", "xacro.")
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("text", REFUSED, ids=range(len(REFUSED)))
def test_what_cannot_be_expanded(
    text: str,
    folder: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
):
    """Each failure is one line that names the file, within some seconds, and nothing is printed."""
    monkeypatch.setattr(
        shockpc.robot.xacro.expand, "SECONDS", 1 if "without end" in REFUSED[text] else 10
    )
    (folder / "text.yaml").write_text('"\\0"')
    (folder / "broken.xacro").write_text("<robot>\n<link></robot>")
    (folder / "entity.xacro").write_text('<!DOCTYPE robot [<!ENTITY a "aaaa">]><robot>&a;</robot>')
    begin = time.monotonic()
    said = refusal(folder, text.replace("{top}", str(tmp_path)), NAME)
    assert time.monotonic() - begin < 11.0
    assert REFUSED[text].replace("{dog}", str(folder)).replace("{top}", str(tmp_path)) in said
    assert "\n" not in said
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("text", "name", "said"),
    [
        (
            PAYLOAD,
            "payloda",
            'has no xacro argument "payloda"; nearest: "payload". It has "payload"',
        ),
        (PAYLOAD, "legs", 'has no xacro argument "legs". It has "payload"'),
        (xacro(link("base")), "m", 'has no xacro argument "m". It has none, so leave it out'),
    ],
)
def test_unknown_argument(text: str, name: str, said: str, folder: Path):
    """A slip in an argument's name is an error that lists those the file has, if any."""
    assert refusal(folder, text, NAME, xacro={name: "1"}) == f"{NAME} {said}"


def test_threads_do_not_mix(folder: Path):
    """Two robots expanded at once keep their arguments."""
    path, payloads = written(folder, PAYLOAD, NAME), [str(1 + k % 4) for k in range(12)]
    with ThreadPoolExecutor(4) as pool:
        found = pool.map(
            lambda payload: read_source(path, xacro={"payload": payload}).xml, payloads
        )
        assert all(
            f'<mass value="{payload}"/>' in text
            for payload, text in zip(payloads, found, strict=True)
        )


@pytest.mark.parametrize("expression", ["python.hash('leg')", "list(python.set(list('abcdefgh')))"])
def test_every_run_gives_the_same_text(expression: str, folder: Path):
    """Python alone would give texts another hash, and sets another order, in every process."""
    document = xacro(link(f"base_${{{expression}}}"))
    assert len({read(folder, document, NAME).xml for _ in range(3)}) == 1


def test_expressions_compute(folder: Path):
    """Numbers, properties and arguments, in both ways to write expressions."""
    numbers = {
        "$(eval 2 * payload)": "3.0",
        "$(eval 2**3 if true else {'a': pi}['a'])": "8",
        "${radians(180) / pi}": "1.0",
        "${2**-n}": "0.125",
        "${xacro.arg('payload')}": "1.5",
        "${f([1, 2])}": "2",
        "${xacro.load_yaml('units.yaml').angle}": "3.141592653589793",
    }
    (folder / "units.yaml").write_text("angle: !degrees 90 * 2\n")
    properties = (
        '<xacro:arg name="payload" default="1.5"/><xacro:property name="n" '
        'value="3"/><xacro:property name="f" value="${len}"/>'
    )
    for expression, value in numbers.items():
        assert (
            f'<mass value="{value}"/>'
            in read(folder, xacro(properties, link("base", mass=expression)), NAME).xml
        )


LEGAL = """
1 - 2.5e-3 * -3 // 2 % 2 + 7 / 2 ** 3 ¦ ~5 & 6 | 1 ^ 3 << 2 >> 1 ¦ 'ab' 'c' + "d" * n ¦ (1, 'a', None, True) ¦ bool(0) ¦ str(1.0)
not n or 0 and 1 / 0 ¦ 0 or '' ¦ 3 and 0 and 1 / 0 ¦ 1 < n <= 3 != 4 == 4 ¦ 1 > 2 > 1 / 0 ¦ 2 in [1, 2] and 'x' not in 'ab'
None is None is not True ¦ 1 if n > 2 else 1 / 0 ¦ words[0][-1] + words[1][::-1][1:] ¦ (0, 1, 2)[n - 1] ¦ dict(a=7)['a']
robot.leg.mass ¦ robot['leg']['mass'] ¦ robot.feet[1].name ¦ [2 * foot.size for foot in robot.feet] ¦ 'mass' in robot.leg
[k * l for k in range(n) if k for l in [k, n] if l > k] ¦ [a + b for a, b in python.zip('ab', words)] ¦ robot.leg.get('none', 1)
python.sum(x**2 for x in [1, 2]) ¦ python.sum([x**2 for x in [1, 2]]) ¦ sorted(words, key=len) ¦ sorted(words, reverse=True)
list(map(str, range(3))) ¦ max([1, 2]) ¦ math.hypot(3, 4) + sin(pi / 6) ¦ 'a b'.split() ¦ (1, n).index(3)
', '.join(words).upper().replace('O', '0') ¦ list(robot.leg.items()) ¦ xacro.tokenize('a, b;c') ¦ xacro.dotify(dict(a=1)).a
'%s_%03d' % ('leg', n) ¦ round(2.567, 1) ¦ int('12') + float('.5') ¦ python.abs(-2) ¦ python.isinstance('a', str)
python.any([0, 1]) ¦ xacro.message('') ¦ python.list(python.enumerate('ab')) ¦ [words.append('c'), words.pop()] ¦ {'a': n}['a']
"""


@pytest.mark.parametrize(
    "expression", [part.strip() for line in LEGAL.strip().splitlines() for part in line.split("¦")]
)
def test_expressions_have_the_value_that_xacro_gives(expression: str):
    """That of Python's evaluation, in type and value."""
    robot = library.YamlDictWrapper(
        leg={"mass": 2.5}, feet=[{"name": "lf", "size": 1}, {"name": "rf", "size": 2}]
    )

    def names() -> dict[str, object]:
        return {**library._global_symbols, "n": 3, "words": ["one", "three"], "robot": robot}

    assert repr(evaluate(expression, names())) == repr(library.safe_eval(expression, names()))


INSIDE = "${(lambda: (lambda: xacro.tokenize.__globals__['sys'].modules)())()"
ATTACKS = {
    **dict.fromkeys(
        [
            INSIDE + "['os'].system('touch {made}')}",
            INSIDE + "['os'].mkfifo('{made}')}",
            INSIDE + "['os'].stat('{secret}').st_size}",
            INSIDE + "['os'].remove('{secret}')}",
            INSIDE + "['builtins'].open('{secret}').read()}",
            INSIDE + "['__main__']._COMPUTING.add('os.system')}",
            INSIDE + "['os'].write(1, b'a')}",
            "${[hook for hook in [0] if (lambda: hook)()]}",
            "$(eval lambda: 0)",
            "$(eval f'{1}')",
            "${(n := 1)}",
            "${b'a'}",
            "${dict(**math)}",
            "${len(*[])}",
            "${[0 for math.pi in [1]]}",
            "${[0 for words[0] in [1]]}",
            "${[0 for *x, y in [[1, 2]]]}",
            "$(eval {**math})",
            "$(eval {1, 2})",
            "$(eval {k: 1 for k in [2]})",
            "${[x async for x in [1]]}",
            "${...}",
        ],
        "is not allowed: an expression may hold numbers",
    ),
    **dict.fromkeys(
        [
            "${xacro.tokenize.__globals__}",
            "${().__class__.__base__.__subclasses__()}",
            "${[x.__class__ for x in [1]]}",
            "${'{0'.format(xacro.tokenize)}",
            "${(n for n in [1]).gi_frame}",
            "${str.format}",
            "${robot.__class__}",
            "${len.__self__}",
            "${'a'.join.__self__}",
            "${[].append.__func__}",
            "${str.join}",
            "${dict.fromkeys}",
            "${'a'.translate}",
            "${math.pi.hex}",
        ],
        ("an expression cannot read .", "the yaml dictionary has no key"),
    ),
    **dict.fromkeys(
        [
            *(
                "${__import__('os')}",
                "${__builtins__}",
                "${open('{secret}')}",
                "${python.open('{secret}')}",
                "${math.__loader__}",
            ),
            *(
                "${python.type(1)}",
                "${python.vars(str)}",
                "${xacro.__init__}",
                "${xacro.root}",
                "${xacro.parent}",
                "${__builtins__['eval']}",
                "${[__builtins__ for x in [1]]}",
                "${eval('1')}",
                "$(eval open)",
                "$(eval __import__)",
            ),
            "${[getattr(x, 'a') for x in [1]]}",
        ],
        "is not defined",
    ),
    "$(env SECRET)": "environment variable 'SECRET' is not set",
    "$(optenv SECRET none)": "which does not exist",
}


@pytest.mark.slow
@pytest.mark.parametrize("expression", ATTACKS)
def test_expressions_run_nothing(
    expression: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Each is refused for what it says: no file is opened, made or removed, no process is started,
    no environment is read.
    """
    monkeypatch.setenv("SECRET", "classified")
    secret, made = tmp_path / "secret.yaml", tmp_path / "made"
    written = (
        expression.replace("{secret}", str(secret))
        .replace("{made}", str(made))
        .replace("&", "&amp;")
        .replace('"', "&quot;")
    )
    robot = '<xacro:property name="robot" value="${xacro.dotify(dict(a=1))}"/>'
    message = refusal(
        folder,
        xacro(link("base"), robot, f'<link name="{written}"/>', joint("j", "base", "x", "fixed")),
        NAME,
    )
    reasons = ATTACKS[expression]
    assert any(
        reason in message.lower()
        for reason in (reasons if isinstance(reasons, tuple) else [reasons.lower()])
    ), message
    assert "classified" not in message
    assert secret.exists()
    assert not made.exists()


def test_the_time_of_a_text_in_which_no_element_ends_is_linear(folder: Path):
    """100 000 beginnings of an argument within a comment: each would be followed to the end of the
    text.
    """
    text = PAYLOAD.replace("</robot>", f"<!-- {'<xacro:arg ' * 100_000} --></robot>")
    start = time.process_time()
    assert '<mass value="2.5"/>' in read(folder, text, NAME, xacro={"payload": "2.5"}).xml
    assert time.process_time() - start < 5.0


def test_the_time_of_a_package_without_a_name_is_linear(folder: Path):
    """Blanks after each <name>, of which every one could be the end of the name."""
    (folder / "package.xml").write_text("<name>" + " " * 100_000)
    start = time.process_time()
    text = xacro(link("base", mass="1"), '<xacro:include filename="$(find cat)/cat.xacro"/>')
    assert 'no package "cat"' in refusal(folder, text, NAME)
    assert time.process_time() - start < 5.0
