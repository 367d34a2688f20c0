"""What shapes, boundaries and unknowns say of themselves when they are printed.

The values themselves are on floors above; here they are known by what they offer.
"""

from __future__ import annotations

from math import prod
from typing import Any

from cadbem.tables import ROUNDING, Overview, count, numbers

FEW = 300  # elements up to which areas are integrated finely
FINE, COARSE = 12, 4  # Gauss points a direction


def nurbs_text(surface: Any) -> str:
    """One line of a NURBS curve or surface."""
    kind = {1: "curve", 2: "surface"}.get(len(surface.degrees), "spline")
    degrees = " × ".join(map(str, surface.degrees))
    points = " × ".join(map(str, surface.weights.shape))
    low, high = float(surface.weights.min()), float(surface.weights.max())
    rational = ", rational" if high - low > ROUNDING * high else ""
    return (
        f"NURBS {kind} in {surface.dimension}D: degree {degrees}, {points} control points{rational}"
    )


def closed_text(spline: Any) -> str:
    """One line of a closed spline."""
    basis, points = spline.basis, spline.points()
    shape = " × ".join(map(str, basis.shape))
    low, high = numbers(points.min(axis=1)), numbers(points.max(axis=1))
    kind = "curve" if spline.dimension == 2 else "surface"
    return (
        f"Closed {kind} in {spline.dimension}D: degree {basis.degree}, {shape} = {basis.count} "
        f"points between {low} and {high}"
    )


def elements(boundary: Any) -> int:
    """How many elements the patches have together."""
    surfaces = [patch.surface for patch in boundary.patches]
    return sum(prod(len(s.breaks(d)) - 1 for d in range(len(s.degrees))) for s in surfaces)


def degrees(boundary: Any) -> str:
    """The degree of all patches, or the lowest and the highest."""
    found = sorted({degree for patch in boundary.patches for degree in patch.surface.degrees})
    return f"degree {found[0]}" if len(found) == 1 else f"degrees {found[0]} to {found[-1]}"


def functions(boundary: Any) -> int:
    """How many functions, and so collocation points, the patches have together."""
    return sum(patch.surface.weights.size for patch in boundary.patches)


def named_areas(boundary: Any) -> dict[str, float]:
    """The area, or length in a plane, of the patches of each name."""
    order = FINE if elements(boundary) < FEW else COARSE
    areas = dict.fromkeys(boundary.names, 0.0)
    for patch in boundary.patches:
        areas[patch.name] += float(patch.quadrature(order)[1].sum())
    return areas


def size_text(boundary: Any) -> str:
    """Patches, elements, degree and points on one line."""
    sizes = count(len(boundary.patches), "patch"), count(elements(boundary), "element")
    return f"{', '.join(sizes)}, {degrees(boundary)}, {functions(boundary)} functions"


def source_text(boundary: Any) -> str:
    """Where a boundary comes from, and its unit."""
    return f"{boundary.source or 'no file'}, {boundary.unit or 'dimensionless'}"


def boundary_overview(boundary: Any) -> Overview:
    """Source, unit, size, extent, and names with patches and areas."""
    unit = boundary.unit
    low, high = boundary.bounds()
    box = f"within {numbers(low)} and {numbers(high)} {unit}".rstrip()
    kind, power = ("area", "²") if boundary.dimension == 3 else ("length", "")
    patches = [patch.name for patch in boundary.patches]
    rows = [
        (name or "(no name)", str(patches.count(name)), f"{area:.4g}")
        for name, area in named_areas(boundary).items()
    ]
    return Overview(
        f"Boundary in {boundary.dimension}D: {source_text(boundary)}",
        (size_text(boundary), box),
        ("name", "patches", f"{kind} ({unit}{power})" if unit else kind),
        tuple(rows),
    )


def space_text(space: Any) -> str:
    """One line of unknowns on a boundary."""
    patches = count(len(space.boundary.patches), "patch")
    where = f" of {space.boundary.source}" if space.boundary.source else ""
    return f"Space: {space.count} functions and collocation points on {patches}{where}"


def field_text(field: Any) -> str:
    """One line of a field on a space."""
    parts = count(len(field.coefficients), "component")
    low, high = field.coefficients.min(), field.coefficients.max()
    return (
        f"Field of {parts} on {field.space.count} functions, coefficients {low:.4g} to {high:.4g}"
    )
