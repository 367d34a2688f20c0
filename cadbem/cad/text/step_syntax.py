"""The text of a STEP file (ISO 10303-21) taken apart into entities, and checked on the way.

The CAD kernel repairs damaged text without a message, or does not end; so text that the standard
does not allow is refused here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import accumulate

DEEPEST = 50  # brackets within brackets; the kernel's parser calls itself for each
# Each pattern takes a time proportional to the length of the text, whatever that is: what may be
# long is taken once (++, *+), and what has no end is taken to the end.
_BLANK = re.compile(r"('[^']*')|/\*.*?(?:\*/|\Z)|\s+", re.DOTALL)
_MARK = re.compile(r"'[^']*(?:'|\Z)|;")
_ENTITY = re.compile(r"#(\d{1,18})=(.*)", re.DOTALL)
_NUMBER = r"[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[Ee][+-]?\d++)?"
_ATOM = rf"(?:#\d{{1,18}}+|{_NUMBER}|\.\w++\.|(?:'[^']*')++|\"[^\"]*\"|\$|\*)"
_BODY = re.compile(
    rf"(?>(?:!?[A-Za-z_]\w*)?\((?!,)|{_ATOM}(?=[,)])|,(?![,)])|\)(?=[,)!A-Za-z_]|\Z))++"
)
_REFERENCE = re.compile(r"'[^']*'|#(\d+)")  # strings are passed over


def entities(text: str) -> dict[int, str]:
    """The bodies of all entities by number, without blanks and comments.

    Raises ValueError, naming the place, where the text is not STEP.
    """
    text = _BLANK.sub(lambda found: found[1] or "", text)
    found: dict[int, str] = {}
    inside, end, last = False, 0, ""
    for words, stop in _statements(text):
        end = stop
        if words == "ENDSEC":
            inside = False
        elif words == "END-ISO-10303-21":
            return found
        elif re.fullmatch(r"DATA(\(.*\))?", words):
            inside = True
        elif inside:
            number, body = _entity(words, last)
            if found.get(number, body) != body:
                raise ValueError(f"#{number} stands for two things")
            found[number] = body
            last = f"#{number}"
    raise ValueError(f"'{text[end : end + 30]}' has no end" if text[end:] else "no end")


def _statements(text: str) -> Iterator[tuple[str, int]]:
    """What stands before each semicolon outside of strings, and where it ends."""
    start = 0
    for mark in _MARK.finditer(text):
        if mark[0] == ";":
            yield text[start : mark.start()], mark.end()
            start = mark.end()


def without_strings(body: str) -> str:
    """The body with nothing in the place of its strings."""
    return re.sub(r"'[^']*'", "", body)


def references(body: str) -> list[int]:
    """Numbers of the entities that a body refers to."""
    return [int(number) for number in _REFERENCE.findall(body) if number]


def dangling(found: dict[int, str]) -> list[tuple[int, int]]:
    """Pairs of entities: one that refers, and the missing one."""
    return [
        (number, reference)
        for number, body in found.items()
        for reference in references(body)
        if reference not in found
    ]


def decoded(text: str) -> str:
    """Undo the escapes of STEP strings: doubled apostrophes, \\X\\ and \\X2\\ code points."""
    text = re.sub(
        r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\",
        lambda m: bytes.fromhex(m[1]).decode("utf-16-be", errors="replace"),
        text,
    )
    text = re.sub(r"\\X\\([0-9A-F]{2})", lambda m: chr(int(m[1], 16)), text)
    return text.replace("''", "'")


def _entity(words: str, last: str) -> tuple[int, str]:
    entity = _ENTITY.fullmatch(words)
    if entity is None or not _is_sound(entity[2]):
        after = f" after {last}" if last else ""
        raise ValueError(f"'{words[:40]}'{after} is not STEP")
    return int(entity[1]), entity[2]


def _is_sound(body: str) -> bool:
    """Words, numbers, commas and brackets stand where they may."""
    if not _BODY.fullmatch(body):
        return False
    if body.count("(") == body.count(")") == 1:
        return body.endswith(")")
    brackets = re.sub(r"[^()]+", "", without_strings(body))
    depths = list(accumulate(1 if bracket == "(" else -1 for bracket in brackets))
    return depths[-1] == 0 and min(depths[:-1]) > 0 and max(depths) <= DEEPEST


def records(body: str) -> dict[str, list]:
    """Parameters by keyword; lists become lists, all else stays a word.

    One record for most entities, several for those that are many things at once.
    """
    stack: list[list] = [[]]
    for word in re.findall(r"(?:'[^']*')+|[()]|[^(),']+", body):
        if word == "(":
            stack[-1].append([])
            stack.append(stack[-1][-1])
        elif word == ")":
            stack.pop()
        else:
            stack[-1].append(word)
    parts = stack[0][0] if isinstance(stack[0][0], list) else stack[0]
    return dict(zip(parts[::2], parts[1::2], strict=True))
