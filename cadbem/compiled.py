"""Compiled functions, whose machine code is kept on disk until one of their source files changes.

numba's own cache looks at the file of the function alone and so misses an edit of a function that
another file calls.  Here the code is kept under a stamp of all files of the package that name this
module: those with compiled functions, and those that define numbers which these take.

Each file begins with a digest of the rest: one that is damaged, by a power cut or a full disk,
counts as missing and is written again.
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
from numba import njit
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.serialize import dumps

from cadbem.progress import notice

DIGEST = 32  # bytes of a SHA-256
MARK = b"cadbem.compiled"
PATIENCE = 2.0  # seconds of compiling after which a notice is shown


def compiled(function: Callable | None = None, /, **options: Any) -> Any:
    """Decorator: `numba.njit` without the interpreter's lock, its machine code kept on disk.

    The options are those of `njit`; divisions by zero give infinity or nan, as NumPy's, unless
    ``error_model="python"``.  Where no folder can be written to, nothing is kept.
    """
    if function is None:
        return functools.partial(compiled, **options)
    defaults: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
    dispatcher: Any = njit(**defaults | options)(function)
    try:
        dispatcher._cache = _Cache(function)
    except RuntimeError:  # numba says so when it finds no folder that it can write to
        _Cache.watch.say_once("no folder to keep it in can be written to; set NUMBA_CACHE_DIR")
    return dispatcher


@contextmanager
def quietly() -> Iterator[None]:
    """Within it, nothing is said about compiling."""
    _Cache.watch.notified, before = True, _Cache.watch.notified
    try:
        yield
    finally:
        _Cache.watch.notified = before


class _Watch:
    """Tells the user once what is going on when compiling takes long.

    Functions are compiled one at a time, those that others call within theirs.
    """

    def __init__(self) -> None:
        self.notified, self.depth, self.since, self.spent = False, 0, 0.0, 0.0
        self.said = False

    def say_once(self, why: str) -> None:
        """Tell that machine code is not kept, the first time."""
        if not self.said:
            self.said = True
            notice(f"compiled code is not kept for later runs: {why}")

    def start(self) -> None:
        """A function is about to be compiled."""
        now = time.monotonic()
        self.since = self.since if self.depth else now
        self.depth += 1
        if not self.notified and self.spent + now - self.since > PATIENCE:
            self.notified = True
            text = "compiling, which is kept for later runs; `cadbem warmup` does it beforehand"
            notice(text)

    def stop(self) -> None:
        """It is compiled."""
        self.depth -= 1
        if self.depth == 0:
            self.spent += time.monotonic() - self.since


class _Folders(CompileResultCacheImpl):
    """numba's choice of a folder: NUMBA_CACHE_DIR, the package's own or the user's; without a known
    home the last one would lie wherever the program is run."""

    _locator_classes = [
        place
        for place in CompileResultCacheImpl._locator_classes
        if "UserWide" not in place.__name__ or os.path.isabs(os.path.expanduser("~"))
    ]


class _Files(IndexDataCacheFile):
    """numba's files, each behind a digest."""

    def _load_index(self) -> dict:
        try:
            version, stamp, overloads = self._read(self._index_path)
        except OSError:
            return {}
        fresh = (version, stamp) == (numba.__version__, self._source_stamp)
        return overloads if fresh else {}

    def _save_index(self, overloads: dict) -> None:
        self._write(self._index_path, (numba.__version__, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        return self._read(self._data_path(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _write(self, path: str, value: Any) -> None:
        content = dumps(value)
        with self._open_for_write(path) as file:
            file.write(hashlib.sha256(content).digest() + content)

    def _read(self, path: str) -> Any:
        content = Path(path).read_bytes()
        if hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
            raise OSError(f"{path} is damaged")
        return pickle.loads(content[DIGEST:])


class _Cache(FunctionCache):
    """numba's cache of one function in the folder numba chooses, under the package's stamp.

    Files bear no line numbers, so that those of an edited function are overwritten.
    """

    watch = _Watch()
    _impl_class = _Folders

    def __init__(self, function: Callable) -> None:
        super().__init__(function)
        version = sys.implementation.cache_tag + getattr(sys, "abiflags", "")
        name = f"{function.__module__}.{function.__qualname__}.{version}"
        self._cache_file = _Files(self.cache_path, name, stamp(_package(function)))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code for a signature from the disk, or None."""
        found = super().load_overload(sig, target_context)
        if found is None:
            self.watch.start()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep machine code."""
        self.watch.stop()
        try:
            super().save_overload(sig, data)
        except OSError as error:
            self.watch.say_once(f"{self.cache_path} cannot be written to ({error.strerror})")


def _package(function: Callable) -> Path:
    """Folder of the outermost package that the function's module belongs to."""
    inner = function.__module__.count(".")
    return Path(function.__code__.co_filename).parents[max(inner - 1, 0)]


@functools.cache
def stamp(package: Path) -> str:
    """Digest of the text of all files below the folder that name this module."""
    texts = (file.read_bytes() for file in sorted(package.rglob("*.py")))
    return hashlib.sha256(b"\0".join(text for text in texts if MARK in text)).hexdigest()
