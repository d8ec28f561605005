"""Code of landings: compiled and run, against proven landings; what it says of itself; and that
wrong code is not written.
"""

import errno
import html
import json
import shutil
import subprocess

import numpy as np
import pytest
from commands import run
from robot_texts import LIMIT, joint, link, urdf
from trees import robot_from

from shockpc import Contact, Scene, StudyError, export, symbolic
from shockpc.wings.symbols.export import code
from shockpc.wings.symbols.export.report import export_report

LEG = urdf(
    link("trunk", "3"),
    link("thigh"),
    link("shank"),
    joint(
        "hip */ evil",
        "trunk",
        "thigh",
        more='<origin xyz="0.1 0 -0.1" rpy="0.2 0 0"/><limit lower="-1" upper="1"/>',
    ),
    joint("knee", "thigh", "shank", "continuous", "0 0.6 0.8", '<origin xyz="0 0.02 -0.3"/>'),
)


@pytest.fixture(scope="module")
def leg():
    robot = robot_from(LEG)
    return Scene(
        robot=robot.label, contact=(Contact(frame="shank", offset=(0.05, 0.0, -0.3)),)
    ), robot


RUN = {"c": ("cc", "make"), "js": ("node",)}


@pytest.mark.slow
@pytest.mark.parametrize("before", ["strike", "velocity"])
@pytest.mark.parametrize("lang", ["c", "js", "casadi"])
def test_code_is_that_of_proven_landings(leg, lang, before):
    scene, robot = leg
    found = export(
        scene,
        ["shock_com@trunk", "copc@thigh", "joint_moment", "impulse"],
        robot=robot,
        lang=lang,
        before=before,
        sample=5,
    )
    assert found.error < 1e-11
    if all(map(shutil.which, RUN.get(lang, ()))):
        assert found.tested < 1e-11
    if lang == "c":
        assert "* /" in found.files["landing.c"]
        assert "hip */" not in found.files["landing.c"]
        assert "LANDING_COPC_THIGH_Z" in found.files["landing.h"]
    names = [name for name, _, _ in found.outputs]
    assert names[-2:] == ["condition", "pivot"]
    assert len(names) == len(set(names)) == len(found.symbols.program.outputs)


