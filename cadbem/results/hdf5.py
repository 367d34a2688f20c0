"""HDF5 files with a digest of their content, of which only plain numbers are read.

A file that somebody else gives away may hold anything: links to other files, data that lie in other
files, shapes far beyond its own size.  What a run writes are groups of contiguous arrays of numbers
with a few attributes, and nothing else is read.  The digest stands before the HDF5 file, in what
HDF5 calls its user block: other programs read the file as it is.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from math import prod
from pathlib import Path
from typing import Any

import h5py

from cadbem.errors import CadbemError, ResultsError
from cadbem.files import as_results_error, write_whole

BLOCK = 512  # bytes before the HDF5 file
MARK = b"cadbem sha256 "
MOST_BYTES = 2**31  # of a file that is read
LONGEST = 10_000  # numbers of an attribute
# what decoding may raise where a file is not what a run writes
ODD = (LookupError, ValueError, TypeError, ArithmeticError, AttributeError, OSError, RuntimeError)


class Writing:
    """``with Writing(path) as file``: an HDF5 file that appears at once when the block ends."""

    def __init__(self, path: Path) -> None:
        self._path, self._memory = path, BytesIO()

    def __enter__(self) -> h5py.File:
        self._file = h5py.File(self._memory, "w", userblock_size=BLOCK)
        return self._file

    def __exit__(self, kind: object, *reference: object) -> None:
        self._file.close()
        if kind is None:
            content = self._memory.getvalue()[BLOCK:]
            write_whole(self._path, _digest(content).ljust(BLOCK, b"\0") + content)


def is_sound(path: Path) -> bool:
    """Whether the file is there, and as it was written to the last bit."""
    try:
        _content(path, "")
    except ResultsError:
        return False
    return True


@contextmanager
def reading(path: Path, remedy: str = "put back a sound copy") -> Iterator[Stored]:
    """The file, to read what ``Writing`` wrote.

    Raises ``ResultsError``, which names the file and the ``remedy``, when it is missing or damaged,
    or holds anything else than a run writes.
    """
    content = _content(path, remedy)
    try:
        with h5py.File(BytesIO(content), "r") as file:
            yield Stored(file, len(content))
    except ResultsError:
        raise
    except (CadbemError, *ODD) as error:
        what = " ".join(str(error).split())[:100]
        raise ResultsError(f"{path} is not what a run writes ({what}); {remedy}") from error


class Stored:
    """A group in a file of ``size`` bytes, by the interface of h5py's; data of another kind than a
    run writes raise ``ValueError``."""

    def __init__(self, group: h5py.Group, size: int) -> None:
        self._group, self._size = group, size

    @property
    def attrs(self) -> Mapping[str, Any]:
        """The attributes."""
        return _attributes(self._group)

    def __iter__(self) -> Iterator[str]:
        return iter(self._group)

    def __len__(self) -> int:
        return len(self._group)

    def __contains__(self, name: str) -> bool:
        return name in self._group

    def __getitem__(self, name: str) -> Any:
        first, _, rest = name.partition("/")
        if not isinstance(self._group.get(first, getlink=True), h5py.HardLink):
            raise ValueError(f"'{first}' is missing or a link")
        item = self._group[first]
        if isinstance(item, h5py.Group):
            group = Stored(item, self._size)
            return group[rest] if rest else group
        if rest or not isinstance(item, h5py.Dataset):
            raise ValueError(f"'{first}' is no group")
        return StoredNumbers(item, self._size)

    def get(self, name: str, otherwise: Any) -> Any:
        """The item of a name, if there is one."""
        if name not in self:
            return otherwise
        return self[name]

    def items(self) -> Iterator[tuple[str, Any]]:
        """All items."""
        return ((name, self[name]) for name in self)


class StoredNumbers:
    """An array of numbers in a file of ``size`` bytes, contiguous and within the file."""

    def __init__(self, data: h5py.Dataset, size: int) -> None:
        within = data.id.get_storage_size() == data.nbytes <= size
        plain = data.chunks is None and data.external is None and not data.is_virtual
        if not (within and plain) or data.dtype.kind not in "fiu":
            raise ValueError(f"'{data.name}' is no plain array of numbers")
        self._data = data

    @property
    def attrs(self) -> Mapping[str, Any]:
        """The attributes."""
        return _attributes(self._data)

    def __getitem__(self, key: Any) -> Any:
        return self._data[key]


def _attributes(item: Any) -> dict[str, Any]:
    for name in item.attrs:
        if prod(item.attrs.get_id(name).shape) > LONGEST:
            raise ValueError(f"the attribute '{name}' is too long")
    return dict(item.attrs)


def _content(path: Path, remedy: str) -> bytes:
    """All bytes of a file; the digest must be that of what follows it."""
    if not os.path.isfile(path):
        raise ResultsError(f"{path} is missing; {remedy}")
    if path.stat().st_size > MOST_BYTES:
        raise ResultsError(f"{path} is too large to be what a run writes; {remedy}")
    with as_results_error(path):
        content = path.read_bytes()
    if content[:BLOCK].rstrip(b"\0") != _digest(content[BLOCK:]):
        raise ResultsError(f"{path} is damaged (its digest is that of something else); {remedy}")
    return content


def _digest(content: bytes) -> bytes:
    return MARK + hashlib.sha256(content).hexdigest().encode()
