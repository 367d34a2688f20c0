"""The CAD kernel in a process of its own: a file in; its BREP record as values out."""
