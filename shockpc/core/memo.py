"""Results that belong to an object, which holds them: they are computed once, and freed with it."""

import functools
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar

from shockpc.core.spatial import freeze

Owner = TypeVar("Owner")
P = ParamSpec("P")
T = TypeVar("T")


class _Memo(dict[Any, dict[Any, Any]]):
    """The results that an object holds, by function and its other arguments.

    A pickled object leaves them behind.
    """

    def __reduce__(self) -> tuple[type, tuple[()]]:
        return _Memo, ()


def memoized(
    most: int | None = None,
) -> Callable[[Callable[Concatenate[Owner, P], T]], Callable[Concatenate[Owner, P], T]]:
    """A decorator that keeps the results of a function in its first argument.

    With `functools.cache` the results would keep that argument alive.

    That object has a `__dict__`, and what the function reads of it does not change. The other
    arguments can be hashed. Nobody can write to the arrays of a result.

    Args:
        most: number of results that an object holds, beyond which the oldest is given up; all by
            default.
    """

    def decorate(compute: Callable[Concatenate[Owner, P], T]) -> Callable[Concatenate[Owner, P], T]:
        @functools.wraps(compute)
        def remembered(owner: Owner, /, *args: P.args, **kwargs: P.kwargs) -> T:
            results: dict[Any, T] = vars(owner).setdefault("_memo", _Memo()).setdefault(compute, {})
            key = args, *kwargs.items()
            if key in results:
                return results[key]
            value = compute(owner, *args, **kwargs)
            freeze(value)
            results[key] = value
            for oldest in () if most is None else list(results)[:-most]:
                results.pop(oldest, None)
            return value

        return remembered

    return decorate
