"""Units of length, as CAD files name them."""

from __future__ import annotations

from dataclasses import dataclass

from cadbem.errors import printable


@dataclass(frozen=True)
class Unit:
    """A unit of length; the kernel always works in millimetres."""

    name: str
    millimetres: float
    assumed: bool = False  # the file does not say

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", printable(self.name))
