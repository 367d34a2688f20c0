"""Faces put together: faces of a file in; one closed, oriented and named body of fluid out."""
