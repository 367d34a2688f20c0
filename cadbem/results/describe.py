"""A value of nested frozen dataclasses as flat text, to tell whether two runs ask for the same."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

LONGEST = 4  # numbers of an array that are written out; more become a digest
DIGITS = 9  # of the largest number, that count: another machine may round differently


def described(value: Any, name: str = "") -> dict[str, str]:
    """Each leaf of a value by its path, such as ``flow.problem.viscosity``, as text."""
    return dict(_leaves(value, name))


def _leaves(value: Any, name: str) -> Iterator[tuple[str, str]]:
    if is_dataclass(value) and not isinstance(value, type):
        yield name, type(value).__name__
        for field in fields(value):
            yield from _leaves(getattr(value, field.name), f"{name}.{field.name}".lstrip("."))
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(item, f"{name}[{key!r}]")
    elif isinstance(value, np.ndarray):
        yield name, _array(value)
    elif isinstance(value, list | tuple):
        for k, item in enumerate(value):
            yield from _leaves(item, f"{name}[{k}]")
    elif callable(value):
        yield name, getattr(value, "__qualname__", type(value).__name__)
    else:
        yield name, repr(value)


def _array(values: np.ndarray) -> str:
    if values.size <= LONGEST:
        return str(values.tolist())
    if np.issubdtype(values.dtype, np.floating):
        values = np.round(values / (abs(values).max() or 1.0), DIGITS) + 0.0
    digest = hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()[:16]
    return f"{'x'.join(map(str, values.shape))} numbers, {digest}"


def first_difference(old: Mapping[str, str], new: Mapping[str, str]) -> str:
    """What differs first, as 'name: old, now new'; empty when nothing does."""
    for name in [*new, *(n for n in old if n not in new)]:
        before, now = old.get(name, "nothing"), new.get(name, "nothing")
        if before != now:
            return f"{name or 'it'}: {before} then, {now} now"
    return ""
