"""What shells complete, and that no name in a robot file makes a shell run it."""

import os
import pty
import re
import select
import shlex
import shutil
import subprocess
import sys

import pytest

from shockpc.cli.app import SHELL_NAMED
from shockpc.cli.completion import ASKED
from shockpc.cli.entry import main


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_completes(shell, here, capfd, monkeypatch):
    """Commands, robots, options, contacts and joints of the robot that is typed, and quantities, as
    each shell asks for them.
    """
    (here / "stick.toml").write_text('robot = "stick.urdf"\ncontact = "foot"\n')
    expected = {
        "sens": ["sensitivity"],
        "analyze anymal_c": ["anymal_c"],
        "analyze --contact-st": ["--contact-stiffness"],
        "analyze stick.urdf --contact f": ["foot"],
        "analyze stick.urdf --contact foot+f": ["foot+foot"],
        "analyze stick.urdf --set knee=0.1 --contact=f": ["foot"],
        "limits stick.toml --joint k": ["knee"],
        "limits stick.toml --quantity peak_joint_f": ["peak_joint_force"],
        "recorded log.csv stick.urdf --contact f": ["foot"],
        "analyze nosuch --contact f": [],
    }
    monkeypatch.setenv(ASKED, f"complete_{shell}")
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("_TYPER_COMPLETE_FISH_ACTION", "get-args")
    for typed, completions in expected.items():
        words = f"shockpc {typed}".replace("=", "\n=\n") if shell == "bash" else f"shockpc {typed}"
        monkeypatch.setenv("COMP_WORDS" if shell == "bash" else "_TYPER_COMPLETE_ARGS", words)
        monkeypatch.setenv("COMP_CWORD", str(len(words.split()) - 1))
        assert main([]) == 0
        out, err = capfd.readouterr()
        named = {"bash": "^(.+)$", "fish": "^([^\t\n]+)", "zsh": r'^(?:_arg.*?\(\()?"([^"]+)"'}[
            shell
        ]
        assert (re.findall(named, out, re.MULTILINE), err) == (completions, ""), typed


HOSTILE_NAMES = (
    "hostile;touch RUN",
    r"hostile\$(touch RUN)",
    "hostile`touch RUN`",
    "hostile$(touch RUN)",
)


