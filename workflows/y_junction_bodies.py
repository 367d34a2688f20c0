"""A droplet and, apart, a rigid particle carried through a Y-junction (thesis Fig. 4.9 to 4.11).

Fluid alone would let the particle come nearer to the outer corner than a hundredth of its radius,
which no such points resolve: a short-range pressure, strength × (1 - gap / 0.1)², keeps it off.
"""

from functools import partial
from pathlib import Path

import cadbem as cb
from cadbem.verification.figures import junction_bodies as junction
from cadbem.verification.figures.common import KEEP, Runs

GEOMETRY = Path(__file__).parents[1] / "geometries" / "y_junction.step"
START = (2.8284, 2.0, 2.0)  # 0.586 off the centreline, towards the outer wall


def simulate(kind, r, capillary, strength, tolerance, end, keep=KEEP) -> cb.History:
    flow = junction.junction_flow(cb.read_cad(GEOMETRY), r)
    body = cb.rigid_sphere(1.0, START, spans=r.particle_spans)
    contact = cb.Repel(0.1, strength) if kind == "particle" and strength else cb.StopAtGap(0.1)
    if kind == "droplet":
        shape = cb.spline_sphere(centre=START, points=r.points)
        body = cb.Droplet(shape, cb.SurfaceTension(1 / capillary))
    simulation = cb.Simulation(flow, body, stepper=cb.Adaptive(tolerance), contact=contact)
    return cb.record(keep(simulation, end, min(0.05, end)))


def main(
    output: str = "results/y_junction_bodies", spans: int = 7, levels: int = 3, points: int = 200,
    particle_spans: int = 4, capillary: float = 0.05, strength: float = 1000.0,
    tolerance: float = 1e-3, end: float = 2.0, parts: str = "droplet particle",
    resume: bool = False,
) -> Runs:  # fmt: skip
    """Bodies of radius 1, branches 4 wide and high, mean velocity 3 in both inlets.

    spans: elements a direction on the channel's faces; levels: cuts towards the outer corner
    points: on the droplet; particle_spans: elements a direction on the particle's patches
    capillary: Ca = μ / γ
    strength: of the pressure that keeps the particle off the walls; 0: the run ends there
    tolerance: error of a time step, as a share of the body's size
    end: time, in radii per unit of velocity
    parts: 'droplet', 'particle'; 'table', both again on coarser and finer channels and bodies
    """
    folder = cb.run_folder(output, GEOMETRY, resume=resume)
    r = junction.Resolution(spans, levels, points, particle_spans)
    kinds = [kind for kind in ("droplet", "particle") if kind in parts]
    case = capillary, strength, tolerance, end
    runs = {(k, r): simulate(k, r, *case, partial(folder.run, part=k)) for k in kinds}
    for other in junction.finer(r) if "table" in parts else ():
        runs |= {(kind, other): simulate(kind, other, *case) for kind in kinds}
    folder.summary(junction.report(runs, r))
    if folder and kinds:
        junction.draw(folder, cb.read_cad(GEOMETRY), runs, r)
        cb.render(folder)
    return runs


if __name__ == "__main__":
    cb.run(main)
