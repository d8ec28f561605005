"""`shockpc quantities`: the numbers that a landing has, by the names that every command takes."""

from shockpc.cli.declared import argument, command
from shockpc.cli.options import OutputOptions


@command(
    examples=(
        "shockpc quantities",
        'shockpc quantities "joint*"',
    ),
    more=(
        "KEY names a quantity in JSON, budgets, sweeps and comparisons; write KIND.KEY if several "
        "kinds of place have it. KEY of a vector is its length; its components are KEY.x, KEY.y "
        "and KEY.z."
    ),
)
def quantities(
    *,
    pattern: str | None = argument(
        "Only quantities of this key or kind, or glob of keys or kinds.", "[PATTERN]"
    ),
    output: OutputOptions,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.studies.quantities.report import quantities_report

    emit(quantities_report(pattern), output)
