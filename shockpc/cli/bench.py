"""`shockpc bench`: how far to trust a number, measured."""

import enum
import gc
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

__all__ = ["Suite", "bench"]


class Suite(enum.StrEnum):
    """How much is measured."""

    QUICK = "quick"
    FULL = "full"


THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def bench(
    scene: Annotated[Path | None, typer.Argument(help="A scene (TOML) to simulate with --compliant.")] = None,
    suite: Annotated[
        Suite | None, typer.Option(help="Quick takes about two minutes, full half an hour. [default: quick]", show_default=False)
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder of the report [out/bench], or of a soak's counts [not kept]; what was interrupted goes on from there.",
        ),
    ] = None,
    compliant: Annotated[
        bool, typer.Option("--compliant", help="Land the scene on softer and harder ground, and compare.")
    ] = False,
    soak: Annotated[int | None, typer.Option(metavar="N", min=1, help="Try the error estimate on N random trees instead.")] = None,
    seed: Annotated[int | None, typer.Option(metavar="S", min=0, help="Number of the first random tree. [0]")] = None,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Processes for the random trees. [one for each core]")
    ] = None,
) -> None:
    """Measure error and run time on hard cases, against exact answers."""
    # Set before numpy is loaded: a clock that counts other threads' work measures nothing.
    for name in THREADS:
        os.environ[name] = "1"
    gc.enable()  # a long run makes garbage that a short command need not mind
    from shockpc.errors import SceneError
    from shockpc.show.files import check_folder

    if compliant != (scene is not None):
        raise SceneError(
            "--compliant needs a scene file, and a scene file needs --compliant: shockpc bench landing.toml --compliant"
        )
    if out is not None:
        check_folder(out, "--out")
    _refuse_unheeded(compliant, {"--suite": suite, "--soak": soak, "--seed": seed, "--workers": workers})
    if scene is not None:
        _compliant(scene, out)
        return
    _require("mpmath")
    if soak is not None:
        _soak(seed or 0, soak, workers or os.cpu_count() or 1, out)
    else:
        _suite((suite or Suite.QUICK).value, out or Path("out/bench"))


def _refuse_unheeded(compliant: bool, options: dict[str, object]) -> None:
    """Refuse options that were given and would do nothing."""
    from shockpc.errors import SceneError

    given = [name for name, value in options.items() if value is not None]
    work, heeded, way_out = "the suite measures hard cases", ["--suite"], ", or add --soak N"
    if compliant:
        work, heeded, way_out = "--compliant lands one scene", [], ""
    elif "--soak" in given:
        work, heeded, way_out = "--soak tries random trees", ["--soak", "--seed", "--workers"], ""
    if idle := " and ".join(name for name in given if name not in heeded):
        raise SceneError(f"{work} and does not heed {idle}; leave {idle} out{way_out}")


def _require(package: str) -> None:
    """Refuse in words where the bench's own packages are not installed."""
    from importlib.util import find_spec

    from shockpc.errors import ShockError

    if find_spec(package) is None:
        raise ShockError(
            f'the bench needs the package {package}, which is not installed; install it with: pip install "shockpc[bench]"'
        )


def _suite(suite: str, out: Path) -> None:
    """Measure, write the report, and say what came out."""
    from shockpc.bench.run import plan_of, run_bench
    from shockpc.bench.tables import outcomes, promise, throughput
    from shockpc.show.tables.text import as_text

    found = run_bench(plan_of(suite), out, f"shockpc bench --suite {suite}")
    for sheet in (promise(found.cases), outcomes(found.cases), throughput(found.peers)):
        sys.stdout.write(as_text(sheet) + "\n")
    sys.stdout.write(f"the report: {out / 'report.md'}\n")


def _compliant(path: Path, out: Path | None) -> None:
    """Land one's own scene on grounds from soft to hard."""
    from shockpc.bench.compliant import compliant, compliant_sheet
    from shockpc.robot.robot import load_robot
    from shockpc.scene import read_scene
    from shockpc.show.files import make_folder, write_text
    from shockpc.show.tables.text import as_csv, as_markdown, as_text

    scene = read_scene(path)
    robot = load_robot(scene.robot, xacro=scene.xacro, packages=scene.packages, srdf=scene.srdf)
    sheet = compliant_sheet(compliant(scene, robot))
    if out is not None:
        make_folder(out)
        write_text(out / "compliant.csv", as_csv(sheet))
        write_text(out / "compliant.md", as_markdown(sheet))
    sys.stdout.write(as_text(sheet))


def _soak(first: int, count: int, workers: int, out: Path | None) -> None:
    """Random trees; ends with 1 if a promise was broken."""
    from shockpc.bench.soak import Tally, soak, tally_text
    from shockpc.bench.store import Store, fingerprint

    tally = Tally()
    for block in soak(first, count, workers, None if out is None else Store(out, fingerprint("soak"))):
        tally += block
        if sys.stderr.isatty():
            sys.stderr.write(f"\r\x1b[K{tally.trees} of {count} trees, {tally.violations} violations")
            sys.stderr.flush()
    if sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K")
    sys.stdout.write(tally_text(tally))
    if tally.violations:
        raise typer.Exit(1)
