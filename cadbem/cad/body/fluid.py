"""The choice of the fluid: one of the solids of a file, or one of the cavities in them."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Sequence, Sized
from dataclasses import dataclass, replace

import numpy as np

from cadbem.cad.body.between import Pick, room_between
from cadbem.cad.body.material import material_of, without_doubles
from cadbem.cad.body.orientation import Shell, shells_of
from cadbem.cad.body.ports import Ports
from cadbem.cad.body.rooms import Fluid, void_room
from cadbem.cad.body.sheets import names_by_sheets
from cadbem.cad.faces.face_geometry import edge_points
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.kernel.process import KernelModel
from cadbem.cad.labels.step_solids import sheet_names, shell_names, solid_names
from cadbem.cad.text.source import CadSource
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError
from cadbem.spline.basis import Array

LISTED = 5  # choices that a question spells out
_UNSAID = re.compile(r"|Open CASCADE STEP translator.*|SOLID|COMPOUND|=>\[.*\]|NONE")


@dataclass(frozen=True, eq=False)
class _Body:
    """A solid, or a piece of the room in solids: its number and names, shells with outer first."""

    number: int
    names: tuple[str, ...]
    shells: list[Shell]

    @property
    def faces(self) -> tuple[BrepFace, ...]:
        return tuple(face for shell in self.shells for face in shell.faces)

    @property
    def volume(self) -> float:
        return float(sum(shell.volume for shell in self.shells))


def room_of(fluid: int | str) -> str:
    """The shape that the kernel has to prepare: "solid", "all" or "void".

    Raises CadError if `fluid` is neither a name nor a number from 1.
    """
    number = isinstance(fluid, int) and not isinstance(fluid, bool) and fluid > 0
    if not number and not (isinstance(fluid, str) and fluid):
        raise CadError(
            f"fluid={fluid!r}: give a solid's name or number (from 1), "
            "'solid', 'material', 'all' or 'void'"
        )
    if isinstance(fluid, str) and re.fullmatch(r"void( \d+)?", fluid):
        return "void"
    return "all" if fluid == "all" else "solid"


def choose_fluid(
    source: CadSource,
    unit: Unit,
    kernel: KernelModel,
    faces: Sequence[BrepFace],
    fluid: int | str = "solid",
    between: Sequence[Pick] = (),
) -> Fluid:
    """The faces that `fluid` or `between` (see `read_cad`) select from those that `import_model`
    found.

    Raises CadError if there is no such solid, shell or void.
    """
    solids: dict[int, list[BrepFace]] = defaultdict(list)
    for face in faces:
        if face.outward:
            solids[face.solid].append(face)
    loose = solids.pop(0, [])
    if solids and not kernel.box and (between or room_of(fluid) == "void"):
        material = material_of(source.name, unit, solids)
        if between:
            return room_between(source.name, unit, material, between)
        return void_room(source.name, unit, material, str(fluid))
    if between:
        raise CadError(
            f"{source.name}: the faces form no solid, which mouths could lead into; close them in "
            "the CAD program and export solids"
        )
    chooser = _Chooser(source, unit, kernel, solids)
    if not solids:
        return chooser.without_solid(loose, fluid)
    stray = [*loose, *(face for face in faces if not face.outward)]
    found = chooser.chosen(fluid)
    said = sheet_names(source, stray, unit) if stray else {}
    said = {number: name for number, name in said.items() if not _UNSAID.fullmatch(name)}
    named, left = names_by_sheets(found.faces, stray, said)
    warnings = (*found.warnings, *chooser.left_out(left, said))
    return replace(found, warnings=warnings, sheets=named)


@dataclass(frozen=True, eq=False)
class _Chooser:
    source: CadSource
    unit: Unit
    kernel: KernelModel
    solids: dict[int, list[BrepFace]]

    @property
    def file(self) -> str:
        return self.source.name

    def without_solid(self, loose: list[BrepFace], fluid: int | str) -> Fluid:
        if fluid not in ("solid", "material"):
            raise CadError(
                f"{self.file}: fluid={fluid!r}: the file's faces form no solid; "
                "close them in the CAD program and export a solid"
            )
        faces = [face for shell in shells_of(loose) for face in shell.faces]
        return Fluid(tuple(sorted(faces, key=lambda face: face.number)))

    def chosen(self, fluid: int | str) -> Fluid:
        if room_of(fluid) == "void":
            return self._void(str(fluid))
        bodies = self._bodies()
        if fluid == "all":
            return self._together(bodies)
        if fluid in ("solid", "material"):
            everything = tuple(face for body in bodies for face in body.faces)
            question = self._question(bodies, fluid == "material")
            return Fluid(everything, question) if question else self._one(bodies[0])
        if isinstance(fluid, int):
            return self._one(self._numbered(bodies, fluid, "solid"))
        return self._named(bodies, fluid)

    def _bodies(self) -> list[_Body]:
        several = len(self.solids) > 1
        labels = solid_names(self.source, self._faces(), self.unit) if several else {}
        bodies = []
        for number, faces in self.solids.items():
            counts = Counter(labels[face.number] for face in faces if face.number in labels)
            names = [name for name, _ in counts.most_common(1)]
            names.append(self.kernel.solids[number - 1].split("/")[-1])
            said = tuple(dict.fromkeys(name for name in names if not _UNSAID.fullmatch(name)))
            bodies.append(_Body(number, said, shells_of(faces)))
        return bodies

    def _faces(self) -> list[BrepFace]:
        return [face for faces in self.solids.values() for face in faces]

    # answers

    def _one(self, body: _Body) -> Fluid:
        faces, doubled = without_doubles(body.faces)
        return Fluid(faces, warnings=self.left_out(doubled, {}), bodies=(body.number,))

    def _together(self, bodies: list[_Body]) -> Fluid:
        faces = without_doubles(face for body in bodies for face in body.faces)[0]
        return Fluid(faces, bodies=tuple(body.number for body in bodies))

    def _named(self, bodies: list[_Body], name: str) -> Fluid:
        found = [body for body in bodies if name in body.names]
        if len(found) == 1:
            return self._one(found[0])
        if found:
            raise CadError(
                f"{self.file}: {len(found)} solids are called {name!r} ({self._listed(found)}); "
                "give fluid the number of one"
            )
        labels = shell_names(self.source, self._faces(), self.unit)
        inner = [shell for body in bodies for shell in body.shells[1:]]
        called = [shell for shell in inner if name in {labels.get(f.number) for f in shell.faces}]
        if len(called) == 1:
            return Fluid(called[0].flipped().faces)
        others = sorted({labels[f.number] for s in inner for f in s.faces if f.number in labels})
        cavities = f" and the inner shells {others}" if others else ""
        raise CadError(
            f"{self.file}: no solid or inner shell is called {name!r}; "
            f"there is {self._listed(bodies)}{cavities}"
        )

    def _void(self, fluid: str) -> Fluid:
        pieces = [_Body(number, (), shells_of(faces)) for number, faces in self.solids.items()]
        ports = Ports(np.reshape(self.kernel.box, (2, 3)), np.reshape(self.kernel.flat, (2, 3)))
        pieces = [piece for piece in pieces if not ports.is_outside(piece.faces)]
        if not pieces:
            raise CadError(
                f"{self.file}: no room in the solid is closed by flat sides of its box; "
                "turn the solid parallel to the axes, or draw the fluid's space in the CAD program"
            )
        pieces.sort(key=lambda piece: _rank(piece, ports))
        voids = [replace(piece, number=n) for n, piece in enumerate(pieces, start=1)]
        if fluid != "void":
            voids = [self._numbered(voids, int(fluid.split()[1]), "void")]
        faces = tuple(face for void in voids for face in void.faces)
        if len(voids) == 1:
            return Fluid(faces, ports=ports.names(faces))
        question = (
            f"{self.file}: {len(voids)} rooms in and around the solid "
            f"({self._listed(voids, ports)}); which is the fluid? say fluid='void 1' or another"
        )
        return Fluid(faces, question)

    def _numbered(self, bodies: list[_Body], number: int, what: str) -> _Body:
        for body in bodies:
            if body.number == number:
                return body
        raise CadError(
            f"{self.file}: there is no {what} {number}, only {self._listed(bodies)}; "
            "give fluid one of these numbers"
        )

    # questions

    def _question(self, bodies: list[_Body], material: bool) -> str:
        if len(bodies) > 1:
            name = f" or fluid={bodies[0].names[0]!r}" if bodies[0].names else ""
            return (
                f"{self.file}: {len(bodies)} solids ({self._listed(bodies)}); which is the fluid? "
                f"say fluid=1{name} for one, 'all' for all together, 'void' for the room in them"
            )
        holes = bodies[0].shells[1:]
        if material or not holes or any(np.isnan(s.volume) for s in bodies[0].shells):
            return ""
        labels = shell_names(self.source, self._faces(), self.unit)
        names = [labels.get(shell.faces[0].number, "") for shell in holes]
        cavities = [
            _Body(number, (name,) if name else (), [hole.flipped()])
            for number, (hole, name) in enumerate(zip(holes, names, strict=True), start=1)
        ]
        inside = f"fluid={names[0]!r}" if names[0] else "fluid='void'"
        return (
            f"{self.file}: the solid has {len(holes)} closed "
            f"{'cavity' if len(holes) == 1 else 'cavities'} ({self._listed(cavities)}); where is "
            f"the fluid? say {inside} for inside, fluid='material' for between the shells"
        )

    def _listed(self, bodies: list[_Body], ports: Ports | None = None) -> str:
        words = []
        for body in bodies[:LISTED]:
            name = f" {body.names[0]!r}" if body.names else ""
            low, high = body.shells[0].bounds() / self.unit.millimetres
            place = ", ".join(f"{x:.4g}" for x in _rounded(low, high))
            openings = ""
            if ports is not None:
                openings = f", {_counted(ports.names(body.faces), 'port')}"
            size = body.volume / self.unit.millimetres**3
            volume = "" if np.isnan(size) else f", volume {size:.3g}"
            words.append(
                f"{body.number}{name} with {_counted(body.faces, 'face')}{openings} about "
                f"[{place}] {self.unit.name}{volume}"
            )
        return "; ".join(words) + ("; ..." if len(bodies) > LISTED else "")

    def left_out(self, faces: Sequence[BrepFace], names: dict[int, str]) -> tuple[str, ...]:
        """A line on faces that do not bound the fluid, with the names that some of them have."""
        if not faces:
            return ()
        said = sorted({names[face.number] for face in faces if face.number in names})
        called = f" {', '.join(map(repr, said))}, which names no face" * bool(said)
        points = edge_points(faces[0]) / self.unit.millimetres
        place = ", ".join(f"{x:.4g}" for x in _rounded(points.min(axis=0), points.max(axis=0)))
        count = "1 face bounds" if len(faces) == 1 else f"{len(faces)} faces bound"
        return (
            f"{self.file}: {count} no volume (a sheet inside or beside it), the first about "
            f"[{place}] {self.unit.name}: left out{called}",
        )


def _counted(things: Sized, what: str) -> str:
    return f"{len(things)} {what}{'s' * (len(things) != 1)}"


def _rounded(low: Array, high: Array) -> Array:
    """Middle of a box, without the noise of a zero."""
    middle, size = 0.5 * (low + high), float(np.ptp([low, high]))
    return np.where(np.abs(middle) < 1e-12 * size, 0.0, middle)


def _rank(piece: _Body, ports: Ports) -> tuple:
    """Large rooms first, equal ones by x, y, z of their middle."""
    middle = piece.shells[0].bounds().mean(axis=0)
    return (-float(f"{np.nan_to_num(piece.volume):.6e}"), *ports.grid(middle))
