"""Records whose fields do not change once they are given."""

import dataclasses
from collections.abc import Callable
from typing import Any, NoReturn, TypeVar, dataclass_transform

R = TypeVar("R")


@dataclass_transform(eq_default=False, frozen_default=True, field_specifiers=(dataclasses.field,))
def frozen(*, kw_only: bool = False) -> Callable[[type[R]], type[R]]:
    """A decorator for records: frozen dataclasses with shared methods.

    It is `dataclasses.dataclass(frozen=True, eq=False, repr=False)`, with methods that all records
    share.

    Those that `dataclass` makes for each class, which it compiles, would lengthen the start of
    every command.

    Args:
        kw_only: whether the fields are given only by name.
    """

    def decorate(record: type[R]) -> type[R]:
        for name, method in (("__setattr__", _set_once), ("__delattr__", _refuse)):
            setattr(record, name, method)
        return dataclasses.dataclass(eq=False, repr=False, kw_only=kw_only)(record)

    return decorate


def _set_once(record: Any, name: str, value: Any) -> None:
    values = vars(record)
    if name in values or name not in record.__dataclass_fields__:
        _refuse(record, name)
    values[name] = value


def _refuse(record: Any, name: str) -> NoReturn:
    raise dataclasses.FrozenInstanceError(
        f'field "{name}" of {type(record).__name__} cannot be changed; use dataclasses.replace'
    )
