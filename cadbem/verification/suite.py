"""All checks, in the order of the thesis."""

from __future__ import annotations

from cadbem.verification import channel, confined, curves, drops, heat, integrals, plane, spheres
from cadbem.verification.check import Check


def all_checks(full: bool = False) -> tuple[Check, ...]:
    """The fast checks, or with ``full`` the long ones as well."""
    rooms = (curves, heat, integrals, channel, spheres, plane, drops, confined)
    found = (check for room in rooms for check in room.checks())
    return tuple(check for check in found if full or not check.long)
