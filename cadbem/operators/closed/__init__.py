"""Layers of a closed spline: its nodes in; its layers on itself and at points near it out."""
