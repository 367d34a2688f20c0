"""Checks against exact and published numbers: ``cadbem verify``.

There is one file for each subject; each has ``checks()``, a tuple of ``Check`` values.
"""

from cadbem.verification.check import Check as Check
from cadbem.verification.check import Result as Result
from cadbem.verification.check import run_checks as run_checks
from cadbem.verification.suite import all_checks as all_checks
