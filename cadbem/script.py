"""Turns a workflow's ``main`` into a command: each keyword argument becomes an option."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from cadbem.errors import CadbemError


def run(main: Callable[..., Any], arguments: list[str] | None = None) -> Any:
    """Call ``main`` with its defaults, changed by options of the command line.

    The type of a default is the type of its option; ``output`` also answers to -o.  The text at
    the top of main's module is the help text.  Mistakes in the input end the process with one
    line and exit code 2.
    """
    parser = _Parser(
        description=(inspect.getmodule(main).__doc__ or "").strip(),  # type: ignore[union-attr]
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for name, parameter in inspect.signature(main).parameters.items():
        short = ["-o"] if name == "output" else []
        parser.add_argument(
            *short,
            f"--{name.replace('_', '-')}",
            type=type(parameter.default),
            default=parameter.default,
            metavar=name.upper(),
            help=f"default: {parameter.default}",
        )
    try:
        return main(**vars(parser.parse_args(arguments)))
    except CadbemError as error:
        parser.exit(2, f"cadbem: {error}\n")


class _Parser(argparse.ArgumentParser):
    """An unknown option is a mistake in the input, told in one line."""

    def error(self, message: str) -> NoReturn:
        raise CadbemError(f"{self.prog}: {message}; --help lists the options")


def fresh_folder(path: str | Path) -> Path:
    """Make and return the folder ``path``; if it holds something, path-2, path-3, ... instead.

    Raises ``CadbemError`` when it cannot be made.
    """
    wanted = Path(path)
    folder, number = wanted, 1
    try:
        while folder.exists() and any(folder.iterdir()):
            number += 1
            folder = wanted.with_name(f"{wanted.name}-{number}")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CadbemError(
            f"{folder}: no folder for results can be made there ({error.strerror}); "
            "choose another with -o"
        ) from error
    return folder


def text_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Lines of text with columns as wide as they need to be, aligned on the right."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
        for line in lines
    )
