"""The help of a command: options under the headings of their groups, without the start-up cost of a rich-text library."""

from typing import Any

from typer.core import TyperCommand

__all__ = ["GroupedCommand"]


class GroupedCommand(TyperCommand):
    """A command whose help groups its options by their `rich_help_panel`, and says which may be repeated."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The parts of the usage line; Typer writes {ROBOT} for an argument that is required."""
        return [piece.strip("{}") for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then one section for each group in order; options without a group come last."""
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": []}
        for parameter in self.get_params(ctx):
            kind = "Arguments" if parameter.param_type_name == "argument" else "Other options"
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            name, text = record
            if getattr(parameter, "multiple", False):
                text += " May be repeated."
            groups.setdefault(getattr(parameter, "rich_help_panel", None) or kind, []).append((name, text))
        rest = groups.pop("Other options", [])
        for heading, records in [*groups.items(), ("Other options", rest)]:
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)
