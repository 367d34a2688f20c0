"""A CAD file as the boundary of a body of fluid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from warnings import warn

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.cad.body.between import Pick
from cadbem.cad.body.crossings import find_crossing
from cadbem.cad.body.model import CadModel, open_model
from cadbem.cad.body.witness import disagreements
from cadbem.cad.layout.face_patches import TOLERANCE
from cadbem.checks import positive, within
from cadbem.errors import CadError, CadWarning
from cadbem.points import gauss_measures
from cadbem.progress import progress, stage

OPEN = 1e-4  # |∮ n dS| / area above which patches do not enclose a volume
ORDER = 8  # Gauss points a direction and element
HOLLOW = 1e-9  # volume / area^(3/2) below which nothing is enclosed


def read_cad(
    path: str | Path,
    *,
    fluid: int | str = "solid",
    between: Sequence[Pick] = (),
    names: str = "names",
    tolerance: float = TOLERANCE,
    sew: float = 0.0,
    time_limit: float = 60.0,
) -> Boundary:
    """NURBS patches of the solid in a STEP or IGES file; the fluid is inside.

    `fluid` says which of several solids, or that a solid is the chip and not the fluid:

    - "solid": the file's only solid. If there are several, or if it has closed cavities, a CadError
      lists the choices.
    - a number (from 1) or the name of a solid: that one.
    - "material": the only solid, without its cavities.
    - the name of a STEP closed shell inside a solid: the room inside that shell.
    - "all": all solids together; faces that two of them share are left out.
    - "void": the room in the solids, closed cavities too. Its mouths, rings of edges at the ends
      of bores, are capped, and called port_1, port_2, ... by x, then y, then z of their middles.
      If there are several such rooms, "void 1", "void 2", ...: large ones first. Where no mouth is
      found it is the room that solids leave of the box of their corners, with ports in its sides.

    `between` picks mouths instead, and gives the room that they lead into: `("mouth 1", "mouth 2")`
    as `inspect_cad` and messages number them (by x, y, z over the whole file), points (x, y, z) in
    them, which also find rings that are no mouths by themselves, or numbers of faces round or
    behind them. A mouth may lie on any face, at the end of any tube, in any of several solids that
    touch. Caps are called mouth_1, ... by their numbers. Ports and mouths keep their names in
    `named(rest=...)`.

    Coordinates are in the file's own unit, normals point into the fluid. Patches are called what
    the file calls their faces (`names="names"`: STEP's name of the face, IGES's entity label), by
    the face's layer or level (`names="layers"`) or by its colour, "#rrggbb" (`names="colours"`).

    Faces that fill a rectangle of their surface's parameters, and plane faces, become exact
    patches; other trimmed faces become splines that deviate from them by less than `tolerance`
    times the face's size. Loose faces are sewn if they are no more apart than the file's digits
    explain; `sew` (1e-4, say) is a wider gap, per size of the model, that may be sewn, too.
    `time_limit` in seconds bounds the CAD kernel's work. Warns with CadWarning of what is unusual
    or had to be assumed.

    Raises CadError, in one line with the remedy, for what cannot be read or does not enclose
    exactly one volume, and for faces that no way of laying patches covers.
    """
    within("tolerance", tolerance, 1e-16, 0.1)
    positive("time_limit", time_limit)
    with stage(f"reading {path}"):
        model = open_model(path, time_limit, names, fluid, between, sew)
        for warning in model.warnings:
            warn(warning, CadWarning, stacklevel=2)
        boundary = Boundary(tuple(_all_patches(model, tolerance)), model.file, model.unit.name)
        boundary = oriented(boundary)
        check_crossings(model, boundary)
        for warning in disagreements(model, boundary):
            warn(warning, CadWarning, stacklevel=2)
        return boundary


def oriented(boundary: Boundary) -> Boundary:
    """Normals turned into the enclosed volume, if the file has the solid inside out.

    Raises CadError if the patches do not close or enclose nothing.
    """
    position, normal, weights = gauss_measures([p.surface for p in boundary.patches], ORDER)
    area = float(np.linalg.norm(normal, axis=0) @ weights)
    opening = float(np.linalg.norm(normal @ weights)) / area
    if opening > OPEN:
        raise CadError(
            f"{boundary.source}: the faces do not close: |∮ n dS| / area = {opening:.1e}; "
            "check the model for missing, doubled or turned faces"
        )
    arm = position - position.mean(axis=1)[:, None]
    volume = -float((arm * normal).sum(axis=0) @ weights) / 3
    if abs(volume) < HOLLOW * area**1.5:
        raise CadError(f"{boundary.source}: the faces enclose no volume; export a solid")
    if volume > 0:
        return boundary
    turned = [replace(patch, surface=patch.surface.swapped()) for patch in boundary.patches]
    return replace(boundary, patches=tuple(turned))


def check_crossings(model: CadModel, boundary: Boundary) -> None:
    """Raises CadError with faces and place if patches cross each other or themselves."""
    crossing = find_crossing(boundary.patches)
    if crossing is None:
        return
    first, second = (boundary.patches[k].face for k in crossing.patches)
    who = f"faces {first} and {second} cross" if first != second else f"face {first} crosses itself"
    raise CadError(
        f"{model.file}: {who} at {model.place(crossing.place)}; "
        "cut or unite what overlaps in the CAD program"
    )


def _all_patches(model: CadModel, tolerance: float) -> list[Patch]:
    for obstacle in model.obstacles():
        raise CadError(obstacle)
    patches: list[Patch] = []
    refused: list[str] = []
    for face in progress(model.faces, f"{model.file}: faces"):
        try:
            laid, deviation = model.patches(face, tolerance)
        except CadError as error:
            refused.append(f"{model.file}: {error}")
            continue
        patches += laid
        for line in model.relaxed(face, deviation, tolerance):
            warn(line, CadWarning, stacklevel=2)
    if refused:
        others = f" ({len(refused) - 1} more faces cannot, either)" if len(refused) > 1 else ""
        raise CadError(refused[0] + others)
    return patches
