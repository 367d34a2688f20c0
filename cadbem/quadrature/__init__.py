"""Rules for regular, nearly singular and singular integrals."""

from cadbem.quadrature.options import Quadrature, Rules, UniformSubdivision

__all__ = ["Quadrature", "Rules", "UniformSubdivision"]
