"""Groups of patches of equal degrees whose panels are treated together, as if of one patch.

A boundary for adaptive solutions has many patches of one element each: what Python does for each
of them would take longer than the integrals.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cadbem.kernels.kernel import Index
from cadbem.operators.interactions import Targets
from cadbem.operators.panels import Panels, split_patch
from cadbem.space import Space
from cadbem.spline.basis import Array
from cadbem.spline.nurbs import Nurbs

FUNCTIONS = 512  # of a group of several patches, at most


@dataclass(frozen=True, eq=False)
class Group:
    """Some ``patches`` and all their ``panels``; patch k has the functions from ``offsets``[k] on,
    and the panels of the rows with ``owner`` k."""

    patches: tuple[int, ...]
    panels: Panels
    offsets: tuple[int, ...]
    owner: Index

    def targets(self, targets: Targets) -> Targets:
        """Targets with ``shares`` for parameters (see ``in_shares_of``) as the group needs them."""
        owner = np.full(targets.count, -1)
        parameters = targets.parameters.copy()
        for number, patch in enumerate(self.patches):
            here = targets.owner == patch
            owner[here] = number
            parameters[0, here] += number
        return Targets(targets.position, owner, parameters)

    def gathered(self, space: Space, density: Array) -> Array:
        """Coefficients (components, n_u, n_v) of the group from those of all functions."""
        parts = [density[:, space.functions(i)] for i in self.patches]
        shape = self.panels.surface.weights.shape
        return np.ascontiguousarray(np.concatenate(parts, axis=1)).reshape(-1, *shape)


def in_shares_of(space: Space, targets: Targets) -> Targets:
    """The same targets, the domain of each patch's parameters being 0 to 1."""
    parameters = targets.parameters.copy()
    for number, patch in enumerate(space.boundary.patches):
        here = targets.owner == number
        for direction, (low, high) in enumerate(patch.surface.domain):
            parameters[direction, here] = (parameters[direction, here] - low) / (high - low)
    return Targets(targets.position, targets.owner, parameters)


def groups(space: Space, kinds: Sequence[Hashable]) -> Iterator[Group]:
    """Groups of all patches, each of one of the ``kinds``, which are given for each patch."""
    alike: dict[Hashable, list[int]] = {}
    panels = [split_patch(p.surface) for p in space.boundary.patches]
    for number, (part, kind) in enumerate(zip(panels, kinds, strict=True)):
        # with a pole, panels are cut in strips, and the shift of parameters would round points off
        # the strips' borders: such patches stay by themselves
        form = _form(part) if part.collapsed_sides is None else (number,)
        alike.setdefault((kind, *form), []).append(number)
    for members in alike.values():
        size = max(panels[i].surface.weights.size for i in members)
        step = max(FUNCTIONS // size, 1)
        for low in range(0, len(members), step):
            chosen = tuple(members[low : low + step])
            parts = tuple(panels[i] for i in chosen)
            sizes = [part.surface.weights.size for part in parts]
            owner = np.repeat(np.arange(len(parts)), [part.shape[0] for part in parts])
            offsets = tuple(np.cumsum([0, *sizes]).tolist())
            yield Group(chosen, joined(parts), offsets, owner)


def _form(panels: Panels) -> tuple[Hashable, ...]:
    """What patches must share to be one above the other."""
    across = panels.surface.weights.shape[1], panels.first[1].tobytes()
    exact = np.round(panels.extraction[1], 12) + 0.0
    shares = np.round(_shares(panels.breaks[1]), 12)
    return panels.surface.degrees, *across, exact.tobytes(), shares.tobytes()


def _shares(breaks: Array) -> Array:
    return (breaks - breaks[0]) / (breaks[-1] - breaks[0])


@lru_cache(maxsize=1024)
def joined(parts: tuple[Panels, ...]) -> Panels:
    """Panels of patches of one form, one above the other: the domain of number k is [k, k + 1] in
    the first parameter and [0, 1] in the second."""
    heights = np.cumsum([0, *[len(part.surface.weights) for part in parts]])
    breaks = [k + _shares(part.breaks[0])[:-1] for k, part in enumerate(parts)]
    first = [part.first[0] + low for part, low in zip(parts, heights[:-1], strict=True)]
    one = parts[0]
    return Panels(
        _stacked([part.surface for part in parts]),
        (np.concatenate([*breaks, [len(parts)]]), _shares(one.breaks[1])),
        np.concatenate([part.nets for part in parts]),
        (np.concatenate([part.extraction[0] for part in parts]), one.extraction[1]),
        (np.concatenate(first), one.first[1]),
    )


def _stacked(surfaces: Sequence[Nurbs]) -> Nurbs:
    """Surfaces as a single one, with jumps between them."""
    (p, q), one = surfaces[0].degrees, surfaces[0]
    knots = [k + _shares(s.knots[0])[p + 1 if k else 0 :] for k, s in enumerate(surfaces)]
    points = np.concatenate([s.points for s in surfaces])
    weights = np.concatenate([s.weights for s in surfaces])
    return Nurbs((p, q), (np.concatenate(knots), _shares(one.knots[1])), points, weights)

