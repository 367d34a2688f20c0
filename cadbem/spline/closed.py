"""Smooth splines on the circle and on the sphere: they carry closed curves and surfaces.

Both use uniform B-splines whose centres are the collocation points.  On the circle they are
periodic in the angle.  On the sphere the longitude is periodic, and the colatitude runs on over the
poles, f(-θ, φ) = f(θ, φ + π), so that no pole is a special point of a basis; the collocation points
are θ_j = (j + 1/2) π / rows, φ_k = (k + 1/2) 2π / columns.  Two conditions, imposed azimuthal
mode by mode (e^{imφ}), make functions of the tensor product functions on a sphere:

- they are as smooth at the poles as elsewhere: f_m and its derivatives below order m vanish
  there, up to order degree - 1 (a pole is one point with one tangent plane; higher derivatives
  join as exactly as the longitude's splines represent e^{imφ});
- near a pole they have no shorter waves than on the equator: the mode m is absent in rows whose
  circle has room for fewer than m waves, up to a factor ``ROOM``.

The second takes no accuracy (smooth functions vanish like θ^m) and the explicit time step of a
droplet becomes that of evenly spread points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import null_space

from cadbem.errors import ShapeError
from cadbem.overviews import closed_text
from cadbem.spline.basis import Array, basis_matrix, greville, open_knots
from cadbem.spline.nurbs import Nurbs
from cadbem.spline.uniform import periodic_matrix, window

ROOM = 1.5  # azimuthal waves kept near the poles, relative to evenly spread points


@dataclass(frozen=True)
class ClosedBasis:
    """Splines of one degree on the circle, ``shape`` (n,), or the sphere, (rows, columns).

    Coefficients and values at the collocation points are arrays (..., *shape).  Raises
    ShapeError for fewer points than a degree needs, and for odd numbers of columns.
    """

    degree: int
    shape: tuple[int, ...]

    def __post_init__(self) -> None:
        if self.degree < 2:
            raise ShapeError("closed splines need degree 2 or higher, for their curvature")
        if min(self.shape) <= self.degree or len(self.shape) == 2 and self.shape[1] % 2:
            raise ShapeError(
                f"{self.shape} points do not carry a closed spline of degree {self.degree}: take "
                "more than the degree in each direction, and an even number around the poles"
            )

    @property
    def dimension(self) -> int:
        """Dimension of space: 2 for curves, 3 for surfaces."""
        return len(self.shape) + 1

    @property
    def count(self) -> int:
        """Number of collocation points."""
        return int(np.prod(self.shape))

    @property
    def lengths(self) -> tuple[float, ...]:
        """Range of each parameter: 2π, or π (colatitude) and 2π (longitude)."""
        return (np.pi, 2 * np.pi)[-len(self.shape) :]

    def refined(self, factor: int) -> ClosedBasis:
        """The basis with ``factor`` times as many points in each direction."""
        return ClosedBasis(self.degree, tuple(factor * n for n in self.shape))

    def axes(self) -> list[Array]:
        """Parameters of the collocation points in each direction."""
        pairs = zip(self.shape, self.lengths, strict=True)
        return [(np.arange(n) + 0.5) * length / n for n, length in pairs]

    def parameters(self) -> Array:
        """Parameters (p, count) of the collocation points, the last parameter fastest."""
        return np.stack([g.ravel() for g in np.meshgrid(*self.axes(), indexing="ij")])

    def breaks(self) -> list[Array]:
        """Ends of the parameters' ranges and the knots between them, in each direction."""
        lines = []
        for n, length in zip(self.shape, self.lengths, strict=True):
            inner = (np.arange(n + 1) - 0.5 * (self.degree % 2)) * length / n
            inner = inner[(inner > 0) & (inner < length)]
            lines.append(np.concatenate([[0.0], inner, [length]]))
        return lines

    def doubled(self, array: Array) -> Array:
        """Coefficients or values continued over the poles to a full turn of the colatitude."""
        if len(self.shape) == 1:
            return array
        rows, half = array.shape[-2], array.shape[-1] // 2
        full = np.empty((*array.shape[:-2], 2 * rows, array.shape[-1]), array.dtype)
        full[..., :rows, :] = array
        full[..., rows:, :half] = array[..., ::-1, half:]
        full[..., rows:, half:] = array[..., ::-1, :half]
        return full

    def folded(self, array: Array) -> Array:
        """The transpose of ``doubled``: what lies beyond the poles is added where it belongs."""
        rows = self.shape[0]
        beyond = np.roll(array[..., rows:, :], -(array.shape[-1] // 2), axis=-1)
        return array[..., :rows, :] + beyond[..., ::-1, :]

    def axis_matrices(self, axes: list[Array], orders: tuple[int, ...]) -> list[Array]:
        """Matrices that evaluate doubled coefficients on a grid, one for each direction."""
        turns = (2 * self.shape[0], self.shape[1]) if len(self.shape) == 2 else self.shape
        return [
            periodic_matrix(self.degree, n, 2 * np.pi, axis, order)
            for n, axis, order in zip(turns, axes, orders, strict=True)
        ]

    def on_grid(self, coefficients: Array, matrices: list[Array]) -> Array:
        """Values on a grid, with matrices from ``axis_matrices``."""
        result = self.doubled(coefficients) @ matrices[-1].T
        return matrices[0] @ result if len(matrices) == 2 else result

    def evaluate(
        self, coefficients: Array, parameters: ArrayLike, orders: tuple[int, ...] | None = None
    ) -> Array:
        """Values or derivatives (..., M) at parameters (p, M) anywhere."""
        orders = orders or (0,) * len(self.shape)
        parameters = np.asarray(parameters, dtype=float)
        data = self.doubled(coefficients)
        first, values = window(self.degree, self.shape[-1], 2 * np.pi, parameters[-1], orders[-1])
        width = np.arange(self.degree + 1)[:, None]
        columns = (first + width) % self.shape[-1]
        if len(self.shape) == 1:
            return (data[..., columns] * values).sum(axis=-2)
        first, row_values = window(self.degree, data.shape[-2], 2 * np.pi, parameters[0], orders[0])
        rows = (first + width) % data.shape[-2]
        picked = data[..., rows[:, None], columns[None]]
        return np.einsum("...abm,am,bm->...m", picked, row_values, values, optimize=True)

    def interpolate(self, values: Array) -> Array:
        """Coefficients of the tensor product spline with these collocation values."""
        axes = tuple(range(-len(self.shape), 0))
        full = self.doubled(values)
        shape = full.shape[-len(self.shape) :]
        modes = np.fft.rfftn(full, axes=axes) / self._symbols
        result = np.fft.irfftn(modes, s=shape, axes=axes)
        return result[..., : self.shape[0], :] if len(self.shape) == 2 else result

    @cached_property
    def _symbols(self) -> Array:
        """The symbols of ``doubled`` coefficients, in the layout of ``rfftn``."""
        last = self._symbol(self.shape[-1])[: self.shape[-1] // 2 + 1]
        return last if len(self.shape) == 1 else np.outer(self._symbol(2 * self.shape[0]), last)

    def _symbol(self, count: int) -> Array:
        """Factors by which the B-splines' values at their centres multiply Fourier modes."""
        row = periodic_matrix(self.degree, count, float(count), [0.5])[0]
        return np.fft.fft(row).real

    def fit(self, values: Array) -> Array:
        """Coefficients of the smooth spline nearest to values at the collocation points.

        On the circle it interpolates; on the sphere it is the least squares fit, each point with
        its share of the sphere's area, among splines that are smooth at the poles.
        """
        if len(self.shape) == 1:
            return self.interpolate(values)
        modes = np.fft.rfft(values, axis=-1)
        fitted = np.einsum("mij,...jm->...im", self._fits, modes)
        return np.fft.irfft(fitted, n=self.shape[1], axis=-1)

    def smoothed(self, coefficients: Array) -> Array:
        """The nearest coefficients (least squares) of a function that is smooth at the poles."""
        if len(self.shape) == 1:
            return coefficients
        modes = np.fft.rfft(coefficients, axis=-1)
        kept = np.einsum("mij,...jm->...im", self._smooth, modes)
        return np.fft.irfft(kept, n=self.shape[1], axis=-1)

    @cached_property
    def _smooth(self) -> Array:
        """Orthogonal projectors (modes, rows, rows) onto the smooth modes."""
        return np.stack([z @ z.T for z in self._smooth_modes])

    @cached_property
    def _fits(self) -> Array:
        """Least squares fits (modes, rows, rows) from values to coefficients, mode by mode."""
        rows, columns = self.shape
        root = np.sqrt(np.sin(self.axes()[0]))[:, None]
        values, symbol = self._row_matrix(self.axes()[0], 0), self._symbol(columns)
        fits = []
        for m, smooth in enumerate(self._smooth_modes):
            matrix = symbol[m] * (values[0] + (-1) ** m * values[1]) @ smooth
            fits.append(smooth @ np.linalg.pinv(root * matrix) * root[:, 0])
        return np.stack(fits)

    def _row_matrix(self, colatitude: Array, order: int) -> tuple[Array, Array]:
        """Rows' functions at colatitudes: their own part, and their part beyond the poles."""
        rows = self.shape[0]
        both = periodic_matrix(self.degree, 2 * rows, 2 * np.pi, colatitude, order)
        return both[:, :rows], both[:, rows:][:, ::-1]

    @cached_property
    def _smooth_modes(self) -> list[Array]:
        """Orthonormal bases (rows, ·) of each azimuthal mode's smooth functions."""
        rows, columns = self.shape
        poles, unit = np.array([0.0, np.pi]), np.pi / rows
        derivatives = [
            [part * unit**d for part in self._row_matrix(poles, d)] for d in range(self.degree)
        ]
        waves = np.maximum(self.degree + 1, ROOM * columns / 2 * np.sin(self.axes()[0]))
        bases = []
        for m in range(columns // 2 + 1):
            conditions = [np.eye(rows)[waves < m]]
            for d in range(m % 2, min(m, self.degree), 2):
                own, beyond = derivatives[d]
                conditions.append(own + (-1) ** m * beyond)
            stacked = np.concatenate(conditions)
            bases.append(null_space(stacked, rcond=1e-10) if len(stacked) else np.eye(rows))
        return bases


def unit_measure(dimension: int) -> float:
    """Length of the unit circle or area of the unit sphere."""
    return 2 * np.pi if dimension == 2 else 4 * np.pi


def unit_point(*parameters: ArrayLike) -> Array:
    """Point (dim, ...) of the unit circle or sphere; poles of the sphere on the z axis."""
    if len(parameters) == 1:
        return np.stack([np.cos(parameters[0]), np.sin(parameters[0])])
    colatitude, longitude = np.broadcast_arrays(*parameters)
    sine = np.sin(colatitude)
    return np.stack([sine * np.cos(longitude), sine * np.sin(longitude), np.cos(colatitude)])


def unit_parameters(place: Array) -> Array:
    """Parameters (p, ...) of the directions of vectors (dim, ...): inverse to ``unit_point``."""
    longitude = np.arctan2(place[1], place[0])
    if len(place) == 2:
        return longitude[None]
    return np.stack([np.arctan2(np.hypot(place[0], place[1]), place[2]), longitude])


@dataclass(frozen=True, eq=False)
class ClosedSpline:
    """A closed curve or surface: ``coefficients`` (dim, *basis.shape).

    Curves run counter-clockwise, surfaces have x_θ × x_φ outwards.
    """

    basis: ClosedBasis
    coefficients: Array

    def __post_init__(self) -> None:
        # sums depend on the order in memory in their last bit, and stored shapes come back so
        object.__setattr__(self, "coefficients", np.ascontiguousarray(self.coefficients))

    __repr__ = closed_text

    @property
    def dimension(self) -> int:
        """Dimension of space."""
        return self.basis.dimension

    def evaluate(self, parameters: ArrayLike, orders: tuple[int, ...] | None = None) -> Array:
        """Points or derivatives (dim, M) at parameters (p, M)."""
        return self.basis.evaluate(self.coefficients, parameters, orders)

    def points(self) -> Array:
        """Collocation points (dim, count)."""
        return self.evaluate(self.basis.parameters())

    def patch(self, coefficients: Array | None = None) -> Nurbs:
        """The same curve or surface as one patch with open knots, or another field on it.

        Its domain is 0 ... 2π, or colatitude 0 ... π by longitude 0 ... 2π.  The patch's
        functions span the splines on that range, so interpolation is exact.
        """
        field = self.coefficients if coefficients is None else coefficients
        knots, sites, matrices = [], [], []
        for breaks in self.basis.breaks():
            knots.append(open_knots(self.basis.degree, breaks))
            sites.append(greville(self.basis.degree, knots[-1]))
            matrices.append(np.linalg.inv(basis_matrix(self.basis.degree, knots[-1], sites[-1])))
        grid = self.basis.axis_matrices(sites, (0,) * len(knots))
        values = self.basis.on_grid(field, grid) @ matrices[-1].T
        if len(matrices) == 2:
            values = matrices[0] @ values
        points = np.moveaxis(values, 0, -1)
        degrees = (self.basis.degree,) * len(knots)
        return Nurbs(degrees, tuple(knots), points, np.ones(points.shape[:-1]))


def closed_spline(basis: ClosedBasis, shape: Callable[[Array], Array]) -> ClosedSpline:
    """The image of the unit circle or sphere under ``shape((dim, N)) -> (dim, N)``."""
    values = shape(unit_point(*basis.parameters()))
    return ClosedSpline(basis, basis.fit(values.reshape(-1, *basis.shape)))
