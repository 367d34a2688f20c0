"""Assembly of the matrix of a system: what the unknowns of each patch need of both layers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadbem.operators.accumulators import MatrixAccumulator
from cadbem.operators.groups import Group, groups, in_shares_of
from cadbem.operators.interactions import interact
from cadbem.operators.layers import OwnLayers, add_mixed, chunks, collocation_targets
from cadbem.operators.parallel import run_tasks
from cadbem.spline.basis import Array


def add_layers(
    layers: OwnLayers, single: Sequence[Array], double: Sequence[Array], matrix: Array
) -> None:
    """Add the map q -> S (F q) + D (U q) to a ``matrix`` (rows, T, k, F).

    ``single`` = F and ``double`` = U hold one (components, k) matrix a patch.  Where U is zero,
    only the single layer is integrated.
    """
    space, kernel = layers.space, layers.kernel
    targets = in_shares_of(space, collocation_targets(space))
    kinds = [bool(u.any()) for u in double]

    def work(_: int, task: tuple[Group, slice]) -> None:
        group, rows = task
        part = kernel if kinds[group.patches[0]] else kernel.single_alone
        entries = np.zeros((part.entries, rows.stop - rows.start, group.offsets[-1]))
        accumulator = MatrixAccumulator(entries, group.panels.surface.weights.shape[1])
        here = group.targets(targets.part(rows))
        interact(part, group.panels, group.owner, here, layers.quadrature, accumulator)
        for k, patch in enumerate(group.patches):
            mine = entries[:, :, group.offsets[k] : group.offsets[k + 1]]
            into = matrix[:, rows, :, space.functions(patch)]
            add_mixed(part, mine, single[patch], double[patch], into)

    together = list(groups(space, kinds))
    tasks = [(group, rows) for group in together for rows in chunks(space.count)]
    tasks.sort(key=lambda task: -len(task[0].panels.flat_nets))
    run_tasks(work, tasks, "boundary integrals")
