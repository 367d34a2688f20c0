"""Results as rows of text."""

from __future__ import annotations

from collections.abc import Sequence

from cadbem.verification.check import Result

HEAD = ("thesis", "check", "computed", "reference", "thesis's", "error", "allowed", "")


def rows(results: Sequence[Result]) -> list[tuple[str, ...]]:
    """One row a result, under ``HEAD``."""
    return [
        (r.check.place, r.check.what, number(r.computed), number(r.check.reference),
         number(r.check.printed), f"{r.error:.1e}", f"{r.check.tolerance:.0e}",
         "pass" if r.passed else f"FAIL {r.trouble}".rstrip())
        for r in results
    ]  # fmt: skip


def number(value: float | None) -> str:
    """Nine digits; nothing where there is no number."""
    return "" if value is None else f"{value:.9g}"


def summary(results: Sequence[Result]) -> str:
    """The number of checks that passed, in one line."""
    failed = sum(not r.passed for r in results)
    return f"{len(results)} checks, {failed} failed" if failed else f"{len(results)} checks passed"
