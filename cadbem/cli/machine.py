"""``cadbem warmup`` and ``cadbem verify``: compilation and checks on this machine."""

from __future__ import annotations

import time

from cadbem.cli.parser import Commands, Options, add_command
from cadbem.command import CHECK_FAILED


def add_warmup(commands: Commands) -> None:
    """``cadbem warmup``."""
    add_command(
        commands,
        _warmup,
        "warmup",
        "compile the kernels now rather than in the first run",
        "The compiled code is kept, so that this is needed once after an installation.\n\n"
        "example: cadbem warmup",
    )


def add_verify(commands: Commands) -> None:
    """``cadbem verify``."""
    parser = add_command(
        commands,
        _verify,
        "verify",
        "compute what is known exactly, and compare",
        "Tables and figures of the thesis as far as they are numbers, and more: a minute or two.\n"
        "Prints each number, its true value, the thesis's, the error and what is allowed; the\n"
        "exit code is 1 if any check fails.\n\n"
        "example: cadbem verify",
    )
    parser.add_argument("--full", action="store_true", help="the long checks as well, some minutes")


def _warmup(options: Options) -> None:
    from cadbem.warmup import warm_up

    start = time.perf_counter()
    folder = warm_up()
    kept = "nothing could be kept: no folder can be written to"
    if folder is not None:
        kept = f"the compiled code is kept in {folder}"
    print(f"{time.perf_counter() - start:.0f} s; {kept}")


def _verify(options: Options) -> int:
    from cadbem.tables import text_table
    from cadbem.verification import all_checks, run_checks
    from cadbem.verification.report import HEAD, rows, summary

    results = list(run_checks(all_checks(options.full)))
    print(text_table(HEAD, rows(results)))
    print(summary(results))
    return 0 if all(result.passed for result in results) else CHECK_FAILED
