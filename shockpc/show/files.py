"""Files of results: each is complete before it gets its name, and none replaces an input."""

import contextlib
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from shockpc.text.errors import OutputError
from shockpc.text.paths import inputs, open_file, read_file


def check_folder(folder: Path, option: str) -> None:
    """Check that the folder of an option can be written, or made, before anything is computed.

    Nothing is left behind.

    Raises:
        OutputError: it is a file, it cannot be made, or nothing may be written in it.
    """
    import tempfile

    try:
        with tempfile.TemporaryFile(
            dir=next(place for place in (folder, *folder.parents) if place.exists())
        ):
            pass
    except OSError as refusal:
        raise OutputError(
            f'nothing can be written in folder "{folder}": {refusal.strerror}; '
            f"name another with {option}, or change its permissions"
        ) from None


def destination(path: Path, replaceable: str = "") -> Path:
    """The file that is written at a path: that to which it leads, if it is a symbolic link.

    Args:
        path: as given.
        replaceable: what a file that this command has read may be to be replaced all the same, such
            as "scene file".

    Raises:
        OutputError: what is there is a folder, a pipe, a device or a link to itself, or is read by
            the same command.
    """
    target = Path(os.path.realpath(path)) if path.is_symlink() else path
    for status_of in (path.stat, target.lstat):
        with contextlib.suppress(OSError):
            status = status_of()
            if not stat.S_ISREG(status.st_mode):
                kind = (
                    "a folder"
                    if stat.S_ISDIR(status.st_mode)
                    else "a pipe, a device or a link to itself"
                )
                raise OutputError(
                    f'"{path}" is {kind}, but a file has to be written there; move it, or name '
                    f"another file"
                )
            if inputs.get((status.st_dev, status.st_ino), replaceable) != replaceable:
                raise OutputError(
                    f'"{path}" is read by the same command, so it is not replaced; name another '
                    f"file"
                )
    return target


def write_folder(folder: Path, files: Mapping[str, str | bytes], name: str) -> None:
    """Write the files of a run into a folder, and remove those of the run before it that it lacks.

    The file `.NAME.sha256` lists what the last run of a name wrote, as `sha256sum` does. Removed is
    what it lists, is still as it was written, and lies in a folder into which this run writes. All
    other files stay as they are.

    Args:
        folder: is made if it does not exist.
        files: the contents by path relative to the folder, with slashes.
        name: of the kind of run.

    Raises:
        OutputError: the folder cannot be written; if a file cannot have its name, nothing is.
    """
    real, manifest = Path(os.path.realpath(folder)), f".{name}.sha256"
    for path in (*files, manifest):
        if os.path.realpath(destination(folder / path)) != str(real / path):
            raise OutputError(
                f'"{folder / path}" leads out of its folder by a link; remove it, or name another '
                f"with --out"
            )
    recorded = _recorded(folder / manifest)
    for path, content in files.items():
        write_file(folder / path, content)
    digests = {path: _digest(_encoded(content)) for path, content in files.items()}
    folders = {os.path.dirname(path) for path in files}
    for path, digest in recorded.items():
        if os.path.dirname(path) not in folders:
            digests[path] = digest
        elif path not in files and _unchanged(real, path, digest):
            _remove(real / path)
    lines = (f"{digest}  {path}\n" for path, digest in digests.items() if "\n" not in path)
    write_file(folder / manifest, "".join(lines))


def _recorded(manifest: Path) -> dict[str, str]:
    """SHA-256 of the files of the last run by path; empty where there was none."""
    if not manifest.exists():
        return {}
    text = read_file(manifest, "file", OutputError, output=True).decode("utf-8", "replace")
    lines = (line.partition("  ") for line in text.split("\n"))
    return {path: digest for digest, _, path in lines if path}


def _unchanged(real: Path, name: str, digest: str) -> bool:
    """True if a file of a folder is as a run wrote it, and not read by this one."""
    path = real / name
    # What is no regular file, or lies behind a link, is none that a run wrote.
    inside = os.path.realpath(path) == str(path) and path.is_relative_to(real)
    if not (inside and path.is_file()):
        return False
    status = path.stat()
    if (status.st_dev, status.st_ino) in inputs:
        return False
    with open_file(path, "file", OutputError, output=True) as file:
        return _digest(file.read()) == digest


def _digest(content: bytes) -> str:
    import hashlib  # of OpenSSL, and needed only where a file is written

    return hashlib.sha256(content).hexdigest()


def _remove(path: Path) -> None:
    try:
        path.unlink()
    except OSError as refusal:
        raise OutputError(
            f'"{path}", of an earlier run, cannot be removed: {refusal.strerror}'
        ) from None


def write_file(
    path: Path, content: str | bytes, replaceable: str = "", flush: bool = False
) -> None:
    """Write a file of one content; the arguments and what is raised are those of `new_file`."""
    with new_file(path, replaceable, flush) as append:
        append(content)


@contextlib.contextmanager
def new_file(
    path: Path, replaceable: str = "", flush: bool = False
) -> Iterator[Callable[[str | bytes], None]]:
    """A function that appends to a new file, which replaces that of its path when the block ends.

    The file has a temporary name beside its place until it is complete; on failure no file is
    left. Text is encoded in UTF-8. Every output goes through here, save the standard streams.

    Args:
        path: as in `destination`.
        replaceable: as in `destination`.
        flush: whether the content is on the disk before the file has its name, so that it is
            complete after a power cut as well.

    Raises:
        OutputError: it cannot be written, or a folder above it cannot be made; as `destination`.
    """
    target = destination(path, replaceable)
    part = target.with_name(f".{target.stem}.{os.urandom(4).hex()}{target.suffix}")

    def append(content: str | bytes) -> None:
        with _refused(path), part.open("ab") as file:
            file.write(_encoded(content))
            if flush:
                file.flush()
                os.fsync(file.fileno())

    with _refused(path):
        target.parent.mkdir(parents=True, exist_ok=True)
    try:
        yield append
        with _refused(path):
            part.replace(target)
    finally:
        with _refused(path):
            part.unlink(missing_ok=True)


@contextlib.contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Raise an OutputError where the system refuses to write."""
    try:
        yield
    except OSError as refusal:
        raise OutputError(f'"{path}" cannot be written: {refusal.strerror}') from None


def _encoded(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace")
