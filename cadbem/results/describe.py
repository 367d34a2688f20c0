"""A value of nested frozen dataclasses as flat text, to compare the definitions of two runs."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from types import CodeType, FunctionType, MethodType
from typing import Any

import numpy as np

LONGEST = 4  # numbers of an array that are written out; more become a digest
PLAIN = (str, bytes, int, float, complex, np.generic, type(None), type)
DEEPEST = 300  # letters of a path, beyond which values that hold each other are not followed
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
    elif isinstance(value, FunctionType | MethodType):
        yield from _function(value, name)
    elif isinstance(value, partial):
        yield from _leaves((value.func, value.args, value.keywords), name)
    elif isinstance(value, PLAIN):
        yield name, repr(value)
    elif len(name) < DEEPEST:
        yield name, getattr(value, "__qualname__", type(value).__qualname__)
        for key, item in getattr(value, "__dict__", {}).items():
            yield from _leaves(item, f"{name}.{key}")


def _function(value: FunctionType | MethodType, name: str) -> Iterator[tuple[str, str]]:
    """A function by its name; those of users by what they do, too, and what they close over."""
    if value.__module__.startswith("cadbem."):
        yield name, value.__qualname__
        return
    yield name, f"{value.__qualname__}, {_digest(repr(_instructions(value.__code__)).encode())}"
    closure = inspect.getclosurevars(value)
    yield from _leaves(dict(closure.nonlocals), f"{name}.closure")
    yield from _leaves(value.__defaults__ or (), f"{name}.defaults")
    if isinstance(value, MethodType):
        yield from _leaves(value.__self__, f"{name}.self")


def _instructions(code: CodeType) -> tuple:
    inner = [_instructions(c) if isinstance(c, CodeType) else c for c in code.co_consts]
    return code.co_code, code.co_names, inner


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _array(values: np.ndarray) -> str:
    if values.size <= LONGEST:
        return str(values.tolist())
    if np.issubdtype(values.dtype, np.floating):
        values = np.round(values / (abs(values).max() or 1.0), DIGITS) + 0.0
    digest = _digest(np.ascontiguousarray(values).tobytes())
    return f"{'x'.join(map(str, values.shape))} numbers, {digest}"


def first_difference(old: Mapping[str, str], new: Mapping[str, str]) -> str:
    """The first difference, as 'name: old, now new'; empty when there is none."""
    for name in [*new, *(n for n in old if n not in new)]:
        before, now = old.get(name, "nothing"), new.get(name, "nothing")
        if before != now:
            return f"{name or 'it'}: {before:.60} then, {now:.60} now"
    return ""
