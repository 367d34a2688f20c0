"""The command ``cadbem``: its parts, warnings, errors and exit codes."""

from __future__ import annotations

import logging
import sys
import traceback
import warnings
from argparse import RawDescriptionHelpFormatter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from cadbem import __version__
from cadbem.cli.files import add_info, add_view
from cadbem.cli.machine import add_verify, add_warmup
from cadbem.cli.parser import Options, Parser
from cadbem.cli.runs import add_render, add_resume, add_run, add_sweep
from cadbem.command import INTERRUPTED, USER_MISTAKE
from cadbem.errors import CadbemError, CadWarning
from cadbem.progress import QUIET

PARTS = (add_info, add_view, add_run, add_resume, add_render, add_sweep, add_warmup, add_verify)
EPILOG = """\
a first hour:
  cadbem info chip.step                     what is in the file, and can it be solved?
  cadbem view chip.step -o chip.png         a picture of its faces with their numbers
  cadbem run my_flow.py -o results/first    a script, see README.md
  cadbem render results/first               movie and pictures of what it computed

'cadbem COMMAND --help' explains a command with an example.
exit codes: 0 done, 1 a check or an error in a script, 2 a mistake in the input, 130 interrupted"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the answer is the exit code: 2 after a mistake of the user, 130 after an
    interruption, else what the command says."""
    parser = _parser()
    options, rest = parser.parse_known_args(arguments)
    if getattr(options, "keeps_rest", False):
        options.arguments = rest
    elif rest:
        parser.error(f"unrecognized arguments: {' '.join(rest)}")
    token = QUIET.set(options.quiet)
    try:
        with _warnings_in_one_line(options), _stages(options.verbose):
            return options.command(options) or 0
    except CadbemError as error:
        if options.verbose:
            traceback.print_exc()
        print(f"cadbem: {' '.join(str(error).split())}", file=sys.stderr)
        return USER_MISTAKE
    except KeyboardInterrupt:
        print("cadbem: interrupted", file=sys.stderr)
        return INTERRUPTED
    finally:
        QUIET.reset(token)


@contextmanager
def _warnings_in_one_line(options: Options) -> Iterator[None]:
    """Ours without the place in the source code; those of others as they are."""
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Any, category: type[Warning], *place: Any, **more: Any) -> None:
            if not issubclass(category, CadWarning):
                usual(message, category, *place, **more)
            elif not options.quiet:
                print(f"cadbem: warning: {' '.join(str(message).split())}", file=sys.stderr)

        warnings.showwarning = show
        yield


@contextmanager
def _stages(shown: bool) -> Iterator[None]:
    """Tell of each stage on stderr, if it is to be shown."""
    stages = logging.getLogger("cadbem")
    handler, level = logging.StreamHandler(), stages.level
    handler.setFormatter(logging.Formatter("%(asctime)s  %(message)s", "%H:%M:%S"))
    if shown:
        stages.addHandler(handler)
        stages.setLevel(logging.INFO)
    try:
        yield
    finally:
        stages.removeHandler(handler)
        stages.setLevel(level)


def _parser() -> Parser:
    parser = Parser(
        prog="cadbem",
        description="Stokes flow in microchannels, from CAD files, by boundary elements.",
        epilog=EPILOG,
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"cadbem {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for add in PARTS:
        add(commands)
    return parser
