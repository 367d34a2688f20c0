"""Rigid-body mechanics: where a body is and its surface in; motion and resistance out."""
