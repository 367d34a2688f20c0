"""Machine code of Python functions, kept on disk until one of the files that it came from changes.

numba's own cache looks at the file of the function alone and so misses an edit of a function that
another file calls.  Here the code is kept under a stamp of all files of the package that hold
compiled functions.  One rule follows: numbers that a compiled function takes from its module stand
in such a file themselves.
"""

from __future__ import annotations

import functools
import hashlib
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache, IndexDataCacheFile

MARK = b"cadbem.compiled"  # every file with compiled functions imports this module


def compiled(function: Callable | None = None, /, **options: Any) -> Any:
    """Decorator: `numba.njit` without the interpreter's lock, its machine code kept on disk.

    The options are those of `njit`.  Where no folder can be written to, nothing is kept.
    """
    if function is None:
        return functools.partial(compiled, **options)
    defaults: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
    dispatcher: Any = njit(**defaults | options)(function)
    with suppress(RuntimeError):  # numba says so when it finds no folder that it can write to
        dispatcher._cache = _Cache(function)
    return dispatcher


class _Cache(FunctionCache):
    """numba's cache of one function in the folder numba chooses, under the package's stamp.

    Files bear no line numbers, so that those of an edited function are overwritten.
    """

    def __init__(self, function: Callable) -> None:
        super().__init__(function)
        version = sys.implementation.cache_tag + getattr(sys, "abiflags", "")
        name = f"{function.__module__}.{function.__qualname__}.{version}"
        self._cache_file = IndexDataCacheFile(self.cache_path, name, stamp(_package(function)))


def _package(function: Callable) -> Path:
    """Folder of the outermost package that the function's module belongs to."""
    inner = function.__module__.count(".")
    return Path(function.__code__.co_filename).parents[max(inner - 1, 0)]


@functools.cache
def stamp(package: Path) -> str:
    """Digest of the text of all files below the folder that hold compiled functions."""
    texts = (file.read_bytes() for file in sorted(package.rglob("*.py")))
    return hashlib.sha256(b"\0".join(text for text in texts if MARK in text)).hexdigest()
