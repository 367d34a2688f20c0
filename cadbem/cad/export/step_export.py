"""The text of a STEP file (ISO 10303-21, schema AP214) that holds patches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from cadbem.boundary import Patch
from cadbem.cad.body.shells import Shells, Side
from cadbem.cad.text.digits import written
from cadbem.errors import CadError
from cadbem.spline.basis import Array, multiplicities
from cadbem.spline.nurbs import Nurbs

PREFIXES = {"m": "$", "mm": ".MILLI.", "cm": ".CENTI.", "dm": ".DECI.", "um": ".MICRO.",
            "nm": ".NANO.", "km": ".KILO.", "": ".MILLI."}  # fmt: skip
CONVERTED = {"inch": 25.4, "ft": 304.8}  # in millimetres
UNCERTAINTY = 1e-7  # of lengths, per size of the boundary
SCHEMA = "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }"


def step_text(shells: Shells, path: Path) -> str:
    """The whole file. Raises CadError for a unit that STEP does not know."""
    name = _string(path.name)
    writer = _Writer()
    context = _context(writer, shells, path.name)
    items, kind = _items(writer, shells)
    origin = writer.placement()
    shape = writer.add(f"{kind}('',({_list([origin, *items])}),{context})")
    _product(writer, _string(path.stem), context, shape)
    header = (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
        f"FILE_NAME({name},'1970-01-01T00:00:00',(''),(''),'cadbem','cadbem','');\n"
        f"FILE_SCHEMA(('{SCHEMA}'));\nENDSEC;\nDATA;\n"
    )
    return f"{header}{writer.text()}ENDSEC;\nEND-ISO-10303-21;\n"


class _Writer:
    """Entities in the order in which they are added; equal ones are written once."""

    def __init__(self) -> None:
        self._numbers: dict[str, str] = {}

    def add(self, entity: str) -> str:
        """The reference, such as #12, of an entity."""
        return self._numbers.setdefault(entity, f"#{len(self._numbers) + 1}")

    def point(self, point: Array) -> str:
        return self.add(f"CARTESIAN_POINT('',({_reals(point)}))")

    def placement(self) -> str:
        z, x = (self.add(f"DIRECTION('',({_reals(d)}))") for d in ((0, 0, 1), (1, 0, 0)))
        return self.add(f"AXIS2_PLACEMENT_3D('',{self.point(np.zeros(3))},{z},{x})")

    def text(self) -> str:
        return "".join(f"{number}={entity};\n" for entity, number in self._numbers.items())


def _context(writer: _Writer, shells: Shells, file: str) -> str:
    length = _length_unit(writer, shells.boundary.unit, file)
    angle = writer.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid = writer.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    size = UNCERTAINTY * float(np.ptp(shells.corners, axis=0).max())
    uncertainty = writer.add(
        f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({written(size)}),{length},"
        "'distance_accuracy_value','')"
    )
    return writer.add(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
        f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))REPRESENTATION_CONTEXT('',''))"
    )


def _length_unit(writer: _Writer, unit: str, file: str) -> str:
    if unit in CONVERTED:
        base = writer.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        amount = writer.add(
            f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({written(CONVERTED[unit])}),{base})"
        )
        exponents = writer.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
        return writer.add(
            f"(CONVERSION_BASED_UNIT('{unit.upper()}',{amount})LENGTH_UNIT()NAMED_UNIT({exponents}))"
        )
    if unit not in PREFIXES:
        known = ", ".join(u for u in (*PREFIXES, *CONVERTED) if u)
        raise CadError(f"{file}: the unit '{unit}' cannot be written; use one of {known}")
    return writer.add(f"(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({PREFIXES[unit]},.METRE.))")


def _items(writer: _Writer, shells: Shells) -> tuple[list[str], str]:
    """Solids, or where the patches do not close one shell; and the kind of representation."""
    parts = shells.parts()
    if not all(shells.is_closed(part) for part in parts):
        everything = tuple(range(len(shells.loops)))
        shell = writer.add(f"OPEN_SHELL('',({_faces(writer, shells, everything, inwards=True)}))")
        return [writer.add(f"SHELL_BASED_SURFACE_MODEL('',({shell}))")], (
            "MANIFOLD_SURFACE_SHAPE_REPRESENTATION"
        )
    volumes = {part: shells.volume(part) for part in parts}
    containers = [part for part in parts if volumes[part] > 0]
    bodies = [part for part in parts if volumes[part] <= 0]
    owners = {body: _owner(shells, body, containers) for body in bodies}
    solids = [
        _solid(writer, shells, part, [b for b in bodies if owners[b] == part])
        for part in containers
    ]
    alone = [_solid(writer, shells, part, []) for part in bodies if owners[part] is None]
    return solids + alone, "ADVANCED_BREP_SHAPE_REPRESENTATION"


def _owner(
    shells: Shells, body: tuple[int, ...], containers: list[tuple[int, ...]]
) -> tuple[int, ...] | None:
    """The smallest container whose box holds the body's."""
    low, high = _box(shells, body)
    around = []
    for part in containers:
        start, end = _box(shells, part)
        if (start <= low).all() and (high <= end).all():
            around.append((shells.volume(part), part))
    return min(around)[1] if around else None


def _box(shells: Shells, part: tuple[int, ...]) -> Array:
    points = [shells.boundary.patches[i].surface.points.reshape(-1, 3) for i in part]
    stacked = np.concatenate(points)
    return np.stack([stacked.min(axis=0), stacked.max(axis=0)])


