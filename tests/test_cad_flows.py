"""Flows through channels whose faces are trimmed: patches that do not meet corner to corner."""

from pathlib import Path

import gmsh
import pytest
from drawn import exported

import cadbem as cb

occ = gmsh.model.occ
GRADIENT = -28.4541538  # times viscosity, mean velocity / width²: series for the square duct


def test_a_disk_on_the_floor_changes_nothing(folder: Path):
    """The square duct with a disk drawn on its floor: the rest of the floor has a round hole. The
    pressure gradient of the duct is known (Shah and London, Laminar Flow Forced Convection in
    Ducts, 1978, f Re = 14.22708); faces of both kinds are walls."""
    box = occ.addBox(0, 0, 0, 2, 1, 1)
    occ.fragment([(3, box)], [(2, occ.addDisk(1.1, 0.45, 0, 0.25, 0.25))])
    channel = cb.read_cad(exported(folder / "duct.step"))
    assert max(patch.face for patch in channel.patches) == 7
    channel = channel.named(inlet=(0, 0.5, 0.5), outlet=(2, 0.5, 0.5), rest="walls")
    conditions = {
        "inlet": cb.Inflow(mean_velocity=1.0),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    fine = channel.elevated(2).refined(size=0.2)
    flow = cb.StokesProblem(fine, viscosity=1.0, conditions=conditions).solve()
    assert -flow.mean_pressure("inlet") / 2 == pytest.approx(GRADIENT, rel=1e-3)
    assert flow.flow_rate("outlet") == pytest.approx(-1, rel=1e-10)
