"""Droplets and rigid particles together in a serpentine channel that is read from a STEP file.

Two droplets, a rigid sphere and a rigid ellipsoid start in the first leg of a channel of 1 × 1 mm
(geometries/serpentine.py), off its centreline, in the mid-plane z = 0, which they do not leave by
symmetry.  Droplets deform, the ellipsoid tumbles.  By default the run follows them through the
first U-turn; --end 20 goes on until the last has left at 'outlet'.

Units: mm, s, Pa s, Pa, hence mN/m = Pa mm for surface tension.  By default the fluid, inside the
droplets too, is a viscous silicone oil, 1 Pa s, of mean velocity 1 mm/s, and the tension is 5 mN/m:
Ca = μ U / γ = 0.2.

Prints what becomes of each body, and draws the paths, D(t) with the ellipsoid's turn, a film strip
and a movie into a folder.
"""

from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots

GEOMETRY = Path(__file__).parents[1] / "geometries" / "serpentine.step"
# The slowest, nearest to a wall, come last; by number, mm, where centres start
DROPLETS = {1: (3.2, 0.12, 0.0), 2: (2.5, -0.12, 0.0)}
SPHERE, ELLIPSOID = 3, 4
SPHERE_START, ELLIPSOID_START = (1.8, 0.18, 0.0), (1.1, -0.2, 0.0)
ASPECT = 2.0  # of the ellipsoid of revolution


def main(
    output: str = "results/serpentine_mixture",
    droplet_radius: float = 0.2,
    sphere_radius: float = 0.18,
    ellipsoid_length: float = 0.44,
    mean_velocity: float = 1.0,
    viscosity: float = 1.0,
    tension: float = 5.0,
    viscosity_ratio: float = 1.0,
    element_size: float = 0.7,
    points: int = 72,
    particle_spans: int = 2,
    tolerance: float = 1e-2,
    end: float = 2.2,
    every: float = 0.1,
    resume: bool = False,
) -> cb.History:
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    flow = empty_channel(element_size, viscosity, mean_velocity)
    print(f"Ca = {viscosity * mean_velocity / tension:g}")

    # Bodies, numbered from the front of the row
    bodies = particles(sphere_radius, ellipsoid_length, particle_spans)
    for number, place in DROPLETS.items():
        shape = cb.spline_sphere(droplet_radius, place, points)
        bodies[number] = cb.Droplet(shape, cb.SurfaceTension(tension), viscosity_ratio)
    in_order = [bodies[number] for number in sorted(bodies)]

    simulation = cb.Simulation(flow, in_order, stepper=cb.Adaptive(tolerance))
    run = cb.record(folder.run(simulation, end, every))

    report(run)
    found = [run.of(cb.taylor_deformation, n).max() for n in DROPLETS]
    turn = angle_of_axis(run)
    folder.summary({"largest D": max(found), "turn of the ellipsoid (degrees)": turn[-1] - turn[0]})
    if folder:
        draw(folder, flow.problem.boundary, run)
        print(f"the pictures are in {folder}")
    return run


def particles(
    sphere_radius: float, ellipsoid_length: float, spans: int
) -> dict[int, cb.Droplet | cb.RigidParticle]:
    """The rigid bodies by number."""
    half = ellipsoid_length / 2
    axes = (half, half / ASPECT, half / ASPECT)
    return {
        SPHERE: cb.rigid_sphere(sphere_radius, SPHERE_START, spans=spans),
        ELLIPSOID: cb.rigid_ellipsoid(axes, ELLIPSOID_START, spans=spans),
    }


def empty_channel(element_size: float, viscosity: float, mean_velocity: float) -> cb.ChannelFlow:
    """The flow without bodies."""
    # Geometry: 42 four-sided faces, sectors of circles among them
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
    return flow


def long_axis(run: cb.History) -> np.ndarray:
    """Directions (3, N) of the ellipsoid's axis of revolution while it was there."""
    here = [s for s in run.states if ELLIPSOID in s.numbers]
    poses = [s.bodies[s.numbers.index(ELLIPSOID)].pose for s in here]
    return np.array([pose.matrix[:, 0] for pose in poses]).T


def angle_of_axis(run: cb.History) -> np.ndarray:
    """Angle (N,) in degrees of the ellipsoid's axis to x in the mid-plane, without jumps."""
    axis = long_axis(run)
    return np.unwrap(np.degrees(np.arctan2(axis[1], axis[0])), period=180.0)


def angle_of_path(run: cb.History) -> np.ndarray:
    """Angle (N,) in degrees of the direction in which the ellipsoid travels, without jumps."""
    times, centres = run.track(ELLIPSOID)
    along = np.gradient(centres[:2], times, axis=1)
    return np.unwrap(np.degrees(np.arctan2(along[1], along[0])), period=360.0)


def report(run: cb.History) -> None:
    """What became of each body."""
    rows = []
    for number in run.states[0].numbers:
        times, centres = run.track(number)
        way = np.linalg.norm(np.diff(centres, axis=1), axis=0).sum()
        gap = min(g.length for s in run.states for g in s.gaps if g.body == number)
        rows.append(
            (f"{number} {kind(number)}", f"{way:.2f}", f"{way / times[-1]:.2f}",
             f"{run.of(cb.taylor_deformation, number).max():.3f}" if number in DROPLETS else "-",
             f"{gap:.3f}" if np.isfinite(gap) else "-", f"{abs(centres[2]).max():.1e}",
             run.last.left.get(number, f"at ({centres[0, -1]:.2f}, {centres[1, -1]:.2f})"))
        )  # fmt: skip
    head = ("body", "way (mm)", "speed (mm/s)", "largest D", "narrowest gap (mm)", "largest |z|",
            "fate")  # fmt: skip
    print(cb.text_table(head, rows))
    turn, bend = (angle[-1] - angle[0] for angle in (angle_of_axis(run), angle_of_path(run)))
    print(f"the ellipsoid has turned by {turn:.0f} degrees, its path by {bend:.0f}")
    last = run.last
    print(f"{last.steps} steps, {last.evaluations} evaluations, {run.seconds:.0f} CPU s")
    if last.stopped:
        print(f"ended: {last.stopped}")


def kind(number: int) -> str:
    """What a body is."""
    return {ELLIPSOID: "ellipsoid", SPHERE: "sphere"}.get(number, "droplet")


def draw(folder: cb.RunFolder, channel: cb.Boundary, run: cb.History) -> None:
    """The paths, D and the ellipsoid's turn over time, a film strip and a movie."""
    tracks = {n: run.track(n) for n in run.states[0].numbers}
    shapes = [
        Curve(tracks[n][0], run.of(cb.taylor_deformation, n), f"droplet {n}", colour=n)
        for n in DROPLETS
    ]
    times = tracks[ELLIPSOID][0]
    turns = [
        Curve(times, angle_of_axis(run), "its axis", colour=ELLIPSOID),
        Curve(times, angle_of_path(run), "its path", dashed=True),
    ]
    draw_plots(
        folder / "motion.png",
        [Plot("t (s)", "D", shapes), Plot("t (s)", "ellipsoid: angle to x (degrees)", turns)],
    )
    cb.draw_trajectories(
        folder / "paths.png", channel, {n: centres for n, (_, centres) in tracks.items()}
    )
    frames = [cb.Frame(s.time, s.shapes) for s in run.states]
    cb.filmstrip(folder / "filmstrip.png", channel, frames)
    cb.draw_movie(folder / "movie.gif", channel, frames)


if __name__ == "__main__":
    cb.run(main)
