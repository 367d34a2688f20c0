"""The command line."""

from cadbem.cli.commands import main

__all__ = ["main"]
