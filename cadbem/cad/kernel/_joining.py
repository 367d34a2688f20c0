"""A file's shapes joined as far as they need it: loose faces sewn and closed to solids, edges and
faces that are too small removed. Part of `_child.py`."""

from __future__ import annotations

SEWING = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5)  # tolerances tried, per size of the model
SMALL = 1e-6  # edges shorter and faces narrower than this, per size of the model, are mistakes
APART = 20.0  # extent of a model, in extents of its largest face, from which parts are far apart
SAME = 1e-6  # difference of place, per size of the model, and of area of faces that are the same
POLE = "Unknown"  # the kernel's word for an edge that is a point
REMEDIES = (
    {"fixSmallFaces": True},
    {"fixSmallEdges": True, "sewFaces": True},
    {"fixSmallEdges": True, "fixSmallFaces": True, "sewFaces": True},
)


def imported(gmsh, source: str, most: float = 0.0) -> dict:
    """Reads the file; says whether faces were `sewn`, and in words what was `healed`. Gaps up to
    `most` per size are sewn, if those of `SEWING` do not do."""
    _load(gmsh, source)
    sewing, twice = 0.0, 0
    loose = bool(gmsh.model.getEntities(2)) and not gmsh.model.getEntities(3)
    if loose:
        sewing, twice = _sew(gmsh, source, most)
    healed = []
    if twice:
        healed = [f"{twice} face{' was' if twice == 1 else 's were'} there twice and left out once"]
    if gmsh.model.getEntities(3):
        healed += _repair(gmsh, source, sewing, loose)
    return {"sewn": sewing > 0, "healed": healed}


def _load(gmsh, source: str) -> None:
    gmsh.clear()
    gmsh.model.occ.importShapes(source, highestDimOnly=False)
    gmsh.model.occ.synchronize()


def _heal(gmsh, source: str, tolerance: float, remedies: dict, loose: bool) -> None:
    """The file read again, and healed as a whole: given one by one, faces would not be joined.
    The kernel makes solids of what is not `loose`; of loose faces it would keep one shell only."""
    _load(gmsh, source)
    off = dict.fromkeys(("fixDegenerated", "fixSmallEdges", "fixSmallFaces", "sewFaces"), False)
    if any(remedies.values()):
        chosen = off | remedies
        gmsh.model.occ.healShapes([], tolerance=tolerance, makeSolids=not loose, **chosen)
        gmsh.model.occ.synchronize()
    if loose:
        _close(gmsh)


def _size(gmsh) -> float:
    """The model's extent; of parts far apart that of the largest face, times `APART`."""
    faces = [_extent(gmsh.model.getBoundingBox(2, tag)) for _, tag in gmsh.model.getEntities(2)]
    whole = _extent(gmsh.model.getBoundingBox(-1, -1))
    return min(whole, APART * max(faces, default=whole))


def _extent(box) -> float:
    return max(high - low for low, high in zip(box[:3], box[3:], strict=True))


# Sewing: only what is needed


def _sew(gmsh, source: str, most: float) -> tuple[float, int]:
    """Join loose faces into solids, or at least to each other. The smallest tolerance (returned)
    that does best is taken, 0 if faces are as well off as they were; and faces that are there twice
    (their number is returned) are taken once if that closes the rest."""
    size = _size(gmsh)
    found = [(_looseness(gmsh), 0.0)]
    wider = [most * share for share in (0.1, 0.3, 1.0) if most * share > SEWING[-1]]
    for tolerance in (*SEWING, *wider):
        _heal(gmsh, source, tolerance * size, {"sewFaces": True}, True)
        found.append((_looseness(gmsh), tolerance * size))
        if gmsh.model.getEntities(3) and not _loose_faces(gmsh):
            return found[-1][1], 0
    best = min(found)[1]
    _load(gmsh, source)
    twice = _doubles(gmsh)
    if twice and best:
        gmsh.model.occ.remove([(2, tag) for tag in twice], recursive=True)
        options = {"fixDegenerated": False, "fixSmallEdges": False, "fixSmallFaces": False}
        gmsh.model.occ.healShapes([], tolerance=best, sewFaces=True, makeSolids=False, **options)
        gmsh.model.occ.synchronize()
        _close(gmsh)
        if gmsh.model.getEntities(3) and not _loose_faces(gmsh):
            return best, len(twice)
    _heal(gmsh, source, best, {"sewFaces": best > 0}, True)
    return best, 0


def _doubles(gmsh) -> list[int]:
    """Faces with the middle, the box and the area of one before them."""
    occ, near = gmsh.model.occ, SAME * _size(gmsh)
    known: list[tuple] = []
    doubles = []
    for _, tag in gmsh.model.getEntities(2):
        area = occ.getMass(2, tag)
        place = [*occ.getCenterOfMass(2, tag), *gmsh.model.getBoundingBox(2, tag)]
        same = any(
            abs(area - other) <= SAME * area
            and max(abs(a - b) for a, b in zip(place, there, strict=True)) <= near
            for other, there in known
        )
        if same:
            doubles.append(tag)
        known.append((area, place))
    return doubles


def _looseness(gmsh) -> tuple[bool, int, int]:
    """Whether there is no solid, faces of none, edges of one face: seams, too."""
    alone = sum(
        len(gmsh.model.getAdjacencies(1, tag)[0]) == 1 for _, tag in gmsh.model.getEntities(1)
    )
    return not gmsh.model.getEntities(3), _loose_faces(gmsh), alone


def _loose_faces(gmsh) -> int:
    faces = gmsh.model.getEntities(2)
    return sum(not len(gmsh.model.getAdjacencies(2, tag)[0]) for _, tag in faces)


