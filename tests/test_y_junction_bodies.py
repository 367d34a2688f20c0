"""Bodies in the Y-junction, coarse and for a short while: what holds whatever the resolution."""

import sys
from pathlib import Path

import numpy as np
import pytest

import cadbem as cb

sys.path.insert(0, str(Path(__file__).parents[1] / "workflows"))

import y_junction_bodies  # noqa: E402

COARSE = {"spans": 3, "levels": 0, "points": 72, "particle_spans": 1, "end": 0.05}


@pytest.fixture(scope="module")
def runs() -> dict[str, cb.History]:
    made = y_junction_bodies.main(output="", **COARSE)
    return {kind: run for (kind, _), run in made.items()}


@pytest.mark.parametrize("kind", ["droplet", "particle"])
def test_mass_and_symmetry(runs, kind):
    """No flux is lost, and nothing leaves the plane of symmetry z = 2, to 1e-8."""
    for state in runs[kind].states:
        assert abs(state.walls.net_flux()) < 1e-10
        assert abs(state.bodies[0].centre[2] - 2) < 1e-8
    shape = runs["droplet"].last.droplet.shape
    mirrored = shape.coefficients[:, ::-1].copy()
    mirrored[2] = 4 - mirrored[2]
    assert shape.coefficients == pytest.approx(mirrored, abs=1e-8)
    assert runs["droplet"].volume == pytest.approx(runs["droplet"].volume[0], rel=1e-12)
    spin = runs["particle"].last.responses[0].angular_velocity
    assert spin[:2] == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("kind", ["droplet", "particle"])
def test_bodies_lag(runs, kind):
    """In the branch bodies go along it, within 6 degrees, slower than the undisturbed duct flow at
    their centre (u = 2.0963 × 3 on the axis of a square duct, less off it), not slower than 2/3 of
    it; the particle turns at half of the shear rate there (Faxén's law, which has no correction
    for size), but for what walls a radius away change, here a quarter at most."""
    times, centres = runs[kind].track()
    step = (centres[:, -1] - centres[:, 0]) / times[-1]
    along = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    speed = step @ along
    assert np.linalg.norm(step - speed * along) < 0.1 * speed
    offset = (2.8284 - 2) / np.sqrt(2)
    fluid = 3 * duct(offset)
    assert 2 / 3 * fluid < speed < fluid
    if kind == "particle":
        shear = 3 * (duct(offset + 1e-4) - duct(offset - 1e-4)) / 2e-4
        spin = runs[kind].states[0].responses[0].angular_velocity[2]
        assert spin == pytest.approx(shear / 2, rel=0.25)


def duct(y: float) -> float:
    """Velocity over its mean on the line z = 0 of the duct |y|, |z| < 2, by its series."""
    n = np.arange(1, 200, 2)
    signs = (-1.0) ** ((n - 1) // 2)
    # cosh of 0 over cosh of nπ/2, without overflow
    decay = 1 / np.cosh(np.minimum(n * np.pi / 2, 700))
    series = (signs * np.cos(n * np.pi * y / 4) * decay / n**3).sum()
    velocity = (4 - y**2) / 2 - 64 / np.pi**3 * series
    mean = 4 / 3 * (1 - 192 / np.pi**5 * (np.tanh(n * np.pi / 2) / n**5).sum())
    return velocity / mean
