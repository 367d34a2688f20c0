"""Makes the numbers and pictures of the documentation: docs/results.md, docs/pictures/*.png.

    python docs/make.py                      everything (about an hour)
    python docs/make.py channels             the two channels at the top only
    python docs/make.py droplet_shear ...    sections and pictures of these workflows only
"""

import platform
import re
import shutil
import sys
import tempfile
import time
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from types import ModuleType

import numpy as np

import cadbem as cb
from cadbem.verification.channel import error_at_outlet

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "workflows"))

import annulus_heat  # noqa: E402
import chip_resistance  # noqa: E402
import constriction_droplet  # noqa: E402
import deformation_limit  # noqa: E402
import droplet_between_plates  # noqa: E402
import droplet_between_plates_2d  # noqa: E402
import droplet_elongation  # noqa: E402
import droplet_extension  # noqa: E402
import droplet_high_deformation_2d  # noqa: E402
import droplet_shear  # noqa: E402
import droplet_shear_2d  # noqa: E402
import droplet_sorting  # noqa: E402
import droplet_train  # noqa: E402
import ellipse_relaxation  # noqa: E402
import flow_split  # noqa: E402
import hollow_sphere_heat  # noqa: E402
import moving_sphere  # noqa: E402
import serpentine_mixture  # noqa: E402
import square_channel  # noqa: E402
import tracer_paths  # noqa: E402
import two_droplets_2d  # noqa: E402
import wall_shear_peak  # noqa: E402
import y_junction_bodies  # noqa: E402
import y_junction_flow  # noqa: E402

Row = tuple[str, ...]
PRINTED = {
    "Moving sphere": moving_sphere,
    "Heat in a quarter of an annulus": annulus_heat,
    "Heat in a hollow sphere": hollow_sphere_heat,
    "Ellipse that relaxes to a circle": ellipse_relaxation,
    "Plane droplet in shear flow": droplet_shear_2d,
    "Plane droplet far from a circle": droplet_high_deformation_2d,
    "Droplet in shear flow": droplet_shear,
    "Droplet drawn out by shear flow": droplet_elongation,
    "Viscous droplet in extension": droplet_extension,
    "Plane droplet between plates": droplet_between_plates_2d,
    "Two plane droplets between plates": two_droplets_2d,
    "Droplet between plates": droplet_between_plates,
    "Bodies in the Y-junction": y_junction_bodies,
    "Train of droplets": droplet_train,
    "Droplet in a constriction": constriction_droplet,
    "Mixture in the serpentine": serpentine_mixture,
    "Resistances of a chip": chip_resistance,
    "How a junction divides the flow": flow_split,
    "Peak of the wall shear stress": wall_shear_peak,
    "Tracers and residence times": tracer_paths,
    "Where droplets end up": droplet_sorting,
    "Limit of deformation": deformation_limit,
}
OPTIONS = {
    "droplet_shear": {"reference": 392},
    "y_junction_bodies": {"parts": "droplet particle table"},
    "droplet_between_plates": {"parts": "time confinement"},
    "droplet_between_plates_2d": {"parts": "widths resolution thesis drift"},
    "two_droplets_2d": {"parts": "pass swap convergence"},
}  # for the tables
DRAWN = {"square_channel": square_channel, "y_junction": y_junction_flow}


