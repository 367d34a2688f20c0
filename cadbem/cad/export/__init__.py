"""Writing: patches, or gmsh's model, in; STEP and IGES files with names out."""
