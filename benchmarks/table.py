"""Tables of measurements as Markdown, and measurements in a process of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path


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


def write(name: str, path: Path) -> None:
    """Run a benchmark, print its tables, and write them to a file."""
    tables = import_module(f"benchmarks.{name}").tables()
    show(tables)
    path.write_text("\n".join(table.markdown() for table in tables))


def fresh(module: str, *words: str, **environment: str) -> dict[str, float]:
    """Numbers that `python -m benchmarks.MODULE WORDS` prints last, as JSON."""
    command = [sys.executable, "-m", f"benchmarks.{module}", *words]
    done = subprocess.run(
        command, env=os.environ | environment, stdout=subprocess.PIPE, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


def least(rounds: Iterable[dict[str, float]]) -> dict[str, float]:
    """The smallest of each number over several rounds."""
    kept = list(rounds)
    return {key: min(numbers[key] for numbers in kept) for key in kept[0]}


if __name__ == "__main__":
    write(sys.argv[1], Path(sys.argv[2]))
