"""The command that this process carries out; the manifest of a run records it."""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

CHECK_FAILED, USER_MISTAKE, INTERRUPTED = 1, 2, 130  # exit codes


@dataclass(frozen=True)
class Command:
    """A ``script`` and the ``arguments`` that its main was called with, by name."""

    script: Path
    arguments: Mapping[str, Any]


# whether a run whose files are damaged goes on from its newest sound state
MEND: ContextVar[bool] = ContextVar("MEND", default=False)
# set by cb.run for as long as main runs
CURRENT: ContextVar[Command | None] = ContextVar("CURRENT", default=None)
