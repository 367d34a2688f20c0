"""Force and torque on a sphere near a plane wall, as series in bispherical coordinates.

Lengths in radii, speeds and viscosity 1; the wall is z = 0, the centre (0, 0, h), h = cosh α, and
r = c sin η / s, z = c sinh ξ / s with c = sinh α, s = cosh ξ - m, m = cos η: ξ = 0 is the wall and
ξ = α the sphere.  After Dean and O'Neill (1963, 1964), with the recurrences made by matrices.

Motion along x or about y.  With harmonic functions Q cos φ, W cos φ, U₀ and U₂ (cos 2φ, sin 2φ),

    p = Q cos φ / c,  u = ½ (x Q cos φ / c + (U₀ + U₂ cos 2φ, U₂ sin 2φ, 2 W cos φ)),

each √s times a sum of P_n' sin η (Q, W), P_n (U₀) or P_n" sin² η (U₂) with coefficients that
are combinations of exp(±(n + ½) ξ), hence known inside from their values q, w, d, f on both
surfaces.  div u is harmonic, so it vanishes if it does on the surfaces, where it is n·∂u/∂n.  On
the wall, u = 0 and ∂u_z/∂z = 0 give W = 0, Q = -2 s ∂W/∂ξ, U₀ = U₂ = sin η ∂W/∂ξ; on the sphere the
given velocity gives Q, U₀ and U₂ in terms of W there.  What is left, n·∂u/∂n = 0 on the
sphere, is a banded system for the coefficients w of W on the sphere.

What is singular inside the sphere, the part with exp((n + ½) ξ), decays like the flow of a force
F and a torque L (about the origin) on the fluid: Q / c -> F r / 4πR³ and W -> -L r / 8πR³.
"""

from math import acosh, ceil, pi

import numpy as np

ROOT = np.sqrt(2)


def enough(height: float) -> int:
    """Terms after which exp(-2 n α) is below rounding."""
    return ceil(30 / acosh(height))


def along_wall(height: float) -> dict[str, float]:
    """Force Ft·6π and torque Tt·8π on the fluid for a sphere that moves along x with speed 1,
    Fr·6π along x and Tr·8π about y for one that turns about y."""
    alpha, terms = acosh(height), enough(height)
    c, cosh, sinh = np.sinh(alpha), height, np.sinh(alpha)
    n = np.arange(terms + 4.0)  # degrees of P_n, in all bases
    half = n + 0.5
    decay = np.exp(-half * alpha)
    rate, transfer = half / np.tanh(half * alpha), half / np.sinh(half * alpha)
    one = np.eye(len(n))
    # columns: P_n' times m in P'; P_n in P'; P_n' in P"; (1 - m²) P_n' in P; (1 - m²) P_n" in P'
    times = np.diag(n[:-1] / (2 * n[:-1] + 1), -1) + np.diag((n[1:] + 1) / (2 * n[1:] + 1), 1)
    lowered = np.diag(1 / (2 * n[:-1] + 1), -1) - np.diag(1 / (2 * n[1:] + 1), 1)
    weight = n * (n + 1) / (2 * n + 1)
    square = np.diag(weight[1:], 1) - np.diag(weight[:-1], -1)
    twice = 2 * times - lowered * (n * (n + 1))
    s = cosh * one - times

    # coefficients on wall and sphere: a matrix on w, and columns for moving and for turning
    root = ROOT * decay  # s^(-1/2) in P
    cube = 2 * ROOT * decay  # s^(-3/2) in P'
    zero = np.zeros((len(n), 2))
    slope = np.diag(transfer)  # of W at the wall
    q_wall, f_wall, d_wall = -2 * (one - times) @ slope, lowered @ slope, square @ slope
    q, f, d = -2 / sinh * s, lowered / sinh, square / sinh
    q_given, f_given, d_given = zero.copy(), zero.copy(), zero.copy()
    q_given[:, 1] = -2 * lowered @ root
    f_given[:, 1] = lowered @ cube
    d_given[:, 0] = 2 * root
    d_given[:, 1] = 2 * (2 * ROOT * c * half * decay - height * root) + square @ cube

    def derivative(sphere, wall):
        return rate[:, None] * sphere - transfer[:, None] * wall

    def equation(q, dq, d, dd, f, df, w, dw):
        """n·∂u/∂n on the sphere, over common factors, in P'."""
        first = 0.5 * sinh**2 * times @ q + cosh * (one - cosh * times) @ q
        first -= sinh * times @ s @ dq + 0.5 * sinh**2 * (lowered @ d + twice @ f)
        first -= sinh * s @ (lowered @ dd + twice @ df)
        return first + (one - cosh * times) @ (sinh * w + 2 * s @ dw)

    matrix = equation(
        q, derivative(q, q_wall), d, derivative(d, d_wall), f, derivative(f, f_wall),
        one, np.diag(rate),
    )  # fmt: skip
    right = -equation(
        q_given, derivative(q_given, zero), d_given, derivative(d_given, zero), f_given,
        derivative(f_given, zero), zero, zero,
    )  # fmt: skip
    kept = slice(1, terms + 1)
    w = np.zeros_like(zero)
    w[kept] = np.linalg.solve(matrix[kept, kept], right[kept])
    inner = ROOT * (n * (n + 1) / (2 * np.sinh(half * alpha)))
    force = 4 * pi * c * inner @ (q @ w + q_given - (decay * (q_wall @ w).T).T)
    torque = -8 * pi * c**2 * inner @ w - height * force
    keys = ("Ft", "Fr"), ("Tt", "Tr")
    return {
        **dict(zip(keys[0], force / (6 * pi), strict=True)),
        **dict(zip(keys[1], torque / (8 * pi), strict=True)),
    }


def towards_wall(height: float) -> float:
    """Drag over 6π of a sphere that moves along z with speed 1 (Brenner 1961)."""
    alpha, n = acosh(height), np.arange(1.0, enough(height) + 1)
    k = 2 * n + 1
    above = 2 * np.sinh(k * alpha) + k * np.sinh(2 * alpha)
    below = 4 * np.sinh(k * alpha / 2) ** 2 - k**2 * np.sinh(alpha) ** 2
    series = n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (above / below - 1)
    return 4 / 3 * np.sinh(alpha) * float(series.sum())
