"""Layers of a closed spline: its nodes in; what it does to itself and to points near it out."""
