"""Makes the numbers and pictures of the documentation: docs/results.md, docs/pictures/*.png.

    python docs/make.py                      everything (some twenty minutes)
    python docs/make.py pictures             the pictures only
    python docs/make.py results              the tables only
    python docs/make.py droplet_shear ...    section and pictures of these workflows only
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

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "workflows"))

import annulus_heat  # noqa: E402
import droplet_elongation  # noqa: E402
import droplet_extension  # noqa: E402
import droplet_high_deformation_2d  # noqa: E402
import droplet_shear  # noqa: E402
import droplet_shear_2d  # noqa: E402
import ellipse_relaxation  # noqa: E402
import hollow_sphere_heat  # noqa: E402
import moving_sphere  # noqa: E402
import square_channel  # noqa: E402
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
}
OPTIONS = {"droplet_shear": {"reference": 392}}  # for the tables
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
             f"{square_channel.outlet_error(solution):.1e}", f"{seconds:.1f}")
        )  # fmt: skip
    head = ("degree", "spans", "levels", "ratio", "points", "net flux / inflow",
            "net force / forces", "gradient", "outlet velocity", "CPU s")  # fmt: skip
    return table(head, rows)


def y_junction_table() -> tuple[str, float]:
    """The table, and the order s of p(n) = p + C n^-s through the three finest grids."""
    rows, spans, drops = [], [3, 5, 7, 9, 11], []
    for n in spans:
        solution, seconds = timed(lambda n=n: y_junction_flow.main(output="", spans=n))
        a, b = solution.mean_pressure("inlet_a"), solution.mean_pressure("inlet_b")
        drops.append(a - solution.mean_pressure("outlet"))
        rows.append(
            (str(n), str(solution.space.count), f"{solution.net_flux():.1e}", f"{drops[-1]:.5f}",
             f"{abs(a - b) / a:.0e}", f"{seconds:.1f}")
        )  # fmt: skip
    head = ("spans", "points", "net flux / inflow", "pressure drop", "inlets' difference", "CPU s")
    return table(head, rows), fitted_order(spans[-3:], drops[-3:])


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

Branches 4 × 4, mean velocity 3 in both inlets, degree 2 (`workflows/y_junction_flow.py`). The \
pressure drop converges with order {order:.1f} in the number of spans (from the three finest \
grids): the flow is singular at the three edges where branches meet.

{junction}"""
    (HERE / "results.md").write_text(text)
    for title in PRINTED:
        update_section(title)


def update_section(title: str) -> None:
    """Put what a workflow prints in the place of its section, or at the end."""
    file = HERE / "results.md"
    text = file.read_text()
    section = f"## {title}\n\n```\n{printed(PRINTED[title])}```\n"
    old = re.search(rf"^## {re.escape(title)}\n.*?(?=\n## |\Z)", text, re.MULTILINE | re.DOTALL)
    file.write_text(text.replace(old[0], section) if old else f"{text}\n{section}")


def printed(workflow: ModuleType) -> str:
    """What a workflow prints but for where its pictures are."""
    with redirect_stdout(StringIO()) as output:
        workflow.main(output="", **OPTIONS.get(workflow.__name__, {}))
    return output.getvalue()


def make_pictures(workflows: dict[str, ModuleType]) -> None:
    folder = HERE / "pictures"
    folder.mkdir(exist_ok=True)
    for name, workflow in workflows.items():
        with tempfile.TemporaryDirectory() as made:
            workflow.main(output=made)
            for picture in Path(made).glob("*.png"):
                target = picture.name if name in picture.name else f"{name}_{picture.name}"
                shutil.copy(picture, folder / target)


if __name__ == "__main__":
    wanted = sys.argv[1:] or ["results", "pictures"]
    chosen = {title: w for title, w in PRINTED.items() if w.__name__ in wanted}
    if "results" in wanted:
        make_results()
    if "pictures" in wanted:
        make_pictures(DRAWN | {w.__name__: w for w in PRINTED.values()})
    for title in chosen:
        update_section(title)
    make_pictures({w.__name__: w for w in chosen.values()})
