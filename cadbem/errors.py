"""Errors that a user can correct: one line each, which names the cause and the remedy."""

from unicodedata import category

INVISIBLE = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")  # controls, and what no font has


def printable(text: str) -> str:
    """Text of others, such as a name in a file, that does nothing to a terminal: every blank is a
    space, every other character that cannot be seen a question mark in a box."""
    if text.isascii() and text.isprintable():
        return text
    shown = (" " if c.isspace() else "\ufffd" if category(c) in INVISIBLE else c for c in text)
    return "".join(shown)


class CadbemError(Exception):
    """Base of every error that cadbem raises for a mistake in its input."""

    def __str__(self) -> str:
        return printable(super().__str__())


class InputError(CadbemError, ValueError):
    """A parameter has a value that it cannot have."""


class CadError(CadbemError):
    """A CAD file cannot be read or does not describe a usable boundary."""


class CadWarning(UserWarning):
    """A CAD file can be read, but something in it is unusual, was assumed or was repaired."""

    def __str__(self) -> str:
        return printable(super().__str__())


class AccuracyWarning(UserWarning):
    """A result may be further off than was asked for, or than is sensible."""


class SelectionError(CadbemError):
    """Faces were named or chosen ambiguously, twice, or not at all."""


class ConditionError(CadbemError):
    """Boundary conditions are missing, doubled or contradict each other."""


class DisplayError(CadbemError):
    """Pictures cannot be drawn on this machine."""


class ShapeError(CadbemError):
    """The shape of a droplet or particle is not valid, or has become so during a run."""


class SolverError(CadbemError):
    """An iteration did not converge."""


class ResultsError(CadbemError):
    """The folder of a run cannot be written or read, or the run in it cannot be continued."""


class UnitsError(CadbemError):
    """A quantity cannot be read, or has another dimension or unit than is required."""
