"""Every public function and class, with values that it cannot have.

A door ends in an error that names the parameter, in one line, or gives an answer without a number
that is not finite.  What is right for a value that is unusual and possible, such as an inflow of 0,
is tested where the quantity is; here nothing may pass that is no value at all: nan, infinity, text,
numbers below what they count, arrays of another shape.
"""

import inspect
import warnings
from collections.abc import Callable
from dataclasses import fields
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import ezdxf
import numpy as np
import pytest

import cadbem as cb
from cadbem.spline.closed import ClosedBasis

GEOMETRIES = Path(__file__).resolve().parents[1] / "geometries"
FILE = GEOMETRIES / "square_channel.step"
INFINITE = {("Adaptive", "longest")}  # where infinity is a value
NOT_FINITE = (np.nan, np.inf, -np.inf, "1 mm", [1.0, np.nan], None, 1j)
COUNTS = (*NOT_FINITE, 0, -1, 2.5)
SIZES = (*NOT_FINITE, 0.0, -1.0)  # of what must be positive
VECTORS = (np.nan, 2.0, "1, 0, 0", (1.0,), (1.0, 0.0, np.inf), np.eye(3), [[1.0], [2.0], [3.0]])
SHARES = (*SIZES, 7.0)

# results and records, which the package makes
FOUND = {
    "Course", "Fate", "Field", "Frame", "HeatSolution", "History", "Network", "Numbers",
    "OperatingPoint", "Quantity", "ReleasePoints", "RunFolder", "Space", "State", "StokesSolution",
    "StoredRun", "Tracers", "WallShear",
}  # fmt: skip
# no parameter is a number or an array of numbers
WORDS = {
    "ChannelFlow", "Dense", "NoSlip", "Units", "UserFlow", "bezier_grid", "bodies_report",
    "course_report", "draw_outlines", "draw_run", "droplet_fates", "fate_of", "fates_report",
    "affine_velocity", "full_velocity", "normal_velocity", "inclination", "inspect_cad",
    "largest_deformation", "network_of", "open_run", "record", "render", "residence_report", "run",
    "run_folder", "taylor_deformation", "text_table", "volume_grid", "wall_shear",
    "write_droplets", "write_frames", "write_mesh", "write_patches", "write_vtu", "closed_spline",
}  # fmt: skip


@cache
def channel() -> cb.Boundary:
    names = ("walls", "walls", "walls", "walls", "inlet", "outlet")
    sides = zip(cb.box(), names, strict=True)
    return cb.Boundary(tuple(cb.Patch(s, n) for s, n in sides)).elevated(2)


CONDITIONS = {"walls": cb.NoSlip(), "inlet": cb.Inflow(1.0), "outlet": cb.Pressure(0.0)}


@cache
def flow() -> cb.StokesSolution:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return cb.StokesProblem(channel(), 1.0, CONDITIONS).solve()


def moved(velocity: Any = 0.0, **words: Any) -> cb.StokesProblem:
    return cb.StokesProblem(
        channel(), 1.0, {n: cb.RigidMotion(velocity, **words) for n in channel().names}
    )


def operated(value: Any) -> cb.OperatingPoint:
    network = cb.hydraulic_network(channel(), 1.0, ("inlet", "outlet"))
    return network.operate(pressures={"inlet": value}, flow_rates={"outlet": 0.0})


def given(value: Any) -> cb.StokesSolution:
    """A problem whose walls have a velocity, solved."""
    conditions = {"walls": cb.Velocity(value), "inlet": cb.Pressure(1.0), "outlet": cb.Pressure(0)}
    return cb.StokesProblem(channel(), 1.0, conditions).solve()


def loaded(value: Any) -> cb.StokesSolution:
    conditions = {"walls": cb.NoSlip(), "inlet": cb.Traction(value), "outlet": cb.Pressure(1.0)}
    return cb.StokesProblem(channel(), 1.0, conditions).solve()


def around(**words: Any) -> cb.StokesSolution:
    body = cb.Boundary(tuple(cb.Patch(s, "body") for s in cb.sphere())).elevated(4)
    return cb.StokesProblem(
        body, 1.0, {"body": cb.NoSlip()}, background=cb.Background(**words)
    ).solve()


