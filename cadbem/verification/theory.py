"""Formulas of theory for droplets that are nearly round."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad

from cadbem.spline.basis import Array


def cox(capillary: float, ratio: float) -> float:
    """Steady D for small deformation (Eq. 4.7); at Ca = 0.2, λ = 1 it is 3.7 % too low."""
    return 1.25 * (19 * ratio + 16) / ((ratio + 1) * np.hypot(20 / capillary, 19 * ratio))


def extension(capillary: Array | float, ratio: float, order: int) -> Array | float:
    """Steady D for small deformation."""
    share = 19 * ratio + 16
    first = 3 * share / (32 * (ratio + 1)) * capillary
    second = share * (23161 * ratio**2 + 35193 * ratio + 10736) / (107520 * (ratio + 1) ** 3)
    return first + (second * capillary**2 if order == 2 else 0.0)


def taylor_capillary(deformation: float, ratio: float) -> float:
    """Ca of a small steady D, by Taylor."""
    return deformation * (16 * ratio + 16) / (19 * ratio + 16)


def shapira_haber(capillary: float, ratio: float, confinement: float) -> float:
    """D = D_Taylor [1 + C_s (1 + 2.5λ) / (1 + λ) (R / d)³], d = 2 W, midway, for small Ca."""
    taylor = capillary * (19 * ratio + 16) / (16 * ratio + 16)
    return taylor * (1 + 5.69961743634 * (1 + 2.5 * ratio) / (1 + ratio) * (confinement / 2) ** 3)


def far_plates(ratio: float) -> float:
    """K in D = D_free (1 + K (R / W)²), for W much larger than R and small Ca.

    In a rate of strain E a round droplet makes u = -(S / πμ) x y (x, y) / r⁴, with the stresslet
    S = 2π μ E R² (1 + 2λ) / (1 + λ).  On the plates y = ±1 the stream function
    ∫ cos kx (A cosh ky + B ky sinh ky) dk cancels it (S / πμ = 1) with A = k / N and
    B = (e⁻ᵏ cosh k - k) / kN, N = 2 (sinh k cosh k + k), which adds ∫ k² (A + B) dk to the rate of
    strain at the droplet.  To first order D is proportional to it.
    """

    def added(k: float) -> float:
        decay = np.exp(-2 * k)
        numerator = k**3 - k**2 + k * (1 + decay) / 2
        return decay * numerator / ((1 - decay**2) / 2 + 2 * k * decay)

    return 2 * (1 + 2 * ratio) / (1 + ratio) * quad(added, 0, 40)[0]
