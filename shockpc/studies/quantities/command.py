"""`shockpc quantities`: the numbers that a landing has, by the names that every command takes."""

from shockpc.cli.declared import argument, command
from shockpc.cli.options import OutputOptions


@command(
    examples=(
        "shockpc quantities",
        'shockpc quantities "joint*"',
    ),
    more=(
        "KEY names a quantity in JSON, budgets, sweeps and comparisons; KIND.KEY where several "
        "kinds of place have it. A vector "
        "stands for its length; its components are KEY.x, KEY.y and KEY.z."
    ),
)
def quantities(
    *,
    pattern: str | None = argument(
        "Only those of this key or kind, or whose key or kind matches this glob.", "[PATTERN]"
    ),
    output: OutputOptions,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.studies.quantities.report import quantities_report

    emit(quantities_report(pattern), output)
