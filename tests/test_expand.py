"""xacro: expanded without ROS in a child process with limits, which reads nothing outside the open folders."""

import os
import threading
import time
from pathlib import Path

import pytest
from robot_texts import arm, joint, link, read, refusal, xacro

import shockpc.robot.xacro
from shockpc.robot.source import read_source

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
    """A file with expressions is expanded whatever its suffix; a URDF that only declares the namespace is left as it is."""
    assert '<mass value="1.5"/>' in read(tmp_path, PAYLOAD).xml
    macro = xacro('<xacro:macro name="base">', link("base", mass="2"), "</xacro:macro><xacro:base/>")
    assert '<mass value="2"/>' in read(tmp_path, macro).xml
    assert "xmlns:xacro" in read(tmp_path, xacro(link("base", mass="2"))).xml
    assert read(tmp_path, arm(), NAME).robot_name == "r"


@pytest.mark.parametrize("text", [arm(), xacro(link("base"))], ids=["undeclared", "declared"])
def test_xacro_elements_left_in_a_urdf(text: str, tmp_path: Path):
    """They are ignored with a warning where the links are complete without them."""
    source = read(tmp_path, text.replace("</robot>", '<xacro:include filename="none.xacro"/><xacro:wheel r="${2*r}"/></robot>'))
    assert source.warnings == (
        "dog.urdf: <xacro:include>, <xacro:wheel> ignored, because the links are complete without xacro; "
        "if not, name the file .xacro",
    )


def test_mesh_paths_stay_as_found(folder: Path):
    """The URDF names meshes as its author did, which a figure resolves later."""
    mesh = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    text = PAYLOAD.replace("</robot>", link("a", more=mesh.format("package://dog/a.stl") + mesh.format("b.stl")) + "</robot>")
    text = text.replace("</robot>", joint("j", "base", "a") + "</robot>")
    source = read(folder, text, NAME)
    assert 'filename="package://dog/a.stl"' in source.xml
    assert 'filename="b.stl"' in source.xml


