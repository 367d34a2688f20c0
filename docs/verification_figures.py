"""Pictures of the verification page that no workflow makes: docs/pictures/verification_*.png.

python docs/verification_figures.py
"""

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import cadbem as cb
from cadbem.post.style.plots import Curve, Plot, draw_plots
from cadbem.post.style.style import INK, PALETTE
from cadbem.problems.profiles import rectangle_profile
from cadbem.quadrature.near import gauss_table
from cadbem.quadrature.uniform import triangle_nodes
from cadbem.space import discontinuous_space
from cadbem.spline.basis import basis_matrix
from cadbem.verification import channel, curves, heat, integrals
from cadbem.verification.plates import between_plates
from cadbem.verification.theory import shapira_haber

HERE = Path(__file__).parent
FINE = np.linspace(0, 1, 1001)
CURVES = {
    "square": curves.square,
    "bspline_circle": curves.bspline_circle,
    "knots_inserted": curves.knots_inserted,
    "degree_raised": curves.degree_raised,
    "nurbs_circle": curves.nurbs_circle,
}


def main() -> None:
    for name, make in CURVES.items():
        draw_curve(target(name), make())
    draw_ring(target("ring"))
    draw_solids()
    draw_triangles(target("triangles"))
    draw_spaces()
    draw_outlet(target("outlet"))
    text = (HERE / "results.md").read_text()
    draw_channel_convergence(target("channel_convergence"), text)
    draw_drag(target("drag"), text)
    draw_confinement(target("confinement"), text)


def target(name: str) -> Path:
    return HERE / "pictures" / f"verification_{name}.png"


def sheet(columns: int) -> tuple[Figure, np.ndarray]:
    figure = Figure(figsize=(5.2 * columns, 4.2), layout="constrained")
    return figure, np.atleast_1d(figure.subplots(1, columns))


def draw_curve(path: Path, curve: cb.Nurbs) -> None:
    """Figures 2.1 to 2.5: functions, and the curve with its control points."""
    figure, (left, right) = sheet(2)
    degree, knots = curve.degrees[0], curve.knots[0]
    functions = basis_matrix(degree, knots, FINE) * curve.weights
    functions /= functions.sum(axis=1, keepdims=True)
    for k, values in enumerate(functions.T):
        shown = values > 0
        left.plot(FINE[shown], values[shown], color=PALETTE[k % len(PALETTE)])
    left.set(xlabel="ξ", ylabel="functions")
    angle = np.linspace(0, 2 * np.pi, 400)
    right.plot(*curve.evaluate(FINE), color=PALETTE[0], label="curve")
    if degree > 1:
        right.plot(np.cos(angle), np.sin(angle), "--", color=INK, linewidth=0.9, label="circle")
    right.plot(*curve.points.T, "s:", color=PALETTE[1], markersize=5, label="control points")
    ends = curve.evaluate(np.unique(knots))
    right.plot(*ends, "|", color=INK, markersize=12, label="ends of elements")
    finish(right)
    figure.savefig(path, dpi=110)


def finish(axes: Axes) -> None:
    axes.set(aspect="equal", xlabel="x", ylabel="y")
    axes.legend(frameon=False, loc="center")


def draw_ring(path: Path) -> None:
    """Figure 2.6: control points, collocation points and elements of the quarter ring."""
    figure, (axes,) = sheet(1)
    space = heat.ring(4).space
    for k, patch in enumerate(space.boundary.patches):
        label = ("elements", "control points", "collocation points") if k == 0 else (None,) * 3
        curve = patch.surface
        axes.plot(*curve.evaluate(FINE), color=INK)
        axes.plot(*curve.evaluate(np.unique(curve.knots[0])), "+", color=INK, markersize=12,
                  label=label[0])  # fmt: skip
        axes.plot(*curve.points.T, "s", color=PALETTE[1], markersize=4, label=label[1])
    axes.plot(*space.collocation.position, "o", color=PALETTE[0], markersize=4, label=label[2])
    axes.plot([], [], "o", color=PALETTE[0], markersize=4, label="collocation points")
    axes.set(aspect="equal", xlabel="x", ylabel="y")
    axes.legend(frameon=False, loc="upper right")
    figure.savefig(path, dpi=110)


