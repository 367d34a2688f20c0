"""``cadbem warmup``: what concerns the machine that cadbem runs on."""

from __future__ import annotations

import time

from cadbem.cli.parser import Commands, Options, add_command


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


def _warmup(options: Options) -> None:
    from cadbem.warmup import warm_up

    start = time.perf_counter()
    folder = warm_up()
    kept = "nothing could be kept: no folder can be written to"
    if folder is not None:
        kept = f"the compiled code is kept in {folder}"
    print(f"{time.perf_counter() - start:.0f} s; {kept}")
