"""Droplets moving in time: shapes, volume, meshes, time steps, ends of runs."""

import json
from pathlib import Path

import numpy as np
import pytest
from alone import alone
from scipy.spatial import cKDTree

import cadbem as cb
from cadbem.closed_points import ClosedPoints, collocation_grid
from cadbem.points import dual_tangents
from cadbem.post.style.plots import fitted_order
from cadbem.quadrature.closed import PolarRule
from cadbem.spline.closed import ClosedBasis
from cadbem.suspension.interface.laws import thesis_tension_2d
from cadbem.suspension.interface.mesh import stretches, turning
from cadbem.suspension.interface.volume import (
    centre,
    nearest_by_sqp,
    nearest_with_volume,
    volume,
    volume_gradient,
)
from cadbem.suspension.time.stepping import chebyshev_coefficients

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
EXACT_2D = REFERENCE["drop_2d_shear"]["Cat0.1_l1"]
EXACT_3D = REFERENCE["drop_3d_shear_Ca0.2_lambda1"]
RANDOM = np.random.default_rng(2)


def last(simulation: cb.Simulation, end: float) -> cb.State:
    return list(simulation.run(end, every=end))[-1]


def points_of(spline: cb.ClosedSpline) -> ClosedPoints:
    return collocation_grid(spline.basis).points(spline)


def distance(a: cb.ClosedSpline, b: cb.ClosedSpline) -> float:
    """Largest distance of b's points from the surface a: from the nearest of many points of a,
    Newton's steps along the surface lead to the foot points."""
    grid = np.meshgrid(*[np.linspace(0, length, 200) for length in a.basis.lengths])
    many = np.stack([g.ravel() for g in grid])
    at = many[:, cKDTree(a.evaluate(many).T).query(b.points().T)[1]]
    units = np.eye(len(at), dtype=int)
    for _ in range(6):
        tangents = np.stack([a.evaluate(at, tuple(unit)) for unit in units])
        duals = np.stack(dual_tangents(*tangents))
        at = at + np.einsum("acn,cn->an", duals, b.points() - a.evaluate(at))
    return float(np.linalg.norm(b.points() - a.evaluate(at), axis=0).max())


def test_shear_in_3d():
    """Ca = 0.2, λ = 1, 200 points: D and the inclination on the way and at τ = 5."""
    run = cb.Simulation(
        cb.FreeFlow(cb.shear()),
        cb.Droplet(cb.spline_sphere(), cb.capillary_tension(0.2)),
        stepper=cb.Adaptive(1e-4),
    )
    for state in run.run(5.0, every=1.0):
        if state.time == 0:
            continue
        k = EXACT_3D["tau"].index(round(state.time, 6))
        shape = state.droplet.shape
        assert cb.taylor_deformation(shape) == pytest.approx(EXACT_3D["D"][k], abs=3e-4)
        assert cb.inclination(shape) == pytest.approx(EXACT_3D["inclination_deg"][k], abs=0.1)
        assert volume(shape) == pytest.approx(volume(run.droplet.shape), rel=1e-12)
    assert cb.taylor_deformation(shape) == pytest.approx(EXACT_3D["D"][k], abs=1e-4)


def test_large_deformation_in_few_evaluations():
    """Ca = 0.35, λ = 1: D(5) = 0.41240 within 1e-3 from at most 70 velocity evaluations."""
    flow = cb.FreeFlow(cb.shear())
    end = last(cb.Simulation(flow, cb.Droplet(cb.spline_sphere(), cb.capillary_tension(0.35))), 5.0)
    assert cb.taylor_deformation(end.droplet.shape) == pytest.approx(0.41240, abs=1e-3)
    assert end.evaluations <= 70
    low, high = stretches(points_of(end.droplet.shape))
    assert (high / low).max() < 3


def test_shear_in_2d():
    """D(τ) within 1e-4 of a spectral run, at 32 points."""
    run = cb.Simulation(
        cb.FreeFlow(cb.shear(dimension=2)),
        cb.Droplet(cb.spline_circle(points=32), cb.capillary_tension(0.1)),
        stepper=cb.Adaptive(1e-5),
    )
    for state in run.run(4.0, every=0.4):
        exact = np.interp(state.time, EXACT_2D["tau"], EXACT_2D["D"])
        assert cb.taylor_deformation(state.droplet.shape) == pytest.approx(exact, abs=1e-4)


