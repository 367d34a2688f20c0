"""The command line: ``cadbem info``, ``view``, ``run`` and ``warmup``."""

from __future__ import annotations

import argparse
import runpy
import sys
from collections.abc import Iterable, Sequence
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from cadbem import __version__
from cadbem.errors import CadbemError

if TYPE_CHECKING:
    from cadbem.cad import CadReport

USER_MISTAKE, INTERRUPTED = 2, 130


class UsageError(CadbemError):
    """A command was given something it cannot work with."""


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, like every other error of the command line."""

    def error(self, message: str) -> NoReturn:
        self.exit(USER_MISTAKE, f"{self.prog}: {message}; see '{self.prog} --help'\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the answer is the exit code (2 after a mistake of the user)."""
    options = _parser().parse_args(arguments)
    try:
        options.command(options)
    except CadbemError as error:
        print(f"cadbem: {' '.join(str(error).split())}", file=sys.stderr)
        return USER_MISTAKE
    except KeyboardInterrupt:
        print("cadbem: interrupted", file=sys.stderr)
        return INTERRUPTED
    return 0


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
        "Lists every face with its number, name, kind, degrees, patches, area and centre, then\n"
        "the unit, area, volume and extent of the fluid, and every problem found.  The numbers\n"
        "and names are what Boundary.named(...) takes.\n\n"
        "example: cadbem info geometries/y_junction.step",
    )
    parser.add_argument("file", metavar="FILE", help="a STEP (.step, .stp) or IGES (.iges, .igs)")
    parser.set_defaults(command=_info)


def _add_view(commands: argparse._SubParsersAction) -> None:
    parser = _add(
        commands,
        "view",
        "draw the boundary in a CAD file, one colour a name",
        "Arrows show the normals, which point into the fluid.\n\n"
        "example: cadbem view geometries/y_junction.step -o y_junction.png",
    )
    parser.add_argument("file", metavar="FILE", help="a STEP (.step, .stp) or IGES (.iges, .igs)")
    parser.add_argument("-o", "--output", metavar="PNG", required=True, help="picture to write")
    parser.add_argument("--force", action="store_true", help="replace the picture if it exists")
    parser.set_defaults(command=_view)


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


def _info(options: argparse.Namespace) -> None:
    from cadbem.cad import inspect_cad

    report = inspect_cad(options.file)
    print("\n".join([*_face_table(report), "", *_totals(report), "", *_verdict(report)]))


def _face_table(report: CadReport) -> list[str]:
    size = abs(report.bounds).max()
    extra = [what for what in ("layer", "colour") if any(getattr(f, what) for f in report.faces)]
    rows = [["face", "name", *extra, "kind", "degrees", "patches", "area", "centre", "problem"]]
    for face in report.faces:
        degrees = "x".join(str(degree) for degree in face.degrees) or "-"
        numbers = [degrees, str(face.patches), _number(face.area, 6), _vector(face.centre, size)]
        problem = "yes, see below" if face.problem else ""
        called = [face.name or "-", *(getattr(face, what) or "-" for what in extra)]
        rows.append([str(face.number), *called, face.kind, *numbers, problem])
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def _totals(report: CadReport) -> list[str]:
    unit = report.unit or "units"
    low, high = (_vector(corner, abs(report.bounds).max()) for corner in report.bounds)
    return [
        f"file    {report.file}",
        f"unit    {unit}",
        f"faces   {len(report.faces)} in {sum(face.patches for face in report.faces)} patches",
        f"area    {_number(report.area, 10)} {unit}^2",
        f"volume  {_number(report.volume, 10)} {unit}^3",
        f"extent  {low} to {high} {unit}",
        f"gap     {_number(report.gap, 2)} {unit}, the largest between neighbouring faces",
    ]


def _verdict(report: CadReport) -> list[str]:
    if not report.problems:
        return ["No problems: read_cad accepts this file."]
    return ["Problems:", *(f"- {problem}" for problem in report.problems)]


def _number(value: float, digits: int) -> str:
    return "unknown" if isnan(value) else f"{value:.{digits}g}"


def _vector(values: Iterable[float], size: float) -> str:
    """Coordinates, without the rounding errors that stand for zeros in a model of this size."""
    cleaned = (value if abs(value) > 1e-9 * size else 0.0 for value in values)
    return f"({', '.join(f'{value:.4g}' for value in cleaned)})"


def _view(options: argparse.Namespace) -> None:
    picture = Path(options.output)
    if picture.exists() and not options.force:
        raise UsageError(f"{picture} exists; choose another name or add --force")
    if not picture.parent.is_dir():
        raise UsageError(f"{picture}: there is no folder {picture.parent}; make it first")
    from cadbem.cad import read_cad
    from cadbem.post import draw_boundary

    draw_boundary(read_cad(options.file), picture)
    print(picture)


def _run(options: argparse.Namespace) -> None:
    script = Path(options.script)
    if not script.is_file():
        raise UsageError(f"{script}: there is no such script")
    sys.argv = [str(script), *options.arguments]
    sys.path.insert(0, str(script.resolve().parent))
    runpy.run_path(str(script), run_name="__main__")


def _warmup(options: argparse.Namespace) -> None:
    from cadbem.warmup import warm_up

    warm_up(progress=True)
