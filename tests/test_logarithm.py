"""The logarithm of the plane kernels against the library's, of which two roundings may differ."""

import numpy as np

from cadbem.compiled import compiled
from cadbem.kernels.logarithm import logarithm


@compiled(fastmath=True)
def all_of(x, out):
    for k in range(len(x)):
        out[k] = logarithm(x[k])


def test_all_magnitudes():
    """From 1e-300 to 1e300, and around 1, where ln x is small: relative error 5e-16."""
    random = np.random.default_rng(0)
    near = 1 + np.concatenate([np.geomspace(1e-15, 0.4, 999), -np.geomspace(1e-15, 0.4, 999)])
    x = np.concatenate([np.exp(random.uniform(-690, 690, 20000)), near, [0.5, 2.0, 1e-300, 1e300]])
    found = np.empty_like(x)
    all_of(x, found)
    assert (abs(found - np.log(x)) <= 5e-16 * abs(np.log(x))).all()
    one = np.empty(1)
    all_of(np.ones(1), one)
    assert one[0] == 0.0
