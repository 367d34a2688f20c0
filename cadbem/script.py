"""Turns a workflow's ``main`` into a command: each keyword argument becomes an option."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cadbem.errors import CadbemError


def run(main: Callable[..., Any], arguments: list[str] | None = None) -> Any:
    """Call ``main`` with its defaults, changed by options of the command line.

    The type of a default is the type of its option; ``output`` also answers to -o.  The first
    line of main's module is the help text.
    """
    parser = argparse.ArgumentParser(
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
    return main(**vars(parser.parse_args(arguments)))


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
