"""The manifest of a run: the script and its arguments, versions, files with their digests."""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import platform
from collections.abc import Sequence
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import FrameType
from typing import Any

from cadbem.command import CURRENT, Command
from cadbem.errors import ResultsError
from cadbem.operators.parallel import CORES, linear_algebra_threads

REMEDY = "put back a sound copy of it, or begin anew in another folder"
LIBRARIES = ("cadbem", "gmsh", "numpy", "scipy", "numba", "pyvista", "h5py")


# kinds of the values in a manifest, those of lists and mappings within them in the second place
KINDS: dict[str, tuple[Any, Any]] = {
    "script": (dict | None, object),
    "arguments": (dict, str | int | float | bool),
    "inputs": (list, dict),
    "began": (str, object),
    "working_folder": (str, object),
    "versions": (dict, str),
    "cores": (int, object),
    "threads": (int, object),
}


def check_manifest(values: Any, path: Path) -> dict[str, Any]:
    """What was read from a manifest.  Raises ``ResultsError`` if it is not what a run writes."""
    for name, (kind, inner) in KINDS.items():
        value: Any = values.get(name, ...) if isinstance(values, dict) else ...
        items = value.values() if isinstance(value, dict) else value
        fits = isinstance(value, kind)
        fits &= not isinstance(value, dict | list) or all(isinstance(i, inner) for i in items)
        if not fits or "\\u0000" in json.dumps(value):
            raise ResultsError(f"{path}: '{name}' is not what a run writes; {REMEDY}")
    for file in (values["script"] or {}, *values["inputs"]):
        if file and not all(isinstance(file.get(k), str) for k in ("file", "sha256")):
            raise ResultsError(f"{path}: a file in it has no name or digest; {REMEDY}")
    return values


def manifest_of(caller: FrameType, inputs: Sequence[str | Path]) -> dict[str, Any]:
    """The command that is carried out, else the function that calls: its file with the digest, its
    arguments that are numbers, words or truth values; versions, machine, time; the ``inputs`` with
    their digests; how many cores and threads of linear algebra it has, on which the last digits
    depend."""
    command = CURRENT.get() or _call(caller)
    plain = {
        name: value
        for name, value in command.arguments.items()
        if isinstance(value, str | int | float | bool)
    }
    return {
        "script": digested(command.script) if command.script.is_file() else None,
        "arguments": plain,
        "inputs": [digested(Path(file)) for file in inputs],
        "began": datetime.now().astimezone().isoformat(timespec="seconds"),
        "working_folder": str(Path.cwd()),
        "versions": {"python": platform.python_version()} | _versions(),
        "cores": CORES.get(),
        "threads": linear_algebra_threads(),
        "machine": f"{platform.platform()}, {os.cpu_count()} cores",
    }


def _call(caller: FrameType) -> Command:
    """A function that was called without a command line, as a command."""
    values = inspect.getargvalues(caller)
    arguments = {name: values.locals[name] for name in values.args}
    return Command(Path(inspect.getframeinfo(caller).filename).resolve(), arguments)


def digested(file: Path) -> dict[str, Any]:
    """A file's whole path, its size in bytes and the SHA-256 of its content."""
    try:
        content = file.read_bytes()
    except OSError as error:
        raise ResultsError(
            f"{file}: cannot be read ({error.strerror}); its digest belongs to the results"
        ) from error
    digest = hashlib.sha256(content).hexdigest()
    return {"file": str(file.resolve()), "bytes": len(content), "sha256": digest}


def _versions() -> dict[str, str]:
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found
