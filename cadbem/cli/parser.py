"""The argument parser of all commands, and the checks of their options."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from math import isfinite
from typing import Any, NoReturn

from cadbem.command import USER_MISTAKE
from cadbem.errors import CadbemError

Commands = argparse._SubParsersAction
Options = argparse.Namespace


class UsageError(CadbemError):
    """A command was given something it cannot work with."""


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, like every other error of the command line."""

    def error(self, message: str) -> NoReturn:
        self.exit(USER_MISTAKE, f"{self.prog}: {message}; see '{self.prog} --help'\n")


def add_command(
    commands: Commands, act: Callable[[Options], Any], name: str, summary: str, more: str
) -> Parser:
    """A command that ``act`` carries out, with its help and the options that all have."""
    parser = commands.add_parser(
        name,
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}.\n\n{more}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    loud = parser.add_mutually_exclusive_group()
    loud.add_argument(
        "-q", "--quiet", action="store_true", help="no bars, notices and warnings; results only"
    )
    loud.add_argument(
        "-v", "--verbose", action="store_true", help="say how long each stage took; full tracebacks"
    )
    parser.set_defaults(command=act)
    return parser


def leave_rest(parser: Parser) -> None:
    """Options that the command does not know itself are kept for its script, in ``arguments``."""
    parser.set_defaults(keeps_rest=True)
    parser.epilog = "all other options are those of the script"


def positive(text: str) -> float:
    """A number above 0, of an option."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not (value > 0 and isfinite(value)):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0, such as 1e-6")
    return value


def counting(text: str) -> int:
    """A whole number above 0, of an option."""
    if not (text.isdecimal() and int(text)):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number above 0, such as 2")
    return int(text)
