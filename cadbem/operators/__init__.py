"""Boundary integral operators: self, near and far interactions behind one interface."""
