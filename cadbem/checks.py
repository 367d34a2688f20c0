"""Checks of what users give: an error names the parameter, its value, and what to give instead.

Every public function and class checks its arguments with these, before anything is worked out.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import inf, isfinite
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadbem.errors import InputError

LONGEST = 60  # letters of a value that a message shows


def finite(name: str, value: Any) -> float:
    """A finite number."""
    return _within(name, value, -inf, inf, "a finite number")


def positive(name: str, value: Any) -> float:
    """A finite number above 0."""
    _within(name, value, 0.0, inf, "a finite number above 0")
    return value if value > 0 else _refused(name, value, "a finite number above 0")


def not_negative(name: str, value: Any) -> float:
    """A finite number, 0 or above."""
    return _within(name, value, 0.0, inf, "a finite number, 0 or above")


def within(name: str, value: Any, low: float, high: float) -> float:
    """A number from ``low`` to ``high``."""
    return _within(name, value, low, high, f"a number from {low:g} to {high:g}")


def whole(name: str, value: Any, least: int = 1, most: float = inf) -> int:
    """A whole number from ``least`` to ``most``."""
    if not _is_number(value) or isinstance(value, bool) or not isinstance(value, Integral):
        _refused(name, value, f"a whole number, {least} or above")
    upper = "" if most == inf else f" to {most:g}"
    what = f"a whole number from {least}{upper}" if upper else f"a whole number, {least} or above"
    return int(_within(name, value, least, most, what))


def one_of(name: str, value: Any, choices: Collection[Any]) -> Any:
    """One of some words or numbers."""
    if isinstance(value, np.ndarray) or value not in choices:
        _refused(name, value, f"one of {', '.join(repr(choice) for choice in choices)}")
    return value


def instance(name: str, value: Any, kind: Any, what: str) -> Any:
    """A value of a type, said in words: ``what``, such as "a boundary, as from read_cad"."""
    return value if isinstance(value, kind) else _refused(name, value, what)


def offers(name: str, value: Any, attributes: Sequence[str], what: str) -> Any:
    """A value that has some attributes, said in words: ``what``."""
    fits = all(hasattr(value, attribute) for attribute in attributes)
    return value if fits and not isinstance(value, type) else _refused(name, value, what)


def shaped(name: str, value: ArrayLike, *shape: int | None) -> NDArray[np.float64]:
    """Finite numbers as an array of a shape, in which None stands for any length."""
    lengths = ", ".join("N" if n is None else str(n) for n in shape)
    what = f"finite numbers of shape ({lengths}{',' if len(shape) == 1 else ''})"
    array = _numbers(name, value, what)
    fits = array.ndim == len(shape) and all(
        n in (None, m) for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise InputError(f"{name} has shape {array.shape}; give {what}")
    return array


def positive_array(name: str, value: ArrayLike, *shape: int | None) -> NDArray[np.float64]:
    """Finite numbers above 0 as an array of a shape, in which None stands for any length."""
    array = shaped(name, value, *shape)
    return array if (array > 0).all() else _refused(name, value, "numbers that are all above 0")


def vector(name: str, value: ArrayLike, dimension: int) -> NDArray[np.float64]:
    """A finite vector (dim,); the number 0 stands for a vector of zeros."""
    if not _is_number(value):
        return shaped(name, value, dimension)
    if value != 0:
        _refused(name, value, f"a vector of {dimension} finite numbers")
    return np.zeros(dimension)


def direction(name: str, value: ArrayLike, dimension: int) -> NDArray[np.float64]:
    """A finite vector (dim,) that is not 0, as a unit vector."""
    given = shaped(name, value, dimension)
    length = float(np.linalg.norm(given))
    return given / length if length > 0 else _refused(name, value, "a vector that is not 0")


def turning(name: str, value: ArrayLike, dimension: int) -> NDArray[np.float64]:
    """A finite vector (3,) about which something turns, or in a plane one finite number."""
    if dimension == 3:
        return vector(name, value, dimension)
    return shaped(name, value) if _is_number(value) else shaped(name, value, 1)


def values_at(name: str, found: Any, shape: Sequence[int]) -> NDArray[np.float64]:
    """What a user's function returned at points, which must be finite numbers of a shape."""
    what = f"a function that returns finite numbers of shape {tuple(shape)} for so many points"
    array = _numbers(f"what {name} returns", found, what)
    if array.shape != tuple(shape):
        raise InputError(f"what {name} returns has shape {array.shape}; give {what}")
    return array


def _within(name: str, value: Any, low: float, high: float, what: str) -> float:
    if not _is_number(value) or not isfinite(value) or not low <= value <= high:
        _refused(name, value, what)
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, Real)


def _numbers(name: str, value: Any, what: str) -> NDArray[np.float64]:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        _refused(name, value, what)
    if not np.isfinite(array).all():
        raise InputError(f"{name} has numbers that are not finite; give {what}")
    return array


def _refused(name: str, value: Any, what: str) -> Any:
    shown = " ".join(repr(value).split())
    shown = shown if len(shown) <= LONGEST else f"{shown[:LONGEST]}..."
    raise InputError(f"{name} is {shown}; give {what}")
