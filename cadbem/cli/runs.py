"""``cadbem run``, ``resume``, ``render`` and ``sweep``: scripts, and the folders of their runs."""

from __future__ import annotations

import argparse
import os
import runpy
import sys
from pathlib import Path
from threading import Thread
from typing import Any

from cadbem.cli.parser import (
    Commands,
    Options,
    Parser,
    UsageError,
    add_command,
    counting,
    leave_rest,
)
from cadbem.command import INTERRUPTED, MEND


def add_run(commands: Commands) -> None:
    """``cadbem run``."""
    parser = add_command(
        commands,
        _run,
        "run",
        "run a workflow: a Python script that uses cadbem",
        "Like 'python SCRIPT', but a mistake in the input ends in one line instead of a\n"
        "traceback.  Whatever follows SCRIPT is for the script; those in workflows/ take\n"
        "-o FOLDER, where results go, and explain themselves: cadbem run SCRIPT --help.\n\n"
        "example: cadbem run workflows/y_junction_flow.py -o results/first",
    )
    _add_cores(parser)
    parser.add_argument("script", metavar="SCRIPT", help="a Python file")
    parser.add_argument("--tied", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument(
        "arguments", metavar="...", nargs=argparse.REMAINDER, help="arguments of the script"
    )


def add_resume(commands: Commands) -> None:
    """``cadbem resume``."""
    parser = add_command(
        commands,
        _resume,
        "resume",
        "go on with a run or a sweep that was interrupted",
        "Runs the folder's script again with the same arguments; what it had stored is kept and\n"
        "gone on with from the last step.  Other arguments may follow, such as a later --end.\n"
        "What is finished is not computed again.\n\n"
        "example: cadbem resume results/first",
    )
    _add_cores(parser)
    parser.add_argument("folder", metavar="FOLDER", help="where the results are")
    parser.add_argument(
        "--trust",
        action="store_true",
        help="run the script even if it has changed, or came with the folder",
    )
    parser.add_argument(
        "--mend",
        action="store_true",
        help="where files are damaged, go on from the newest sound state before them",
    )
    _add_engine(parser)
    leave_rest(parser)


def add_render(commands: Commands) -> None:
    """``cadbem render``."""
    parser = add_command(
        commands,
        _render,
        "render",
        "draw movie, film strip, paths and time series of a stored simulation",
        "The run need not have ended.  Pictures go to FOLDER/pictures and replace what was drawn\n"
        "there; for ParaView there is FOLDER/paraview/bodies.pvd.\n\n"
        "example: cadbem render results/first --colour 'mean curvature'",
    )
    parser.add_argument("folder", metavar="FOLDER", help="where the results are")
    parser.add_argument(
        "--colour",
        metavar="FIELD",
        default="",
        help="what colours show: 'mean curvature', 'velocity', 'traction jump' (default: the body)",
    )


def add_sweep(commands: Commands) -> None:
    """``cadbem sweep``."""
    parser = add_command(
        commands,
        _sweep,
        "sweep",
        "run a workflow for many values of its parameters",
        "Values are first:last:count, first:last:count:log, or a list 1,2,5; several options make\n"
        "all combinations; other options are passed on.  Each point is a run in a folder of its\n"
        "own; table.csv and sweep.png collect what they found.  All cores are used, each by one\n"
        "run.  An interrupted sweep goes on with 'cadbem resume FOLDER'.\n\n"
        "example: cadbem sweep workflows/droplet_shear.py --capillary 0.05:0.4:8 --parts shape",
    )
    parser.add_argument("-o", "--output", metavar="FOLDER", help="default: results/NAME_sweep")
    _add_engine(parser)
    parser.add_argument("script", metavar="SCRIPT", help="a Python file that ends in cb.run(main)")
    leave_rest(parser)


def _add_cores(parser: Parser) -> None:
    parser.add_argument(
        "--cores",
        type=counting,
        metavar="N",
        help="cores to use (default: all that there are, or those that a run began with)",
    )
    parser.set_defaults(threads=None)


def _add_engine(parser: Parser) -> None:
    """Where the runs of a sweep take place."""
    parser.add_argument(
        "-j",
        "--jobs",
        type=counting,
        metavar="N",
        help="runs of a sweep at a time (default: one a core)",
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="of a dask scheduler, such as tcp://host:8786, whose workers see the same files",
    )


def _run(options: Options) -> None:
    script = _script(options)
    if options.cores:
        from cadbem.operators.parallel import use_cores

        use_cores(options.cores, options.threads or options.cores)
    if options.tied:
        Thread(target=_end_with_parent, daemon=True).start()
    sys.argv = [str(script), *options.arguments]
    sys.path.insert(0, str(script.resolve().parent))
    runpy.run_path(str(script), run_name="__main__")


def _script(options: Options) -> Path:
    script = Path(options.script)
    if not os.path.isfile(script):
        raise UsageError(f"{str(script):.200}: there is no such script")
    return script


def _end_with_parent() -> None:
    """End when the process that began this one, a sweep, has ended and its pipe is closed."""
    while os.read(0, 1):
        pass
    os._exit(INTERRUPTED)


def _resume(options: Options) -> Any:
    folder = Path(options.folder).resolve()
    if (folder / "sweep.json").exists():
        return _resume_sweep(folder, options)
    from cadbem.results.folder import read_manifest
    from cadbem.results.trust import check_script

    manifest = read_manifest(folder)
    script = Path(manifest["script"]["file"]) if manifest["script"] else None
    if script is None or not os.path.isfile(script):
        raise UsageError(
            f"{folder}: its script, {str(script or 'unknown'):.200}, is not there; run its copy "
            f"with the same arguments: cadbem run {folder / 'script.py'} -o {folder} --resume ..."
        )
    check_script(folder, script, manifest["script"]["sha256"], options.trust)
    if "resume" not in manifest["arguments"]:
        raise UsageError(
            f"{script} cannot go on with a run: its main takes no 'resume'; run it again"
        )
    if os.path.isdir(manifest["working_folder"]):
        os.chdir(manifest["working_folder"])  # where relative paths among the arguments begin
    given = manifest["arguments"] | {"output": str(folder)}
    words = [word for name, value in given.items() for word in _option(name, value)]
    options.script, options.tied = str(script), False
    if options.cores is None:  # the last digits depend on them
        options.cores = max(1, manifest["cores"])
        options.threads = max(1, manifest["threads"])
    options.arguments = [*words, *options.arguments, "--resume"]
    MEND.set(options.mend)
    return _run(options)


def _resume_sweep(folder: Path, options: Options) -> int:
    if options.arguments:
        raise UsageError(
            f"{folder} is a sweep, which goes on with the options it was begun with; leave away "
            f"{' '.join(options.arguments)}"
        )
    from cadbem.sweep import resume_sweep

    return resume_sweep(folder, options.jobs, options.cluster, options.trust)


def _option(name: str, value: Any) -> list[str]:
    """An argument of a workflow's main as words of a command line."""
    option = f"--{name.replace('_', '-')}"
    if name == "resume":
        return []
    if isinstance(value, bool):
        return [option if value else f"--no{option[1:]}"]
    return [f"{option}={value}"]


def _render(options: Options) -> None:
    from cadbem.results.render import render

    for picture in render(options.folder, options.colour):
        print(picture)


def _sweep(options: Options) -> int:
    from cadbem.sweep import begin_sweep

    script = _script(options)
    output = options.output or f"results/{script.stem}_sweep"
    return begin_sweep(script, options.arguments, output, options.jobs, options.cluster)
