"""Files of what was drawn with gmsh."""

from pathlib import Path

import gmsh


def exported(path: Path) -> Path:
    """The current model written to a file, whose ending says how."""
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    return path
