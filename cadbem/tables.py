"""Aligned tables, as text and as HTML for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

Row = Sequence[str]
MOST = 12  # rows of an overview
LONGEST = 48  # letters of a value in it
ROUNDING = 1e-9


@dataclass(frozen=True)
class Overview:
    """What a value says of itself when it is printed: a ``title``, ``facts``, and a table."""

    title: str
    facts: tuple[str, ...] = ()
    head: Row = ()
    rows: tuple[Row, ...] = ()

    def text(self) -> str:
        """Lines, without those facts that are empty; long tables are cut."""
        lines = [self.title, *(f"  {fact}" for fact in self.facts if fact)]
        if self.rows:
            table = text_table(self.head, self.rows[:MOST])
            lines += [f"  {line}" for line in table.splitlines()]
        more = len(self.rows) - MOST
        return "\n".join([*lines, f"  and {more} more"] if more > 0 else lines)

    def html(self) -> str:
        """The same for a notebook."""
        facts = "".join(f"<div>{escape(fact)}</div>" for fact in self.facts if fact)
        table = html_table(self.head, self.rows) if self.rows else ""
        return f"<div><b>{escape(self.title)}</b></div>{facts}{table}"


def brief(value: Any) -> str:
    """A value in a few letters on one line."""
    text = " ".join((value if isinstance(value, str) else repr(value)).split())
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def numbers(values: Iterable[float]) -> str:
    """A vector, as in "(1, 0.5, 0)"."""
    return f"({', '.join(rounded(values, 4))})"


def rounded(values: Iterable[float], digits: int = 5) -> list[str]:
    """Numbers of the same kind with so many digits; what is nothing but rounding beside the
    largest is 0."""
    known = [float(value) for value in values]
    small = ROUNDING * max(map(abs, known), default=0.0)
    return [f"{v if abs(v) > small else 0:.{digits}g}" for v in known]


def count(number: int, thing: str) -> str:
    """As in "1 patch", "6 patches"."""
    ending = "" if number == 1 else "es" if thing.endswith(("ch", "s")) else "s"
    stem = thing[:-1] + "ie" if number != 1 and thing.endswith("dy") else thing
    return f"{number} {stem}{ending}"


def text_table(head: Row, rows: Iterable[Row]) -> str:
    """Lines of text with columns as wide as they need to be, aligned on the right."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
        for line in lines
    )


def html_table(head: Row, rows: Iterable[Row]) -> str:
    """The same table for a notebook."""
    cells = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    lines = [f"<tr>{cells}</tr>"]
    for row in rows:
        lines.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>")
    return f"<table>{''.join(lines)}</table>"
