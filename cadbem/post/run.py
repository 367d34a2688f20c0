"""All pictures of a run at once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cadbem.boundary import Boundary
from cadbem.post.frames import Frame
from cadbem.post.movie import draw_movie, filmstrip
from cadbem.post.series import write_frames
from cadbem.post.trajectories import draw_trajectories

if TYPE_CHECKING:
    from cadbem.suspension.history import History


def draw_run(
    folder: str | Path, channel: Boundary | None, run: History, name: str = "bodies"
) -> list[Path]:
    """Movie, film strip and paths of bodies in a ``channel``, and in 3D files for ParaView.

    They are called ``name``.gif, .png, _paths.png, and _frames/bodies.pvd in the ``folder``.
    """
    frames = [Frame(state.time, state.shapes) for state in run.states]
    numbers = run.states[0].numbers
    place = Path(folder)
    made = [
        draw_movie(place / f"{name}.gif", channel, frames),
        filmstrip(place / f"{name}.png", channel, frames),
        draw_trajectories(
            place / f"{name}_paths.png", channel, {n: run.track(n)[1] for n in numbers}
        ),
    ]
    if run.states[0].bodies[0].dimension == 3:
        made.append(write_frames(place / f"{name}_frames", frames, channel))
    return made
