"""What bodies say of themselves when they are printed."""

from __future__ import annotations

from typing import Any

from cadbem.tables import brief, numbers


def droplet_text(droplet: Any) -> str:
    """Two lines of a droplet."""
    what = "volume" if droplet.dimension == 3 else "area"
    basis = droplet.shape.basis
    return (
        f"Droplet in {droplet.dimension}D at {numbers(droplet.centre)}, {what} "
        f"{droplet.volume:.5g}, viscosity ratio {droplet.viscosity_ratio:g}\n"
        f"  {brief(droplet.interface)}, {basis.count} points of degree {basis.degree}"
    )


def particle_text(particle: Any) -> str:
    """Two lines of a rigid particle."""
    volume = particle.resistance.volume
    what = "volume" if particle.dimension == 3 else "area"
    turn = "not turned" if particle.turn is None else f"turned by {numbers(particle.turn)}"
    loads = {"force": particle.force, "torque": particle.torque}
    pushed = [f"{k} {brief(v)}" for k, v in loads.items() if not (isinstance(v, float) and v == 0)]
    patches = len(particle.shape.patches)
    return (
        f"Rigid particle in {particle.dimension}D at {numbers(particle.centre)}, {what} "
        f"{volume:.5g}, {turn}\n  {patches} patches, {', '.join(pushed) or 'no load'}"
    )
