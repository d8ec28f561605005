"""Files of results: each is complete before it gets its name, and those of an earlier run do not remain beside the new ones."""

import contextlib
import os
import re
import stat
from collections.abc import Mapping
from pathlib import Path

from shockpc.text.errors import OutputError
from shockpc.text.paths import inputs, read_file

MANIFEST = ".shockpc-files"
"""In a folder of results: SHA-256 and path of each file that the last run wrote there, as `sha256sum --check` reads them."""

_RESULT = (
    "(.+/)?(batch|bench|bodies|cases|check|claims|compare|contacts|correlations|damage|error-against-run-time|figure[0-9]+|joints|junit|landings?|limits|paper|parts|places?|points|postures|"
    r"profile|quantities|report|robots?|sensitivity|sheet|shock|spectrum|summary|sweep|time)\.(csv|html|json|md|png|svg|xml)"
)
"""Names of results; a file of another name is never removed."""


def check_folder(folder: Path, option: str) -> None:
    """Check that the folder of an option can be written, or made, before anything is computed; nothing is left behind.

    Raises:
        OutputError: it is a file, it cannot be made, or nothing may be written in it.
    """
    import tempfile

    try:
        with tempfile.TemporaryFile(dir=next(place for place in (folder, *folder.parents) if place.exists())):
            pass
    except OSError as refusal:
        raise OutputError(
            f'nothing can be written in folder "{folder}": {refusal.strerror}; '
            f"name another with {option}, or change its permissions"
        ) from None


def destination(path: Path, over_input: bool = False) -> Path:
    """The file that is written at a path: that to which it leads, if it is a symbolic link.

    Args:
        path: as given.
        over_input: whether it may be a file that this command has read.

    Raises:
        OutputError: what is there is a folder, a pipe, a device or a link to itself, or is read by the same command.
    """
    target = Path(os.path.realpath(path)) if path.is_symlink() else path
    for status_of in (path.stat, target.lstat):
        with contextlib.suppress(OSError):
            status = status_of()
            if not stat.S_ISREG(status.st_mode):
                kind = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe, a device or a link to itself"
                raise OutputError(f'"{path}" is {kind}, but a file has to be written there; move it, or name another file')
            if (status.st_dev, status.st_ino) in inputs and not over_input:
                raise OutputError(f'"{path}" is read by the same command, so it is not replaced; name another file')
    return target


def write_folder(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write the files of a run into a folder, and remove those that an earlier run wrote there and this one does not.

    The contents are given by path relative to the folder, with slashes. An earlier file is removed only if it has the name of a
    result and is unchanged since.

    Raises:
        OutputError: the folder cannot be written; if a file cannot have its name, nothing is.
    """
    real = Path(os.path.realpath(folder))
    for name in (*files, MANIFEST):
        if os.path.realpath(destination(folder / name)) != str(real / name):
            raise OutputError(f'"{folder / name}" leads out of its folder by a link; remove it, or name another with --out')
    try:
        listed = read_file(folder / MANIFEST, "file", OutputError, output=True).decode()
    except (OutputError, UnicodeDecodeError):
        listed = ""
    for name, content in files.items():
        write_file(folder / name, content)
    for digest, name in re.findall("(?m)^([0-9a-f]{64})  (.+)$", listed):
        path = real / name
        if name not in files and re.fullmatch(_RESULT, name) and os.path.realpath(path) == str(path) and path.is_relative_to(real):
            with contextlib.suppress(OutputError, OSError):
                if _digest(read_file(path, "file", OutputError, output=True)) == digest:
                    path.unlink()
                    path.parent.rmdir()
    write_file(folder / MANIFEST, "".join(f"{_digest(_encoded(content))}  {name}\n" for name, content in files.items()))


def write_file(path: Path, content: str | bytes, over_input: bool = False, flush: bool = False) -> None:
    """Write a file under a temporary name beside its place and rename it; text is encoded in UTF-8. On failure no file is left.

    Every output goes through here, save the standard streams. The arguments are those of `destination`; and flush: whether the
    content is on the disk before the file has its name, so that it is complete after a power cut as well.

    Raises:
        OutputError: it cannot be written, or a folder above it cannot be made; as `destination`.
    """
    target = destination(path, over_input)
    part = target.with_name(f".{target.stem}.{os.urandom(4).hex()}{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            with part.open("wb") as file:
                file.write(_encoded(content))
                if flush:
                    file.flush()
                    os.fsync(file.fileno())
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)
    except OSError as refusal:
        raise OutputError(f'"{path}" cannot be written: {refusal.strerror}') from None


def _encoded(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace")


def _digest(content: bytes) -> str:
    import hashlib

    return hashlib.sha256(content).hexdigest()
