"""``cadbem info`` and ``cadbem view``: the report and the picture of a CAD file."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from cadbem.cli.cad_report import report_lines
from cadbem.cli.parser import Commands, Options, Parser, UsageError, add_command, positive
from cadbem.errors import CadError, CadWarning


def add_info(commands: Commands) -> None:
    """``cadbem info``."""
    parser = add_command(
        commands,
        _info,
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


def add_view(commands: Commands) -> None:
    """``cadbem view``."""
    parser = add_command(
        commands,
        _view,
        "view",
        "draw the boundary in a CAD file, one colour a name",
        "Faces bear their numbers and names.  If the file cannot be solved, its defective faces\n"
        "are red; the reasons are printed, and the exit code is 2.\n\n"
        "example: cadbem view geometries/y_junction.step -o y_junction.png",
    )
    _add_reading(parser)
    parser.add_argument("-o", "--output", metavar="PNG", required=True, help="picture to write")
    parser.add_argument("--force", action="store_true", help="replace the picture if it exists")


def _add_reading(parser: Parser) -> None:
    """The file, and the options of `read_cad`, which are left to it where they are not given."""
    parser.add_argument("file", metavar="FILE", help="a STEP (.step, .stp) or IGES (.iges, .igs)")
    parser.add_argument(
        "--fluid",
        type=lambda text: int(text) if text.isdecimal() else text,
        help="what the fluid is: solid (default), a solid's number or name, material, all, void",
    )
    parser.add_argument(
        "--between",
        nargs="+",
        type=lambda text: int(text) if text.isdecimal() else text,
        metavar="MOUTH",
        help="the room between mouths of a chip, such as 'mouth 1' 'mouth 2', or face numbers",
    )
    parser.add_argument(
        "--names",
        choices=("names", "layers", "colours"),
        help="what faces are called by (default: names)",
    )
    parser.add_argument(
        "--tolerance",
        type=positive,
        metavar="SHARE",
        help="deviation allowed from curved trimmed faces, per size of the face (default: 1e-6)",
    )
    parser.add_argument(
        "--sew", type=positive, metavar="SHARE", help="gap that may be sewn, per size of the model"
    )


def _reading(options: Options) -> dict[str, Any]:
    """The options of `read_cad` that were given."""
    keys = ("fluid", "between", "names", "tolerance", "sew")
    chosen = {key: getattr(options, key) for key in keys}
    return {key: value for key, value in chosen.items() if value is not None}


def _info(options: Options) -> None:
    from cadbem.cad import inspect_cad

    report = inspect_cad(options.file, **_reading(options))
    print("\n".join(report_lines(report)))


def _view(options: Options) -> None:
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
