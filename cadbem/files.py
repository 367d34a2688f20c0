"""Files that are complete at any moment, even if the process that writes them is interrupted."""

from __future__ import annotations

import csv
import errno
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from io import StringIO
from pathlib import Path
from typing import Any, Protocol

from filelock import FileLock, Timeout

from cadbem.errors import ResultsError

LOCK = ".lock"


class Folder(Protocol):
    """Where files go: a path, or the folder of a run."""

    def __truediv__(self, name: str, /) -> Path: ...

    def __fspath__(self) -> str: ...


def write_whole(path: Path, content: bytes) -> None:
    """Replace a file at once: readers see the old content or the new one, never a part.

    Raises ``ResultsError`` for a full disk or a folder that cannot be written to.
    """
    beside = path.with_name(f".{path.name}.new")
    with as_results_error(path):
        try:
            with beside.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            beside.replace(path)
        except OSError:
            with suppress(OSError):
                beside.unlink()
            raise


def write_at(path: Path, position: int, content: bytes) -> int:
    """Write at a position of a file and cut off what follows; returns where it ends now.

    Raises ``ResultsError`` as ``write_whole`` does, and where the file is too short.
    """
    with as_results_error(path), path.open("r+b" if path.exists() else "w+b") as file:
        if file.seek(0, os.SEEK_END) < position:
            raise ResultsError(f"{path} has been shortened since: the run cannot go on with it")
        file.seek(position)
        file.write(content)
        file.truncate()
        file.flush()
        os.fsync(file.fileno())
        return file.tell()


def write_json(path: Path, values: Any) -> None:
    """Replace a file by values as JSON, see ``write_whole``."""
    text = json.dumps(values, indent=2, ensure_ascii=False) + "\n"
    write_whole(path, text.encode("utf-8", "backslashreplace"))


def read_json(path: Path) -> Any:
    """The values in a file.  Raises ``ResultsError`` when it is missing or damaged."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        why = "missing" if not path.exists() else "damaged"
        raise ResultsError(f"{path} is {why}; begin anew in another folder") from error


def fresh_folder(path: Path, mark: str) -> Path:
    """Make a folder for what goes on for long, known by the file ``mark`` in it.

    Hidden files are what a process that was killed at its very beginning leaves.  Raises
    ``ResultsError`` when there is anything else, and when the folder cannot be made.
    """
    with as_results_error(path):
        if path.is_dir():
            taken = any(not file.name.startswith(".") for file in path.iterdir())
        else:
            taken = path.exists()
    if taken:
        how = f"go on with 'cadbem resume {path}', or " if (path / mark).exists() else ""
        raise ResultsError(f"{path} exists already; {how}choose another folder with -o")
    return make_folder(path)


def remove_unfinished(folder: Path) -> None:
    """Remove what a process that was killed while it replaced files has left in a folder."""
    with as_results_error(folder):
        for file in folder.glob(".*.new"):
            file.unlink(missing_ok=True)


def names_of(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """The columns of a table: all names in its rows, in their order."""
    return list(dict.fromkeys(name for row in rows for name in row))


def csv_lines(
    rows: Sequence[Mapping[str, Any]], names: Sequence[str], headed: bool = True
) -> bytes:
    """Lines of a table, below its head; what a row lacks stays empty, numbers keep all digits."""
    text = StringIO()
    table = csv.DictWriter(text, names, lineterminator="\n")
    if headed:
        table.writeheader()
    table.writerows(rows)
    return text.getvalue().encode()


def make_folder(path: Path) -> Path:
    """The folder, made with those above it.  Raises ``ResultsError`` when it cannot be made."""
    with as_results_error(path):
        path.mkdir(parents=True, exist_ok=True)
    return path


@contextmanager
def as_results_error(path: Path) -> Iterator[None]:
    """Say what the system refused as a ``ResultsError``, with the remedy."""
    try:
        yield
    except ValueError as error:  # such as a NUL in a name
        raise ResultsError(f"'{str(path):.200}' is no name of a file ({error})") from error
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            remedy = "make room and go on with 'cadbem resume'"
        else:
            remedy = "choose a folder that you may write to with -o"
        raise ResultsError(
            f"{str(path):.300}: cannot be used ({error.strerror}); {remedy}"
        ) from error


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other processes from writing to a folder; a lock ends with its process.

    Raises ``ResultsError`` when another one holds it.
    """
    lock = FileLock(folder / LOCK)
    with as_results_error(folder / LOCK):
        try:
            lock.acquire(timeout=0)
        except Timeout as error:
            raise ResultsError(
                f"{folder}: another process is writing to it; wait for that, or choose another -o"
            ) from error
    try:
        yield
    finally:
        lock.release()