def table(head: Row, rows: list[Row]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def timed(solve) -> tuple[cb.StokesSolution, float]:
    start = time.process_time()
    solution = solve()
    return solution, time.process_time() - start


def square_channel_table() -> str:
    rows = []
    cases = [{"degree": d, "spans": n} for d, n in ((2, 4), (2, 7), (2, 10), (3, 8), (4, 7))]
    graded = {"along": 1, "tolerance": 1e-10}
    cases += [graded | {"degree": d, "spans": 6, "levels": 2, "ratio": 0.5} for d in range(2, 7)]
    cases.append(graded | {"degree": 6, "spans": 8, "levels": 1, "ratio": 0.35})
    for case in cases:
        solution, seconds = timed(lambda case=case: square_channel.main(output="", **case))
        drop = solution.mean_pressure("inlet") - solution.mean_pressure("outlet")
        error = -drop / square_channel.LENGTH / square_channel.EXACT_GRADIENT - 1
        rows.append(
            (str(case["degree"]), f"{case['spans']}", str(case.get("levels", "-")),
             str(case.get("ratio", "-")), str(solution.space.count), f"{solution.net_flux():.1e}",
             f"{solution.net_force():.1e}", f"{error:+.1e}",
             f"{error_at_outlet(solution):.1e}", f"{seconds:.1f}")
        )  # fmt: skip
    head = ("degree", "spans", "levels", "ratio", "points", "net flux / inflow",
            "net force / forces", "gradient", "outlet velocity", "CPU s")  # fmt: skip
    return table(head, rows)


def y_junction_table() -> tuple[str, float]:
    """The table, and the order s of p(n) = p + C n^-s through the three finest grids."""
    rows, spans, drops = [], [3, 5, 7, 9, 11], []
    for n in spans:
        solution, seconds = timed(lambda n=n: y_junction(n))
        a, b = solution.mean_pressure("inlet_a"), solution.mean_pressure("inlet_b")
        drops.append(a - solution.mean_pressure("outlet"))
        rows.append(
            (str(n), str(solution.space.count), f"{solution.net_flux():.1e}", f"{drops[-1]:.5f}",
             f"{abs(a - b) / a:.0e}", f"{seconds:.1f}")
        )  # fmt: skip
    head = ("spans", "points", "net flux / inflow", "pressure drop", "inlets' difference", "CPU s")
    return table(head, rows), fitted_order(spans[-3:], drops[-3:])


def y_junction(spans: int) -> cb.StokesSolution:
    """The flow of ``workflows/y_junction_flow.py`` on an even grid."""
    channel = cb.read_cad(y_junction_flow.GEOMETRY).elevated(2).refined(spans)
    ends = {name: cb.Inflow(mean_velocity=3.0) for name in ("inlet_a", "inlet_b")}
    ends |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    return cb.StokesProblem(channel, 1.0, ends).solve()


def fitted_order(spans: list[int], values: list[float]) -> float:
    """The order s for which three values lie on p + C n^-s."""
    target = (values[1] - values[0]) / (values[2] - values[1])
    orders = np.linspace(0.2, 8, 4000)
    powers = np.array(spans, dtype=float)[:, None] ** -orders
    ratios = (powers[0] - powers[1]) / (powers[1] - powers[2])
    return float(orders[np.argmin(abs(ratios - target))])


def make_results() -> None:
    channel = square_channel_table()
    junction, order = y_junction_table()
    text = f"""# Results

Made by `python docs/make.py results` on {platform.processor() or platform.machine()}, \
{cb.__version__}. CPU seconds are of the whole run without pictures, \
reading the CAD file included, on a shared machine.

## Square channel

W = H = 1, L = 2, mean velocity 1 (`workflows/square_channel.py`). The exact pressure gradient \
is -28.4541538 μU/W²; net flux and net force vanish for the exact flow. What limits the \
convergence is the r² log r singularity of the duct flow in its corners; elements cut at *ratio*, \
ratio², ... of their width *levels* times at the four long edges, and one element along the \
channel, resolve it (quadrature tolerance 1e-10 there). Columns *gradient* and *outlet \
velocity* are errors, the latter the largest on the line z = -0.047 over the mean velocity.

{channel}
## Y-junction

Branches 4 × 4, mean velocity 3 in both inlets, on even grids of degree 2 (the flow of \
`workflows/y_junction_flow.py`, which chooses its elements by itself). The pressure drop \
converges with order {order:.1f} in the number of spans (from the three finest \
grids): the flow is singular at the three edges where branches meet.

{junction}"""
    file = HERE / "results.md"
    others = re.findall(r"^## .*?(?=\n## |\Z)", file.read_text(), re.MULTILINE | re.DOTALL)
    kept = [part.rstrip() + "\n" for part in others if part[3:].split("\n")[0] in PRINTED]
    file.write_text("\n".join([text, *kept]))


def make_section(title: str, workflow: ModuleType) -> None:
    """Run a workflow once, for its section and its pictures."""
    with tempfile.TemporaryDirectory() as made, redirect_stdout(StringIO()) as output:
        workflow.main(output=made, **OPTIONS.get(workflow.__name__, {}))
        copy_pictures(workflow.__name__, Path(made))
    lines = [line for line in output.getvalue().splitlines(True) if made not in line]
    update_section(title, "".join(lines))


def update_section(title: str, printed: str) -> None:
    """Put what a workflow printed in the place of its section, or at the end."""
    file = HERE / "results.md"
    text = file.read_text()
    section = f"## {title}\n\n```\n{printed}```\n"
    old = re.search(rf"^## {re.escape(title)}\n.*?(?=\n## |\Z)", text, re.MULTILINE | re.DOTALL)
    file.write_text(text.replace(old[0], section) if old else f"{text}\n{section}")


def copy_pictures(name: str, made: Path) -> None:
    folder = HERE / "pictures"
    folder.mkdir(exist_ok=True)
    for picture in made.glob("*.png"):
        target = picture.name if name in picture.name else f"{name}_{picture.name}"
        shutil.copy(picture, folder / target)
    for strip in made.glob("*/pictures/filmstrip.png"):  # of a part of the run
        shutil.copy(strip, folder / f"{name}_{strip.parts[-3]}.png")


def main() -> None:
    wanted = sys.argv[1:] or ["channels", *(w.__name__ for w in PRINTED.values())]
    if "channels" in wanted:
        make_results()
        for name, workflow in DRAWN.items():
            with tempfile.TemporaryDirectory() as made:
                workflow.main(output=made)
                copy_pictures(name, Path(made))
    for title, workflow in PRINTED.items():
        if workflow.__name__ in wanted:
            make_section(title, workflow)


if __name__ == "__main__":
    main()
