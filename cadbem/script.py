"""Turns a workflow's ``main`` into a command: each keyword argument becomes an option."""

from __future__ import annotations

import argparse
import errno
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from cadbem.errors import CadbemError
from cadbem.progress import verbose

USER_MISTAKE, INTERRUPTED = 2, 130
# what a file system may answer without anything being wrong with a script
REFUSALS = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM}


def run(main: Callable[..., Any], arguments: list[str] | None = None) -> Any:
    """Call ``main`` with its defaults, changed by options of the command line.

    The type of a default is the type of its option, a truth value's option needs no value;
    ``output`` also answers to -o.  The text at the top of main's module is the help text.  Mistakes
    in the input end the process with one line and exit code 2, Ctrl-C with 130.
    """
    parser = _Parser(
        description=(inspect.getmodule(main).__doc__ or "").strip(),  # type: ignore[union-attr]
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for name, parameter in inspect.signature(main).parameters.items():
        _add_option(parser, name, parameter.default)
    values: dict[str, Any] = {}
    try:
        values = vars(parser.parse_args(arguments))
        return main(**values)
    except CadbemError as error:
        if verbose():
            raise
        parser.exit(USER_MISTAKE, f"cadbem: {' '.join(str(error).split())}\n")
    except OSError as error:
        if error.errno not in REFUSALS:
            raise
        parser.exit(USER_MISTAKE, f"cadbem: {error.filename or 'output'}: {error.strerror}\n")
    except KeyboardInterrupt:
        parser.exit(INTERRUPTED, f"cadbem: interrupted{_remedy(values)}\n")


def _add_option(parser: argparse.ArgumentParser, name: str, default: Any) -> None:
    short = ["-o"] if name == "output" else []
    option = f"--{name.replace('_', '-')}"
    if isinstance(default, bool):
        text = "go on with the run in the folder" if name == "resume" else None
        parser.add_argument(option, action="store_true", default=default, help=text)
        return
    text = f"default: {default}"
    kind: Any = type(default)
    parser.add_argument(
        *short, option, type=kind, default=default, metavar=name.upper(), help=text
    )


def _remedy(values: Mapping[str, Any]) -> str:
    """How an interrupted run can go on, if it can."""
    output = values.get("output")
    if "resume" in values and output and Path(output, "run.json").exists():
        return f"; go on with 'cadbem resume {output}'"
    return ""


class _Parser(argparse.ArgumentParser):
    """An unknown option is a mistake in the input, told in one line."""

    def error(self, message: str) -> NoReturn:
        raise CadbemError(f"{self.prog}: {message}; --help lists the options")


def text_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Lines of text with columns as wide as they need to be, aligned on the right."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
        for line in lines
    )
