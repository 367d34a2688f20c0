"""The layout of points on closed curves and surfaces: how well it serves, and other ones.

A closed surface is the image of the unit sphere, and a map of the sphere onto itself before that
changes where points and poles lie and nothing else.
"""

from __future__ import annotations

import numpy as np

from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline, unit_parameters, unit_point

WAVES = 6  # of the map from even to present colatitudes: few, so that it is smooth
SAMPLES = 96  # colatitudes at which lengths along a surface are measured
MOST_UNEVEN = 0.8  # of a colatitude's step may be taken away by the map
ENDS = 9  # power of a place along an axis: an odd one, to find its two ends


def interpolation_error(degree: int, share: Array) -> Array:
    """Relative error of the spline through equidistant values of a wave, in the mean.

    ``share`` (K,) of a wave among n points is k / n, at most 1/2.  The spline through the values of
    exp(ikx) is Σ_j w_j exp(i(k + jn)x) / Σ_j w_j with w_j = (k / (k + jn))^(degree + 1), as its
    spectrum falls like that of its B-splines; what is too much at j = -1 is missing at j = 0, so
    that the error is about √2 |w_-1|.  It is at most 1 here, the wave itself.
    """
    known = np.minimum(np.abs(share), 0.5)
    return np.minimum(np.sqrt(2) * (known / (1 - known)) ** (degree + 1), 1.0)


def spline_residuals(basis: ClosedBasis, coefficients: Array) -> Array:
    """By how much a field's splines are wrong, for each direction of the parameters (p,).

    The root of the mean square over the circle or the sphere's parameters, in the units of the
    field with ``coefficients`` (components, *shape): each wave in the values at the collocation
    points has the share of an error that ``interpolation_error`` gives.  Waves beyond those that
    the points carry are taken to be as strong as the shortest of those.
    """
    grid = tuple(range(-len(basis.shape), 0))
    values = basis.on_grid(coefficients, basis.axis_matrices(basis.axes(), (0,) * len(grid)))
    turns = basis.doubled(values)
    waves = np.fft.fftn(turns, axes=grid) / np.prod(turns.shape[1:])
    power = (np.abs(waves) ** 2).sum(axis=0)
    found = []
    for axis, count in enumerate(power.shape):
        others = tuple(a for a in range(power.ndim) if a != axis)
        errors = interpolation_error(basis.degree, np.fft.fftfreq(count).astype(float))
        found.append(np.sqrt((power.sum(axis=others) * errors**2).sum()))
    return np.array(found)


def relaid(spline: ClosedSpline, basis: ClosedBasis) -> ClosedSpline:
    """The same curve or surface on another basis, of more or fewer points or another degree.

    The new spline interpolates (on a sphere, fits) the old one; what that changes is of the size
    of ``spline_residuals``.
    """
    return _through(spline, basis, unit_point(*basis.parameters()))


def laid_out(spline: ClosedSpline, basis: ClosedBasis, axis: Array) -> ClosedSpline:
    """The same surface with its poles at its two ends along an ``axis``, a vector (3,), and with
    rows as far apart as each other along the surface, in the mean around it.

    Where the surface has nearly the symmetry of the axis, few columns do.  Curves have no poles and
    keep their layout.
    """
    if spline.dimension == 2:
        return relaid(spline, basis)
    turn = _to_ends(spline, axis)
    colatitude, longitude = basis.parameters()
    even = _even_colatitudes(spline, turn, colatitude)
    return _through(spline, basis, turn @ unit_point(even, longitude))


def longest_axis(spline: ClosedSpline) -> Array:
    """The direction (dim,) in which the points have the largest second moment."""
    arm = spline.points()
    share = np.sin(spline.basis.parameters()[0]) if spline.dimension == 3 else np.ones(arm.shape[1])
    arm = arm - (arm @ share)[:, None] / share.sum()
    return np.linalg.svd(arm * np.sqrt(share), full_matrices=False)[0][:, 0]


def _through(spline: ClosedSpline, basis: ClosedBasis, unit: Array) -> ClosedSpline:
    """The spline whose collocation points are images of points ``unit`` (dim, N)."""
    values = spline.evaluate(unit_parameters(unit))
    return ClosedSpline(basis, basis.fit(values.reshape(-1, *basis.shape)))


def _to_ends(spline: ClosedSpline, axis: Array) -> Array:
    """The rotation (3, 3) of the unit sphere after which the poles are at the ends along an axis.

    The ends are, on the sphere, the middle of all points by a high odd power of their places along
    the axis.
    """
    sphere, share = unit_point(*spline.basis.parameters()), np.sin(spline.basis.parameters()[0])
    along = axis @ spline.points()
    along = along - (along.max() + along.min()) / 2
    pole = sphere @ (share * (along / np.abs(along).max()) ** ENDS)
    pole *= np.copysign(1.0, pole[2]) / np.linalg.norm(pole)
    side = np.eye(3)[int(np.abs(pole).argmin())]
    side = np.cross(pole, side) / np.linalg.norm(np.cross(pole, side))
    return np.stack([side, np.cross(pole, side), pole], axis=1)


def _even_colatitudes(spline: ClosedSpline, turn: Array, colatitude: Array) -> Array:
    """Where, on the turned sphere, rows at even ``colatitude`` (N,) of a new layout belong.

    Lengths along the meridians, in the mean around, as a share t of π from pole to pole; the
    colatitude as a function of them is t + Σ b_k sin kt, which is smooth at the poles.
    """
    edges, around = np.linspace(0, np.pi, SAMPLES + 1), np.linspace(0, 2 * np.pi, 17)[:-1]
    grid = np.meshgrid(edges, around, indexing="ij")
    unit = turn @ unit_point(*(g.ravel() for g in grid))
    line = spline.evaluate(unit_parameters(unit)).reshape(3, *grid[0].shape)
    pieces = np.linalg.norm(np.diff(line, axis=1), axis=0).mean(axis=1)
    share = np.pi * np.concatenate([[0.0], np.cumsum(pieces)]) / pieces.sum()
    number = np.arange(1, WAVES + 1)
    amounts = np.linalg.lstsq(np.sin(np.outer(share, number)), edges - share, rcond=None)[0]
    steepest = float((np.cos(np.outer(edges, number)) @ (number * amounts)).min())
    amounts *= min(1.0, MOST_UNEVEN / max(-steepest, MOST_UNEVEN))
    return colatitude + np.sin(np.outer(colatitude, number)) @ amounts
