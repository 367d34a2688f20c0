"""Runs that are stored in folders, continued, and read back."""

from cadbem.results.folder import RunFolder, run_folder
from cadbem.results.render import render
from cadbem.results.stored import StoredRun, open_run

__all__ = ["RunFolder", "StoredRun", "open_run", "render", "run_folder"]
