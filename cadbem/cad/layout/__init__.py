"""Patches on one face: a trimmed face in; four-sided NURBS patches that cover it out."""
