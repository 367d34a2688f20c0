"""Messages during long computations: bars with the remaining time, and the times of stages."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from tqdm import tqdm

PATIENCE = 2.0  # seconds after which a bar appears
# whether bars are drawn and notices given
QUIET = ContextVar("QUIET", default=False)
STAGES = logging.getLogger("cadbem")


def progress(items: Iterable[Any] | None = None, label: str = "", **options: Any) -> Any:
    """``items`` one by one, or without them a bar to ``update()``: tqdm's, with its options.

    It appears after two seconds, on a terminal only, and goes away in the end.
    """
    hidden = True if QUIET.get() else None
    return tqdm(items, desc=label, delay=PATIENCE, leave=False, disable=hidden, **options)


def notice(text: str) -> None:
    """A line for the user on stderr that leaves bars whole."""
    if not QUIET.get():
        tqdm.write(text, file=sys.stderr)


def verbose() -> bool:
    """Whether the user wants stages and tracebacks."""
    return STAGES.isEnabledFor(logging.INFO)


@contextmanager
def stage(label: str) -> Iterator[None]:
    """Log the time of a stage of the computation (``cadbem run --verbose``)."""
    wall, cpu = time.perf_counter(), time.process_time()
    yield
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    STAGES.info("%s: %.2f s, %.2f CPU s", label, wall, cpu)
