"""A check: a number with its reference and tolerance, and its result."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import isfinite, nan

from cadbem.errors import CadbemError
from cadbem.progress import progress


@dataclass(frozen=True)
class Check:
    """``what`` is computed, in one line, and its ``place`` in the thesis, such as "Table 2.1".

    ``compute`` gives the number; the ``reference`` is the true value, from a ``source``;
    ``tolerance`` is the error allowed, relative to the reference, or absolute where that is 0.
    ``printed`` is the thesis's own value, which is shown but decides nothing; ``long`` checks take
    minutes.
    """

    place: str
    what: str
    compute: Callable[[], float]
    reference: float
    tolerance: float
    source: str
    printed: float | None = None
    long: bool = False

    def error(self, computed: float) -> float:
        """Relative error, absolute where the reference is 0."""
        return abs(computed - self.reference) / (abs(self.reference) or 1.0)

    def run(self) -> Result:
        """Compute the number; what the library refuses to do counts as failed."""
        try:
            return Result(self, float(self.compute()))
        except CadbemError as error:
            return Result(self, nan, " ".join(str(error).split()))


@dataclass(frozen=True)
class Result:
    """The result of a ``check``; ``trouble`` says why there is no number, if there is none."""

    check: Check
    computed: float
    trouble: str = ""

    @property
    def error(self) -> float:
        """Relative error, absolute where the reference is 0; not a number where there is none."""
        return self.check.error(self.computed)

    @property
    def passed(self) -> bool:
        """Whether the error is at most what is allowed."""
        return isfinite(self.error) and self.error <= self.check.tolerance


def run_checks(checks: Iterable[Check]) -> Iterator[Result]:
    """Run one check after the other, with a progress bar."""
    bar = progress(list(checks), "checks")
    for check in bar:
        bar.set_postfix_str(f"{check.place}: {check.what}"[:50])
        yield check.run()
