"""Ways to damage the text of a CAD file, seeded, for `test_cad_damaged.py`."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random

END = {"step": b"\nENDSEC;\nEND-ISO-10303-21;\n", "igs": b""}
_NUMBER = {
    "step": re.compile(rb"(?<=[(,])-?\d+\.\d*(?:E[+-]\d+)?(?=[,)])"),
    "igs": re.compile(rb"(?<=,)-?\d*\.\d*(?:D[+-]\d+)?(?=[,;])"),
}
_INTEGER = re.compile(rb"(?<=[(,])\d+(?=[,)])")
Damage = Callable[[bytes, str, Random], bytes]


def data_of(text: bytes, kind: str) -> tuple[int, int]:
    """Where the part with the geometry begins and ends."""
    if kind == "step":
        return text.index(b"DATA;") + 5, text.rindex(b"ENDSEC;")
    lines = text.splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if line[72:73] == b"P")
    return len(b"".join(lines[:first])), len(b"".join(lines[:-1]))


def _picked(text: bytes, kind: str, random: Random) -> re.Match[bytes]:
    """A number with digits other than zero or with a place in the geometry."""
    return random.choice(list(_NUMBER[kind].finditer(text, *data_of(text, kind))))


def _put(text: bytes, found: re.Match[bytes], word: bytes, kind: str) -> bytes:
    """The text with other words in a place; columns of IGES stay where they are."""
    if kind == "step":
        return text[: found.start()] + word + text[found.end() :]
    start = text.rindex(b"\n", 0, found.start()) + 1
    line = text[start : start + 64]
    cut = found.start() - start, found.end() - start
    line = (line[: cut[0]] + word + line[cut[1] :]).rstrip().ljust(64)[:64]
    return text[:start] + line + text[start + 64 :]


def truncated(text: bytes, kind: str, random: Random) -> bytes:
    return text[: random.randrange(len(text) // 20, len(text) - 40)]


def truncated_with_end(text: bytes, kind: str, random: Random) -> bytes:
    """Cut off after a whole line, and ended properly."""
    start, stop = data_of(text, kind)
    cut = text.index(b"\n", random.randrange(start, stop)) + 1
    if kind == "step":
        return text[:cut] + END[kind]
    rows = [line[72:73] for line in text[:cut].splitlines()]
    counts = b"".join(letter + b"%7d" % rows.count(letter) for letter in (b"S", b"G", b"D", b"P"))
    return text[:cut] + counts.ljust(72) + b"T      1\n"


def byte_flipped(text: bytes, kind: str, random: Random) -> bytes:
    place = random.randrange(*data_of(text, kind))
    return text[:place] + bytes([text[place] ^ 1 << random.randrange(8)]) + text[place + 1 :]


def digit_changed(text: bytes, kind: str, random: Random) -> bytes:
    """The first digit that counts of a number, by at least a fifth of it."""
    found = _picked(text, kind, random)
    word = found[0]
    places = [i for i, c in enumerate(word) if chr(c).isdigit()]
    place = next((i for i in places if word[i : i + 1] != b"0"), places[0])
    digit = random.choice([d for d in b"123456789" if d != word[place]])
    return _put(text, found, word[:place] + bytes([digit]) + word[place + 1 :], kind)


def sign_changed(text: bytes, kind: str, random: Random) -> bytes:
    found = _picked(text, kind, random)
    word = found[0]
    return _put(text, found, word[1:] if word.startswith(b"-") else b"-" + word, kind)


def number_replaced(word: bytes) -> Damage:
    def damage(text: bytes, kind: str, random: Random) -> bytes:
        return _put(text, _picked(text, kind, random), word, kind)

    damage.__name__ = f"number_{word.decode()}"
    return damage


def _lines(text: bytes, kind: str) -> tuple[bytes, list[bytes], bytes]:
    start, stop = data_of(text, kind)
    return text[:start], text[start:stop].splitlines(keepends=True), text[stop:]


def lines_shuffled(text: bytes, kind: str, random: Random) -> bytes:
    head, lines, tail = _lines(text, kind)
    random.shuffle(lines)
    return head + b"".join(lines) + tail


def line_deleted(text: bytes, kind: str, random: Random) -> bytes:
    head, lines, tail = _lines(text, kind)
    del lines[random.randrange(len(lines))]
    return head + b"".join(lines) + tail


def line_doubled(text: bytes, kind: str, random: Random) -> bytes:
    head, lines, tail = _lines(text, kind)
    place = random.randrange(len(lines))
    lines.insert(place, lines[place])
    return head + b"".join(lines) + tail


def lines_swapped(text: bytes, kind: str, random: Random) -> bytes:
    head, lines, tail = _lines(text, kind)
    i, j = random.sample(range(len(lines)), 2)
    lines[i], lines[j] = lines[j], lines[i]
    return head + b"".join(lines) + tail


def references_exchanged(text: bytes, kind: str, random: Random) -> bytes:
    """Two references (STEP) or two integers, most of them references (IGES), swap places."""
    pattern = re.compile(rb"(?<=[(,])#\d+(?=[,)])" if kind == "step" else rb"(?<=,)\d+(?=[,;])")
    start, stop = data_of(text, kind)
    found = list(pattern.finditer(text, start, stop))
    first, second = sorted(random.sample(found, 2), key=lambda m: m.start())
    if kind == "step":
        return (text[: first.start()] + second[0] + text[first.end() : second.start()] + first[0]
                + text[second.end() :])  # fmt: skip
    return _put(_put(text, second, first[0], kind), first, second[0], kind)


def reference_redirected(text: bytes, kind: str, random: Random) -> bytes:
    """One reference becomes another one of the file."""
    pattern = re.compile(rb"(?<=[(,])#\d+(?=[,)])" if kind == "step" else rb"(?<=,)\d+(?=[,;])")
    found = list(pattern.finditer(text, *data_of(text, kind)))
    first, second = random.sample(found, 2)
    return _put(text, first, second[0], kind)


def flag_turned(text: bytes, kind: str, random: Random) -> bytes:
    """.T. becomes .F. or the other way round (STEP)."""
    found = random.choice(list(re.finditer(rb"\.[TF]\.", text)))
    return _put(text, found, b".F." if found[0] == b".T." else b".T.", "step")


def section_removed(text: bytes, kind: str, random: Random) -> bytes:
    start, stop = data_of(text, kind)
    return text[:start] + b"\n" + text[stop:]


def header_removed(text: bytes, kind: str, random: Random) -> bytes:
    if kind == "step":
        return re.sub(rb"HEADER;.*?ENDSEC;\n", b"", text, count=1, flags=re.DOTALL)
    return b"".join(line for line in text.splitlines(keepends=True) if line[72:73] != b"G")


def count_made(word: bytes) -> Damage:
    """An integer of a list becomes another: degrees, multiplicities, counts."""

    def damage(text: bytes, kind: str, random: Random) -> bytes:
        pattern = _INTEGER if kind == "step" else re.compile(rb"(?<=,)\d+(?=[,;])")
        found = list(pattern.finditer(text, *data_of(text, kind)))
        if kind == "igs":  # of splines and composite curves
            found = [m for m in found if re.match(rb"(12[68]|102|144),", _record(text, m))]
        return _put(text, random.choice(found), word, kind)

    damage.__name__ = f"count_{word.decode()}"
    return damage


def _record(text: bytes, found: re.Match[bytes]) -> bytes:
    """The first line of the entity that a place is in."""
    start = text.rindex(b"\n", 0, found.start()) + 1
    pointer = text[start + 64 : start + 72]
    lines = text[:start].splitlines() + [text[start : start + 80]]
    return next(line for line in lines if line[64:73] == pointer + b"P").lstrip()


def nested(text: bytes, kind: str, random: Random) -> bytes:
    return _put(text, _picked(text, kind, random), b"(" * 100_000 + b"1." + b")" * 100_000, kind)


def null_bytes(text: bytes, kind: str, random: Random) -> bytes:
    place = random.randrange(*data_of(text, kind))
    return text[:place] + bytes(4) + text[place + 4 :]


def not_ascii(text: bytes, kind: str, random: Random) -> bytes:
    place = random.randrange(*data_of(text, kind))
    return text[:place] + "ü".encode() + text[place + 2 :]


def utf_16(text: bytes, kind: str, random: Random) -> bytes:
    return text.decode().encode("utf-16")


def crlf(text: bytes, kind: str, random: Random) -> bytes:
    return text.replace(b"\n", b"\r\n")


def marked(text: bytes, kind: str, random: Random) -> bytes:
    return b"\xef\xbb\xbf" + text


def tail_of_nulls(text: bytes, kind: str, random: Random) -> bytes:
    return text + bytes(512)
