"""Boundary value problems: conditions, linear systems, solutions."""
