"""Elements cut from the patches of a boundary, small where something comes near."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from cadbem.boundary import Boundary
from cadbem.kernels.kernel import Index
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

Sizes = Callable[[Array], Array]  # the length (M,) that an element at points (dim, M) may have
SAMPLES = 5  # samples a direction of an element
BESIDE = 0.5  # share of the length it may have from which an element counts as near


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of a boundary's patches: the number of the ``patch`` (K,) that each is of, its ``box``
    (K, p, 2) of parameters, and its least ``degree`` (K,)."""

    patch: Index
    box: Array
    degree: Index

    @classmethod
    def whole(cls, boundary: Boundary) -> Pieces:
        """All patches, uncut."""
        boxes = [patch.surface.domain for patch in boundary.patches]
        count = len(boxes)
        return cls(np.arange(count), np.array(boxes, dtype=float), np.zeros(count, dtype=int))

    def of(self, boundary: Boundary) -> Boundary:
        """The pieces as patches of their own; uncut patches stay as they are."""
        patches = []
        for number, box, degree in zip(self.patch, self.box, self.degree, strict=True):
            patch = boundary.patches[number]
            surface = patch.surface
            if not np.array_equal(box, surface.domain):
                surface = surface.restricted(*[(float(a), float(b)) for a, b in box])
            if degree > min(surface.degrees):
                surface = surface.elevated([max(degree, d) for d in surface.degrees])
            patches.append(replace(patch, surface=surface))
        return replace(boundary, patches=tuple(patches))

    def same_as(self, other: Pieces | None) -> bool:
        """Whether the pieces are equal."""
        if other is None or len(self.patch) != len(other.patch):
            return False
        pairs = ((self.patch, other.patch), (self.box, other.box), (self.degree, other.degree))
        return all(np.array_equal(a, b) for a, b in pairs)


@dataclass(frozen=True, eq=False)
class Elements:
    """The elements of a boundary: ``patch`` (K,) and ``box`` (K, p, 2) of each."""

    boundary: Boundary
    patch: Index
    box: Array

    @classmethod
    def of(cls, boundary: Boundary) -> Elements:
        """All elements of all patches."""
        owners, boxes = [], []
        for number, patch in enumerate(boundary.patches):
            found = _element_boxes(patch.surface)
            owners += [number] * len(found)
            boxes += found
        return cls(boundary, np.array(owners), np.array(boxes))

    @cached_property
    def samples(self) -> Array:
        """Points (K, dim, S) of each, a grid with its edges."""
        grids = [
            self.boundary.patches[number].surface.evaluate(
                *np.meshgrid(*[np.linspace(a, b, SAMPLES) for a, b in box], indexing="ij")
            )
            for number, box in zip(self.patch, self.box, strict=True)
        ]
        samples = SAMPLES ** self.box.shape[1]
        return np.reshape(grids, (len(grids), self.boundary.dimension, samples))

    @cached_property
    def lengths(self) -> Array:
        """The longest line along each direction (K, p)."""
        axes = self.box.shape[1]
        grid = self.samples.reshape(*self.samples.shape[:2], *[SAMPLES] * axes)
        lines = [
            np.linalg.norm(np.diff(grid, axis=2 + d), axis=1).sum(axis=1 + d)
            for d in range(axes)
        ]
        others = tuple(range(1, axes))
        return np.stack([line.max(axis=others) for line in lines], axis=1)

    @property
    def points(self) -> Array:
        """All samples (dim, K S)."""
        return np.concatenate(list(self.samples), axis=1)

    def least(self, values: Sizes) -> Array:
        """The least value (K,) on each of what has ``values`` (M,) at points (dim, M)."""
        return values(self.points).reshape(self.samples.shape[::2]).min(axis=1)

    def shares(self, sizes: Sizes) -> Array:
        """The length of each over what it may be (K,)."""
        return self.lengths.max(axis=1) / self.least(sizes)

    def chosen(self, rows: Index) -> Elements:
        """Some of the elements."""
        return replace(self, patch=self.patch[rows], box=self.box[rows])

    def halved(self) -> Elements:
        """Each in two, across its longest direction."""
        longest = self.lengths.argmax(axis=1)
        rows = np.arange(len(longest))
        middle = self.box[rows, longest].mean(axis=1)
        first, second = self.box.copy(), self.box.copy()
        first[rows, longest, 1] = middle
        second[rows, longest, 0] = middle
        return replace(
            self, patch=np.concatenate([self.patch] * 2), box=np.concatenate([first, second])
        )


def pieces_near(elements: Elements, sizes: Sizes, degree: int) -> Pieces:
    """Pieces of the boundary of ``elements``, halved until none is longer than it may be.

    A patch without such elements stays whole.  Those that are more than ``BESIDE`` of what they may
    be have at least the ``degree``.
    """
    share = elements.shares(sizes)
    cut = np.unique(elements.patch[share > 1])
    whole = Pieces.whole(elements.boundary)
    stay = np.setdiff1d(whole.patch, cut)
    beside = np.isin(stay, elements.patch[share > BESIDE])
    owners, boxes = [stay], [whole.box[stay]]
    degrees = [np.where(beside, degree, 0)]
    left = elements.chosen(np.nonzero(np.isin(elements.patch, cut))[0])
    while len(left.patch):
        share = left.shares(sizes)
        long = share > 1
        done = left.chosen(np.nonzero(~long)[0])
        owners.append(done.patch)
        boxes.append(done.box)
        degrees.append(np.where(share[~long] > BESIDE, degree, 0))
        left = left.chosen(np.nonzero(long)[0]).halved()
    order = np.argsort(np.concatenate(owners), kind="stable")
    return Pieces(
        np.concatenate(owners)[order], np.concatenate(boxes)[order], np.concatenate(degrees)[order]
    )


def _element_boxes(surface: Nurbs) -> list[list[tuple[float, float]]]:
    """The rectangles of parameters of a patch's elements."""
    breaks = [surface.breaks(d) for d in range(len(surface.degrees))]
    spans = [list(zip(b[:-1], b[1:], strict=True)) for b in breaks]
    return [list(box) for box in product(*spans)]
