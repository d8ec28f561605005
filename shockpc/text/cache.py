"""Files in the user's cache folder: what costs time to make and is the same in the next run."""

import contextlib
import functools
import hashlib
import itertools
import os
from collections.abc import Callable
from pathlib import Path

MOST_FILES = 256
"""Files that are kept; the oldest give way."""


def cache_folder() -> Path | None:
    """The folder: `shockpc` in $XDG_CACHE_HOME, or in ~/.cache; None for a user without a home.

    It need not exist.
    """
    folder = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return None if folder.startswith("~") else Path(folder) / "shockpc"


@functools.cache
def version_of_code(rooms: tuple[str, ...] = (".",)) -> str:
    """The version of this package, with a digest of its code.

    Args: rooms, the folders of it that count.
    """
    import shockpc

    root, code = Path(shockpc.__file__).parent, hashlib.sha256()
    files = itertools.chain.from_iterable((root / room).rglob("*.py") for room in rooms)
    for file in sorted(files):
        code.update(file.read_bytes())
    return f"{shockpc.__version__} {code.hexdigest()}"


def cached(name: str, make: Callable[[], bytes]) -> bytes:
    """Bytes as an earlier run made them, or else made now and kept.

    A file begins with the digest of its content: one that is incomplete, or was changed, is made
    again. Where the folder cannot be written, they are made each time.

    Args:
        name: of the file, which says all that the bytes depend on.
        make: makes the bytes.
    """
    folder = cache_folder()
    if folder is None:
        return make()
    file = folder / name
    with contextlib.suppress(OSError):
        digest, content = (kept := file.read_bytes())[:32], kept[32:]
        if hashlib.sha256(content).digest() == digest:
            return content
    content = make()
    part = file.with_name(f".{name}.{os.urandom(4).hex()}")
    with contextlib.suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.write_bytes(hashlib.sha256(content).digest() + content)
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)
        files = sorted(file.parent.glob(f"*{file.suffix}"), key=lambda path: path.stat().st_mtime)
        for old in files[:-MOST_FILES]:
            old.unlink(missing_ok=True)
    return content
