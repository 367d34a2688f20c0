"""Calls of the CAD kernel, in a child process with a time limit."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL, PIPE, STDOUT, Popen, TimeoutExpired
from tempfile import TemporaryDirectory
from time import monotonic

import numpy as np

from cadbem.cad.text.source import CadSource
from cadbem.errors import CadError, printable
from cadbem.progress import progress
from cadbem.spline.basis import Array


@dataclass(frozen=True)
class KernelModel:
    """What the kernel found in a file; `brep` is its exact record, in millimetres.

    `solids` are the names of the solids, in the order of the record. `healed` says in words what
    was repaired, beyond joining faces within the file's digits. `box` (min and max corner, mm) is
    the one that solids were taken from, () unless that was requested; `flat` says which of its six
    sides are sides of the solids. `measures` are area and middle (4 numbers) of each face by the
    kernel's own triangles, in any order, `volumes` those of the solids; mm.
    """

    brep: str
    faces: int
    curves: int
    sewn: bool
    solids: tuple[str, ...]
    log: tuple[str, ...]
    healed: tuple[str, ...] = ()
    box: tuple[float, ...] = ()
    flat: tuple[bool, ...] = ()
    measures: tuple[tuple[float, ...], ...] = ()
    volumes: tuple[float, ...] = ()


def import_model(
    source: CadSource, time_limit: float, room: str = "solid", sew: float = 0.0
) -> KernelModel:
    """Read the file; loose faces (IGES) are sewn into a solid if they fit together, within the
    file's digits or within `sew` per size of the model.

    `room`: "solid" leaves solids as they are, "all" makes those that touch share their faces,
    "void" takes them out of their box.
    Raises CadError if the kernel fails, crashes or takes longer than `time_limit` seconds.
    """
    with _temporary(source) as folder:
        found, log = _run(source, folder, time_limit, "record", room, repr(sew))
        record = folder / "model.brep"
        brep = record.read_text() if record.exists() else ""
    return KernelModel(
        brep, found["faces"], found["curves"], found["sewn"],
        tuple(map(printable, found["solids"])), log,
        tuple(found["healed"]), tuple(found.get("box", ())), tuple(found.get("flat", ())),
        tuple(map(tuple, found.get("measures", ()))), tuple(found.get("volumes", ())),
    )  # fmt: skip


def mesh_model(source: CadSource, size: float, time_limit: float) -> tuple[Array, np.ndarray]:
    """Points (3, N) in millimetres and tetrahedra (4, M) of the file's only solid.

    Raises CadError as `import_model` does, and if there is not exactly one solid.
    """
    with _temporary(source) as folder:
        found, log = _run(source, folder, time_limit, "mesh", repr(size))
        if len(found["solids"]) != 1:
            raise CadError(
                f"{source.name}: {len(found['solids'])} solids instead of one; "
                "export the fluid's space as one closed solid"
            )
        with np.load(folder / "mesh.npz") as mesh:
            return mesh["points"], mesh["tetrahedra"]


def section_model(
    source: CadSource, time_limit: float, plane: tuple[Array, Array] | None = None
) -> tuple[str, list[Array]]:
    """The record of the faces in which solids meet a plane (point, normal; mm), "" if nowhere.

    Without a plane: of the faces that the file's closed wires bound, one a wire, or, if wires are
    open, their ends.
    Raises CadError as `import_model` does.
    """
    option = json.dumps([list(map(float, vector)) for vector in plane]) if plane else ""
    with _temporary(source) as folder:
        found, _ = _run(source, folder, time_limit, "section", option)
        brep = (folder / "model.brep").read_text() if found["faces"] else ""
    return brep, [np.array(end) for end in found["open"]]


@contextmanager
def _temporary(source: CadSource) -> Iterator[Path]:
    """A folder for the kernel's files.  Raises CadError where there is none, or no room in it."""
    try:
        with TemporaryDirectory(prefix="cadbem-") as folder:
            yield Path(folder)
    except OSError as error:
        raise CadError(_no_room(source, str(error.strerror))) from error


def _run(
    source: CadSource, folder: Path, time_limit: float, task: str, *options: str
) -> tuple[dict, tuple[str, ...]]:
    copy = folder / f"input.{source.kind}"  # the kernel goes by the ending, in lower case
    copy.write_bytes(source.data)
    child = Path(__file__).with_name("_child.py")
    command = [sys.executable, "-P", str(child), task, str(copy), str(folder), *options]
    code, output = _finished(command, folder, time_limit, source.name)
    log = _noteworthy(output.decode(errors="replace"))
    result = folder / "model.json"
    if not result.exists():
        raise CadError(_crash_message(source, code, log))
    found = json.loads(result.read_text() or "{}") or {"error": "its answer is empty"}
    if "error" in found:
        raise CadError(
            f"{source.name}: the CAD kernel cannot use the file ({_one_line(found['error'])}); "
            "export it again from the CAD program"
        )
    return found, log


def _finished(command: list[str], folder: Path, time_limit: float, name: str) -> tuple[int, bytes]:
    """Exit code and output of the child; it is killed when the time is over."""
    start = monotonic()
    with (
        progress(label=f"{name}: CAD kernel", unit="s", total=time_limit) as bar,
        Popen(command, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT, cwd=folder) as process,
    ):
        try:
            while True:
                left = start + time_limit - monotonic()
                try:
                    output, _ = process.communicate(timeout=max(0.0, min(0.5, left)))
                    return process.returncode, output
                except TimeoutExpired:
                    if left <= 0.5:
                        break
                    bar.update(monotonic() - start - bar.n)
        finally:
            process.kill()  # also when the user interrupts
            process.wait()  # `Popen` waits only a moment then, and may leave a zombie
    raise CadError(
        f"{name}: the CAD kernel was not done after {time_limit:g} s; "
        "simplify the model, or allow more time with time_limit"
    )


def _no_room(source: CadSource, why: str) -> str:
    where = tempfile.tempdir or "the folder for them"
    return (
        f"{source.name}: no room for temporary files ({why}); make room in {where}, or set TMPDIR "
        "to another folder"
    )


def _crash_message(source: CadSource, code: int, log: tuple[str, ...]) -> str:
    full = [line for line in log if "No space left" in line or "File too large" in line]
    if full:
        return _no_room(source, full[0])
    if any("ModuleNotFoundError" in line or "ImportError" in line for line in log):
        return f"gmsh does not start ({log[-1]}); install it and the system libraries it names"
    if any("OSError" in line for line in log):  # a shared library is missing
        return f"gmsh does not start ({log[-1]}); install the system library it names"
    return (
        f"{source.name}: the CAD kernel crashed on the file (exit code {code}), or found too "
        "little memory; "
        "export it again from the CAD program, perhaps in the other format"
    )


def _noteworthy(output: str) -> tuple[str, ...]:
    """Lines of the kernel's output that report errors, without terminal colours."""
    lines = [line.replace("\x1b[32;1m", "").replace("\x1b[0m", "") for line in output.splitlines()]
    labels = ("Error", "ERR", "Warning", "fail", "Fail")
    found = [_one_line(line) for line in lines if any(label in line for label in labels)]
    return tuple(dict.fromkeys(found))


def _one_line(text: str) -> str:
    return " ".join(text.split())[:200]
