"""The provenance of a result: versions, commit, machine, settings and command."""

import importlib.metadata
import os
import platform
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pigbench import settings
from pigbench.support import files, typed

PACKAGES = ("pigbench", "jax", "mujoco")


def package_versions(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """The installed version of each package, or "not installed"."""
    return {package: _version(package) for package in packages}


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"  # for example, if the code runs from a bare copy of its folder


def provenance(*, dataset: Path, dataset_digest: str) -> dict[str, Any]:
    """The provenance to store beside a result, ready for JSON."""
    return surroundings() | {
        "dataset": str(dataset),
        "dataset_digest": dataset_digest,
        "command": typed.command(),
    }


def surroundings() -> dict[str, Any]:
    """Versions, commit, machine and settings, ready for JSON."""
    import jax

    return {
        "versions": {"python": platform.python_version(), **package_versions()},
        "commit": _commit(),
        "machine": {
            "platform": platform.platform(),
            "cpu_count": os.cpu_count(),
            "device": jax.devices()[0].device_kind,
            "device_count": jax.device_count(),
            "threads": os.environ.get("NPROC", "all"),  # XLA's
        },
        "numerics": settings.in_force(),
    }


def save(path: Path | None, **content: Any) -> None:
    """Write a result with its surroundings to a JSON file, if there is one for it."""
    if path is not None:
        files.write_json(path, content | surroundings())


def _commit() -> str | None:
    """The git commit of this code, with `-dirty` if files differ from it; None outside git."""
    root = Path(__file__).resolve().parents[1]
    if not (root / ".git").exists():
        return None
    command = [
        "git",
        "-C",
        str(root),
        "describe",
        "--always",
        "--dirty",
        "--abbrev=40",
        "--exclude=*",
    ]
    try:
        return subprocess.run(command, capture_output=True, check=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None
