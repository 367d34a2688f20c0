"""The values of a sweep, read from the text that a user writes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from cadbem.errors import CadbemError

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
RANGE = re.compile(rf"({NUMBER}):({NUMBER}):(\d+)(:log)?(\s+\S.*)?")
LIST = re.compile(rf"({NUMBER}(?:,{NUMBER})+)(\s+\S.*)?")
LIKELY = re.compile(rf"{NUMBER}[:,]")  # what was meant to be one of these
DIGITS, MOST = 12, 100_000


def parsed(arguments: Sequence[str]) -> tuple[dict[str, list[str]], list[str]]:
    """The swept options with their values, as words, and all other arguments.

    ``--capillary 0.05:0.4:8`` has 8 values evenly spaced, ``1:1000:4:log`` evenly in proportion,
    ``1,2,5`` those given; a unit may follow after a space.  Raises ``CadbemError`` when nothing is
    swept, one option twice, or values are not understood.
    """
    swept: dict[str, list[str]] = {}
    others: list[str] = []
    for option, value in _options(arguments):
        values = values_of(value) if value else []
        if not values:
            others.append(option if value is None else f"{option}={value}")
        elif option in swept:
            raise CadbemError(f"{option} is swept twice; give all its values at once")
        else:
            swept[option] = values
    if not swept:
        raise CadbemError(
            "nothing to sweep: give an option of the script several values, such as "
            "--capillary 0.05:0.4:8 or --points 100,200"
        )
    return {option[2:]: values for option, values in swept.items()}, others


def _options(arguments: Sequence[str]) -> Iterator[tuple[str, str | None]]:
    """Options with their values, None where there is none."""
    words = list(arguments)
    while words:
        option, given, value = words.pop(0).partition("=")
        if not option.startswith("--"):
            raise CadbemError(
                f"'{option}' belongs to no option of the script; write --name {option}"
            )
        if given:
            yield option, value
        elif words and not words[0].startswith("--"):
            yield option, words.pop(0)
        else:
            yield option, None


def values_of(text: str) -> list[str]:
    """The values that a range or a list stands for; none for any other text."""
    if found := RANGE.fullmatch(text):
        first, last, count = float(found[1]), float(found[2]), int(found[3])
        if not 1 <= count <= MOST:
            raise CadbemError(f"'{text}': the count is {count}; it must be from 1 to {MOST}")
        if found[4] and not first * last > 0:
            raise CadbemError(f"'{text}': with ':log' both ends must be on one side of zero")
        spread = np.geomspace if found[4] else np.linspace
        return [_text(value, found[5]) for value in spread(first, last, count)]
    if found := LIST.fullmatch(text):
        return [_text(float(value), found[2]) for value in found[1].split(",")]
    if LIKELY.match(text):
        raise CadbemError(
            f"'{text}' is not understood; values are first:last:count, first:last:count:log or a "
            "list 1,2,5; a unit follows after a space"
        )
    return []


def _text(value: float, unit: str | None) -> str:
    return f"{value:.{DIGITS}g}{unit or ''}"


def points_of(swept: dict[str, list[str]]) -> list[dict[str, str]]:
    """Every combination of the values, the last option's varying fastest."""
    return [dict(zip(swept, values, strict=True)) for values in product(*swept.values())]
