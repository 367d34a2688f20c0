"""Files that hold a chip, although its fluid was asked for."""

from __future__ import annotations

from pathlib import Path

from cadbem.cad.body.between import Mouths, find_all_mouths
from cadbem.cad.body.model import CadModel, open_model
from cadbem.cad.body.rooms import Room
from cadbem.cad.faces.face_geometry import size_of
from cadbem.errors import CadError

WIDE = 3.0  # faces this many times as wide as a hole in them, or wider, are no tube's end


def chip_remarks(path: str | Path, model: CadModel, time_limit: float) -> list[str]:
    """A line with all mouths if solids with openings into them have been taken for the fluid; of a
    room in solids one with the mouths that it has."""
    if model.ports:
        return [f"{model.file}: mouths of the room: {'; '.join(_mouths(model))}"]
    if not model.kernel.solids or model.kernel.box:
        return []
    try:  # solids that touch may close a room together
        whole = open_model(path, time_limit, fluid="all") if model.question else model
    except CadError:
        return []
    found = find_all_mouths(model.file, model.unit, whole.faces)
    if not any(_leads_inside(found, room) for room in found.rooms):
        return []
    return [
        f"{model.file}: this looks like a chip, with openings into it, not like a fluid; for the "
        "room inside say fluid='void', or pick its mouths as in between=('mouth 1', 'mouth 2'): "
        + found.listed()
    ]


def _mouths(model: CadModel) -> list[str]:
    """Name, place and width of each mouth of a room."""
    scale, unit = model.unit.millimetres, model.unit.name
    return [
        f"{model.names[face.number]} at {model.place(model.centre(face))}, "
        f"{size_of(face) / scale:.3g} {unit} wide"
        for face in model.faces
        if face.number in model.ports
    ]


def _leads_inside(found: Mouths, room: Room) -> bool:
    """Whether a room is more than a hole straight through a wide body, as round a pillar."""
    return len(room.mouths) > 1 and not (_is_straight(room) and _is_wide(found, room))


def _is_straight(room: Room) -> bool:
    """Whether all walls of the room reach from mouth to mouth."""
    sides = [mouth.walls for mouth in room.mouths.values()]
    walls = len(room.faces) - len(room.mouths)
    return len(room.mouths) == 2 and len(sides[0] & sides[1]) == walls


def _is_wide(found: Mouths, room: Room) -> bool:
    """Whether faces round the mouths are much wider than these."""
    return all(
        size_of(*(found.faces[k] for k in mouth.hosts)) > WIDE * mouth.diameter
        for mouth in room.mouths.values()
    )
