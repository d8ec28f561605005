"""The base class of the parts of a scene."""

CHECKED = {"extra": "forbid", "allow_inf_nan": False}
"""How scene files are checked against the records they become: no unknown keys, no numbers that are not finite."""


class Record:
    """A part of a scene, compared and printed by its fields."""

    __pydantic_config__ = CHECKED

    # Made by dataclass for each class, these methods would lengthen the start of every command.
    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash(tuple(vars(self).values()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in vars(self).items())})"
