"""Numbers as CAD files write them."""

from __future__ import annotations


def written(value: float) -> str:
    """As few digits as give the same number back, with the point that STEP and IGES require."""
    digits, _, exponent = repr(float(value) + 0.0).partition("e")
    digits = digits.removesuffix(".0")
    return digits + ("" if "." in digits else ".") + (f"E{exponent}" if exponent else "")
