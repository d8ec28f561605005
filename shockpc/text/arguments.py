"""Checks of arguments: a wrong type or value beyond its bounds is an error that says what is valid.

They are those of the public functions of the package.
"""

import dataclasses
import functools
import inspect
import numbers
import re
import reprlib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from types import UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin

from shockpc.text.errors import StudyError

LARGEST_NUMBER = 1e12
"""Largest number of an option or a record without a maximum, in whatever unit.

Beyond it squares run out of range.
"""

F = TypeVar("F", bound=Callable[..., Any])

typed: set[str] = set()
"""Names of the records whose fields the running command takes from its options; none in Python."""


def checked(
    function: F,
    signature: inspect.Signature | None = None,
    fault_of: Mapping[str, Callable[[Any], str]] | None = None,
) -> F:
    """The function with a check of its arguments by their annotations and bounds before each call.

    The check raises a StudyError.

    Args:
        function: whose arguments are checked.
        signature: as it is documented, by default the function's.
        fault_of: what is wrong with the numbers of an argument, empty if nothing is, by parameter.
    """
    signature = signature or inspect.signature(function)
    kinds = {name: parameter.annotation for name, parameter in signature.parameters.items()}

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            if not _fits(value, kinds[name]):
                wanted = re.sub(r"\b(?:\w+\.)+", "", inspect.formatannotation(kinds[name]))
                raise StudyError(
                    f"{name} is {reprlib.repr(value)}, of type {type(value).__name__}; it has to "
                    f"be {wanted}"
                )
            if fault_of and name in fault_of and (fault := fault_of[name](value)):
                raise StudyError(f"{name} {fault}")
        return function(*args, **kwargs)

    vars(call)["__signature__"] = signature
    return cast(F, call)


def default_of(field: dataclasses.Field[Any]) -> Any:
    """The default of a field of a record; MISSING if it has none."""
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def is_numeric(kind: Any) -> bool:
    """True if a type is that of numbers, or of collections of numbers."""
    return kind in (int, float) or any(map(is_numeric, get_args(kind)))


def _fits(value: Any, kind: Any) -> bool:
    """True if a value is of a type as annotations write it.

    A text is no sequence, any other collection is one; int is a float.

    An array without an axis is the number in it. An annotation that is a text is not looked up, so
    any value is.
    """
    value = value.item() if getattr(value, "ndim", None) == 0 else value
    origin, parts = get_origin(kind) or kind, get_args(kind)
    if origin in (Union, UnionType):
        return any(_fits(value, part) for part in parts)
    if origin is Literal:
        return isinstance(value, str) and value in parts
    if origin in (int, float):
        number = numbers.Integral if origin is int else numbers.Real
        return isinstance(value, number) and not isinstance(value, bool)
    if origin is Mapping:
        if not isinstance(value, Mapping):
            return False
        of_key, of_value = parts
        return all(_fits(key, of_key) and _fits(part, of_value) for key, part in value.items())
    if origin in (Sequence, tuple, Iterable):
        return _fits_in_order(value, origin, parts)
    if origin in (Any, inspect.Parameter.empty) or isinstance(origin, str):
        return True
    return isinstance(value, origin)


def _fits_in_order(value: Any, origin: Any, parts: Sequence[Any]) -> bool:
    """True if a value is a sequence, or anything that can be iterated, of parts that fit.

    What can be iterated once is not looked into.
    """
    collection = Iterable if origin is Iterable else Collection
    if isinstance(value, str | bytes) or not isinstance(value, collection):
        return False
    entries = list(value) if isinstance(value, Collection) else []
    if origin is tuple and parts[-1] is not ...:
        return len(entries) == len(parts) and all(map(_fits, entries, parts))
    return all(_fits(entry, parts[0]) for entry in entries)
