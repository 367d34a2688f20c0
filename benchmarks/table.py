"""A table of measurements as Markdown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """Numbers in words: a title, what they are and how they were measured, columns, rows."""

    title: str
    text: str
    head: tuple[str, ...]
    rows: list[tuple[str, ...]]

    def markdown(self) -> str:
        """The table under its title; all columns but the first flush right."""
        rule = ("---", *("---:" for _ in self.head[1:]))
        lines = ("| " + " | ".join(cells) + " |" for cells in (self.head, rule, *self.rows))
        return f"### {self.title}\n\n{self.text.strip()}\n\n" + "\n".join(lines) + "\n"


def show(tables: Iterable[Table]) -> None:
    """Print each table as soon as it is there."""
    for table in tables:
        print(table.markdown(), flush=True)
