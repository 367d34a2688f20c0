"""Errors that a user can correct: one line each, naming the culprit and the remedy."""


class CadbemError(Exception):
    """Base of every error that cadbem raises for a mistake in its input."""


class CadError(CadbemError):
    """A CAD file cannot be read or does not describe a usable boundary."""


class CadWarning(UserWarning):
    """A CAD file can be read, but something in it is unusual, was assumed or was repaired."""


class SelectionError(CadbemError):
    """Faces were named or chosen ambiguously, twice, or not at all."""


class ConditionError(CadbemError):
    """Boundary conditions are missing, doubled or contradict each other."""


class DisplayError(CadbemError):
    """Pictures cannot be drawn on this machine."""


class ShapeError(CadbemError):
    """A droplet's or particle's shape, or what became of it."""


class SolverError(CadbemError):
    """An iteration did not converge."""


class ResultsError(CadbemError):
    """A run's folder cannot be written, read or gone on with."""


class UnitsError(CadbemError):
    """A quantity is not understood, has another dimension than is asked for, or another unit."""
