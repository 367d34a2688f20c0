"""What going on with a folder would execute, and whether that is what was run before."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from cadbem.errors import ResultsError
from cadbem.files import as_results_error


def check_script(folder: Path, file: Path, digest: str, trusted: bool) -> None:
    """Refuse, by ``ResultsError``, to run the script of a folder unless it is ``trusted``, or its
    SHA-256 is the recorded ``digest`` and it belongs to the user and lies outside of the folder."""
    with as_results_error(file):
        content, owner = file.read_bytes(), file.stat().st_uid
    reasons = {
        "has changed since the run began": hashlib.sha256(content).hexdigest() != digest,
        "came with the folder": file.resolve().is_relative_to(folder.resolve()),
        "belongs to another user": hasattr(os, "getuid") and owner not in (os.getuid(), 0),
    }
    doubt = next((text for text, holds in reasons.items() if holds), "")
    if doubt and not trusted:
        raise ResultsError(
            f"{folder}: going on would run {file}, which {doubt}; read it, and say --trust if it "
            "may run"
        )
