"""What a user writes for the values of a sweep."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import product

import numpy as np

from cadbem.errors import CadbemError

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
RANGE = re.compile(rf"({NUMBER}):({NUMBER}):(\d+)(:log)?(\s+\S.*)?")
LIST = re.compile(rf"({NUMBER}(?:,{NUMBER})+)(\s+\S.*)?")
DIGITS = 12

Options = list[tuple[str, str]]


def parsed(arguments: Sequence[str]) -> tuple[dict[str, list[str]], list[str]]:
    """The swept options with their values, as words, and all other arguments.

    ``--capillary 0.05:0.4:8`` has 8 values evenly spaced, ``1:1000:4:log`` evenly in proportion,
    ``1,2,5`` those given; a unit may follow after a space.  Raises ``CadbemError`` when nothing is
    swept.
    """
    swept, others, words = {}, [], iter(arguments)
    for word in words:
        name, given, value = word.partition("=")
        if word.startswith("--") and not given:
            value = next(words, "")
        values = values_of(value) if word.startswith("--") else []
        if values:
            swept[name[2:]] = values
        else:
            others += [word] if given or not word.startswith("--") else [word, value]
    if not swept:
        raise CadbemError(
            "nothing to sweep: give an option of the script several values, such as "
            "--capillary 0.05:0.4:8 or --points 100,200"
        )
    return swept, [word for word in others if word]


def values_of(text: str) -> list[str]:
    """The values that a range or a list stands for; none for any other text."""
    if found := RANGE.fullmatch(text):
        first, last, count = float(found[1]), float(found[2]), int(found[3])
        if found[4] and not first * last > 0:
            raise CadbemError(f"'{text}': with ':log' both ends must be on one side of zero")
        spread = np.geomspace if found[4] else np.linspace
        return [_text(value, found[5]) for value in spread(first, last, count)]
    if found := LIST.fullmatch(text):
        return [_text(float(value), found[2]) for value in found[1].split(",")]
    return []


def _text(value: float, unit: str | None) -> str:
    return f"{value:.{DIGITS}g}{unit or ''}"


def points_of(swept: dict[str, list[str]]) -> list[dict[str, str]]:
    """Every combination of the values, the last option's varying fastest."""
    return [dict(zip(swept, values, strict=True)) for values in product(*swept.values())]
