"""Python in xacro files: it computes, and reaches nothing."""

from pathlib import Path

import pytest
from robot_texts import link, xacro

from shockpc.errors import RobotError
from shockpc.robot.source import read_source


def refusal(folder: Path, text: str) -> str:
    """The text of the error that reading it raises."""
    (folder / "dog.urdf.xacro").write_text(text)
    with pytest.raises(RobotError) as caught:
        read_source(str(folder / "dog.urdf.xacro"))
    return str(caught.value)


ATTACKS = {
    "${[x.__class__ for x in [1]]}": "__class__",
    "${(lambda: (1).__class__)()}": "__class__",
    "${(x for x in [1]).gi_frame}": "gi_frame",
    "${str.mro()}": "mro",
    "${'__class__'}": "__class__",
    "${__import__('os')}": "__import__",
    "$(eval open)": "open",
    "$(eval [e for e in [exec]])": "exec",
    "$(eval str.mro)": "mro",
}


@pytest.mark.parametrize("expression", ATTACKS)
def test_expressions_reach_nothing(expression: str, tmp_path: Path):
    """Python in a xacro file may compute; it may not open, import or look into the interpreter."""
    assert refusal(tmp_path, xacro(f'<link name="{expression}"/>')) == (
        f'dog.urdf.xacro: the xacro expression {expression} uses "{ATTACKS[expression]}", which could reach files or programs; '
        "it is not evaluated"
    )


@pytest.mark.parametrize("name", ["type", "vars", "getattr", "open", "eval", "globals"])
def test_namespace_holds_no_way_in(name: str, tmp_path: Path):
    """The namespace that xacro offers to its expressions lacks what would lead from a value to the whole process."""
    assert f"name '{name}' is not defined" in refusal(tmp_path, xacro(f'<link name="${{python.{name}(1)}}"/>'))


POWERS = ("9**65", "9**-65", "9**64.5", "9**9**9", "2**(3 + 4)", "2**len([1, 2])", "2**'3'")


@pytest.mark.parametrize(
    "expression", [*(f"${{{power}}}" for power in POWERS), *(f"$(eval {power})" for power in POWERS if ")" not in power)]
)
def test_powers_that_might_never_end_are_not_raised(expression: str, tmp_path: Path):
    """A number of a million digits takes as long as a robot file may not."""
    assert refusal(tmp_path, xacro(f'<link name="{expression}"/>')) == (
        f"dog.urdf.xacro: the xacro expression {expression} raises to a power that is not a plain number up to 64; "
        "it might never end, so it is not evaluated"
    )


REPEATED = ("'ab' * 3", "3 * 'ab'", "len('ab' * 1000000000)", "[1] * 3", "len((1, 2) * 3)", "2 * 'a' * 2")


@pytest.mark.parametrize(
    "expression", [*(f"${{{text}}}" for text in REPEATED), *(f"$(eval {text})" for text in REPEATED if ")" not in text)]
)
def test_texts_are_not_repeated(expression: str, tmp_path: Path):
    """A short line could fill the memory."""
    assert refusal(tmp_path, xacro(f'<link name="{expression}"/>')) == (
        f"dog.urdf.xacro: the xacro expression {expression} repeats a text, which might fill the memory; write it out"
    )


def test_harmless_expressions_still_compute(tmp_path: Path):
    """Arithmetic, comprehensions, text and arguments work, in both ways to write them."""
    numbers = {
        "$(eval 2 * payload)": "3.0",
        "${sum([x**2 for x in [1, 2]]) if False else 2 * len('ab')}": "4",
        "${python.sum([x**2 for x in [1, 2]])}": "5",
        "${radians(180) / pi}": "1.0",
        "${int(dict(a=7)['a'])}": "7",
        "${2**64}": "18446744073709551616",
        "${2**-2}": "0.25",
        "${4**+0.5}": "2.0",
        "${2**n}": "8",
        "${2**-n}": "0.125",
        "$(eval 2**3)": "8",
    }
    for expression, value in numbers.items():
        text = xacro('<xacro:arg name="payload" default="1.5"/><xacro:property name="n" value="3"/>', link("base", mass=expression))
        (tmp_path / "dog.urdf.xacro").write_text(text)
        assert f'<mass value="{value}"/>' in read_source(str(tmp_path / "dog.urdf.xacro")).xml


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("2**big", "raises to a power that is not a plain number up to 64; it might never end, so it is not evaluated"),
        ("len(big*s)", 'multiplies by "ab", which is no number; correct the argument or property that holds it'),
        ("len([s for _ in [1]] * n)", "repeats a text, which might fill the memory; write it out"),
    ],
)
def test_properties_hide_neither_powers_nor_repeated_texts(tmp_path: Path, written: str, told: str):
    """What a property holds is looked at when the expression is evaluated; ordinary sums, products and powers are as ever."""
    text = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
      <xacro:property name="big" value="100000"/><xacro:property name="s" value="ab"/><xacro:property name="n" value="3"/>
      <link name="base"><inertial><mass value="${%s}"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
    path = tmp_path / "r.urdf.xacro"
    path.write_text(text % "2*n**2 + 0.5*n")
    assert '<mass value="19.5"/>' in read_source(str(path)).xml
    path.write_text(text % written)
    with pytest.raises(RobotError) as caught:
        read_source(str(path))
    assert str(caught.value) == f"r.urdf.xacro: the xacro expression ${{{written}}} {told}"
