"""xacro's state: each call has its own, and leaves nothing behind."""

import os
import threading
from pathlib import Path

import pytest
from robot_texts import link, xacro

from shockpc.errors import RobotError
from shockpc.robot.source import RobotSource, read_source

PAYLOAD = xacro('<xacro:arg name="payload" default="1.5"/>', link("base", mass="$(arg payload)"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder for the robot."""
    (tmp_path / "dog").mkdir()
    return tmp_path / "dog"


def read(folder: Path, text: str, **given: object) -> RobotSource:
    """Read a xacro file with this text."""
    (folder / "dog.urdf.xacro").write_text(text)
    return read_source(str(folder / "dog.urdf.xacro"), **given)  # type: ignore[arg-type]


def refusal(folder: Path, text: str, **given: object) -> str:
    """The text of the error that reading it raises."""
    with pytest.raises(RobotError) as caught:
        read(folder, text, **given)
    return str(caught.value)


def test_xacros_globals_are_put_back(folder: Path):
    """A call leaves xacro as it found it, whether it succeeds or fails."""
    import xacro as module
    from xacro import substitution_args

    def state() -> tuple[object, ...]:
        return (
            "open" in vars(module),
            module.safe_eval,
            module.filestack,
            module.macrostack,
            substitution_args._eval_find,
            substitution_args._eval,
            substitution_args._eval_dict["find"],
            sorted(module._global_symbols["python"]),
            dict(module.substitution_args_context),
        )

    read(folder, PAYLOAD)  # imports xacrodoc, which patches xacro once and for all
    before = state()
    read(folder, PAYLOAD, xacro={"payload": "7"})
    assert state() == before
    refusal(folder, xacro('<xacro:include filename="none.xacro"/>'))
    assert state() == before
    assert '<mass value="1.5"/>' in read(folder, PAYLOAD).xml


def test_package_cache_is_not_shared(folder: Path, tmp_path: Path):
    """A package of one call is unknown to the next."""
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "a.xacro").write_text(xacro(link("base")))
    text = xacro('<xacro:include filename="$(find other)/a.xacro"/>')
    assert '<link name="base">' in read(folder, text, packages={"other": tmp_path / "other"}).xml
    assert 'no package "other"' in refusal(folder, text)


def test_threads_do_not_mix(folder: Path):
    """Two robots expanded at once keep their own arguments."""
    path = folder / "dog.urdf.xacro"
    path.write_text(PAYLOAD)
    found: dict[str, bool] = {}

    def expand(payload: str) -> None:
        found[payload] = all(
            f'<mass value="{payload}"/>' in read_source(str(path), xacro={"payload": payload}).xml for _ in range(20)
        )

    threads = [threading.Thread(target=expand, args=(str(k),)) for k in range(1, 5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == dict.fromkeys(("1", "2", "3", "4"), True)


def test_dirname_is_the_files_own(folder: Path):
    """$(dirname) is the folder of the file that says it."""
    (folder / "numbers.yaml").write_text("mass: 3\n")
    text = xacro(link("base", mass="${xacro.load_yaml('$(dirname)/numbers.yaml')['mass']}"))
    assert '<mass value="3"/>' in read(folder, text).xml
    assert os.fspath(folder) not in read(folder, text).xml
