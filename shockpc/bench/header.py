"""What a report begins with: versions, machine, date, command; and what the method cannot do."""

import importlib.metadata
import os
import platform
import sys
from datetime import UTC, datetime
from pathlib import Path

import shockpc

__all__ = ["LIMITS", "header"]

LIMITS = (
    "bodies are rigid and the impact takes no time; a real one takes milliseconds, which `shockpc bench SCENE --compliant` weighs",
    "contacts stick or slide along given directions; whether friction would hold is reported, not enforced",
    "a drive is free, has a reflected inertia, or holds; gearboxes that slip in between are not modelled",
    "all contacts, in all directions, come to rest together; a ground that lets one go before another ends elsewhere",
    "terms that cancel to within their rounding are zero, and so is a rotation that moves no point by 1e-9 of the strike",
    "restitution is Newton's, per contact; several contacts with different restitutions can make energy, which is warned of",
    "masses and placements are taken as exact; their own uncertainty is usually the larger error by far",
    "impulses of contacts that repeat one another are not unique, and are not given",
    "bodies that no rounding can tell from resting ones (1e-13 of the fastest) are measured against the fastest",
)
"""What no number in the report says."""

LIBRARIES = ("pin", "numpy", "scipy", "mpmath", "mujoco", "example-robot-data")


def header(command: str, suite: str) -> list[tuple[str, str]]:
    """Name and value of everything that a rerun may depend on."""
    versions = [(name, _version(name)) for name in LIBRARIES]
    return [
        ("shockpc", shockpc.__version__),
        *versions,
        ("Python", platform.python_version()),
        ("CPU", _cpu()),
        ("threads", f"{os.environ.get('OMP_NUM_THREADS', 'not set')} (of {os.cpu_count()} cores)"),
        ("system", platform.platform()),
        ("suite", suite),
        ("command", command),
        ("date", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
    ]


def _version(name: str) -> str:
    """Version of an installed distribution."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _cpu() -> str:
    """The processor's name, where the system tells it."""
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
