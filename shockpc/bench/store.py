"""Finished cases are kept as they come, so that a bench that was interrupted goes on where it stopped."""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import shockpc
from shockpc.show.files import make_folder, write_text

__all__ = ["Store", "fingerprint"]


def fingerprint(settings: str) -> str:
    """What results depend on: every line of the package, and how it was asked to measure."""
    seen = hashlib.sha256(settings.encode())
    home = Path(shockpc.__file__).parent
    for path in sorted(home.rglob("*.py")):
        seen.update(path.relative_to(home).as_posix().encode())
        seen.update(path.read_bytes())
    return seen.hexdigest()[:16]


class Store:
    """A folder of finished parts, one JSON file each; what another version of the package left there is done again.

    Args:
        folder: where they lie.
        mark: fingerprint of this run.
    """

    def __init__(self, folder: Path, mark: str):
        self.folder, self.mark = folder, mark
        make_folder(folder)

    def get(self, name: str) -> Any | None:
        """A finished part, or None."""
        path = self._path(name)
        if not path.is_file():
            return None
        try:
            kept = json.loads(path.read_text(encoding="utf-8"))
        except json.JSONDecodeError:
            return None
        return kept["part"] if isinstance(kept, dict) and kept.get("mark") == self.mark else None

    def put(self, name: str, part: Any) -> None:
        """Keep a finished part.

        Raises:
            OutputError: it cannot be written.
        """
        write_text(self._path(name), json.dumps({"mark": self.mark, "part": part}, ensure_ascii=False) + "\n")

    def _path(self, name: str) -> Path:
        return self.folder / (re.sub(r"[^A-Za-z0-9.+-]+", "_", name) + ".json")