def test_extension_of_a_viscous_drop():
    """Ca = 0.05, λ = 10 in uniaxial extension: D = 0.101853 when steady."""
    run = cb.Simulation(
        cb.FreeFlow(cb.uniaxial_extension()),
        cb.Droplet(cb.spline_sphere(points=128), cb.capillary_tension(0.05), 10.0),
        stepper=cb.Adaptive(1e-4),
    )
    exact = REFERENCE["drop_3d_extension_lambda10"]["D"]
    end = last(run, 7.0)
    assert cb.taylor_deformation(end.droplet.shape) == pytest.approx(exact, abs=2e-4)


def test_ellipse_relaxes_to_the_circle_of_its_area():
    """R = √(4.7126 / π) = 1.2247723 to 1e-6."""
    scale = np.sqrt(4.7126 / (1.5 * np.pi))
    shape = cb.spline_ellipse((1.5 * scale, scale), points=32)
    shape = nearest_with_volume(shape, 4.7126)
    run = cb.Simulation(
        cb.FreeFlow(cb.at_rest(2)),
        cb.Droplet(shape, thesis_tension_2d(0.2)),
        stepper=cb.Adaptive(1e-5),
    )
    circle = last(run, 6.0).droplet.shape
    radii = np.linalg.norm(circle.evaluate(np.linspace(0, 6, 99)[None]), axis=0)
    assert radii == pytest.approx(1.2247723, abs=1e-6)


@pytest.mark.parametrize("motion", [cb.full_velocity, cb.normal_velocity, cb.affine_velocity])
def test_motions_differ_tangentially_only(motion):
    """The normal velocity of the points is the fluid's."""
    shape = cb.spline_ellipsoid((1.4, 1.0, 0.8))
    run = cb.Simulation(cb.FreeFlow(cb.shear()), cb.Droplet(shape, cb.SurfaceTension(1.0)))
    layers, velocity = run.start.layers[0], run.start.response.velocity
    grid = layers.operator.collocation
    difference = grid.values(motion(layers, velocity) - velocity)
    assert (difference * layers.targets.normal).sum(axis=0) == pytest.approx(0.0, abs=3e-4)


def test_affine_motion_maps_a_sphere_to_an_ellipsoid():
    """In u = A x with A symmetric and traceless it is A x itself: the points of a sphere at the
    start go where the linear map exp(A t) takes them."""
    shape = cb.spline_ellipsoid((1.3, 1.0, 0.9))
    strain = np.diag([1.0, -0.3, -0.7])
    layers = cb.Droplet(shape, cb.SurfaceTension(1.0)).placed(PolarRule()).layers
    velocity = np.einsum("ij,j...->i...", strain, shape.coefficients)
    assert cb.affine_velocity(layers, velocity) == pytest.approx(velocity, abs=2e-3)


def test_volume_and_centre_are_exact():
    """Volumes of an ellipsoid and an ellipse converge with twice the degree and more."""
    errors = []
    for n in (8, 12, 16):
        solid = cb.spline_ellipsoid((1.6, 1.0, 0.7), (1, 2, 3), points=2 * n**2)
        errors.append(abs(volume(solid) / (4 / 3 * np.pi * 1.12) - 1))
        assert centre(solid) == pytest.approx((1, 2, 3), abs=1e-12)
    assert fitted_order([8, 12, 16], errors) > 5
    ellipse = cb.spline_ellipse((2.0, 0.5), (3.0, -1.0), points=48)
    assert volume(ellipse) == pytest.approx(np.pi, rel=1e-6)
    assert centre(ellipse) == pytest.approx((3, -1), abs=1e-12)