def heated(value: Any) -> cb.HeatSolution:
    conditions = {n: cb.Temperature(1.0) for n in channel().names} | {"inlet": value}
    return cb.HeatProblem(channel(), 1.0, conditions).solve()


@cache
def drawing() -> Path:
    """A square of 1 mm as a DXF drawing."""
    document = ezdxf.new(units=4)
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    document.modelspace().add_lwpolyline(square, close=True)
    path = Path(mkdtemp()) / "square.dxf"
    document.saveas(path)
    return path


def drop() -> cb.Droplet:
    return cb.Droplet(cb.spline_circle(points=16), cb.SurfaceTension(1.0))


def still() -> cb.Simulation:
    return cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), drop())


def first_states(**words: Any) -> list[cb.State]:
    return list(still().run(**{"end": 0.01, "every": 0.01} | words))


def curve() -> cb.Nurbs:
    return channel().patches[0].surface


def nurbs(**words: Any) -> cb.Nurbs:
    return cb.Nurbs(**{f.name: getattr(curve(), f.name) for f in fields(curve())} | words)


PICTURE = (np.nan, (0, 0), (100, -1), (100.5, 80), (100, 100, 100), "large")
SCALARS = (np.full((1, 5), 2.0), lambda x: x, lambda x: np.nan * x[0], lambda x: x[:2])
ONES = (np.full((1, 5), 2.0), lambda x: x[0], lambda x: np.nan * x, lambda x: x[:2])
# public name -> a call that is sound, and values of its parameters that are not
Door = tuple[Callable[..., Any], dict[str, tuple[Any, ...]]]
DOORS: dict[str, Door] = {
    "Adaptive": (cb.Adaptive, {"tolerance": SHARES, "longest": SIZES, "stages": (*COUNTS, 1)}),
    "AdaptivePoints": (cb.AdaptivePoints, {"accuracy": SHARES, "most": COUNTS, "degree": COUNTS}),
    "Background": (around, {"velocity": VECTORS, "pressure": NOT_FINITE}),
    "Bending": (cb.Bending, {"rigidity": (*NOT_FINITE, -1.0)}),
    "Boundary": (lambda **w: channel().refined(**w), {"spans": (*COUNTS[:5], *COUNTS[6:])}),
    "Boundary.size": (lambda **w: channel().refined(**w), {
        "size": (np.nan, np.inf, 0.0, -1.0, "1 mm", (1.0, 2.0), (1.0, 0.0, 1.0), lambda x: -x[0],
                 lambda x: np.nan * x[0]),
    }),
    "Boundary.near": (lambda **w: channel().refined(size=0.5, **w), {
        "near": ((1.0, 2.0), np.eye(2), (0.0, 0.0, np.nan)), "growth": (*NOT_FINITE, -1.0),
    }),
    "Boundary.elements": (lambda **w: channel().refined(**w), {
        "elements": COUNTS[:5] + COUNTS[6:]}),
    "Boundary.elevated": (lambda **w: channel().elevated(**w), {"degree": (*COUNTS, 1000)}),
    "Boundary.graded": (lambda **w: channel().graded(**{"levels": 2} | w), {
        "levels": (*NOT_FINITE[:5], 1j, -1, 2.5), "ratio": (*SHARES, 1.0)}),
    "Boundary.transformed": (lambda **w: channel().transformed(**{"matrix": np.eye(3)} | w), {
        "matrix": (1.0, np.eye(2), np.diag([1.0, 1.0, -1.0]), np.full((3, 3), np.nan), "x"),
        "shift": VECTORS}),
    "Boundary.area": (lambda **w: channel().area(**w), {"order": COUNTS}),
    "ClosedSpline": (lambda **w: cb.Droplet(
        cb.ClosedSpline(ClosedBasis(4, (16,)), **w), cb.SurfaceTension(1.0)), {
        "coefficients": (np.full((2, 16), np.nan), np.zeros((2, 15)), np.zeros((3, 16)), 1.0)}),
    "Compressed": (cb.Compressed, {"tolerance": SHARES}),
    "CorrectVolume": (cb.CorrectVolume, {"trigger": (*NOT_FINITE, -1.0, 7.0)}),
    "Droplet": (lambda **w: cb.Droplet(cb.spline_circle(), cb.SurfaceTension(1.0), **w), {
        "viscosity_ratio": SIZES}),
    "Droplet.shape": (lambda **w: cb.Droplet(interface=cb.SurfaceTension(1.0), **w), {
        "shape": (1.0, None, channel)}),
    "Euler": (cb.Euler, {"step": SIZES}),
    "FarField": (cb.FarField, {"tolerance": SHARES}),
    "FreeFlow": (lambda **w: cb.FreeFlow(cb.shear(), **w), {"viscosity": SIZES}),
    "HeatFlux": (lambda value: heated(cb.HeatFlux(value)), {"value": (*NOT_FINITE, *SCALARS)}),
    "HeatProblem": (lambda **w: cb.HeatProblem(
        **{"boundary": channel(), "conductivity": 1.0,
           "conditions": {n: cb.Temperature(1.0) for n in channel().names}} | w
    ).solve(), {
        "conductivity": SIZES, "source": (*NOT_FINITE[:5], *NOT_FINITE[6:]),
        "boundary": (None, 1.0), "quadrature": (None, 1e-8), "storage": ("dense", 1e-6),
    }),
    "InextensibleMembrane": (cb.InextensibleMembrane, {
        "rigidity": (*NOT_FINITE, -1.0), "tension": SIZES}),
    "Inflow": (cb.Inflow, {"mean_velocity": NOT_FINITE, "flow_rate": NOT_FINITE}),
    "Nurbs": (nurbs, {
        "weights": (np.zeros((3, 3)), np.full((3, 3), np.nan), np.ones(2)),
        "points": (np.zeros(3), np.zeros((3, 2, 3))),
    }),
    "Patch.surface": (lambda points: cb.Patch(nurbs(points=points)), {
        "points": (np.full((3, 3, 3), np.inf), np.full((3, 3, 3), np.nan)),
    }),
    "Patch": (lambda **w: cb.Patch(curve(), **w), {}),
    "Patch.quadrature": (lambda **w: channel().patches[0].quadrature(**w), {"order": COUNTS}),
    "Pressure": (cb.Pressure, {"value": NOT_FINITE}),
    "Quadrature": (cb.Quadrature, {"tolerance": SHARES}),
    "RelaxMesh": (cb.RelaxMesh, {
        "even": (*NOT_FINITE, -1.0), "curved": (*NOT_FINITE, -1.0), "steps": COUNTS,
        "pseudo_step": SIZES}),
    "Repel": (lambda **w: cb.Repel(**{"reach": 0.1, "strength": 1.0} | w), {
        "reach": SIZES, "strength": SIZES}),
    "RigidMotion": (moved, {
        "velocity": VECTORS, "angular_velocity": VECTORS, "centre": VECTORS}),
    "RigidParticle": (lambda **w: cb.RigidParticle(
        **{"shape": cb.rigid_sphere(spans=1).shape} | w
    ), {"shape": (None, 1.0), "position": VECTORS, "force": VECTORS, "torque": VECTORS}),
    "ShearDeformation": (cb.ShearDeformation, {
        "viscosity_ratio": SIZES, "end": SIZES, "points": COUNTS, "every": SIZES}),
    "Simulation": (first_states, {"end": SIZES, "every": SIZES[:5] + SIZES[6:]}),
    "StokesProblem": (lambda **w: cb.StokesProblem(
        **{"boundary": channel(), "viscosity": 1.0, "conditions": CONDITIONS} | w
    ).solve(), {
        "viscosity": SIZES, "boundary": (None, 1.0), "quadrature": (None, 1e-8),
        "storage": ("dense", 1e-6), "background": (None, 1.0),
    }),
    "StokesProblem.solve": (lambda **w: cb.StokesProblem(channel(), 1.0, CONDITIONS).solve(**w), {
        "accuracy": SHARES[:5] + SHARES[6:], "most_points": COUNTS}),
    "StokesSolution.points": (lambda **w: flow().velocity_at(**w), {
        "points": (np.nan, (1.0, 2.0), np.full((3, 2), np.nan), "0, 0, 0", np.zeros((2, 4)))}),
    "StokesSolution.pressure": (lambda **w: flow().pressure_at(**w), {
        "points": (np.nan, (1.0, 2.0), np.full((3, 2), np.nan), "0, 0, 0", np.zeros((2, 4)))}),
    "StokesSolution.torque": (lambda **w: flow().torque("walls", **w), {"centre": VECTORS}),
    "StopAtError": (cb.StopAtError, {"share": SIZES}),
    "StopAtGap": (cb.StopAtGap, {"share": SIZES}),
    "SurfaceExchange": (lambda **w: cb.SurfaceExchange(**{"convection": 1.0} | w), {
        "convection": (*SIZES,), "radiation": (*NOT_FINITE, -1.0), "ambient": NOT_FINITE}),
    "SurfaceTension": (cb.SurfaceTension, {"tension": (*NOT_FINITE, -3.0)}),
    "Temperature": (lambda value: heated(cb.Temperature(value)), {
        "value": (*NOT_FINITE, *SCALARS)}),
    "Traction": (loaded, {"value": (*VECTORS, *ONES)}),
    "Velocity": (given, {"value": (*VECTORS, *ONES)}),
    "at_rest": (cb.at_rest, {"dimension": COUNTS}),
    "box": (cb.box, {"low": VECTORS, "high": (*VECTORS, (0.0, 1.0, 1.0), (1.0, -1.0, 1.0))}),
    "capillary_tension": (cb.capillary_tension, {"capillary": SIZES}),
    "cylinder": (cb.cylinder, {"radius": SIZES, "length": SIZES, "start": VECTORS}),
    "draw_around": (lambda **w: cb.draw_around(flow(), "picture.png", **w), {
        "reach": SIZES, "resolution": COUNTS, "size": PICTURE}),
    "draw_boundary": (lambda **w: cb.draw_boundary(channel(), "picture.png", **w), {
        "size": PICTURE}),
    "draw_collocation": (lambda **w: cb.draw_collocation(flow().space, "picture.png", **w), {
        "size": PICTURE}),
    "draw_droplets": (lambda **w: cb.draw_droplets("picture.png", [cb.spline_sphere()], **w), {
        "size": PICTURE}),
    "draw_flow": (lambda **w: cb.draw_flow(flow(), "picture.png", **w), {
        "points": COUNTS, "size": PICTURE}),
    "draw_movie": (lambda **w: cb.draw_movie("movie.gif", None, [], **w), {"size": PICTURE}),
    "draw_paths": (lambda **w: cb.draw_paths("picture.png", None, [np.eye(3)], **w), {
        "size": PICTURE}),
    "draw_scene": (lambda **w: cb.draw_scene(
        "picture.png", None, {1: cb.spline_sphere()}, colour="mean curvature", **w
    ), {"size": PICTURE, "limits": (1.0, (1.0,), (2.0, 1.0), (np.nan, 1.0))}),
    "draw_series": (lambda **w: cb.draw_series("picture.png", columns={"D": np.ones(3)}, **w), {
        "times": (1.0, np.eye(3), (0.0, np.nan, 1.0), "x")}),
    "draw_slices": (lambda **w: cb.draw_slices(None, channel(), "picture.png", **w), {
        "sections": COUNTS, "size": PICTURE}),
    "draw_solution": (lambda **w: cb.draw_solution("pictures", flow(), FILE, **w), {
        "mesh_size": SIZES}),
    "draw_streamlines": (lambda **w: cb.draw_streamlines(None, channel(), "picture.png", **w), {
        "lines": COUNTS, "size": PICTURE}),
    "draw_traction": (lambda **w: cb.draw_traction(flow(), "picture.png", **w), {
        "size": PICTURE}),
    "draw_trajectories": (lambda **w: cb.draw_trajectories(
        "picture.png", None, {1: np.eye(3)}, **w), {"size": PICTURE}),
    "droplet_fate": (lambda **w: cb.droplet_fate(still(), **{"end": 0.01} | w), {
        "end": SIZES, "every": SIZES[:5] + SIZES[6:]}),
    "ellipsoid": (lambda **w: cb.ellipsoid(**{"semi_axes": (1.0, 1.0, 1.0)} | w), {
        "semi_axes": (*VECTORS, (1.0, 1.0, 0.0)), "centre": VECTORS}),
    "extended": (lambda **w: cb.extended(channel(), "inlet", **w), {"length": SIZES}),
    "filmstrip": (lambda **w: cb.filmstrip("picture.png", None, [], **w), {
        "count": COUNTS, "size": PICTURE}),
    "hydraulic_network": (lambda **w: cb.hydraulic_network(
        channel(), openings=("inlet", "outlet"), **{"viscosity": 1.0} | w
    ).operate(pressures={"inlet": 1.0}, flow_rates={"outlet": 0.0}), {
        "viscosity": SIZES, "accuracy": SHARES[:5] + SHARES[6:]}),
    "pressure": (operated, {"value": NOT_FINITE}),
    "inlet_points": (lambda **w: cb.inlet_points(flow(), **w), {"count": COUNTS}),
    "largest_capillary": (lambda **w: cb.largest_capillary(
        **{"limit": 0.1, "deformation": lambda capillary: capillary} | w), {
        "limit": (*SHARES, 1.0), "guess": SIZES[:5] + SIZES[6:], "tolerance": SHARES}),
    "linear_flow": (lambda **w: cb.linear_flow(**{"rates": np.zeros((3, 3))} | w), {
        "rates": (1.0, np.zeros(3), np.zeros((3, 2)), np.zeros((4, 4)), np.eye(3) * np.nan),
        "about": VECTORS, "drift": VECTORS}),
    "mesh_volume": (lambda **w: cb.mesh_volume(FILE, **{"size": 1.0} | w), {
        "size": SIZES, "time_limit": SIZES}),
    "numbers": (lambda **w: cb.numbers(**{"viscosity": 1.0, "velocity": 1.0, "length": 1.0} | w), {
        "viscosity": SIZES, "velocity": SIZES, "length": SIZES, "tension": SIZES[:5] + SIZES[6:],
        "density": SIZES[:5] + SIZES[6:], "viscosity_inside": SIZES[:5] + SIZES[6:]}),
    "pipe_poiseuille": (lambda **w: cb.pipe_poiseuille(**{"peak": 1.0, "radius": 1.0} | w), {
        "peak": NOT_FINITE, "radius": SIZES}),
    "plane_extension": (cb.plane_extension, {"rate": NOT_FINITE, "dimension": COUNTS}),
    "plane_poiseuille": (lambda **w: cb.plane_poiseuille(
        **{"peak": 1.0, "half_width": 1.0} | w), {
        "peak": NOT_FINITE, "half_width": SIZES, "dimension": COUNTS}),
    "plate": (lambda **w: cb.plate(**{"middle": 1.0, "side": 2.0} | w), {
        "middle": SIZES, "side": (*SIZES, 0.5, 1.0), "degree": COUNTS, "spans": COUNTS,
        "rings": COUNTS}),
    "plug": (lambda **w: cb.plug(channel(), **{"at": (0.5, 0.5, 0.5), "volume": 0.1} | w), {
        "at": VECTORS, "volume": SIZES, "film": SIZES[:5] + SIZES[6:],
        "along": (*VECTORS, (0.0, 0.0, 0.0))}),
    "read_cad": (lambda **w: cb.read_cad(FILE, **w), {"tolerance": SHARES, "time_limit": SIZES}),
    "read_layout": (lambda **w: cb.read_layout(drawing(), **{"height": 1.0} | w), {
        "height": SIZES, "region": COUNTS[:5] + COUNTS[6:],
        "ports": ([(1.0, np.nan)], [(1.0, 2.0, 3.0)], [1.0], ["1 mm"])}),
    "read_outline": (lambda **w: cb.read_outline(FILE, **w), {
        "point": VECTORS, "normal": (*VECTORS, (0.0, 0.0, 0.0)), "time_limit": SIZES,
        "region": COUNTS[:5] + COUNTS[6:]}),
    "rigid_ellipsoid": (lambda **w: cb.rigid_ellipsoid(**{"semi_axes": (2.0, 1.0, 1.0)} | w), {
        "semi_axes": (*VECTORS, (1.0, 1.0, 0.0), (1.0,) * 4), "position": VECTORS,
        "degree": COUNTS, "spans": COUNTS}),
    "rigid_sphere": (cb.rigid_sphere, {
        "radius": SIZES, "position": VECTORS, "degree": COUNTS, "spans": COUNTS}),
    "shear": (cb.shear, {"rate": NOT_FINITE, "dimension": COUNTS}),
    "sphere": (cb.sphere, {"radius": SIZES, "centre": VECTORS}),
    "sphere_octants": (cb.sphere_octants, {"radius": SIZES, "centre": VECTORS}),
    "spline_circle": (cb.spline_circle, {
        "radius": SIZES, "centre": VECTORS, "points": COUNTS, "degree": COUNTS}),
    "spline_ellipse": (lambda **w: cb.spline_ellipse(**{"semi_axes": (2.0, 1.0)} | w), {
        "semi_axes": VECTORS, "centre": VECTORS, "points": COUNTS, "degree": COUNTS}),
    "spline_ellipsoid": (lambda **w: cb.spline_ellipsoid(**{"semi_axes": (2.0, 1.0, 1.0)} | w), {
        "semi_axes": (*VECTORS, (1.0,) * 4), "centre": VECTORS, "points": COUNTS,
        "degree": COUNTS, "pole": (*COUNTS[:5], 3, -1, 0.5)}),
    "spline_sphere": (cb.spline_sphere, {
        "radius": SIZES, "centre": VECTORS, "points": COUNTS, "degree": COUNTS,
        "pole": (*COUNTS[:5], 3, -1, 0.5)}),
    "trace": (lambda **w: cb.trace(flow(), **{"release_points": [[0.5], [0.5], [0.5]]} | w), {
        "release_points": (1.0, (1.0, 2.0, 3.0), [[np.nan]] * 3, np.zeros((2, 4))),
        "time_limit": SIZES[:5] + SIZES[6:], "tolerance": SHARES}),
    "tube_resistance": (lambda **w: cb.tube_resistance(
        **{"viscosity": 1.0, "length": 1.0, "bore": 1.0} | w), {
        "viscosity": SIZES, "length": (*NOT_FINITE, -1.0), "bore": SIZES}),
    "uniaxial_extension": (cb.uniaxial_extension, {"rate": NOT_FINITE}),
}  # fmt: skip
CASES = [
    (name, parameter, value)
    for name, (_, table) in DOORS.items()
    for parameter, values in table.items()
    for value in values
    if (name, parameter) not in INFINITE or value is not np.inf
]


def test_every_public_name_is_looked_at():
    errors = {
        n for n in dir(cb) if inspect.isclass(v := getattr(cb, n)) and issubclass(v, Exception)
    }
    known = {name.split(".")[0] for name in DOORS} | FOUND | WORDS | errors | {"__version__"}
    assert set(dir(cb)) - known == set()
    assert set(dir(cb)) >= (FOUND | WORDS)


@pytest.mark.filterwarnings("ignore::cadbem.errors.CadWarning", "error::RuntimeWarning")
@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    CASES,
    ids=[f"{name}-{parameter}-{k}" for k, (name, parameter, _) in enumerate(CASES)],
)
def test_what_is_no_value_is_refused(
    name: str, parameter: str, value: Any, tmp_path: Path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    try:
        answer = DOORS[name][0](**{parameter: value})
    except cb.CadbemError as error:
        said = str(error)
        word = parameter if parameter != "value" else name.split(".")[0]
        assert "\n" not in said
        assert len(said) < 400
        assert word.split("_")[0].lower() in said.lower(), said
        return
    except TypeError as error:
        assert "missing" in str(error)  # noqa: PT017 - a word that must be given
        return
    pytest.fail(f"{name}({parameter}={value!r}) gave {answer!r}"[:300])
