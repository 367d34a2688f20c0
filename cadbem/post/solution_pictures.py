"""Pictures and files of a solved flow, all at once."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from cadbem.cad import mesh_volume
from cadbem.checks import positive
from cadbem.post.channel.view_boundary import draw_boundary, draw_collocation
from cadbem.post.channel.view_flow import draw_slices, draw_streamlines
from cadbem.post.channel.view_walls import draw_traction
from cadbem.post.fields.bezier import bezier_grid
from cadbem.post.fields.volume import volume_grid
from cadbem.post.files.export import write_vtu
from cadbem.problems.solution import StokesSolution
from cadbem.units import UnitNames

ON_WALLS = ("faces.png", "collocation.png", "traction.png")
INSIDE = ("slices.png", "streamlines.png", "volume.vtu")
FOR_PARAVIEW = ("walls.vtu",)


def draw_solution(
    folder: str | PathLike[str],
    solution: StokesSolution,
    geometry: str | Path,
    mesh_size: float,
    pictures: Sequence[str] = (*ON_WALLS, *INSIDE, *FOR_PARAVIEW),
    *,
    units: UnitNames | None = None,
) -> None:
    """Draw a solved flow into a ``folder``, or nothing for a run's folder that keeps nothing.

    ``pictures`` names those to make: faces, collocation points and stresses on the walls; slices
    and streamlines on a mesh of the CAD file ``geometry``, whose cells have a ``mesh_size``; for
    ParaView that mesh, "volume.vtu", and the walls, "walls.vtu".  ``units`` are what labels say.
    """
    positive("mesh_size", mesh_size)
    if not folder:
        return
    place, channel = Path(folder), solution.space.boundary
    if "faces.png" in pictures:
        draw_boundary(channel, place / "faces.png")
    if "collocation.png" in pictures:
        draw_collocation(solution.space, place / "collocation.png")
    if "traction.png" in pictures:
        draw_traction(solution, place / "traction.png", units=units)
    if "walls.vtu" in pictures:
        fields = {"velocity": solution.velocity, "traction": solution.traction}
        write_vtu(place / "walls.vtu", bezier_grid(channel, fields))
    if set(INSIDE).isdisjoint(pictures):
        return
    grid = volume_grid(*mesh_volume(geometry, mesh_size), solution)
    if "slices.png" in pictures:
        draw_slices(grid, channel, place / "slices.png", units=units)
    if "streamlines.png" in pictures:
        draw_streamlines(grid, channel, place / "streamlines.png", units=units)
    if "volume.vtu" in pictures:
        write_vtu(place / "volume.vtu", grid)
