"""Plane curves put together to one region of fluid."""

from __future__ import annotations

from dataclasses import replace
from warnings import warn

import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.cad.faces.surfaces import smooth_pieces
from cadbem.cad.layout.rings import Ring, polyline, regions, rings
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError, CadWarning
from cadbem.spline.basis import Array

JOINED = 1e-4  # share of the figure's size within which ends belong together
SAME = 1e-6  # share of the figure's size within which ends meet well


def plane_region(file: str, patches: list[Patch], unit: Unit, region: int | None) -> Boundary:
    """The curves put together, turned, cut at kinks, and scaled to the file's unit."""
    size = float(np.ptp(np.concatenate([p.surface.points for p in patches]), axis=0).max())
    loops, gap, end = rings(patches, JOINED * size)
    if end is not None:
        place = in_words(end, unit)
        raise CadError(f"{file}: the curves do not close, an end is at {place}; join them")
    if gap > SAME * size:
        gap_there = f"{gap / unit.millimetres:.2g} {unit.name}"
        warn(f"{file}: curves meet up to {gap_there} only", CadWarning, stacklevel=3)
    _check_crossings(file, patches, JOINED * size, unit)
    chosen = _chosen(file, regions(loops), region, unit)
    pieces = [
        replace(patch, surface=replace(piece, points=piece.points / unit.millimetres))
        for patch in chosen
        for piece in smooth_pieces(patch.surface)
    ]
    return Boundary(tuple(pieces), file, unit.name)


def _check_crossings(file: str, patches: list[Patch], near: float, unit: Unit) -> None:
    """Raises CadError if curves meet elsewhere than at ends of both."""
    lines = [_polyline(patch) for patch in patches]
    start = np.concatenate([line[:, :-1] for line in lines], axis=1)
    step = np.concatenate([np.diff(line) for line in lines], axis=1)
    owner = np.repeat(np.arange(len(lines)), [line.shape[1] - 1 for line in lines])
    ends = np.concatenate([line[:, [0, -1]] for line in lines], axis=1)
    for k in range(start.shape[1]):
        arm = start - start[:, k : k + 1]
        across = step[0, k] * step[1] - step[1, k] * step[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            here = (arm[0] * step[1] - arm[1] * step[0]) / across
            there = (arm[0] * step[1, k] - arm[1] * step[0, k]) / across
        meets = (here >= 0) & (here <= 1) & (there >= 0) & (there <= 1) & (owner > owner[k])
        for other in np.flatnonzero(meets):
            place = start[:, k] + here[other] * step[:, k]
            if np.hypot(*(ends - place[:, None])).min() > near:
                raise CadError(
                    f"{file}: curves cross at {in_words(place, unit)}; unite or cut the shapes in "
                    "the CAD program"
                )


def _polyline(patch: Patch) -> Array:
    """Points (2, n) along a curve, of a straight one its ends."""
    curve = patch.surface
    return curve.points.T if curve.degrees == (1,) else polyline(curve)


def _chosen(file: str, found: list[Ring], region: int | None, unit: Unit) -> Ring:
    if region is not None and 1 <= region <= len(found):
        return found[region - 1]
    if region is None and len(found) == 1:
        return found[0]
    sizes = [
        f"{k} of area {Boundary(ring).volume() / unit.millimetres**2:.4g} about "
        + in_words(Boundary(ring).bounds().mean(axis=0), unit)
        for k, ring in enumerate(found, start=1)
    ]
    raise CadError(
        f"{file}: {len(found)} regions ({'; '.join(sizes)}); choose one with region=1, ..."
    )


def in_words(point: Array, unit: Unit) -> str:
    """A place in the file's unit."""
    rounded = (f"{x + 0.0:.4g}" for x in np.round(point / unit.millimetres, 12))
    return f"[{', '.join(rounded)}] {unit.name}".rstrip()
