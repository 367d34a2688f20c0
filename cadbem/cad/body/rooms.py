"""Rooms in solids: where faces hang together once their mouths are cut, told apart from the outside
by the side on which they enclose a volume."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cadbem.cad.body.mouths import Mouth, find_mouths
from cadbem.cad.body.orientation import enclosed
from cadbem.cad.faces.face_geometry import real_uses
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError
from cadbem.spline.basis import Array

LISTED = 5  # rooms that a question spells out
GRID = 1e-6  # steps, per size, of coordinates by which mouths are ordered


@dataclass(frozen=True, eq=False)
class Fluid:
    """The faces round the fluid, normals (`outward` times ∂u × ∂v) out of it.

    If the file leaves a choice, `question` asks for it and `faces` are those of all candidates.
    `ports` are names of faces by number, `sheets` those that sheets on faces give them; `bodies`
    the solids of the record that are the fluid, () if it is a room between them; `caps` the numbers
    of faces that no solid has.
    """

    faces: tuple[BrepFace, ...]
    question: str = ""
    ports: dict[int, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    bodies: tuple[int, ...] = ()
    caps: frozenset[int] = frozenset()
    sheets: dict[int, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Room:
    """Faces round a room, normals out of it, its caps among them; mouths by the number of their cap
    in the order of x, y, z; volume in mm³ (nan if it cannot be computed)."""

    faces: tuple[BrepFace, ...]
    mouths: dict[int, Mouth]
    volume: float

    def ports(self) -> dict[int, str]:
        """port_1, port_2, ... by number of the cap."""
        return {number: f"port_{k}" for k, number in enumerate(self.mouths, start=1)}

    def __len__(self) -> int:
        return len(self.faces)


def void_room(file: str, unit: Unit, faces: Sequence[BrepFace], fluid: str) -> Fluid:
    """The room that `fluid` ("void", "void 2") selects; without faces if there is none.

    Raises CadError if there is no room of that number.
    """
    rooms = find_rooms(faces, find_mouths(faces))
    listed = "; ".join(_words(n, room, unit) for n, room in enumerate(rooms[:LISTED], start=1))
    number = int(fluid.split()[1]) if fluid != "void" else 1
    if not rooms:
        return Fluid(())
    if number > len(rooms):
        raise CadError(
            f"{file}: there is no void {number}, only {listed}; give fluid one of these numbers"
        )
    if fluid == "void" and len(rooms) > 1:
        more = "; ..." * (len(rooms) > LISTED)
        question = (
            f"{file}: {len(rooms)} rooms in the solid ({listed}{more}); which is the fluid? "
            "say fluid='void 1' or another"
        )
        return Fluid(tuple(face for room in rooms for face in room.faces), question)
    room = rooms[number - 1]
    return Fluid(room.faces, ports=room.ports(), caps=frozenset(room.mouths))


def _words(number: int, room: Room, unit: Unit) -> str:
    """A room and its mouths, with place and diameter."""
    named = zip(room.ports().values(), room.mouths.values(), strict=True)
    mouths = [f"{name} {place_of(mouth, unit)}" for name, mouth in named]
    volume = f"volume {room.volume / unit.millimetres**3:.3g}"
    plural = "s" * (len(room) != 1)
    return f"{number} with {', '.join([f'{len(room)} face{plural}', volume, *mouths])}"


def place_of(mouth: Mouth, unit: Unit) -> str:
    """Where a mouth is and how wide, in words."""
    place = ", ".join(f"{x + 0.0:.4g}" for x in np.round(mouth.middle / unit.millimetres, 12))
    return f"at [{place}] {mouth.diameter / unit.millimetres:.3g} {unit.name} wide"


def find_rooms(
    faces: Sequence[BrepFace], mouths: Sequence[Mouth], forced: Sequence[Mouth] = ()
) -> list[Room]:
    """The rooms in solids with these faces (normals out of the material), large ones first. Caps
    get numbers that no face has. A step inside a room, with the room on both sides, is no mouth,
    unless it is `forced`."""
    mouths = [*mouths, *forced]
    labels, sides = _parts(faces, mouths)
    outside = {part for part in set(labels) if _volume(faces, mouths, labels, sides, part) > 0}
    mouths = [
        mouth
        for mouth, ends in zip(mouths, sides, strict=True)
        if len(set(ends) & outside) == 1 or (mouth in forced and len(set(ends)) == 2)
    ]
    labels, sides = _parts(faces, mouths)
    order = sorted(range(len(mouths)), key=lambda k: grid(faces, mouths[k].middle))
    number = 1 + max(face.number for face in faces)
    caps = {k: replace(mouths[k].cap, number=number + n) for n, k in enumerate(order)}
    rooms = []
    for part in dict.fromkeys(labels):
        if _volume(faces, mouths, labels, sides, part) >= 0:
            continue
        own_faces = [face for face, label in zip(faces, labels, strict=True) if label == part]
        walls = [replace(face, outward=-face.outward) for face in own_faces]
        own = {caps[k].number: mouths[k] for k in order if part in sides[k]}
        lids = [
            replace(caps[k], outward=caps[k].outward * (1 if sides[k][1] == part else -1))
            for k in order
            if part in sides[k]
        ]
        around = (*walls, *lids)
        rooms.append(Room(around, own, enclosed(around)))
    return sorted(rooms, key=lambda r: (-float(f"{r.volume:.6e}"), *grid(faces, _middle(r))))


def _middle(room: Room) -> Array:
    points = np.array([m.middle for m in room.mouths.values()]).reshape(-1, 3)
    if not len(points):
        points = np.concatenate([use.ends for face in room.faces for use in real_uses(face)])
    return 0.5 * (points.min(axis=0) + points.max(axis=0))


def grid(faces: Sequence[BrepFace], point: Array) -> tuple[float, ...]:
    """Coordinates so rounded that digits do not decide an order."""
    corners = np.concatenate([use.ends for face in faces for use in real_uses(face)])
    return tuple(np.round(point / (GRID * np.ptp(corners, axis=0).max())).tolist())


def _parts(
    faces: Sequence[BrepFace], mouths: Sequence[Mouth]
) -> tuple[list[int], list[tuple[int, int]]]:
    """Number of the part of each face, with mouths cut; and those before and behind each mouth.
    Mouths that divide nothing have one part on both sides."""
    cut = {key for mouth in mouths for key in mouth.keys}
    parent = list(range(len(faces)))

    def root(k: int) -> int:
        while parent[k] != k:
            k = parent[k]
        return k

    first: dict[tuple, int] = {}
    for index, face in enumerate(faces):
        for use in real_uses(face):
            if use.key not in cut:
                parent[root(index)] = root(first.setdefault(use.key, index))
    labels = [root(k) for k in range(len(faces))]
    sides = [(labels[min(m.hosts)], labels[min(m.walls)]) for m in mouths]
    return labels, sides


def _volume(
    faces: Sequence[BrepFace],
    mouths: Sequence[Mouth],
    labels: list[int],
    sides: list[tuple[int, int]],
    part: int,
) -> float:
    """Enclosed by a part and the caps of its mouths: negative if it is a room."""
    around = [face for face, label in zip(faces, labels, strict=True) if label == part]
    for mouth, (host, wall) in zip(mouths, sides, strict=True):
        if host == part:
            around.append(mouth.cap)
        if wall == part:
            around.append(replace(mouth.cap, outward=-mouth.cap.outward))
    return enclosed(around)