def _solid(
    writer: _Writer, shells: Shells, part: tuple[int, ...], holes: list[tuple[int, ...]]
) -> str:
    inwards = shells.volume(part) > 0
    outer = writer.add(f"CLOSED_SHELL('',({_faces(writer, shells, part, inwards)}))")
    if not holes:
        return writer.add(f"MANIFOLD_SOLID_BREP('',{outer})")
    inner = [
        writer.add(f"CLOSED_SHELL('',({_faces(writer, shells, hole, inwards=False)}))")
        for hole in holes
    ]
    turned = [writer.add(f"ORIENTED_CLOSED_SHELL('',*,{shell},.F.)") for shell in inner]
    return writer.add(f"BREP_WITH_VOIDS('',{outer},({_list(turned)}))")


def _faces(writer: _Writer, shells: Shells, part: Sequence[int], inwards: bool) -> str:
    """Faces whose normals point out of what they enclose; the patches' may point `inwards`."""
    return _list(
        _face(writer, shells, shells.boundary.patches[i], shells.loops[i], inwards) for i in part
    )


def _face(
    writer: _Writer, shells: Shells, patch: Patch, loop: tuple[Side, ...], inwards: bool
) -> str:
    passes = loop if inwards else tuple(Side(s.edge, -s.sign) for s in reversed(loop))
    if passes:
        oriented = (
            writer.add(f"ORIENTED_EDGE('',*,*,{_edge(writer, shells, s.edge)},{_flag(s.sign > 0)})")
            for s in passes
        )
        bound = writer.add(f"EDGE_LOOP('',({_list(oriented)}))")
    else:
        vertex = writer.add(f"VERTEX_POINT('',{writer.point(patch.surface.points[0, 0])})")
        bound = writer.add(f"VERTEX_LOOP('',{vertex})")
    outer = writer.add(f"FACE_OUTER_BOUND('',{bound},.T.)")
    surface = writer.add(_spline(writer, patch.surface))
    return writer.add(
        f"ADVANCED_FACE({_string(patch.name)},({outer}),{surface},{_flag(not inwards)})"
    )


def _edge(writer: _Writer, shells: Shells, number: int) -> str:
    edge = shells.edges[number]
    start, end = (
        writer.add(f"VERTEX_POINT('',{writer.point(shells.corners[k])})")
        for k in (edge.start, edge.end)
    )
    curve = writer.add(_spline(writer, edge.curve))
    return writer.add(f"EDGE_CURVE('',{start},{end},{curve},.T.)")


def _spline(writer: _Writer, spline: Nurbs) -> str:
    """A curve or surface; rational only if its weights differ."""
    kind = "CURVE" if len(spline.degrees) == 1 else "SURFACE"
    nested = [_list(map(writer.point, row)) for row in _rows(spline.points, 2)]
    closed = [".F."] * (len(spline.degrees) + 1)  # closed in each direction, crosses itself
    form = [*map(str, spline.degrees), _joined(nested, kind), ".UNSPECIFIED.", *closed]
    values, counts = zip(*map(multiplicities, spline.knots), strict=True)
    knots = [f"({_list(map(str, c))})" for c in counts] + [f"({_reals(k)})" for k in values]
    knots.append(".UNSPECIFIED.")
    if np.ptp(spline.weights) == 0:
        return f"B_SPLINE_{kind}_WITH_KNOTS('',{_list([*form, *knots])})"
    weights = _joined([_reals(row) for row in _rows(spline.weights, 1)], kind)
    parts = {
        f"BOUNDED_{kind}": "",
        f"B_SPLINE_{kind}": _list(form),
        f"B_SPLINE_{kind}_WITH_KNOTS": _list(knots),
        "GEOMETRIC_REPRESENTATION_ITEM": "",
        f"RATIONAL_B_SPLINE_{kind}": weights,
        "REPRESENTATION_ITEM": "''",
        kind: "",
    }
    # parts of one entity stand in alphabetical order, '_' after letters
    ordered = sorted(parts, key=lambda name: name.replace("_", "~"))
    return f"({''.join(f'{name}({parts[name]})' for name in ordered)})"


def _rows(values: Array, dimension: int) -> Array:
    """The points or weights of a curve as one row, of a surface as one row a first parameter."""
    return values if values.ndim > dimension else values[None]


def _joined(rows: list[str], kind: str) -> str:
    nested = [f"({row})" for row in rows]
    return nested[0] if kind == "CURVE" else f"({_list(nested)})"


def _product(writer: _Writer, name: str, context: str, shape: str) -> None:
    """The entities of the product to which the shape belongs, as every STEP file has them."""
    schema = writer.add(
        "APPLICATION_CONTEXT('core data for automotive mechanical design processes')"
    )
    writer.add(
        "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,"
        f"{schema})"
    )
    mechanical = writer.add(f"PRODUCT_CONTEXT('',{schema},'mechanical')")
    product = writer.add(f"PRODUCT({name},{name},'',({mechanical}))")
    version = writer.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    design = writer.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{schema},'design')")
    definition = writer.add(f"PRODUCT_DEFINITION('design','',{version},{design})")
    whole = writer.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    writer.add(f"SHAPE_DEFINITION_REPRESENTATION({whole},{shape})")
    writer.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))")


def _list(words: Iterable[str]) -> str:
    return ",".join(words)


def _flag(value: bool) -> str:
    return ".T." if value else ".F."


def _reals(values: Iterable[float]) -> str:
    return _list(map(written, values))


def _string(text: str) -> str:
    """Quoted; apostrophes and backslashes doubled, other than ASCII as \\X2\\ code points."""
    code = "".join(
        c if " " <= c <= "~" else f"\\X2\\{c.encode('utf-16-be').hex().upper()}\\X0\\"
        for c in text.replace("\\", "\\\\").replace("'", "''")
    )
    return f"'{code}'"
