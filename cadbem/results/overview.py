"""What folders of runs say of themselves when they are printed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cadbem.tables import count


def folder_text(folder: Any) -> str:
    """Where the folder of a run is, and what is in it."""
    if folder.path is None:
        return "Run folder: none, nothing is kept"
    path = Path(folder.path)
    frames = sorted(place.parent for place in path.glob("**/frames/00000.h5"))
    parts = [f"{count(len(list(place.glob('*.h5'))), 'frame')} in {place}" for place in frames[:8]]
    files = sorted(place.name for place in path.glob("*") if place.is_file())[:12]
    return "\n  ".join([f"Run folder {path}", *parts, ", ".join(files) or "empty"])


def stored_text(run: Any) -> str:
    """Where a stored run is, and how far it has come."""
    times = run.times
    reach = f"time {times[0]:g} to {times[-1]:g}" if len(times) else "nothing yet"
    where = "in unbounded fluid"
    if run.channel is not None:
        where = f"in a channel: {run.channel.source or 'no file'}"
    return (
        f"Stored run {run.folder}: {count(len(times), 'frame')}, {reach}\n  {where}\n"
        "  frames, and the columns of run_table and body_table"
    )
