"""Fixtures that several files of tests share."""

from collections.abc import Iterator
from pathlib import Path

import gmsh
import pytest


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A fresh gmsh model, and a folder for files."""
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield tmp_path
    gmsh.finalize()


@pytest.fixture
def record(folder: Path) -> Path:
    """A fresh gmsh model, and where to record it."""
    return folder / "model.brep"
