"""Asking the CAD kernel, in a child process with a time limit."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cadbem.cad.source import CadSource
from cadbem.errors import CadError
from cadbem.spline.basis import Array


@dataclass(frozen=True)
class Solid:
    """A solid as the kernel sees it: its box (2, 3) in millimetres."""

    name: str
    box: tuple[float, ...]
    faces: int


@dataclass(frozen=True)
class KernelModel:
    """What the kernel made of a file; `brep` is its exact record, in millimetres."""

    brep: str
    faces: int
    curves: int
    sewn: bool
    solids: tuple[Solid, ...]
    log: tuple[str, ...]


def import_model(source: CadSource, time_limit: float) -> KernelModel:
    """Read the file; loose faces (IGES) are sewn into a solid if they fit together.

    Raises CadError if the kernel fails, crashes or takes longer than `time_limit` seconds.
    """
    with TemporaryDirectory(prefix="cadbem-") as folder:
        found, log = _run(source, Path(folder), time_limit, "record")
        record = Path(folder, "model.brep")
        brep = record.read_text() if record.exists() else ""
    solids = tuple(Solid(s["name"], tuple(s["box"]), s["faces"]) for s in found["solids"])
    return KernelModel(brep, found["faces"], found["curves"], found["sewn"], solids, log)


def mesh_model(source: CadSource, size: float, time_limit: float) -> tuple[Array, np.ndarray]:
    """Points (3, N) in millimetres and tetrahedra (4, M) of the file's only solid.

    Raises CadError as `import_model` does, and if there is not exactly one solid.
    """
    with TemporaryDirectory(prefix="cadbem-") as folder:
        found, log = _run(source, Path(folder), time_limit, "mesh", repr(size))
        if len(found["solids"]) != 1:
            raise CadError(
                f"{source.name}: {len(found['solids'])} solids instead of one; "
                "export the fluid's space as one closed solid"
            )
        with np.load(Path(folder, "mesh.npz")) as mesh:
            return mesh["points"], mesh["tetrahedra"]


def _run(
    source: CadSource, folder: Path, time_limit: float, task: str, *options: str
) -> tuple[dict, tuple[str, ...]]:
    copy = folder / f"input.{source.kind}"  # the kernel goes by the ending, in lower case
    copy.write_bytes(source.data)
    child = Path(__file__).with_name("_child.py")
    command = [sys.executable, "-P", str(child), task, str(copy), str(folder), *options]
    try:
        done = subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            cwd=folder,
            timeout=time_limit,
        )
    except subprocess.TimeoutExpired:
        raise CadError(
            f"{source.name}: the CAD kernel was not done after {time_limit:g} s; "
            "simplify the model, or allow more time with time_limit"
        ) from None
    log = _noteworthy(done.stdout.decode(errors="replace"))
    result = folder / "model.json"
    if not result.exists():
        raise CadError(_crash_message(source, done.returncode, log))
    found = json.loads(result.read_text())
    if "error" in found:
        raise CadError(
            f"{source.name}: the CAD kernel cannot use the file ({_one_line(found['error'])}); "
            "export it again from the CAD program"
        )
    return found, log


def _crash_message(source: CadSource, code: int, log: tuple[str, ...]) -> str:
    if any("ModuleNotFoundError" in line or "ImportError" in line for line in log):
        return f"gmsh does not start ({log[-1]}); install it and the system libraries it names"
    if any("OSError" in line for line in log):  # a shared library is missing
        return f"gmsh does not start ({log[-1]}); install the system library it names"
    return (
        f"{source.name}: the CAD kernel crashed on the file (exit code {code}); "
        "export it again from the CAD program, perhaps in the other format"
    )


def _noteworthy(output: str) -> tuple[str, ...]:
    """Lines of the kernel's output that tell of trouble, without terminal colours."""
    lines = [line.replace("\x1b[32;1m", "").replace("\x1b[0m", "") for line in output.splitlines()]
    marks = ("Error", "ERR", "Warning", "fail", "Fail")
    return tuple(_one_line(line) for line in lines if any(mark in line for mark in marks))


def _one_line(text: str) -> str:
    return " ".join(text.split())[:200]
