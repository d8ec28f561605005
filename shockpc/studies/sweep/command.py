"""`shockpc sweep`: landings that differ in posture, strike, contact, inertia or joint model."""

from typing import Any, Literal

from shockpc.cli.computed_rows import computed
from shockpc.cli.declared import command
from shockpc.cli.options import ROBOT, OutputOptions, RunOptions, SceneOptions, in_run
from shockpc.cli.output import emit, exit_code
from shockpc.cli.scenes import scenes_from, with_contact
from shockpc.cli.study_command import help_of, study_arguments, study_options
from shockpc.cli.unused_options import refuse_unasked, refuse_varied
from shockpc.evaluation.variations.kinds.registry import kind_and_target
from shockpc.evaluation.variations.variation import Variation
from shockpc.landing.contact import contact_name
from shockpc.studies.sweep.report import sweep_report
from shockpc.studies.sweep.study import sweep as study
from shockpc.studies.sweep.summary import summarise
from shockpc.text.errors import StudyError


@command(**help_of(study))
def sweep(
    *,
    robot: str = ROBOT,
    typed: Any = study_options(study),
    options: SceneOptions,
    rows: Literal["parquet", "csv"] | None = in_run(
        "Format of the rows that --out writes. [default: parquet]"
    ),
    run: RunOptions,
    output: OutputOptions,
) -> int:
    contacts = []
    for subject, values in typed["vary"]:
        kind, _ = kind_and_target(subject)
        if kind.names_contacts and values is not None:
            contacts.append(values)
    # The rows have other contacts, as --contact names them; a scene without any needs one until
    # they are set.
    completed = with_contact(robot, options, contacts[0].split(","))[0] if contacts else options
    loaded, scenes = scenes_from(robot, completed)
    if len(scenes) > 1 and not contacts:
        names = [contact_name(scene) for scene in scenes]
        raise StudyError(
            f"a sweep varies one landing, but there are {len(scenes)}; name one, such as --contact "
            f"{names[0]}, or compare them "
            f"with --vary contact={','.join(names)}"
        )
    refuse_unasked(study, options, typed)
    arguments = study_arguments(study, typed, loaded)
    evaluation = study(scenes[0], robot=loaded, at=scenes[0].point, **arguments)
    landings = evaluation.landings
    refuse_varied(options, loaded, landings.variations)
    if rows is None and output.out is not None:
        rows = "parquet"
    # Of a sample, the numbers with which quantities are correlated; of a small grid, its values.
    correlated: list[Variation] = []
    if landings.sample is not None:
        correlated = [varied for varied in landings.variations if not varied.kind.names_contacts]
    is_drawn = landings.sample is None and len(landings.variations) <= 2
    with computed(evaluation, "rows", output.out, rows, run) as table:
        summary = summarise(evaluation, table, correlated, keep=is_drawn)
        emit(sweep_report(summary), output)
    return exit_code(summary.failed, summary.rows, run.strict, table.defects)