@pytest.mark.parametrize("size", [7, 300])
def test_pieces_compile_without_warnings_and_compute_the_same(leg, tmp_path, size):
    if not shutil.which("cc"):
        return
    scene, robot = leg
    program = export(
        scene, ["shock_com@trunk"], robot=robot, lang="casadi", sample=1
    ).symbols.program
    inputs = {"q": robot.model.nq, "strike": 3}
    bodies, slots = code.pieces(program, inputs, code.C, "const double", size)
    assert len(bodies) == -(-len(program.operation) // size)
    functions = "".join(
        f"static void p{k}(const double *q, const double *strike) {{ (void)q; "
        f"(void)strike;\n{b}\n}}\n"
        for k, b in enumerate(bodies)
    )
    x = np.concatenate([robot.start, (0.3, 0.1, -1.0)])
    given = ", ".join(map(repr, x.tolist()))
    calls = "".join(f"p{k}(x, x + {robot.model.nq});\n" for k in range(len(bodies)))
    source = f"""#include <math.h>\n#include <stdio.h>\nstatic double w[{slots + 1}], out[3];\n{functions}
int main(void) {{ const double x[] = {{{given}}};\n{calls}printf("%.17g %.17g %.17g\\n", out[0], out[1], out[2]); return 0; }}"""
    (tmp_path / "t.c").write_text(source)
    subprocess.run(
        ["cc", "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-o", "t", "t.c", "-lm"],
        cwd=tmp_path,
        check=True,
    )
    printed = subprocess.run([tmp_path / "t"], capture_output=True, text=True, check=True).stdout
    np.testing.assert_allclose(
        [float(word) for word in printed.split()], program(x[None])[0], rtol=1e-13
    )


def test_names_that_are_the_same_in_code_are_refused():
    same = urdf(
        *map(link, ("a-b", "a_b", "A_B")),
        joint("j", "a-b", "a_b", more=LIMIT),
        joint("k", "a-b", "A_B", more=LIMIT),
    )
    robot = robot_from(same)
    scene = Scene(robot=robot.label, contact=(Contact(frame="A_B", offset=(0.1, 0.0, -0.3)),))
    for other in ("a_b", "A_B"):
        with pytest.raises(StudyError, match=f"shock@a-b and shock@{other}"):
            export(scene, ["shock@a-b", f"shock@{other}"], robot=robot, lang="js", sample=1)
    with pytest.raises(StudyError, match="shock@a-b and shock@a_b"):
        symbolic(scene, ["shock@a-b", "shock@a_b"], robot=robot).casadi()


def test_names_are_data_in_code(tmp_path, monkeypatch):
    """A name ends no comment and no script of a page, and each letter of it is one that C takes."""
    monkeypatch.setenv("FORCE_COLOR", "1")  # in which node colours numbers
    ending = "</script><script>document.title=1</script><!--*/"
    name = html.escape(ending)
    robot = robot_from(
        urdf(link("trunk"), link("²x"), joint("j", "trunk", "²x", more=LIMIT), name=name)
    )
    scene = Scene(robot=robot.label, contact=(Contact(frame="²x", offset=(0.1, 0.0, -0.3)),))
    for lang, file in (("js", "landing.mjs"), ("c", "landing.h")):
        found = export(scene, ["shock@²x"], robot=robot, lang=lang, sample=1)
        assert found.outputs[0][0] == "shock_u00b2x"
        text = found.files[file]
        comment, _, rest = text.partition("*/")
        assert "< /script>" in comment
        assert "document.title" not in rest
        assert not any(end in text for end in ("</", "<!--"))
        if all(map(shutil.which, RUN[lang])):
            assert found.tested < 1e-11


def test_without_room_for_temporary_files_a_command_says_so(capfd, monkeypatch, tmp_path):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tempfile.TemporaryDirectory", full)
    scene = ("solo8", "--contact", "FL_FOOT", "--contact-point", "frame")
    words = ("export", *scene, "--quantity", "shock_com@base_link", "--lang", "js", "--sample", "1")
    code, out, err = run(capfd, *words, "--out", tmp_path / "code")
    assert (code, out) == (2, "")
    assert err.endswith("No space left on device; free space, or set TMPDIR\n")


@pytest.mark.parametrize("wrong", [1e-8, float("nan")])
def test_wrong_code_is_not_written(leg, monkeypatch, wrong):
    scene, robot = leg
    monkeypatch.setattr("shockpc.wings.symbols.export.study._tested", lambda lang, files: wrong)
    with pytest.raises(StudyError, match="is off by"):
        export(scene, ["shock_com@trunk"], robot=robot, lang="js", sample=2)
    monkeypatch.undo()
    monkeypatch.setitem(code.JAVASCRIPT, "add", "{}-{}")
    if shutil.which("node"):
        with pytest.raises(StudyError, match="is off by"):
            export(scene, ["shock_com@trunk"], robot=robot, lang="js", sample=2)


@pytest.mark.slow
def test_the_command_writes_code_of_a_sole(capfd, tmp_path):
    """With the point that the refusal of its lowest one names."""
    foot = ("--contact", "left_ankle_roll_link")
    code, _, err = run(capfd, "export", "g1", *foot)
    assert code == 2
    hint = err.split("--offset ")[1].split()
    assert hint[1:3] == ["--contact-kind", "flat"]
    sole = (*foot, "--offset", hint[0], *hint[1:3])
    out = tmp_path / "code"
    asked = ("--quantity", "shock_com@pelvis", "--lang", "js", "--sample", "2", "--out", str(out))
    code, printed, err = run(capfd, "export", "g1", *sole, *asked)
    assert (code, "maximum error" in printed) == (0, True), err
    assert {"landing.mjs", "landing_test.mjs", "landing.toml"} <= {
        file.name for file in out.iterdir()
    }
    if shutil.which("node"):
        assert (
            float(
                subprocess.run(
                    ["node", "landing_test.mjs"], cwd=out, capture_output=True, check=True
                ).stdout
            )
            < 1e-11
        )


def test_report_has_inputs_outputs_and_the_scene(leg, tmp_path):
    scene, robot = leg
    found = export(scene, ["copc@thigh"], robot=robot, lang="c", before="velocity", sample=2)
    report = export_report(found)
    files = report.files(tmp_path)
    assert {
        "landing.c",
        "landing.h",
        "landing_test.c",
        "Makefile",
        "landing.toml",
        "export.json",
        "outputs.csv",
    } <= files.keys()
    document = json.loads(files["export.json"])
    assert document["tables"]["inputs"][-1]["joint"] == "knee sine"
    assert [row["output"] for row in document["tables"]["outputs"]][:3] == [
        "copc_thigh_x",
        "copc_thigh_y",
        "copc_thigh_z",
    ]
    assert document["before"] == "velocity"
