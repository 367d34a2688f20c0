"""The text of an IGES file (version 5.3) taken apart into sections, and checked on the way.

Lines are numbered, counted at the end, and refer to each other; so lines that are missing, doubled
or in disorder are found. The CAD kernel gives no message in such cases.
"""

from __future__ import annotations

import re
from math import prod

from cadbem.cad.text.spline_checks import check_knots, check_weights

SECTIONS = "SGDPT"
_NUMBER = re.compile(r"[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[EeDd][+-]?\d++)?")
_STRING = re.compile(r" *+(\d{1,9}+)H")
_SPACES = re.compile(r"\s*+")
_CURVE, _SURFACE = 126, 128


def sections(text: str) -> dict[str, list[str]]:
    """The lines of each section; raises ValueError, naming the place, where they are not IGES."""
    lines = [line.rstrip("\r") for line in text.rstrip("\0\x1a \r\n").split("\n")]
    found: dict[str, list[str]] = {letter: [] for letter in SECTIONS}
    latest = 0
    for number, line in enumerate(lines, start=1):
        order = SECTIONS.find(line[72:73] or "?")
        place = re.fullmatch(r" *(\d+) *", line[73:80])
        if order < latest or not place or int(place[1]) != len(found[SECTIONS[order]]) + 1:
            raise ValueError(f"line {number} is not where it belongs")
        latest = order
        found[SECTIONS[order]].append(line)
    counts = re.findall(r"([SGDP]) *(\d+)", found["T"][0][:72] if found["T"] else "")
    for letter, count in counts:
        if len(found[letter]) != int(count):
            raise ValueError(f"section {letter} has {len(found[letter])} lines instead of {count}")
    if len(counts) != 4 or len(found["D"]) % 2:
        raise ValueError("the last line or half an entity is missing")
    return found


def check_parameters(kind: int, place: str, words: list[str]) -> None:
    """Raises ValueError if an entity's words are not its numbers and strings, in the right number.

    Strings begin with an apostrophe here, as `words` gives them.
    """
    for word in words:
        if not (word == "" or word[0] == "'" or _NUMBER.fullmatch(word)):
            raise ValueError(f"'{word[:30]}' in {place} is not a number")
    if not words or words[0] != str(kind):
        raise ValueError(f"the parameters of {place} are those of another entity")
    if kind in (_CURVE, _SURFACE):
        _check_spline(words, 1 + (kind == _SURFACE), place)


def _check_spline(words: list[str], dimension: int, place: str) -> None:
    """Upper indices, degrees, properties, knots, weights, points, range."""
    counts = [int(word) + 1 for word in words[1 : 1 + dimension]]
    degrees = [int(word) for word in words[1 + dimension : 1 + 2 * dimension]]
    start, total = 4 + 3 * dimension, prod(counts)
    if len(words) < start + sum(counts) + sum(degrees) + dimension + 4 * total:
        raise ValueError(f"{place} has fewer numbers than it says")
    for count, degree in zip(counts, degrees, strict=True):
        stop = start + count + degree + 1
        check_knots([number(word) for word in words[start:stop]], degree, count, place)
        start = stop
    check_weights([number(word) for word in words[start : start + total]], place)


def number(word: str) -> float:
    """A number as IGES writes it; nothing is zero."""
    return float(word.upper().replace("D", "E") or 0)


def words(text: str, separator: str, end: str) -> list[str]:
    """Parameters up to the end of the record; strings (`5Habc,d`) may hold separators and come with
    an apostrophe before them."""
    found, position = [], 0
    before = re.compile(rf"[^{re.escape(separator + end)}]*+")
    while position < len(text):
        string = _STRING.match(text, position)
        if string:
            stop = string.end() + int(string[1])
            word, position = "'" + text[string.end() : stop], min(stop, len(text))
            position += len(_SPACES.match(text, position)[0])  # type: ignore[index]
        else:
            plain = before.match(text, position)
            assert plain is not None
            word, position = plain[0].strip(), plain.end()
        found.append(word)
        if text[position : position + 1] == end:
            break
        position += 1
    return found