# Solids of loose faces: the kernel's own way drops all shells but one


def _close(gmsh) -> None:
    """Make solids of closed shells; those that lie in another one are cavities of it."""
    shells = [shell for shell in _shells(gmsh) if _is_closed(gmsh, shell)]
    loops = [gmsh.model.occ.addSurfaceLoop(shell) for shell in shells]
    alone = [gmsh.model.occ.addVolume([loop]) for loop in loops]
    gmsh.model.occ.synchronize()
    order = sorted(range(len(shells)), key=lambda k: -abs(gmsh.model.occ.getMass(3, alone[k])))
    around = {
        k: [j for j in order if j != k and _lies_in(gmsh, shells[k], alone[j])] for k in order
    }
    holes: dict[int, list[int]] = {k: [] for k in order if len(around[k]) % 2 == 0}
    for k in order:
        if k not in holes:  # the innermost one around it is the smallest
            holes[around[k][-1]].append(k)
    gmsh.model.occ.remove([(3, alone[k]) for k in order if k not in holes or holes[k]])
    for k, inner in holes.items():
        if inner:
            gmsh.model.occ.addVolume([loops[k], *(loops[j] for j in inner)])
    gmsh.model.occ.synchronize()
    used = {face for shell in shells for face in shell}  # solids have copies of some of them
    left = [f for f in used if not len(gmsh.model.getAdjacencies(2, f)[0])]
    gmsh.model.occ.remove([(2, face) for face in left], recursive=True)
    gmsh.model.occ.synchronize()


def _shells(gmsh) -> list[list[int]]:
    """Faces that hang together by edges."""
    left = [tag for _, tag in gmsh.model.getEntities(2)]
    shells = []
    while left:
        shell = [left.pop(0)]
        for face in shell:
            edges = gmsh.model.getAdjacencies(2, face)[1]
            near = {n for edge in edges for n in gmsh.model.getAdjacencies(1, edge)[0]} - {face}
            shell += [tag for tag in left if tag in near]
            left = [tag for tag in left if tag not in near]
        shells.append(sorted(shell))
    return shells


def _is_closed(gmsh, shell: list[int]) -> bool:
    """Whether each edge is passed twice; a face lists both sides of its seam."""
    edges = [edge for face in shell for edge in gmsh.model.getAdjacencies(2, face)[1]]
    real = [edge for edge in edges if gmsh.model.getType(1, edge) != POLE]
    return bool(real) and all(real.count(edge) == 2 for edge in set(real))


def _lies_in(gmsh, shell: list[int], solid: int) -> bool:
    """Whether middles of all edges of a shell lie inside a solid."""
    edges = {edge for face in shell for edge in gmsh.model.getAdjacencies(2, face)[1]}
    for edge in edges:
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
        middle = gmsh.model.getValue(1, edge, [0.5 * (low + high)])
        if not gmsh.model.isInside(3, solid, middle):
            return False
    return True


# Repair: only if it makes nothing worse


def _repair(gmsh, source: str, sewing: float, loose: bool) -> list[str]:
    """Remove edges and faces that are too small to be meant; [] if there are none, or if no
    remedy leaves a model that is as good. `sewing` is the tolerance it has been sewn with, or 0."""
    tolerance = SMALL * _size(gmsh)
    before = _health(gmsh, tolerance)
    if not before["short"] + before["narrow"]:
        return []
    sewn = {"sewFaces": sewing > 0}
    for remedies in REMEDIES:
        _heal(gmsh, source, max(tolerance, sewing), sewn | remedies, loose)
        after = _health(gmsh, tolerance)
        if _is_better(before, after, tolerance):
            counts = (f"{before[what]} {what} became {after[what]}" for what in ("faces", "edges"))
            return [
                f"{before['short']} edges shorter and {before['narrow']} faces narrower than "
                f"{tolerance:.1g} mm were removed ({', '.join(counts)})"
            ]
    _heal(gmsh, source, sewing, sewn, loose)
    return []


def _health(gmsh, tolerance: float) -> dict:
    """Counts, volume and area of the model, and of what is smaller than the tolerance."""
    occ, model = gmsh.model.occ, gmsh.model
    lengths = {tag: occ.getMass(1, tag) for _, tag in model.getEntities(1)}
    areas = {tag: occ.getMass(2, tag) for _, tag in model.getEntities(2)}
    uses = {tag: model.getAdjacencies(1, tag)[0] for tag in lengths}
    borders = {tag: model.getAdjacencies(2, tag)[1] for tag in areas}
    short = [t for t, x in lengths.items() if x < tolerance and model.getType(1, t) != POLE]
    perimeters = {tag: sum(lengths[edge] for edge in edges) for tag, edges in borders.items()}
    return {
        "solids": len(model.getEntities(3)),
        "faces": len(areas),
        "edges": len(lengths),
        "alone": sum(len(faces) == 1 for faces in uses.values()),
        "short": len(short),
        "narrow": sum(2 * area < tolerance * perimeters[t] for t, area in areas.items()),
        "area": sum(areas.values()),
        "volume": sum(occ.getMass(3, tag) for _, tag in model.getEntities(3)),
    }


def _is_better(before: dict, after: dict, tolerance: float) -> bool:
    """Whether nothing small is left and nothing else is lost: a layer as thick as the tolerance."""
    fewer = all(after[what] <= before[what] for what in ("faces", "edges", "alone"))
    same = after["solids"] == before["solids"]
    kept = abs(after["volume"] - before["volume"]) <= tolerance * before["area"]
    return fewer and same and kept and not after["short"] + after["narrow"]