@pytest.mark.parametrize(
    "shape", [cb.spline_ellipsoid((1.6, 1, 0.7), points=128), cb.spline_ellipse((2, 1))]
)
def test_volume_gradient_and_correction(shape):
    """The gradient agrees with differences; the correction meets the volume to 1e-12 and is the
    smallest, as sequential quadratic programming finds it too."""
    direction = shape.basis.smoothed(RANDOM.normal(size=shape.coefficients.shape))

    def moved(t):
        return cb.ClosedSpline(shape.basis, shape.coefficients + t * direction)

    slope = (volume(moved(1e-5)) - volume(moved(-1e-5))) / 2e-5
    assert (volume_gradient(shape) * direction).sum() == pytest.approx(slope, rel=1e-8)
    target = 1.001 * volume(shape)
    corrected = cb.CorrectVolume().apply(shape, target)
    oracle = cb.CorrectVolume(nearest=nearest_by_sqp).apply(shape, target)
    assert volume(corrected) == pytest.approx(target, rel=1e-14)
    assert corrected.coefficients == pytest.approx(oracle.coefficients, abs=1e-8)


def test_volume_far_from_the_origin():
    """The correction works wherever a droplet is."""
    shape = cb.spline_sphere(points=128, centre=(1e5, 0.0, -1e5))
    here = cb.spline_sphere(points=128)
    target = 1.001 * volume(here)
    assert volume(shape) == pytest.approx(volume(here), rel=1e-9)
    assert volume(cb.CorrectVolume().apply(shape, target)) == pytest.approx(target, rel=1e-9)


def test_thesis_trigger():
    """Below 0.1 % nothing happens."""
    shape = cb.spline_circle()
    rule = cb.CorrectVolume(1e-3)
    assert rule.apply(shape, 1.0005 * volume(shape)) is shape
    assert volume(rule.apply(shape, 1.002 * volume(shape))) == pytest.approx(1.002 * volume(shape))


@pytest.mark.parametrize(
    "semi_axes, counts, relax",
    [
        ((2.0, 0.9, 0.7), (200, 512), cb.RelaxMesh(steps=100)),
        ((2.0, 0.6), (48, 96), cb.RelaxMesh(0.2, 0.2, 100, 0.01)),
    ],
)
def test_relaxation_moves_points_along_the_surface(semi_axes, counts, relax):
    """Points move by a hundredth of the size and more, the surface by less than 1 % of that: what
    the splines resolve, less with more points."""
    changes = []
    for points in counts:
        shape = cb.spline_ellipsoid(semi_axes, points=points)
        relaxed = relax.relaxed(shape)
        travel = np.linalg.norm(relaxed.points() - shape.points(), axis=0).max()
        assert travel > 5e-3
        changes.append(distance(shape, relaxed) / travel)
    assert changes[0] < 1e-2
    assert changes[1] < changes[0] / 2


def test_relaxation_evens_out_distances():
    """C_r1 alone: on a circle with crowded points the ratio of distances falls."""
    crowded = cb.closed_spline(
        ClosedBasis(4, (32,)),
        lambda u: np.stack([f(np.arctan2(u[1], u[0]) + 0.4 * u[1]) for f in (np.cos, np.sin)]),
    )
    even = cb.RelaxMesh(0.4, 0.0, steps=400, pseudo_step=0.02).relaxed(crowded)
    ratios = [points_of(s).jacobian.max() / points_of(s).jacobian.min() for s in (crowded, even)]
    assert ratios[0] > 2
    assert ratios[1] < 1.2


def test_long_run_keeps_its_mesh():
    """Ca = 0.5, λ = 0.1 to τ = 12: no step fails, and the points stay useful.  Area grows by 48 %
    in the thesis."""
    run = cb.Simulation(
        cb.FreeFlow(cb.shear()),
        cb.Droplet(cb.spline_sphere(points=128), cb.capillary_tension(0.5), 0.1),
        stepper=cb.Adaptive(3e-3),
    )
    end = last(run, 12.0)
    assert not end.stopped
    points = points_of(end.droplet.shape)
    low, high = stretches(points)
    assert (high / low).max() < 5
    assert turning(points).max() < 70


def test_break_up_is_reported():
    """Far above the critical Ca of extension the drop is drawn out until the points no longer
    resolve it: the run ends by itself, with a finite shape and the reason."""
    run = cb.Simulation(
        cb.FreeFlow(cb.uniaxial_extension()),
        cb.Droplet(cb.spline_sphere(points=128, pole=0), cb.capillary_tension(0.5)),
    )
    states = list(run.run(50.0, every=0.5))
    end = states[-1]
    assert "points" in end.stopped
    assert end.time < 50
    assert np.isfinite(end.droplet.shape.coefficients).all()
    assert all(not s.stopped for s in states[:-1])
    assert volume(end.droplet.shape) == pytest.approx(volume(run.droplet.shape), rel=1e-12)