def draw_solids() -> None:
    """Figures 2.9 to 2.11: a patch and its parameters, and elements cut near a point."""
    quarter = integrals.quarter_cylinder()
    octant = cb.sphere_octants()[0]
    wavy = quarter.elevated((2, 2)).inserted([[0.5], [0.5]])
    bent = wavy.points + 0.25 * np.sin(3 * wavy.points[..., [1, 2, 0]])
    surface = cb.Nurbs(wavy.degrees, wavy.knots, bent, np.ones(bent.shape[:2]))
    draw_patch(target("mapping"), surface, (2, 2), None)
    near = np.array([np.sqrt(0.5), 2.1, np.sqrt(0.5)])
    draw_patch(target("cylinder"), quarter, (3, 3), near)
    angle = 18 * np.pi / 32
    draw_patch(target("octant"), octant, (3, 3),
               np.array([np.cos(angle), np.sin(angle), 1]) * np.sqrt(0.5), azimuth=80)  # fmt: skip


def draw_patch(
    path: Path, surface: cb.Nurbs, parts: Sequence[int], source: np.ndarray | None,
    azimuth: float = -60,
) -> None:  # fmt: skip
    """A patch in its parameters and in space, cut evenly, and a point nearby."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    left = figure.add_subplot(1, 2, 1, aspect="equal", xlabel="ξ", ylabel="η")
    right = figure.add_subplot(1, 2, 2, projection="3d")
    grid = np.linspace(0, 1, 41)
    u, v = np.meshgrid(grid, grid, indexing="ij")
    right.plot_surface(*surface.evaluate(u, v), color=PALETTE[5], alpha=0.35, linewidth=0)
    for axis, count in enumerate(parts):
        for place in np.linspace(0, 1, count + 1):
            across = np.full_like(grid, place)
            line = (across, grid) if axis == 0 else (grid, across)
            left.plot(*line, color=INK, linewidth=1)
            right.plot(*surface.evaluate(*line), color=INK, linewidth=1)
    if source is not None:
        right.plot(*source[:, None], "o", color=PALETTE[1])
    right.set(xlabel="x", ylabel="y", zlabel="z")
    right.locator_params(nbins=4)
    right.view_init(elev=25, azim=azimuth)
    limits = np.array([right.get_xlim(), right.get_ylim(), right.get_zlim()])
    right.set_box_aspect(np.ptp(limits, axis=1), zoom=0.85)
    figure.savefig(path, dpi=110)


def draw_triangles(path: Path) -> None:
    """Figure 2.12: the rectangle of table 2.3, a point on it, and polar nodes in triangles."""
    figure, (left, right) = sheet(2)
    own = np.array([0.75, 0.25])
    nodes = np.empty((3, 400))
    count = triangle_nodes(*own, 10, gauss_table(), nodes)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
    left.plot(*integrals.rectangle().evaluate(*corners.T)[:2], color=INK)
    left.plot(*integrals.rectangle().evaluate(*own)[:2], "o", color=PALETTE[1])
    left.set(aspect="equal", xlabel="x", ylabel="y")
    for corner, following in pairwise(corners):
        right.plot(*np.stack([own, corner, following]).T, color=INK, linewidth=0.9)
    right.plot(*nodes[:2, :count], ".", color=PALETTE[0], markersize=3)
    right.plot(*own, "o", color=PALETTE[1])
    right.set(aspect="equal", xlabel="ξ", ylabel="η")
    figure.savefig(path, dpi=110)


def draw_spaces() -> None:
    """Figures 2.13 and 4.6: elements and collocation points of a sphere, and of a plate."""
    ball = cb.Boundary(tuple(cb.Patch(s, "sphere") for s in cb.sphere()))
    cb.draw_collocation(discontinuous_space(ball.refined(2)), target("sphere"))
    plates = between_plates(1.25, 12.0, spans=8, rings=2).problem.boundary
    one = cb.Boundary(tuple(p for p in plates.patches if p.name == "plate_low"))
    cb.draw_collocation(discontinuous_space(one), target("plate"))


def draw_outlet(path: Path) -> None:
    """Figure 2.16: velocity across the outlet of the square channel at z = -0.047."""
    fine, places = np.linspace(-0.5, 0.5, 201), np.linspace(-0.48, 0.48, 25)
    line = np.array([np.ones(25), places, np.full(25, -0.047)])
    found = channel.duct(1.0).velocity_at(line)[0]
    exact = rectangle_profile(fine, np.full(201, -0.047), 1.0, 1.0)
    draw_plots(path, [Plot("y", "velocity / mean velocity", [
        Curve(fine, exact, "Fourier series"),
        Curve(places, found, "computed", line=False, marks=True),
    ])])  # fmt: skip


def rows_of(text: str, section: str, pattern: str) -> list[tuple[float, ...]]:
    """Numbers caught by a pattern in the lines of a section of docs/results.md."""
    part = re.search(rf"^## {section}\n(.*?)(?=\n## |\Z)", text, re.MULTILINE | re.DOTALL)
    assert part, section
    return [tuple(map(float, found)) for found in re.findall(pattern, part[1], re.MULTILINE)]


def draw_channel_convergence(path: Path, text: str) -> None:
    """Figures 2.17 and 2.18, from the table in docs/results.md."""
    cells = r"\s*\| (\d+) \| (\S+) \| (\S+) \| (\S+) \|"
    rows = rows_of(text, "Square channel", r"^\| 2 \| \d+ \| - \| -" + cells)
    graded = rows_of(text, "Square channel", r"^\| \d \| \d+ \| \d \| [\d.]+" + cells)
    plots = []
    for name, column, scale in (
        ("net force / forces", 2, 1), ("error of the pressure gradient (%)", 3, 100)
    ):  # fmt: skip
        found = [
            Curve([3 * r[0] for r in part], [scale * abs(r[column]) for r in part], label,
                  marks=True, line=k == 0)
            for k, (part, label) in enumerate(((rows, "even, degree 2"), (graded, "graded")))
        ]  # fmt: skip
        plots.append(Plot("unknowns", name, found, logarithmic=True))
    draw_plots(path, plots)


def draw_drag(path: Path, text: str) -> None:
    """Figure 2.19: a sphere held in a paraboloidal flow; moving, it is exact to rounding."""
    pattern = r"^\s+\d\s+(\d+)\s+([+-]\S+e-\d\d)$"
    rows = rows_of(text, "Moving sphere", pattern)
    names = ("octants, degree 2", "octants, degree 3", "six patches, degree 4")
    found = [
        Curve([n for n, _ in rows[5 * k : 5 * k + 5]], [abs(e) for _, e in rows[5 * k : 5 * k + 5]],
              name, marks=True)
        for k, name in enumerate(names)
    ]  # fmt: skip
    draw_plots(path, [Plot("collocation points", "relative error of the drag", found, True)])


def draw_confinement(path: Path, text: str) -> None:
    """Figure 4.7, from the table in docs/results.md."""
    rows = rows_of(text, "Droplet between plates", r"^\s+(0\.\d)\s+(0\.\d+)\s+[+-]\S+\s+0\.")
    shares = np.linspace(0, 0.8, 60)
    theory = [shapira_haber(0.2, 1.0, share) for share in shares]
    draw_plots(path, [Plot("R / W", "steady D", [
        Curve([r[0] for r in rows], [r[1] for r in rows], "ours", marks=True),
        Curve(shares, theory, "Shapira and Haber, small Ca", dashed=True),
    ])])  # fmt: skip


if __name__ == "__main__":
    main()
