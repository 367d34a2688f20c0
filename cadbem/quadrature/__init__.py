"""Rules for regular, nearly singular and singular integrals."""

from cadbem.quadrature.options import Quadrature

__all__ = ["Quadrature"]