def test_includes_yaml_and_packages(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Includes and YAML are found beside the file, in its package and in a given one, whatever the current folder.

    What a file calls optional may be missing, and $(dirname) is the folder of the file that says it.
    """
    monkeypatch.chdir(tmp_path)
    (folder / "package.xml").write_text("<package><name>dog_description</name></package>")
    (folder / "parts.xacro").write_text(
        xacro('<xacro:arg name="m" default="2"/>', '<xacro:macro name="part" params="n"><link name="${n}"/></xacro:macro>')
    )
    (folder / "numbers.yaml").write_text("mass: 3\n")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "more.xacro").write_text(xacro(joint("j", "base", "hand", "fixed")))
    text = xacro(
        '<xacro:include filename="parts.xacro"/>',
        '<xacro:include filename="$(find other)/more.xacro"/>',
        '<xacro:include filename="none.xacro" optional="true"/>',
        '<xacro:property name="again" value="${xacro.load_yaml(\'$(dirname)/numbers.yaml\')}"/>',
        '<xacro:property name="numbers" value="${xacro.load_yaml(\'$(find dog_description)/numbers.yaml\')}"/>',
        link("base", mass="${numbers.mass * again.mass * $(arg m)}"),
        '<xacro:part n="hand"/>',
    )
    source = read(folder, text, NAME, packages={"other": tmp_path / "other"}, xacro={"m": "4"})
    assert '<mass value="36"/>' in source.xml
    assert '<link name="hand"/>' in source.xml


def test_warnings_are_caught(folder: Path, capfd: pytest.CaptureFixture[str]):
    """Messages of xacro become warnings, each once, and nothing is printed."""
    text = PAYLOAD.replace("<link", '<xacro:property name="pi" value="3"/>${xacro.message(\'built for dogs\')}<link', 1)
    assert read(folder, text, NAME).warnings == (
        "dog.urdf.xacro: xacro: redefining global symbol: pi",
        "dog.urdf.xacro: xacro: built for dogs",
    )
    assert capfd.readouterr() == ("", "")


NO_ARGUMENTS = xacro('<xacro:property name="m" value="1"/>', link("base", mass="${m}"))
ARGUMENTS = {
    "payloda": (PAYLOAD, 'has no xacro argument "payloda"; nearest: "payload". It has "payload"'),
    "legs": (PAYLOAD, 'has no xacro argument "legs". It has "payload"'),
    "m": (NO_ARGUMENTS, 'has no xacro argument "m". It has none, so leave it out'),
}


@pytest.mark.parametrize("name", ARGUMENTS)
def test_unknown_argument(name: str, folder: Path):
    """A slip in an argument's name is an error that lists those the file has, if any."""
    text, said = ARGUMENTS[name]
    assert refusal(folder, text, NAME, xacro={name: "1"}) == f"{NAME} {said}"


HOLDS_TEXT = "an argument or property holds a text where arithmetic needs a number: "
TEXTS = {
    "m / 2": HOLDS_TEXT + "unsupported operand type(s) for /: 'str' and 'int' when evaluating expression 'm / 2'",
    "-m": HOLDS_TEXT + "bad operand type for unary -: 'str' when evaluating expression '-m'",
    "m**2": HOLDS_TEXT + "unsupported operand type(s) for ** or pow(): 'str' and 'int' when evaluating expression 'm**2'",
    "m + 1": HOLDS_TEXT + "can only concatenate str (not \"int\") to str when evaluating expression 'm + 1'",
}


@pytest.mark.parametrize("expression", TEXTS)
def test_texts_where_arithmetic_needs_numbers(expression: str, folder: Path):
    """An argument that is no number is named as the cause, wherever it is used."""
    mass = '<xacro:property name="m" value="$(arg payload)"/>'
    text = xacro('<xacro:arg name="payload" default="1.5"/>', mass, link("base", mass=f"${{{expression}}}"))
    assert refusal(folder, text, NAME, xacro={"payload": "abc"}) == f"dog.urdf.xacro: {TEXTS[expression]}"


REFUSED = {
    xacro(link("base", mass="$(arg payload)")): (
        'dog.urdf.xacro: xacro argument "payload" has no value; give: --xacro payload:=VALUE'
    ),
    xacro('<xacro:include filename="none.xacro"/>'): ('dog.urdf.xacro includes "{folder}/none.xacro", which does not exist'),
    xacro('<xacro:include filename="$(find cat)/a.xacro"/>'): (
        'dog.urdf.xacro: $(find cat): no package "cat" among those given, in ROS_PACKAGE_PATH or above the file. '
        "Say where it is: --package cat=DIR"
    ),
    xacro('<xacro:dog legs="4"/>'): "dog.urdf.xacro: xacro cannot expand it: unknown macro name: xacro:dog",
    xacro(link("base", mass="${payload}")): (
        "dog.urdf.xacro: xacro cannot expand it: name 'payload' is not defined when evaluating expression 'payload'"
    ),
    xacro(link("base", mass="${1 +}")): (
        "dog.urdf.xacro: xacro cannot expand it: invalid syntax (<expression>, line 1) when evaluating expression '1 +'"
    ),
    xacro(link("base", mass="${1 / 0}")): (
        "dog.urdf.xacro: xacro cannot expand it: division by zero when evaluating expression '1 / 0'"
    ),
    xacro('<xacro:macro name="dog"><xacro:dog/></xacro:macro><xacro:dog/>'): (
        "dog.urdf.xacro: xacro does not come to an end; a macro or an include calls itself"
    ),
    xacro('<xacro:include filename="dog.urdf.xacro"/>'): (
        "dog.urdf.xacro: xacro does not come to an end; a macro or an include calls itself"
    ),
    xacro("<xacro:if value=\"${xacro.fatal('too many legs')}\"/>"): (
        "dog.urdf.xacro: xacro cannot expand it: too many legs when evaluating expression 'xacro.fatal('too many legs')'"
    ),
    xacro('<xacro:macro name="dog"><link name="base"/></xacro:macro>'): (
        "dog.urdf.xacro: it has no <link>, so there is no robot in it; if it defines macros, give the file that uses "
        "them; if it is an SRDF, give the URDF, and this file with --srdf"
    ),
    xacro('<xacro:if value="false"><link name="a"/></xacro:if><link name="b"/>'): (
        "dog.urdf.xacro: no link has mass, so nothing in it can be struck; give at least one link an <inertial>"
    ),
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_xacro_cannot_expand(text: str, folder: Path, capfd: pytest.CaptureFixture[str]):
    """Each failure is one line that names the file, and nothing is printed."""
    assert refusal(folder, text, NAME) == REFUSED[text].replace("{folder}", str(folder))
    assert capfd.readouterr() == ("", "")


def test_broken_included_file(folder: Path):
    """An included file breaks under its own name, and may not define entities either."""
    text = xacro('<xacro:include filename="part.xacro"/>')
    (folder / "part.xacro").write_text("<robot>\n<link></robot>")
    assert refusal(folder, text, NAME) == (
        "part.xacro: line 2, column 9: mismatched tag; the file is not well-formed XML, so nothing of it is used"
    )
    (folder / "part.xacro").write_text('<!DOCTYPE robot [<!ENTITY a "aaaa">]><robot>&a;</robot>')
    assert refusal(folder, text, NAME) == (
        "part.xacro: line 1: a DOCTYPE can define entities, and those are never expanded here; "
        "delete it and write out what they stand for"
    )


@pytest.mark.parametrize(
    ("text", "called", "leads"),
    [
        (xacro('<xacro:include filename="../secret.xacro"/>'), "{dog}/../secret.xacro", "secret.xacro"),
        (xacro('<xacro:include filename="{top}/secret.xacro"/>'), "{top}/secret.xacro", "secret.xacro"),
        (xacro('<xacro:include filename="../sec*.xacro"/>'), "{dog}/../secret.xacro", "secret.xacro"),
        (xacro('<xacro:include filename="../secret.xacro" optional="true"/>'), "{dog}/../secret.xacro", "secret.xacro"),
        (xacro('<xacro:include filename="link.xacro"/>'), "{dog}/link.xacro", "secret.xacro"),
        (xacro("<link name=\"${xacro.load_yaml('../secret.yaml')}\"/>"), "{dog}/../secret.yaml", "secret.yaml"),
        (xacro("<link name=\"${load_yaml('../secret.yaml')}\"/>"), "{dog}/../secret.yaml", "secret.yaml"),
        (xacro('<xacro:include filename="../none.xacro"/>'), "{dog}/../none.xacro", "none.xacro"),
    ],
)
def test_nothing_outside_the_folders(text: str, called: str, leads: str, folder: Path, tmp_path: Path):
    """No include, YAML, glob or symbolic link leads out of the open folders, whether the file exists or not."""
    (folder / "link.xacro").symlink_to(tmp_path / "secret.xacro")
    called = called.format(dog=folder, top=tmp_path)
    assert refusal(folder, text.replace("{top}", str(tmp_path)), NAME) == (
        f'dog.urdf.xacro: "{called}" leads to "{tmp_path / leads}", outside the folders that may be read ("{folder}"). '
        "If it belongs to the robot, name the folder that holds it: --package NAME=DIR"
    )


def test_threads_do_not_mix(folder: Path):
    """Two robots expanded at once keep their own arguments."""
    path = folder / "dog.urdf.xacro"
    path.write_text(PAYLOAD)
    found: dict[str, bool] = {}

    def expand(payload: str) -> None:
        found[payload] = all(
            f'<mass value="{payload}"/>' in read_source(str(path), xacro={"payload": payload}).xml for _ in range(3)
        )

    threads = [threading.Thread(target=expand, args=(str(k),)) for k in range(1, 5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == dict.fromkeys(("1", "2", "3", "4"), True)


def test_expressions_compute(folder: Path):
    """Arithmetic, comprehensions, text and arguments work, in both ways to write them."""
    numbers = {
        "$(eval 2 * payload)": "3.0",
        "${sum([x**2 for x in [1, 2]]) if False else 2 * len('ab')}": "4",
        "${python.sum([x**2 for x in [1, 2]])}": "5",
        "${radians(180) / pi}": "1.0",
        "${int(dict(a=7)['a'])}": "7",
        "${2**-n}": "0.125",
        "$(eval 2**3)": "8",
    }
    properties = '<xacro:arg name="payload" default="1.5"/><xacro:property name="n" value="3"/>'
    for expression, value in numbers.items():
        assert f'<mass value="{value}"/>' in read(folder, xacro(properties, link("base", mass=expression)), NAME).xml


INSIDE = "${(lambda: xacro.load_yaml.__globals__)()"
ATTACKS = {
    INSIDE + "['__builtins__']['open']('{secret}').read()}": 'an expression asks for "open"',
    INSIDE + "['__builtins__']['__import__']('socket')}": 'an expression asks for "import"',
    INSIDE + "['os'].system('touch {made}')}": 'an expression asks for "os.system"',
    INSIDE + "['os'].mkdir('{made}')}": 'an expression asks for "os.mkdir"',
    INSIDE + "['os'].fork()}": 'an expression asks for "os.fork"',
    INSIDE + "['os'].remove('{secret}')}": 'an expression asks for "os.remove"',
    INSIDE + "['os'].environ['SECRET']}": "'SECRET'",
    "$(eval open)": None,
    "${__import__('os')}": "Use of invalid name(s)",
    "${[x.__class__ for x in [1]].nothing}": "has no attribute",
    "${python.open('{secret}')}": "name 'open' is not defined",
    "$(env SECRET)": "environment variable 'SECRET' is not set",
    "$(optenv SECRET none)": None,
}


@pytest.mark.parametrize("expression", ATTACKS)
def test_expressions_open_nothing(expression: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """No file is opened, made or removed, no process is started, no environment is read."""
    monkeypatch.setenv("SECRET", "classified")
    secret, made = tmp_path / "secret.yaml", tmp_path / "made"
    written = expression.replace("{secret}", str(secret)).replace("{made}", str(made)).replace("&", "&amp;").replace('"', "&quot;")
    text = xacro(link("base"), f'<link name="{written}"/>', joint("j", "base", "x", "fixed"))
    message = refusal(folder, text, NAME)
    assert (ATTACKS[expression] or "which does not exist") in message, message
    assert "classified" not in message
    assert secret.exists()
    assert not made.exists()


ENDLESS = {
    "time": "${9**9**9}",
    "memory": "${len('ab' * 3 * 10**9)}",
    "list": "${len([0] * 10**9)}",
}


@pytest.mark.parametrize("name", ENDLESS)
def test_time_and_memory_are_limited(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch):
    """After some seconds, or when it takes more memory than it may have, with one message."""
    monkeypatch.setattr(shockpc.robot.xacro, "SECONDS", 1.0)
    begin = time.monotonic()
    message = refusal(folder, xacro(link("base", mass=ENDLESS[name])), NAME)
    assert message.startswith("dog.urdf.xacro: xacro ")
    assert "grows without end" in message
    assert time.monotonic() - begin < 5.0


def test_links_are_limited(folder: Path):
    """A macro that doubles itself would give millions."""
    macros = "".join(
        f'<xacro:macro name="m{k}" params="n"><xacro:m{k - 1} n="${{n}}a"/><xacro:m{k - 1} n="${{n}}b"/></xacro:macro>'
        for k in range(1, 12)
    )
    text = xacro('<xacro:macro name="m0" params="n"><link name="${n}"/></xacro:macro>', macros, '<xacro:m11 n="l"/>')
    assert refusal(folder, text, NAME) == "dog.urdf.xacro: xacro cannot expand it: it has 2048 links, more than 2000"


def test_a_child_that_crashes_is_an_error(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Whatever ends it: there is no result, and one message says so."""
    child = tmp_path / "child.py"
    child.write_text("import os\nos.abort()\n")
    monkeypatch.setattr(shockpc.robot.xacro, "_CHILD", child)
    assert refusal(folder, PAYLOAD, NAME).startswith("dog.urdf.xacro: xacro gave no result")


def test_included_pipes_are_refused(folder: Path):
    """A pipe as include, YAML file or package.xml is refused and not waited for."""
    os.mkfifo(folder / "pipe")
    for text in (xacro('<xacro:include filename="pipe"/>'), xacro(link("base", mass="${xacro.load_yaml('pipe')}"))):
        assert refusal(folder, text, NAME) == f'"{folder}/pipe" is a pipe or a device; save what it gives in a file'
