"""Plane drawings, DXF and GDS: a file in; curves with layers and the unit out."""
