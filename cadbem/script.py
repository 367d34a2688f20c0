"""Turns a workflow's ``main`` into a command: each keyword argument becomes an option."""

from __future__ import annotations

import argparse
import errno
import inspect
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from cadbem.command import CURRENT, INTERRUPTED, USER_MISTAKE, Command
from cadbem.errors import CadbemError
from cadbem.progress import verbose

KINDS = {"str": str, "int": int, "float": float, "bool": bool}
# what a file system may answer without anything being wrong with a script
REFUSALS = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM}

# "name: text" or "name, name: text" at the beginning of a line of a docstring
EXPLANATION = re.compile(r"[^\W\d]\w*(?:, \w+)*: +\S.*")
NEXT = re.compile(r"; (?=[^\W\d]\w*(?:, \w+)*: )")
ALWAYS = {
    "output": "folder that results go to, '' for none",
    "resume": "go on with the run in the folder",
}


def run(main: Callable[..., Any], arguments: list[str] | None = None) -> Any:
    """Call ``main`` with its defaults, changed by options of the command line.

    The type of a default is the type of its option; without one, or where it is None, the
    annotation decides (text, a number or a truth value), and an option without a default must be
    given.  ``output`` may be given as -o, too.  The text at the top of main's module is the help
    text, and lines such as ``radius: of the droplet (mm)`` in main's docstring explain the options.
    Mistakes in the input end the process with one line and exit code 2, Ctrl-C with 130.
    """
    parser = _Parser(
        description=(inspect.getmodule(main).__doc__ or "").strip(),  # type: ignore[union-attr]
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    values: dict[str, Any] = {}
    try:
        texts = ALWAYS | explained(inspect.getdoc(main) or "")
        for parameter in inspect.signature(main).parameters.values():
            _add_option(parser, parameter, texts.get(parameter.name, ""))
        values = vars(parser.parse_args(arguments))
        token = CURRENT.set(Command(Path(inspect.getfile(main)).resolve(), values))
        try:
            return main(**values)
        finally:
            CURRENT.reset(token)
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


def explained(docstring: str) -> dict[str, str]:
    """What lines such as "width: of the channel (mm); wide, narrow: of its ends" say of each name.

    Explanations go on in lines that are indented; one serves all names before its colon.
    """
    entries: list[str] = []
    known = False
    for line in docstring.splitlines():
        if known and line.startswith(" "):
            entries[-1] += f" {line.strip()}"
        elif known := bool(EXPLANATION.fullmatch(line)):
            entries.append(line)
    texts: dict[str, str] = {}
    for entry in (part for line in entries for part in NEXT.split(line)):
        names, text = entry.split(":", 1)
        texts |= dict.fromkeys(names.split(", "), text.strip())
    return texts


def _add_option(
    parser: argparse.ArgumentParser, parameter: inspect.Parameter, explanation: str
) -> None:
    name, default, kind = parameter.name, parameter.default, _kind(parameter)
    needed = default is inspect.Parameter.empty
    known = "needed" if needed else f"default: {_shown(default)}"
    text = (f"{explanation} ({known})" if explanation else known).replace("%", "%%")
    option = f"--{name.replace('_', '-')}"
    more: dict[str, Any] = {"required": True} if needed else {"default": default}
    if kind is bool:
        parser.add_argument(option, action=argparse.BooleanOptionalAction, help=text, **more)
        return
    names = ["-o", option] if name == "output" else [option]
    parser.add_argument(*names, type=kind, metavar=name.upper(), help=text, **more)


def _shown(default: Any) -> str:
    """A default in the way in which one would give it."""
    if isinstance(default, bool):
        return "yes" if default else "no"
    return "none" if default is None else str(default) or "''"


def _kind(parameter: inspect.Parameter) -> Any:
    """The type of an option's value."""
    known = parameter.default
    if isinstance(known, tuple(KINDS.values())):
        return type(known)
    annotation = parameter.annotation
    words = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", "")
    words = words or str(annotation)  # such as float | None
    found = [KINDS[word] for word in words.replace(" ", "").split("|") if word in KINDS]
    if known in (None, inspect.Parameter.empty) and found:
        return found[0]
    raise CadbemError(
        f"'{parameter.name}' of main cannot be an option of the command line: give it a default "
        "that is a number, text, True or False, and make what you need of it inside"
    )


def _remedy(values: Mapping[str, Any]) -> str:
    """The command that continues an interrupted run, if there is one."""
    output = values.get("output")
    if "resume" in values and output and Path(output, "run.json").exists():
        return f"; go on with 'cadbem resume {output}'"
    return ""


class _Parser(argparse.ArgumentParser):
    """An unknown option is a mistake in the input, reported in one line."""

    def error(self, message: str) -> NoReturn:
        raise CadbemError(f"{self.prog}: {message}; --help lists the options")

