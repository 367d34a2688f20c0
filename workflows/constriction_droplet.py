"""A droplet squeezes through a smooth constriction that is read from a STEP file.

The channel is 1 mm high; its side walls, B-splines, go from 2 mm apart to 0.8 mm and back
(geometries/constriction.py).  The droplet, by default nine tenths as wide as the throat, is carried
through, and the run ends when it leaves at 'outlet'.

Units: mm, s, Pa s, Pa, hence mN/m = Pa mm for surface tension.  By default the outer fluid is a
viscous silicone oil, 1 Pa s, of mean velocity 1 mm/s at the inlet, and the tension is 20 mN/m:
Ca = μ U / γ is 0.125 with the mean velocity U in the throat.  The droplet has to stay clear of
floor and ceiling too; gaps are 0.06 to 0.14 mm wide, 0.7 to 1.6 times the distance of its points.
The extra pressure is small beside the 355 Pa of the empty channel; at this resolution it scatters
by about 3 Pa in the throat.

Prints D, the speed of the centre, the extra pressure drop that the droplet causes between inlet
and outlet at the same flow rate, and the narrowest gap over time; draws them, the path, a film
strip and a movie into a folder.  --viscosity-ratio λ is inner over outer viscosity; other values
than 1 take longer.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

GEOMETRY = Path(__file__).parents[1] / "geometries" / "constriction.step"
WIDEST, THROAT = 2.0, 0.8  # mm


@dataclass(frozen=True, eq=False)
class Passage:
    """Measures of a run at each of its times (N,): the centre's x and its speed, Taylor's D,
    the extra pressure drop and the narrowest gap, inf where it is wide."""

    run: cb.History
    x: np.ndarray
    speed: np.ndarray
    deformation: np.ndarray
    extra_pressure: np.ndarray
    gap: np.ndarray


def main(
    output: str = "results/constriction_droplet",
    radius: float = 0.36,
    start: float = -2.5,
    mean_velocity: float = 1.0,
    viscosity: float = 1.0,
    tension: float = 20.0,
    viscosity_ratio: float = 1.0,
    element_size: float = 0.33,
    points: int = 200,
    tolerance: float = 1e-2,
    end: float = 10.0,
    every: float = 0.05,
    resume: bool = False,
) -> Passage:
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    flow = empty_channel(element_size, viscosity, mean_velocity)
    speed = mean_velocity * WIDEST / THROAT
    print(f"throat: mean velocity {speed:g} mm/s, Ca = {viscosity * speed / tension:g}")

    # A round droplet on the centreline, at x = start
    shape = cb.spline_sphere(radius, (start, 0.0, 0.0), points)
    droplet = cb.Droplet(shape, cb.SurfaceTension(tension), viscosity_ratio)
    simulation = cb.Simulation(flow, droplet, stepper=cb.Adaptive(tolerance))
    passage = passage_of(cb.record(folder.run(simulation, end, every)), flow.empty)

    report(passage)
    folder.summary({
        "largest D": passage.deformation.max(),
        "largest extra pressure (Pa)": passage.extra_pressure.max(),
        "narrowest gap (mm)": passage.gap.min(),
        "end (s)": passage.run.last.time,
    })
    if folder:
        draw(folder, flow.problem.boundary, passage)
        print(f"the pictures are in {folder}")
    return passage


def empty_channel(element_size: float, viscosity: float, mean_velocity: float) -> cb.ChannelFlow:
    """The flow without the droplet."""
    # Geometry: 6 four-sided faces, two of them cubic B-splines
    channel = cb.read_cad(GEOMETRY).elevated(2).refined(size=element_size)

    # Problem: developed inflow, pressure zero at the outlet
    conditions = {
        "inlet": cb.Inflow(mean_velocity=mean_velocity),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    problem = cb.StokesProblem(channel, viscosity, conditions, cb.Quadrature(1e-4))
    flow = cb.ChannelFlow(problem)
    print(f"{problem.space.count} points, net flux / inflow {flow.empty.net_flux():.1e}")
    print(f"empty channel: pressure drop {pressure_drop(flow.empty):.2f} Pa")
    return flow


def pressure_drop(solution: cb.StokesSolution) -> float:
    """Mean pressure at the inlet less that at the outlet."""
    return solution.mean_pressure("inlet") - solution.mean_pressure("outlet")


def passage_of(run: cb.History, empty: cb.StokesSolution) -> Passage:
    """Centre, speed, D, extra pressure drop and gap at each time of a run."""
    centres = run.track(1)[1]
    return Passage(
        run=run,
        x=centres[0],
        speed=np.array([speed_of_centre(s) for s in run.states]),
        deformation=run.deformation,
        extra_pressure=np.array([pressure_drop(s.walls) for s in run.states])
        - pressure_drop(empty),
        gap=np.array([s.gaps[0].length for s in run.states]),
    )


def speed_of_centre(state: cb.State) -> float:
    """Speed of the centre of volume along x: ∫ u dV = ∮ (x - centre) u·n dS, over the volume."""
    droplet, layers = state.droplet, state.layers[0]
    velocity = layers.operator.grid.values(state.response.velocity)
    normal_velocity = (velocity * layers.points.normal).sum(axis=0)
    arm = layers.points.position[0] - droplet.centre[0]
    return float((arm * normal_velocity) @ layers.weights) / droplet.volume


def report(passage: Passage) -> None:
    """A table over time, and how the run ended."""
    run = passage.run
    columns = (run.times, passage.x, passage.deformation, passage.speed, passage.extra_pressure)
    shown = np.unique(np.linspace(0, len(run.times) - 1, 14).round().astype(int))
    rows = [
        (*(f"{column[k]:.3f}" for column in columns),
         f"{passage.gap[k]:.3f}" if np.isfinite(passage.gap[k]) else "-")
        for k in shown
    ]  # fmt: skip
    head = ("t (s)", "x (mm)", "D", "speed (mm/s)", "extra pressure (Pa)", "gap (mm)")
    print(cb.text_table(head, rows))
    last = run.last
    print(f"{last.steps} steps, {last.evaluations} evaluations, {run.seconds:.0f} CPU s")
    if last.stopped:
        print(f"ended: {last.stopped}")


def draw(folder: cb.RunFolder, channel: cb.Boundary, passage: Passage) -> None:
    """Plots of the measures over time and over x; the path, a film strip and a movie."""
    x, way, found = passage.x, "x of the centre (mm)", passage.deformation
    over_time = Plot("t (s)", "D", [Curve(passage.run.times, found)])
    draw_plots(folder / "deformation.png", [over_time, Plot(way, "D", [Curve(x, found)])])
    draw_plots(
        folder / "passage.png",
        [
            Plot(way, "speed of the centre (mm/s)", [Curve(x, passage.speed)]),
            Plot(way, "extra pressure drop (Pa)", [Curve(x, passage.extra_pressure)]),
            Plot(way, "narrowest gap (mm)", [Curve(x, passage.gap)]),
        ],
    )
    cb.draw_trajectories(folder / "path.png", channel, {1: passage.run.track(1)[1]})
    frames = [cb.Frame(s.time, s.shapes) for s in passage.run.states]
    cb.filmstrip(folder / "filmstrip.png", channel, frames)
    cb.draw_movie(folder / "movie.gif", channel, frames)


if __name__ == "__main__":
    cb.run(main)
