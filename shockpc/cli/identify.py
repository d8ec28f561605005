"""`shockpc identify`: what measured landings say about drives, friction, restitution, stiffness and masses."""

from pathlib import Path

from shockpc.cli.declare import argument, command, group
from shockpc.cli.options import ROBOT, OutputOptions, SceneOptions
from shockpc.cli.parse import Setting, Variable, finite, path, renaming, setting, variable

_in_question, _in_table, _in_search = group("Question"), group("Table"), group("How it is found")


@command(
    "Find drives, friction, restitution and masses from measured landings.",
    "shockpc identify drops.csv leg.toml --unknown 'rotor:*knee=1e-6:1e-3:log' --out leg/",
    "shockpc identify tosses.csv blocks.urdf --unknown friction=0:1.5 --unknown restitution=0:1",
    more=(
        "The table is one as shockpc landings takes, with velocities after the impact in columns after_…. Unknowns are found where "
        "predicted and measured jumps differ least, with 95 % intervals; what the data do not tell is said. --out has drives.toml "
        "for --drives, and scene.toml with all values, which every command takes."
    ),
)
def identify(
    *,
    table: Path = argument("A table of landings: .csv, .parquet or .npz.", "TABLE", path, default=...),
    robot: str = ROBOT,
    unknown: tuple[Variable, ...] = _in_question(
        "What is unknown, and its range, of which :log searches the logarithm: friction, restitution, contact-stiffness [N/m], "
        "contact-damping [N s/m], armature:JOINTS [kg m²], rotor:JOINTS (inertia of the rotor itself) [kg m²], "
        "joint-stiffness:JOINTS [N m/rad], mass:LINKS, com-x:LINKS, inertia:LINKS, or scale:before, a factor on the velocities "
        "before the impact.",
        "NAME=LOW:HIGH[:log]",
        variable,
    ),
    map_: tuple[tuple[str, str], ...] = _in_table(
        "Another name for a column or joint, as for shockpc landings; nothing after the = leaves it out.", "NAME=[NAME]", renaming
    ),
    after: float | None = _in_table("Which of several measured times counts; by default the first [ms].", "MS", finite),
    noise: tuple[Setting, ...] = _in_search(
        "Standard deviation of measured velocities by name or glob [m/s, rad/s], in place of weights by energy.",
        "NAME=SIGMA",
        setting,
    ),
    draws: int = _in_search("Draws of the bootstrap; 1000 by default.", "N", default=1000, least=100),
    folds: int = _in_search("Parts in which landings are left out; 5 by default.", "N", default=5, least=2),
    options: SceneOptions,
    output: OutputOptions,
) -> None:
    import datetime

    from shockpc.cli.output import emit
    from shockpc.cli.scenes import one_scene, with_contact
    from shockpc.evaluation.table_files import read_table
    from shockpc.show.reports.identify import identify_report
    from shockpc.studies.identify import identify as study
    from shockpc.text.errors import StudyError

    columns = read_table(table)
    if "contact" in columns:
        options = with_contact(robot, options, columns["contact"].astype(str).ravel().tolist())
    loaded, scene = one_scene(robot, options)
    if lacking := [name for name, values in unknown if values is None]:
        raise StudyError(f"{lacking[0]} has no range; give one, such as {lacking[0]}=0:1")
    ranges = [(name, values or "") for name, values in unknown]
    found = study(
        columns, scene, ranges, robot=loaded, rename=dict(map_), after=after, noise=dict(noise), draws=draws, folds=folds
    )  # fmt: skip
    day = datetime.date.today().isoformat()
    emit(identify_report(found, table.name, day, output.out or Path.cwd()), output)
