"""One workflow for many values of its parameters."""

from cadbem.sweep.sweep import begin_sweep, resume_sweep

__all__ = ["begin_sweep", "resume_sweep"]
