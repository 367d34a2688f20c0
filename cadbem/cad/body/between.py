"""The room between mouths that somebody picks: by number, by a point in each, or by a face."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cadbem.cad.body.mouths import Mouth, find_mouths, rings_round
from cadbem.cad.body.rooms import Fluid, Room, find_rooms, grid, place_of
from cadbem.cad.kernel.brep import BrepFace
from cadbem.cad.text.unit import Unit
from cadbem.errors import CadError

Pick = str | int | ArrayLike  # "mouth 2", the number of a face, or a point
LISTED = 12  # mouths that a message spells out
_NUMBERED = re.compile(r"mouth[ _]?(\d+)")


@dataclass(frozen=True, eq=False)
class Mouths:
    """The mouths of solids with these faces (normals out of the material), numbered from 1 by x,
    y, z of their middles, and the rooms behind them."""

    file: str
    unit: Unit
    faces: tuple[BrepFace, ...]
    mouths: tuple[Mouth, ...]
    rooms: tuple[Room, ...]

    def listed(self) -> str:
        """All of them, with place and diameter."""
        words = [f"mouth {k} {place_of(m, self.unit)}" for k, m in enumerate(self.mouths, 1)]
        return "; ".join(words[:LISTED]) + "; ..." * (len(words) > LISTED) if words else "none"

    def picked(self, pick: Pick) -> Mouth:
        """Raises CadError unless the pick is one mouth."""
        if isinstance(pick, str):
            return self._numbered(pick)
        if isinstance(pick, int | np.integer):
            return self._of_face(int(pick))
        point = np.asarray(pick, dtype=float)
        if point.shape != (3,):
            raise CadError(f"{self.file}: a point in a mouth has three coordinates, not {pick!r}")
        return self._at(point)

    def _numbered(self, word: str) -> Mouth:
        found = _NUMBERED.fullmatch(word)
        if found and 1 <= int(found[1]) <= len(self.mouths):
            return self.mouths[int(found[1]) - 1]
        raise CadError(
            f"{self.file}: there is no {word!r}; mouths found: {self.listed()}; "
            "give between one of these, a point in the mouth, or the number of its face"
        )

    def _of_face(self, number: int) -> Mouth:
        sides = [
            [m for m in self.mouths if number in {self.faces[k].number for k in side(m)}]
            for side in (lambda m: m.walls, lambda m: m.hosts)
        ]
        for found in sides:
            if len(found) == 1:
                return found[0]
        several = "several mouths" if any(sides) else "no mouth"
        raise CadError(
            f"{self.file}: face {number} has {several}; mouths found: {self.listed()}; "
            "pick one by its number, or by a point in it"
        )

    def _at(self, point: np.ndarray) -> Mouth:
        place = self.unit.millimetres * point
        near = sorted(self.mouths, key=lambda m: float(np.linalg.norm(m.middle - place)))
        near = [mouth for mouth in near if mouth.holds(place)] or rings_round(self.faces, place)
        if near:
            return near[0]
        raise CadError(
            f"{self.file}: no mouth is round the point {point.tolist()}; "
            f"mouths found: {self.listed()}; give a point in the middle of one"
        )


def find_all_mouths(file: str, unit: Unit, faces: Sequence[BrepFace]) -> Mouths:
    """All mouths in the faces of solids, whose normals point out of the material."""
    rooms = find_rooms(faces, find_mouths(faces))
    mouths = [mouth for room in rooms for mouth in room.mouths.values()]
    mouths.sort(key=lambda mouth: grid(faces, mouth.middle))
    return Mouths(file, unit, tuple(faces), tuple(mouths), tuple(rooms))


def room_between(
    file: str, unit: Unit, faces: Sequence[BrepFace], between: Sequence[Pick]
) -> Fluid:
    """The room that has all mouths of `between`; caps are called mouth_1, ... by their numbers.

    Raises CadError if a pick is no mouth, or if the mouths are not those of one room.
    """
    found = find_all_mouths(file, unit, faces)
    picked = [found.picked(pick) for pick in between]
    new = [mouth for mouth in picked if mouth not in found.mouths]
    numbers = {m.keys: k for k, m in enumerate((*found.mouths, *new), start=1)}
    rooms = find_rooms(faces, found.mouths, new) if new else found.rooms
    wanted = {mouth.keys for mouth in picked}
    fitting = [room for room in rooms if wanted <= {m.keys for m in room.mouths.values()}]
    if len(wanted) < len(picked) or len(fitting) != 1:
        whose = " and ".join(f"mouth {numbers[m.keys]} {place_of(m, unit)}" for m in picked)
        reason = "is picked twice" if len(wanted) < len(picked) else "belong to no common room"
        raise CadError(f"{file}: {whose} {reason}; mouths found: {found.listed()}")
    room = fitting[0]
    names = {cap: f"mouth_{numbers[m.keys]}" for cap, m in room.mouths.items()}
    others = [m for m in room.mouths.values() if m.keys not in wanted]
    more = [f"mouth {numbers[m.keys]} {place_of(m, unit)}" for m in others]
    said = f"{file}: the room has further mouths, which are capped, too: {'; '.join(more)}"
    warnings = (said,) if more else ()
    return Fluid(room.faces, ports=names, warnings=warnings, caps=frozenset(room.mouths))
