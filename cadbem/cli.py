"""The command line: ``cadbem info``, ``view``, ``run``, ``warmup`` and ``verify``."""

from __future__ import annotations

import argparse
import runpy
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Any, NoReturn

from cadbem import __version__
from cadbem.cli_report import report_lines
from cadbem.errors import CadbemError, CadError, CadWarning

CHECK_FAILED, USER_MISTAKE, INTERRUPTED = 1, 2, 130


class UsageError(CadbemError):
    """A command was given something it cannot work with."""


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, like every other error of the command line."""

    def error(self, message: str) -> NoReturn:
        self.exit(USER_MISTAKE, f"{self.prog}: {message}; see '{self.prog} --help'\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the answer is the exit code (2 after a mistake of the user, 1 if a check
    of ``verify`` fails)."""
    options = _parser().parse_args(arguments)
    try:
        with _warnings_in_one_line():
            return options.command(options) or 0
    except CadbemError as error:
        print(f"cadbem: {' '.join(str(error).split())}", file=sys.stderr)
        return USER_MISTAKE
    except KeyboardInterrupt:
        print("cadbem: interrupted", file=sys.stderr)
        return INTERRUPTED


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """Ours without the place in the source code; those of others as they are."""
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Any, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, CadWarning):
                print(f"cadbem: warning: {' '.join(str(message).split())}", file=sys.stderr)
            else:
                usual(message, category, *place, **more)

        warnings.showwarning = show
        yield


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="cadbem",
        description="Stokes flow in microchannels, from CAD files, by boundary elements.",
        epilog="'cadbem COMMAND --help' explains a command with an example.",
    )
    parser.add_argument("--version", action="version", version=f"cadbem {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _add_info(commands)
    _add_view(commands)
    _add_run(commands)
    _add_warmup(commands)
    _add_verify(commands)
    return parser


def _add(commands: argparse._SubParsersAction, name: str, summary: str, more: str) -> _Parser:
    return commands.add_parser(
        name,
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}.\n\n{more}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _add_info(commands: argparse._SubParsersAction) -> None:
    parser = _add(
        commands,
        "info",
        "say what a CAD file holds and whether it can be solved",
        "Lists every face with its number, name, kind, degrees, patches, area, deviation of the\n"
        "patches from it, smallest angle between parameter lines in degrees, smallest over\n"
        "largest area element, and centre; then the unit, area, volume and extent of the fluid,\n"
        "what is unusual, and every problem found.  The numbers and names are what\n"
        "Boundary.named(...) takes.\n\n"
        "example: cadbem info geometries/y_junction.step",
    )
    _add_reading(parser)
    parser.set_defaults(command=_info)


def _add_view(commands: argparse._SubParsersAction) -> None:
    parser = _add(
        commands,
        "view",
        "draw the boundary in a CAD file, one colour a name",
        "If the file cannot be solved, its defective faces are red; the reasons are printed, and\n"
        "the exit code is 2.\n\n"
        "example: cadbem view geometries/y_junction.step -o y_junction.png",
    )
    _add_reading(parser)
    parser.add_argument("-o", "--output", metavar="PNG", required=True, help="picture to write")
    parser.add_argument("--force", action="store_true", help="replace the picture if it exists")
    parser.set_defaults(command=_view)


def _add_reading(parser: _Parser) -> None:
    """The file, and the options of `read_cad`, which are left to it where they are not given."""
    parser.add_argument("file", metavar="FILE", help="a STEP (.step, .stp) or IGES (.iges, .igs)")
    parser.add_argument(
        "--fluid",
        type=lambda text: int(text) if text.isdecimal() else text,
        help="what the fluid is: solid (default), a solid's number or name, material, all, void",
    )
    parser.add_argument(
        "--names",
        choices=("names", "layers", "colours"),
        help="what faces are called by (default: names)",
    )
    parser.add_argument(
        "--tolerance",
        type=_positive,
        metavar="SHARE",
        help="deviation allowed from curved trimmed faces, per size of the face (default: 1e-6)",
    )


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not (value > 0 and isfinite(value)):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0, such as 1e-6")
    return value


def _reading(options: argparse.Namespace) -> dict[str, Any]:
    """The options of `read_cad` that were given."""
    chosen = {key: getattr(options, key) for key in ("fluid", "names", "tolerance")}
    return {key: value for key, value in chosen.items() if value is not None}


def _add_run(commands: argparse._SubParsersAction) -> None:
    parser = _add(
        commands,
        "run",
        "run a workflow: a Python script that uses cadbem",
        "Like 'python SCRIPT', but a mistake in the input ends in one line instead of a\n"
        "traceback.  Whatever follows SCRIPT is for the script; those in workflows/ take\n"
        "-o FOLDER, where results go.\n\n"
        "example: cadbem run workflows/y_junction_flow.py -o results/first",
    )
    parser.add_argument("script", metavar="SCRIPT", help="a Python file")
    parser.add_argument(
        "arguments", metavar="...", nargs=argparse.REMAINDER, help="arguments of the script"
    )
    parser.set_defaults(command=_run)


def _add_warmup(commands: argparse._SubParsersAction) -> None:
    parser = _add(
        commands,
        "warmup",
        "compile the kernels now rather than in the first run",
        "The compiled code is kept, so that this is needed once after an installation.\n\n"
        "example: cadbem warmup",
    )
    parser.set_defaults(command=_warmup)


def _add_verify(commands: argparse._SubParsersAction) -> None:
    parser = _add(
        commands,
        "verify",
        "compute what is known exactly, and compare",
        "Tables and figures of the thesis as far as they are numbers, and more: a minute or two.\n"
        "Prints each number, its true value, the thesis's, the error and what is allowed; the\n"
        "exit code is 1 if any check fails.\n\n"
        "example: cadbem verify",
    )
    parser.add_argument("--full", action="store_true", help="the long checks as well, some minutes")
    parser.set_defaults(command=_verify)


def _info(options: argparse.Namespace) -> None:
    from cadbem.cad import inspect_cad

    report = inspect_cad(options.file, **_reading(options))
    print("\n".join(report_lines(report)))


def _view(options: argparse.Namespace) -> None:
    picture = Path(options.output)
    if picture.exists() and not options.force:
        raise UsageError(f"{picture} exists; choose another name or add --force")
    if not picture.parent.is_dir():
        raise UsageError(f"{picture}: there is no folder {picture.parent}; make it first")
    from cadbem.cad.picture import defect_lines, skins
    from cadbem.cad.survey import survey_cad
    from cadbem.post import draw_boundary

    survey = survey_cad(options.file, **_reading(options))
    for warning in survey.model.warnings:
        warnings.warn(warning, CadWarning, stacklevel=1)
    draw_boundary(survey.boundary, picture, defects=defect_lines(survey), skins=skins(survey))
    print("\n".join([str(picture), *survey.complaints()]))
    if survey.problems:
        more = len(survey.problems) - 1
        raise CadError(survey.problems[0] + (f" (and {more} more problems)" if more else ""))


def _run(options: argparse.Namespace) -> None:
    script = Path(options.script)
    if not script.is_file():
        raise UsageError(f"{script}: there is no such script")
    sys.argv = [str(script), *options.arguments]
    sys.path.insert(0, str(script.resolve().parent))
    runpy.run_path(str(script), run_name="__main__")


def _warmup(options: argparse.Namespace) -> None:
    from cadbem.warmup import warm_up

    start = time.perf_counter()
    folder = warm_up(progress=True)
    kept = "nothing could be kept: no folder can be written to"
    if folder is not None:
        kept = f"the compiled code is kept in {folder}"
    print(f"{time.perf_counter() - start:.0f} s; {kept}")


def _verify(options: argparse.Namespace) -> int:
    from cadbem.script import text_table
    from cadbem.verification import all_checks, run_checks
    from cadbem.verification.report import HEAD, rows, summary

    results = list(run_checks(all_checks(options.full)))
    print(text_table(HEAD, rows(results)))
    print(summary(results))
    return 0 if all(result.passed for result in results) else CHECK_FAILED
