"""Pictures of a whole run: movie, film strip, paths, and what becomes of bodies over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from cadbem.boundary import Boundary
from cadbem.post.bodies.movie import draw_movie, filmstrip
from cadbem.post.bodies.time_series import draw_series
from cadbem.post.bodies.trajectories import draw_trajectories
from cadbem.post.fields.frames import Frame, extent_of
from cadbem.post.files.export import prepared
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.post.style.style import quantity_label
from cadbem.spline.basis import Array
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.history import Course, History
from cadbem.units import UnitNames

STILL = 1e-3  # way, as a share of what there is to see, below which bodies stay where they are
ALL = ("movie.gif", "filmstrip.png", "paths.png", "series.png", "along.png")
Series = Mapping[str, Array | Mapping[int, Array]]


def draw_run(
    folder: str | PathLike[str],
    run: History,
    pictures: Sequence[str] = ALL,
    *,
    channel: Boundary | None = None,
    units: UnitNames | None = None,
    colour: str = "",
) -> list[Path]:
    """Draw a run into a ``folder``, or nothing for a run's folder that keeps nothing; returns what
    was drawn.

    ``pictures`` names those to draw: a movie (movie.gif, movie.mp4), a film strip, the paths of
    bodies that move (without a path where none does), and D, speed, narrowest gap and extra
    pressure over time and, in a channel, over x of the centres ("along.png").  ``channel`` is drawn
    in place of that of the run's flow, ``units`` are what labels say, ``colour`` names a field to
    colour bodies by, see ``draw_movie``.
    """
    if not folder:
        return []
    flow = run.last.flow
    if channel is None and isinstance(flow, ChannelFlow):
        channel = flow.problem.boundary
    frames = [Frame(state.time, state.shapes) for state in run.states]
    tracks: dict[str | int, Array] = {n: run.track(n)[1] for n in run.numbers}
    drawn = RunPictures(Path(folder), channel, frames, tracks, units, colour)
    series = series_of(run, drawn.moving) if "series.png" in pictures else None
    made = drawn.draw(pictures, run.times, series)
    if "along.png" in pictures and drawn.moving and isinstance(flow, ChannelFlow):
        made.append(prepared(drawn.folder / "along.png"))
        draw_plots(made[-1], along(run, units))
    return made


@dataclass(frozen=True, eq=False)
class RunPictures:
    """A run as pictures know it: where they go, the ``channel`` or None, ``frames``, and the
    ``tracks`` (dim, N) of bodies, by number."""

    folder: Path
    channel: Boundary | None
    frames: Sequence[Frame]
    tracks: Mapping[str | int, Array]
    units: UnitNames | None = None
    colour: str = ""

    @property
    def moving(self) -> bool:
        """Whether any body moves by more than it would with rounding and quadrature errors."""
        size = float(np.ptp(extent_of(None, self.frames[:1]), axis=1).max())
        ways = [float(np.ptp(track, axis=1).max()) for track in self.tracks.values()]
        return max(ways) > STILL * size

    def draw(
        self, pictures: Sequence[str], times: Array | None = None, series: Series | None = None
    ) -> list[Path]:
        """Draw those of the ``pictures`` that there is something to see on.

        The names of movie and film strip get that of the colour's field.
        """
        ending = f"_{self.colour.replace(' ', '_')}" if self.colour else ""
        made = []
        for name in pictures:
            path = self.folder / name
            if path.stem in ("movie", "filmstrip"):
                draw: Any = draw_movie if path.stem == "movie" else filmstrip
                path = path.with_stem(path.stem + ending)
                look = {"colour": self.colour, "units": self.units}
                made.append(draw(path, self.channel, self.frames, **look))
            elif path.stem == "series" and series:
                assert times is not None
                made.append(draw_series(path, times, series, units=self.units))
            elif path.stem == "paths" and self.moving:
                made.append(draw_trajectories(path, self.channel, self.tracks, units=self.units))
        return made


def series_of(run: History, moving: bool) -> Series:
    """What ``draw_series`` shows of a run: quantities that are known at more than one time."""
    courses = [run.course(number) for number in run.numbers]
    named = {"D": [c.deformation for c in courses], "narrowest gap": [c.gap for c in courses]}
    if moving:
        named = {"speed": [c.speed for c in courses]} | named
    pressures = {f"extra pressure, {name}": v for name, v in run.extra_pressure.items()}
    return {
        label: {c.number: _placed(run.times, c, v) for c, v in zip(courses, values, strict=True)}
        for label, values in named.items()
        if any(np.isfinite(v).sum() > 1 for v in values)
    } | pressures


def along(run: History, units: UnitNames | None = None) -> list[Plot]:
    """Plots of what becomes of bodies over x of their centres."""
    courses = [run.course(number) for number in run.numbers]
    wanted: dict[str, Callable[[Course], Array]] = {
        "D": lambda c: c.deformation,
        "speed": lambda c: c.speed,
        "narrowest gap": lambda c: c.gap,
        **{f"extra pressure, {n}": partial(_extra, n) for n in run.extra_pressure},
    }
    length = "" if units is None else units.length
    plots = []
    for label, value in wanted.items():
        curves = [
            Curve(c.centre[0], np.where(np.isfinite(value(c)), value(c), np.nan),
                  f"body {c.number}" if len(courses) > 1 else "", colour=c.number)
            for c in courses
            if np.isfinite(value(c)).any()
        ]  # fmt: skip
        shown = label if units is None else quantity_label(label, length, units)
        x = f"x of the centre ({length})" if length else "x of the centre"
        plots += [Plot(x, shown, curves)] if curves else []
    return plots


def _extra(opening: str, course: Course) -> Array:
    return course.extra_pressure[opening]


def _placed(times: Array, course: Course, values: Array) -> Array:
    """A body's values at each of a run's times, not a number where there is none."""
    placed = np.full(len(times), np.nan)
    placed[np.searchsorted(times, course.times)] = np.where(np.isfinite(values), values, np.nan)
    return placed