def hostile_robot(name: str) -> str:
    """A URDF with a foot, a second link of this name, and a joint that moves it."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
        'iyz="0"/></inertial>'
    )
    links = "".join(f'<link name="{link}">{inertial}</link>' for link in ("base", "footpad", name))
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="base"/><child link="{link}"/><axis '
        f'xyz="0 1 0"/></joint>'
        for k, link in enumerate(("footpad", name))
    )
    return f'<robot name="r">{links}{joints}</robot>'


def typed_in_a_shell(arguments, lines, folder):
    """What an interactive shell prints when lines are typed one after another, each when the output
    rests.
    """
    terminal, inside = pty.openpty()
    environment = {
        "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
        "HOME": str(folder),
        "TERM": "dumb",
        "PS1": "% ",
    }
    # A shell that reads keys needs a terminal that controls its session.
    command = ["setsid", "--ctty", *arguments]
    shell = subprocess.Popen(
        command, stdin=inside, stdout=inside, stderr=inside, cwd=folder, env=environment
    )
    os.close(inside)
    printed = b""
    with shell:
        for line in ("", *lines):
            os.write(terminal, line.encode())
            wait = 10.0
            while select.select([terminal], [], [], wait)[0]:
                printed += os.read(terminal, 65536)
                wait = 2.0
        shell.kill()
    os.close(terminal)
    return printed.decode(errors="replace")


@pytest.mark.parametrize("name", HOSTILE_NAMES)
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_names_of_a_file_that_a_shell_would_run_are_not_completed(
    shell, name, here, capfd, monkeypatch
):
    (here / "hostile.urdf").write_text(hostile_robot(name))
    monkeypatch.setenv(ASKED, f"complete_{shell}")
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("_TYPER_COMPLETE_FISH_ACTION", "get-args")
    words = "shockpc analyze hostile.urdf --contact "
    monkeypatch.setenv("COMP_WORDS" if shell == "bash" else "_TYPER_COMPLETE_ARGS", words)
    monkeypatch.setenv("COMP_CWORD", "4")
    assert main([]) == 0
    out = capfd.readouterr().out
    assert "footpad" in out
    assert "touch" not in out


def test_completion_reads_no_large_robot_and_expands_no_xacro(here, capfd, monkeypatch):
    robot = hostile_robot("other")
    (here / "large.urdf").write_text(robot + " " * 1_000_000)
    (here / "macro.xacro").write_text(robot)
    (here / "marked.urdf").write_text(robot.replace("<link", '<xacro:if value="1"/><link', 1))
    (here / "scene.toml").write_text('robot = "macro.xacro"\n')
    monkeypatch.setenv(ASKED, "complete_bash")
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("COMP_CWORD", "4")
    for word in ("large.urdf", "macro.xacro", "marked.urdf", "scene.toml"):
        monkeypatch.setenv("COMP_WORDS", f"shockpc analyze {word} --contact f")
        assert main([]) == 0
        assert capfd.readouterr() == ("\n", ""), word


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_no_shell_runs_a_name_of_a_robot_file(shell, tmp_path):
    """TAB inserts the name that is plain, and neither TAB nor Enter runs what another name holds."""
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    start = {
        "bash": (["bash", "--norc", "-i"], "source ./script\n"),
        "zsh": (
            ["zsh", "-f", "-i"],
            "autoload -Uz compinit; compinit -u -D; source ./script; compdef _shockpc_completion "
            "shockpc\n",
        ),
        "fish": (["fish", "--no-config", "-i"], "source ./script\n"),
    }[shell]
    asked = {**os.environ, ASKED: f"source_{shell}"}
    command = [sys.executable, "-m", "shockpc"]
    script = subprocess.run(command, env=asked, capture_output=True, text=True, check=True).stdout
    (tmp_path / "script").write_text(script)
    (tmp_path / "bin").mkdir()
    wrapper = tmp_path / "bin" / "shockpc"
    path = os.pathsep.join(sys.path)
    wrapper.write_text(
        f'#!/bin/sh\nPYTHONPATH={shlex.quote(path)} exec {shlex.join(command)} "$@"\n'
    )
    wrapper.chmod(0o755)
    for k, name in enumerate(HOSTILE_NAMES[:2]):
        (tmp_path / f"hostile{k}.urdf").write_text(hostile_robot(name))
    lines = [start[1]]
    for k in range(2):
        lines += [
            f"shockpc analyze hostile{k}.urdf --contact {begin}\t\n" for begin in ("footp", "hos")
        ]
    printed = typed_in_a_shell(start[0], lines, tmp_path)
    assert "footpad" in printed
    assert not (tmp_path / "RUN").exists()


def test_completion_is_shown_and_installed(tmp_path):
    for option, file in (
        ("--show-completion", None),
        ("--install-completion", ".bash_completions/shockpc.sh"),
    ):
        words = [sys.executable, "-m", "shockpc", option, "bash"]
        shell = {**os.environ, "HOME": str(tmp_path)}
        done = subprocess.run(words, capture_output=True, text=True, check=True, env=shell)
        script = done.stdout if file is None else (tmp_path / file).read_text()
        assert f"{ASKED}=complete_bash" in script


@pytest.mark.parametrize(
    ("shell", "script"), [("zsh", "#compdef shockpc"), ("fish", "complete --command shockpc")]
)
def test_completion_is_that_of_the_named_shell(capfd, monkeypatch, shell, script):
    monkeypatch.setenv(SHELL_NAMED, "")
    assert main(["--show-completion", shell]) == 0
    assert capfd.readouterr().out.startswith(script)


def test_an_unknown_shell_is_refused(capfd, monkeypatch):
    monkeypatch.setenv(SHELL_NAMED, "")
    assert main(["--show-completion", "tcsh"]) == 2
    assert "'tcsh' is not one of 'bash', 'zsh', 'fish'" in capfd.readouterr().err
