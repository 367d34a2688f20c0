"""A report on a CAD file as text: what ``cadbem info`` prints."""

from __future__ import annotations

from collections.abc import Iterable
from math import isnan, nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cadbem.cad import CadReport


def report_lines(report: CadReport) -> list[str]:
    """A row for each face, then the totals, what is unusual, and what is wrong."""
    parts = [_face_table(report), _totals(report)]
    if report.remarks:
        parts.append(["Remarks:", *(f"- {remark}" for remark in report.remarks)])
    parts.append(_verdict(report))
    return [line for part in parts for line in (*part, "")][:-1]


def _face_table(report: CadReport) -> list[str]:
    size = abs(report.bounds).max()
    extra = [what for what in ("layer", "colour") if any(getattr(f, what) for f in report.faces)]
    rows = [
        ["face", "name", *extra, "kind", "degrees", "patches", "area", "deviation", "angle",
         "jacobian", "centre", "problem"]
    ]  # fmt: skip
    for face in report.faces:
        degrees = "x".join(str(degree) for degree in face.degrees) or "-"
        called = [face.name or "-", *(getattr(face, what) or "-" for what in extra)]
        problem = "yes, see below" if face.number in report.defects else ""
        rows.append([
            str(face.number), *called, face.kind, degrees, str(face.patches),
            _cell(face.area, 6), _cell(face.deviation, 2), _cell(face.angle, 3),
            _cell(face.jacobian_ratio, 2), _vector(face.centre, size), problem,
        ])  # fmt: skip
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def _totals(report: CadReport) -> list[str]:
    unit = report.unit or "units"
    low, high = (_vector(corner, abs(report.bounds).max()) for corner in report.bounds)
    exact_volume = nan if _bad_edges(report) else report.exact_volume  # of closed surfaces only
    faces = f"{len(report.faces)} in {sum(face.patches for face in report.faces)} patches"
    return [
        f"file       {report.file}",
        f"unit       {unit}",
        f"faces      {faces}",
        f"area       {_beside(report.area, report.exact_area, f'{unit}^2')}",
        f"volume     {_beside(report.volume, exact_volume, f'{unit}^3')}",
        f"extent     {low} to {high} {unit}",
        f"gap        {_length(report, report.gap)}, the largest between neighbouring faces",
        f"deviation  {_deviation(report)}",
        *_worst(report),
    ]


def _beside(value: float, exact: float, unit: str) -> str:
    """A total of the patches beside that of the CAD kernel's own surfaces."""
    if isnan(exact):
        return "unknown" if isnan(value) else f"{value:.10g} {unit}"
    if isnan(value):
        return f"unknown; of the CAD kernel's own surfaces {exact:.10g} {unit}"
    difference = abs(value - exact) / abs(exact)
    return (
        f"{value:.10g} {unit}, relative difference from the CAD kernel's own surfaces"
        f" {difference:.2g}"
    )


def _length(report: CadReport, value: float) -> str:
    """A length, and per size of the model."""
    if isnan(value):
        return "unknown"
    size = float((report.bounds[1] - report.bounds[0]).max())
    share = f" = {value / size:.2g} of the size" if value else ""
    return f"{value:.2g} {report.unit or 'units'}{share}"


def _deviation(report: CadReport) -> str:
    largest = max((f.deviation for f in report.faces if not isnan(f.deviation)), default=nan)
    return f"{_length(report, largest)}, the largest of patches from their faces"


def _worst(report: CadReport) -> list[str]:
    """The least regular patches."""
    covered = [face for face in report.faces if face.patches]
    if not covered:
        return []
    angle = min(covered, key=lambda face: face.angle)
    ratio = min(covered, key=lambda face: face.jacobian_ratio)
    return [
        f"angle      {angle.angle:.3g} degrees, the smallest between parameter lines"
        f" (face {angle.number})",
        f"jacobian   {ratio.jacobian_ratio:.2g}, the least of smallest over largest area element"
        f" of a patch (face {ratio.number})",
    ]


def _verdict(report: CadReport) -> list[str]:
    if not report.problems:
        return ["No problems: read_cad accepts this file."]
    return [
        "Problems:",
        *(f"- {problem}" for problem in report.problems),
        *(f"- face {number}: {reason}" for number, reason in _bad_edges(report).items()),
    ]


def _bad_edges(report: CadReport) -> dict[int, str]:
    """The defects of faces that have patches, or could have."""
    refused = {face.number for face in report.faces if face.problem}
    return {n: report.defects[n] for n in sorted(report.defects.keys() - refused)}


def _cell(value: float, digits: int) -> str:
    return "-" if isnan(value) else f"{value:.{digits}g}"


def _vector(values: Iterable[float], size: float) -> str:
    """Coordinates, without the rounding errors that stand for zeros in a model of this size."""
    cleaned = (value if abs(value) > 1e-9 * size else 0.0 for value in values)
    return f"({', '.join(f'{value:.4g}' for value in cleaned)})"