def test_states_between_steps_do_not_change_the_run():
    """Asking for more states leaves the steps as they are."""
    drop = cb.Droplet(cb.spline_circle(points=24), cb.capillary_tension(0.2))
    run = cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), drop)
    coarse, fine = list(run.run(2.0, every=2.0)), list(run.run(2.0, every=0.1))
    assert [s.time for s in fine] == pytest.approx(np.arange(21) * 0.1)
    assert coarse[-1].evaluations == fine[-1].evaluations
    steps = list(run.run(2.0))
    assert len(steps) == steps[-1].steps + 1
    assert steps[-1].time == pytest.approx(2.0)


def test_euler_converges_with_first_order():
    """The thesis's stepper on a relaxing ellipse, against small tolerances."""
    shape = cb.spline_ellipse((1.2, 1.0), points=24)
    drop = cb.Droplet(shape, cb.SurfaceTension(1.0))

    def deformation(stepper):
        run = cb.Simulation(cb.FreeFlow(cb.at_rest(2)), drop, stepper=stepper)
        return cb.taylor_deformation(last(run, 1.0).droplet.shape)

    truth = deformation(cb.Adaptive(1e-7))
    errors = [abs(deformation(cb.Euler(1 / n)) - truth) for n in (20, 40, 80)]
    assert fitted_order([20, 40, 80], errors) == pytest.approx(1.0, abs=0.15)


def test_chebyshev_steps_are_stable_and_of_second_order():
    """On y' = -k y a step of s stages stays bounded up to k h = 0.65 (s² - 1), and equals e^{-kh}
    to third order."""
    for stages in (2, 4, 9):
        start, rows = chebyshev_coefficients(stages)

        def grow(z, start=start, rows=rows):
            before, now = 1.0, 1.0 - start * z
            for mix, previous, new, first in rows:
                after = (1 - mix - previous) + mix * now + previous * before - z * (
                    new * now + first
                )  # fmt: skip
                before, now = now, after
            return now

        assert (
            abs(np.array([grow(z) for z in np.linspace(0.01, 0.65 * (stages**2 - 1), 50)])).max()
            < 1
        )
        errors = [abs(grow(z) - np.exp(-z)) for z in (0.2, 0.1, 0.05)]
        assert fitted_order([1, 2, 4], errors) == pytest.approx(3, abs=0.2)


def test_wrong_values_are_refused():
    shape = cb.spline_circle(points=24)
    with pytest.raises(cb.InputError, match="viscosity_ratio"):
        cb.Droplet(shape, cb.SurfaceTension(1.0), 0.0)
    with pytest.raises(cb.InputError, match="viscosity"):
        cb.FreeFlow(cb.shear(), viscosity=-1.0)
    drop = cb.Droplet(shape, cb.SurfaceTension(1.0))
    with pytest.raises(cb.InputError, match="end is -1"):
        list(cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), drop).run(-1.0))


@pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), (1.6, 1.0, 0.7), (1.0, 1.0), (2.0, 0.6)])
def test_fastest_relaxation_is_bounded(axes):
    """The rate by which time steps are limited is above the largest eigenvalue of a relaxing
    shape's motion, from power iteration, by less than a factor of two."""
    shape = cb.spline_ellipsoid(axes, points=128 if len(axes) == 3 else 32)
    run = cb.Simulation(
        cb.FreeFlow(cb.at_rest(len(axes))), cb.Droplet(shape, cb.SurfaceTension(1.0))
    )

    def slope(coefficients):
        drop = run.droplet.moved(cb.ClosedSpline(shape.basis, coefficients))
        layers = drop.placed(run.rule).layers
        velocity = alone(run.flow, drop, layers).velocity
        return cb.normal_velocity(layers, velocity)

    start, wave = slope(shape.coefficients), RANDOM.normal(size=shape.coefficients.shape)
    wave = shape.basis.smoothed(wave)
    for _ in range(60):
        wave /= np.linalg.norm(wave)
        wave = (slope(shape.coefficients + 1e-5 * wave) - start) / 1e-5
    bound = run.march.fastest(run.start)
    assert bound / 2 < np.linalg.norm(wave) < bound
