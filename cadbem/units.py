"""Quantities in SI or laboratory units, as numbers in one consistent set of units.

A ``Units`` value turns text such as "30 uL/min" into a ``Quantity``: a float in the model's units
that remembers its dimension, so that the places where it is used can check it.  Arithmetic makes
plain floats, which are taken as they are everywhere.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

from cadbem.checks import instance, positive
from cadbem.errors import UnitsError

Dimension = tuple[int, int, int]  # powers of length, mass and time


class UnitNames(Protocol):
    """The names of units, such as "mm", "s", "Pa"; empty where there are none."""

    @property
    def length(self) -> str: ...

    @property
    def time(self) -> str: ...

    @property
    def pressure(self) -> str: ...


class Drawn(Protocol):
    """A geometry with a unit of length, such as a ``Boundary``."""

    @property
    def source(self) -> str:
        """The file, or nothing."""

    @property
    def unit(self) -> str:
        """The unit, or nothing."""


# what a kind of quantity is: its dimension, words for it, an example, and how it is shown
_KINDS: dict[str, tuple[Dimension, str, str, str]] = {
    "length": ((1, 0, 0), "a length", "50 um", "m"),
    "area": ((2, 0, 0), "an area", "2 mm^2", "mm^2"),
    "volume": ((3, 0, 0), "a volume", "5 nL", "L"),
    "time": ((0, 0, 1), "a time", "20 ms", "s"),
    "rate": ((0, 0, -1), "a number per time", "100 1/s", "1/s"),
    "velocity": ((1, 0, -1), "a length per time", "1 mm/s", "m/s"),
    "flow_rate": ((3, 0, -1), "a volume per time", "30 uL/min", "L/min"),
    "plane_flow_rate": ((2, 0, -1), "an area per time", "2 mm^2/s", "mm^2/s"),
    "pressure": ((-1, 1, -2), "a pressure", "2 kPa", "Pa"),
    "viscosity": ((-1, 1, -1), "a viscosity", "1 mPa s", "Pa s"),
    "tension": ((0, 1, -2), "a force per length", "72 mN/m", "N/m"),
    "force": ((1, 1, -2), "a force", "3 nN", "N"),
    "density": ((-3, 1, 0), "a mass per volume", "1000 kg/m^3", "kg/m^3"),
    "resistance": ((-4, 1, -1), "a pressure per flow rate", "2 Pa min/uL", "Pa*min/uL"),
}
LONGEST = 100  # letters of a quantity
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*\*?\s*(.*)", re.DOTALL)
_POWER = re.compile(r"(?<=[A-Za-zµμ])(-?\d+)(?![A-Za-z\d])")  # m3, s-1, not H2O
MANY = 1e-9  # relative difference at which two units are not the same


class Quantity(float):
    """A float in the units of ``units``, with its ``dimension`` and the ``text`` it came from."""

    dimension: Dimension
    text: str
    units: Units

    @classmethod
    def of(cls, value: float, dimension: Dimension, text: str, units: Units) -> Quantity:
        """A quantity with all that is known of it."""
        made = cls(value)
        made.dimension, made.text, made.units = dimension, text, units
        return made


@dataclass(frozen=True)
class Units:
    """A consistent set of units made of those of ``length``, ``time`` and ``pressure``.

    ``units("30 uL/min")`` is the number of length³ / time that this is.  With "mm", "s" and "Pa"
    viscosities are in Pa s, and tensions in Pa mm = mN/m.  Raises ``UnitsError`` for units that do
    not exist or measure something else.
    """

    length: str = "mm"
    time: str = "s"
    pressure: str = "Pa"

    def __post_init__(self) -> None:
        for kind in ("length", "time", "pressure"):
            text = instance(kind, getattr(self, kind), str, "a unit as text")
            if _parsed(text, text)[1] != _KINDS[kind][0]:
                raise UnitsError(f"{kind}='{text}' is not {_KINDS[kind][1]}; give a unit of one")

    @classmethod
    def of(cls, channel: Drawn, time: str = "s", pressure: str = "Pa") -> Units:
        """Units with the length of a ``channel``'s CAD file.

        Raises ``UnitsError`` for a channel without a unit.
        """
        if not channel.unit:
            raise UnitsError(
                f"{channel.source or 'the channel'} has no unit of length; say it: "
                "cb.Units(length='mm')"
            )
        return cls(channel.unit, time, pressure)

    def __call__(self, text: str) -> Quantity:
        """The quantity of a ``text``: a number and a unit in SI or others, as "1 mPa s".

        u, µ and μ are micro; powers are ^2, ** 2, ² or 2; products a space, * or ·.  Raises
        ``UnitsError`` for text without number or unit, and for unknown units.
        """
        found = _NUMBER.fullmatch(text) if isinstance(text, str) else None
        if not found:
            raise UnitsError(f"{text!r} is not a quantity; write a number and a unit: '30 uL/min'")
        if not found[2]:
            raise UnitsError(f"'{text}' has no unit; write one behind it, such as '{text} mm/s'")
        if len(text) > LONGEST:
            raise UnitsError(f"'{text[:40]}...' is not a quantity; write one like '30 uL/min'")
        factor, dimension = _parsed(found[2].strip(), text)
        if not any(dimension):
            raise UnitsError(f"'{text}' is a plain number; give it without units, or another unit")
        size = self._size(dimension)
        value = float(found[1]) * factor / size if size else math.inf
        if not math.isfinite(value):
            raise UnitsError(f"'{text:.40}' is no finite number in {self}; give a smaller one")
        return Quantity.of(value, dimension, text, self)

    def several(self, text: str) -> list[Quantity]:
        """Quantities of one unit, as in "100 200 um"."""
        *values, unit = text.split()
        return [self(f"{value} {unit}") for value in values]

    def si(self, value: float, kind: str) -> float:
        """A ``value`` of a ``kind`` ("pressure", "flow_rate", ...) in SI units: m, kg, s."""
        return float(value) * self._size(_kind(kind)[0])

    def show(self, value: float, kind: str) -> str:
        """A ``value`` of a ``kind`` as text of four digits with a unit that suits its size."""
        unit = _kind(kind)[3]
        shown = self.si(value, kind) / _parsed(unit, unit)[0]
        quantity = _registry().Quantity(shown, unit.replace(" ", "*"))
        simple = not set(unit) & set("^/") or unit in ("m/s", "L/min", "N/m")
        made = f"{quantity.to_compact() if simple and shown else quantity:.4g~P}"
        return made.replace("l", "L") if "L" in unit else made  # pint writes litres with an l

    def _size(self, dimension: Dimension) -> float:
        """One unit of a dimension in SI units."""
        length, time, pressure = (_parsed(t, t)[0] for t in (self.length, self.time, self.pressure))
        mass = pressure * length * time**2
        return length ** dimension[0] * mass ** dimension[1] * time ** dimension[2]


def check(what: str, value: Any, *kinds: str) -> None:
    """Refuse, by ``UnitsError``, a quantity (or one in a sequence) of none of the ``kinds``.

    ``what`` is the parameter's name.  Plain numbers pass, text does not.
    """
    if isinstance(value, str):
        raise UnitsError(
            f"{what}: '{value}' is text; make a number of it: u = cb.Units.of(channel), then "
            f"u('{value}')"
        )
    for entry in value if isinstance(value, Sequence) else (value,):
        if isinstance(entry, Quantity) and entry.dimension not in {_kind(k)[0] for k in kinds}:
            wanted = _kind(kinds[0])
            raise UnitsError(
                f"{what}: '{entry.text}' is {_words(entry.dimension)}; give {wanted[1]} such as "
                f"'{wanted[2]}'"
            )


def check_same(length: str, values: Iterable[tuple[str, Any]]) -> None:
    """Refuse, by ``UnitsError``, quantities made with different ``Units``, or with another unit of
    length than a boundary's (which may be ""); ``values`` are pairs with the parameters' names."""
    first: Quantity | None = None
    for what, value in values:
        if not isinstance(value, Quantity):
            continue
        first = value if first is None else first
        if value.units != first.units:
            raise UnitsError(
                f"{what}: '{value.text}' was made with {value.units}, others with {first.units}; "
                "make all with the same"
            )
        own = value.units.length
        if length and abs(_parsed(own, own)[0] / _parsed(length, length)[0] - 1) > MANY:
            raise UnitsError(
                f"{what}: '{value.text}' was made for lengths in {own}, but the boundary is in "
                f"{length}; make it with cb.Units.of(channel)"
            )


@dataclass(frozen=True)
class Numbers:
    """Dimensionless numbers of a flow: the ``capillary`` number Ca = μ U / γ,
    ``viscosity_ratio`` λ of inner over outer viscosity, ``reynolds`` number Re = ρ U L / μ; None
    where something for it is missing."""

    capillary: float | None
    viscosity_ratio: float | None
    reynolds: float | None


def numbers(
    *,
    viscosity: float,
    velocity: float,
    length: float,
    tension: float | None = None,
    viscosity_inside: float | None = None,
    density: float | None = None,
) -> Numbers:
    """Dimensionless numbers of a flow, from quantities or numbers in consistent units.

    Stokes flow is the limit Re → 0: the relative error of cadbem's results is about Re, so that
    they are meaningless unless Re is far below 1.  Raises ``UnitsError`` for quantities of the
    wrong dimension.
    """
    given = locals()
    for name, value in given.items():
        check(name, value, "viscosity" if name == "viscosity_inside" else name)
        if value is not None or name in ("viscosity", "velocity", "length"):
            positive(name, value)
    check_same("", given.items())
    return Numbers(
        None if tension is None else viscosity * velocity / tension,
        None if viscosity_inside is None else viscosity_inside / viscosity,
        None if density is None else density * velocity * length / viscosity,
    )


def _kind(name: str) -> tuple[Dimension, str, str, str]:
    if name not in _KINDS:
        raise UnitsError(f"'{name}' is no kind of quantity; there are {', '.join(_KINDS)}")
    return _KINDS[name]


def _words(dimension: Dimension) -> str:
    """The name of a dimension in words."""
    for kind in _KINDS.values():
        if kind[0] == dimension:
            return kind[1]
    powers = zip(("length", "mass", "time"), dimension, strict=True)
    return " ".join(f"{name}^{power}" for name, power in powers if power) or "a plain number"


@lru_cache(maxsize=1)
def _registry() -> Any:
    """All units that are known; it takes most of a second to load."""
    from pint import UnitRegistry

    return UnitRegistry()


@lru_cache(maxsize=256)
def _parsed(unit: str, text: str) -> tuple[float, Dimension]:
    """A ``unit`` in SI base units, and its dimension; ``text`` is what to name in a message."""
    plain = _POWER.sub(r"**\1", unit if not unit.startswith("/") else "1" + unit)
    try:
        base = _registry().Quantity(1.0, _registry().parse_units(plain)).to_base_units()
    except Exception as error:  # pint's parser raises all sorts of them
        raise UnitsError(
            f"'{text:.60}': the unit '{unit:.60}' is not known; write it like 'mm/s', 'uL/min', "
            "'mPa s'"
        ) from error
    powers = {name.strip("[]"): power for name, power in base.dimensionality.items()}
    dimension = tuple(powers.pop(name, 0) for name in ("length", "mass", "time"))
    if powers or any(power != int(power) for power in dimension):
        raise UnitsError(f"'{text}' is not a mechanical quantity; use units of length, mass, time")
    return float(base.magnitude), (int(dimension[0]), int(dimension[1]), int(dimension[2]))
