"""The box around a chip; the channel is the box without the chip. Part of `_child.py`."""

from __future__ import annotations

SMALL = 1e-6  # distance, per size of the model, within which a face lies in a side of the box
BEHIND = 1e-3  # distance, per size, at which one looks whether a solid goes on behind its side
INFLATED = 2e-7  # by which the kernel's boxes are too large at most, mm
EXACT = ("Plane", "Cylinder", "Cone", "Sphere", "Torus")  # surfaces with exact boxes
GRID = 16  # steps of parameters at which other surfaces are looked at
MARGIN = 0.1  # room left beside sides that are not flat, per size of the model


def room_box(gmsh, solids: list) -> tuple[list[float], list[bool]]:
    """The box of the corners (the kernel's own boxes are a little larger), and which of its sides
    hold a plane face with nothing behind it; the others are moved away from the solids."""
    model = gmsh.model
    boxes = [model.getBoundingBox(*solid) for solid in solids]
    size = max(max(b[k + 3] for b in boxes) - min(b[k] for b in boxes) for k in range(3))
    tags = {tag for _, tag in model.getBoundary(solids, combined=False, oriented=False)}
    faces = [(tag, _corners(gmsh, tag), model.getBoundingBox(2, tag)) for tag in tags]
    tolerance = SMALL * size + INFLATED
    places = [place for tag, _, b in faces for place in _places(gmsh, tag, b)]
    box, flat = [], []
    for pick, sign, shift in ((min, -1, 0), (max, 1, 3)):
        for k in range(3):
            side = pick(point[k] for _, points, _ in faces for point in points)
            beyond = pick(b[k + shift] for b in boxes) + sign * MARGIN * size
            flush = [
                [*points, _middle(gmsh, tag)]
                for tag, points, b in faces
                if max(abs(b[k] - side), abs(b[k + 3] - side)) < tolerance
            ]
            behind = [point.copy() for points in flush for point in points]
            for point in behind:
                point[k] += sign * BEHIND * size
            free = not any(model.isInside(*s, [x for p in behind for x in p]) for s in solids)
            last = all(sign * (place[k] - side) < tolerance for place in places)
            flat.append(bool(flush) and free and last)
            box.append(float(side if flat[-1] else beyond))
    return box, flat


def _corners(gmsh, face: int) -> list[list[float]]:
    ends = gmsh.model.getBoundary([(2, face)], recursive=True)
    return [list(gmsh.model.getValue(0, tag, [])) for _, tag in ends]


def _places(gmsh, face: int, box: list[float]) -> list[list[float]]:
    """Points that bound a face: the ends of its box, or points on it where such boxes are too
    large, as with splines."""
    if gmsh.model.getType(2, face) in EXACT:
        return [list(box[:3]), list(box[3:])]
    low, high = gmsh.model.getParametrizationBounds(2, face)
    steps = [(i / GRID, j / GRID) for i in range(GRID + 1) for j in range(GRID + 1)]
    grid = [[a + s * (b - a) for s, a, b in zip(st, low, high, strict=True)] for st in steps]
    inside = [uv for uv in grid if gmsh.model.isInside(2, face, uv, parametric=True)]
    return [list(gmsh.model.getValue(2, face, uv)) for uv in inside]


def _middle(gmsh, face: int) -> list[float]:
    """The point of the face's surface in the middle of its parameters."""
    low, high = gmsh.model.getParametrizationBounds(2, face)
    return list(gmsh.model.getValue(2, face, [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2]))
