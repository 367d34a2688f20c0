"""A natural logarithm that compilers can vectorise; they cannot vectorise that of the library."""

from __future__ import annotations

import numpy as np

from cadbem.compiled import compiled

LN_2 = 0.6931471805599453
ROOT_HALF = 0x3FE6A09E667F3BCD  # the bits of the number √½
DIGITS = 52  # bits of a number behind those of its exponent


@compiled(fastmath=True, inline="always")
def logarithm(x):
    """ln x to the last digit, for x > 0 (not below 2e-308).

    With x = m 2^k, √½ <= m < √2, f = m - 1 and s = f / (2 + f): ln m = 2 artanh s, of which f is
    taken out so that no digits are lost near x = 1: ln m = f - (f²/2 - s (f²/2 + R)) with
    R = 2 s² (1/3 + s²/5 + s⁴/7 + ...); as s² < 0.0295, ten terms are enough.
    """
    bits = np.float64(x).view(np.int64)
    power = (bits - np.int64(ROOT_HALF)) >> np.int64(DIGITS)
    f = np.int64(bits - (power << np.int64(DIGITS))).view(np.float64) - 1.0
    s = f / (2.0 + f)
    z = s * s
    series = 1.0 / 15 + z * (1.0 / 17 + z * (1.0 / 19 + z * (1.0 / 21)))
    series = 1.0 / 7 + z * (1.0 / 9 + z * (1.0 / 11 + z * (1.0 / 13 + z * series)))
    rest = 2.0 * z * (1.0 / 3 + z * (1.0 / 5 + z * series))
    half = 0.5 * f * f
    return np.float64(power) * LN_2 + (f - (half - s * (half + rest)))
