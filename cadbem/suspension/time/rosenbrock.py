"""Linearly implicit steps of order 3, with any matrix A in place of the Jacobian.

The W-method ROS34PW2 of Rang and Angermann (BIT 45, 2005) solves y' = f(y) by

    k_i = f(y + h Σ_{j<i} α_ij k_j) + h A Σ_{j≤i} γ_ij k_j,    y_1 = y + h Σ_i b_i k_i,

with γ_ii = γ.  Its conditions of order hold whatever A is; the nearer A is to the Jacobian where
that is large, the longer the steps that are stable.  The last stage leads to y_1 itself, so that a
quantity that follows the others at once, such as the shape of a droplet with a large tension, ends
where it belongs.  With q = Σ_{j<i} (γ_ij / γ) k_j each stage is

    (I - γ h A) (k_i + q) = f_i + q.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cadbem.spline.basis import Array

Damping = Callable[[Array], Array]  # (I - s A)^-1 of an array

GAMMA = 0.43586652150845900
ALPHA = np.array([
    [0.0, 0.0, 0.0, 0.0],
    [0.87173304301691801, 0.0, 0.0, 0.0],
    [0.84457060015369423, -0.11299064236484185, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
])  # fmt: skip
LOWER = np.array([
    [0.0, 0.0, 0.0, 0.0],
    [-0.87173304301691801, 0.0, 0.0, 0.0],
    [-0.90338057013044082, 0.054180672388095326, 0.0, 0.0],
    [0.24212380706095346, -1.2232505839045147, 0.54526025533510214, 0.0],
])  # fmt: skip
WEIGHTS = np.array([0.24212380706095346, -1.2232505839045147, 1.5452602553351020, GAMMA])
WEIGHTS_LOW = np.array([0.37810903145819369, -0.096042292212423178, 0.5, 0.21793326075422950])


def start_weights() -> Array:
    """Weights p (4,) of the slope at the beginning, Σ p_i k_i = f(y) + O(h²) whatever A is.

    Σ p_i = 1, Σ p_i α_i = 0 and Σ p_i γ_i = 0, α_i and γ_i the sums of rows; the least of them.
    """
    rows = np.stack([np.ones(4), ALPHA.sum(axis=1), LOWER.sum(axis=1) + GAMMA])
    return np.linalg.pinv(rows) @ [1.0, 0.0, 0.0]


START = start_weights()


def rosenbrock_stages(
    rate: Callable[[Array], Array], state: Array, slope: Array, length: float, damping: Damping
) -> Array:
    """The slopes k_i (4, ·) of a step of a ``length`` h, from the ``slope`` f(y) at its beginning
    and three evaluations of the ``rate``; ``damping`` applies (I - γ h A)^-1."""
    slopes = np.zeros((4, state.size))
    for i in range(4):
        there = slope if i == 0 else rate(state + length * (ALPHA[i] @ slopes))
        carried = LOWER[i] @ slopes / GAMMA
        slopes[i] = damping(there + carried) - carried
    return slopes
