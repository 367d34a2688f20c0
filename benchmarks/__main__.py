"""Runs the benchmarks and keeps their tables in docs/benchmarks.md.

    python -m benchmarks                     all of them
    python -m benchmarks kernels cad         some; the others' tables stay as they are
    python -m benchmarks --list

Every module with a function `tables` is a benchmark.  Each runs in a process of its own, with one
thread for linear algebra.  One that needs a package which is not installed runs only if named.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import subprocess
import sys
import tempfile
from datetime import date
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
PAGE = FOLDER.parent / "docs" / "benchmarks.md"
HEADER = """# Benchmarks

Written by `python -m benchmarks`; sections of single modules by `python -m benchmarks NAME ...`.
Times are CPU seconds of all threads and are the smallest of several rounds, since other work on a
machine makes them longer and never shorter; what is compared is measured in turn in one process.
Linear algebra has one thread.  Each section says where and when it was measured: sections measured
on different days or machines cannot be compared.
"""


def names() -> list[str]:
    """All benchmarks."""
    files = sorted(FOLDER.glob("*.py"))
    return [file.stem for file in files if "\ndef tables(" in file.read_text()]


def runnable() -> list[str]:
    """All benchmarks whose packages are installed; NEEDS in a module names one."""
    found = []
    for name in names():
        needs = re.search(r'^NEEDS = "(\w+)"', (FOLDER / f"{name}.py").read_text(), re.MULTILINE)
        if needs is None or find_spec(needs[1]):
            found.append(name)
    return found


def machine() -> str:
    """Processor, cores, versions and the day."""
    import scipy.linalg  # noqa: F401  brings its library for linear algebra
    from threadpoolctl import threadpool_info

    blas = {f"{i['internal_api']} {i['version']}" for i in threadpool_info() if "blas" in
            (i["user_api"] or "")}  # fmt: skip
    packages = [f"{name} {version(name)}" for name in ("numba", "numpy", "scipy")]
    software = ", ".join([f"Python {platform.python_version()}", *packages, *sorted(blas)])
    return f"{date.today()}, {processor()}, {os.cpu_count()} cores; {software}."


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    described = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", described.read_text()) if described.exists() else None
    return found[1] if found else platform.processor() or platform.machine()


def measured(name: str) -> str:
    """The tables of one benchmark, from a process of its own; printed while it runs."""
    libraries = ("OPENBLAS", "OMP", "MKL", "VECLIB_MAXIMUM")
    environment = os.environ | {f"{library}_NUM_THREADS": "1" for library in libraries}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "tables.md")  # what libraries print is not wanted
        command = [sys.executable, "-m", "benchmarks.table", name, str(file)]
        if subprocess.run(command, env=environment, cwd=FOLDER.parent).returncode:
            sys.exit(f"benchmark '{name}' failed; the tables of others are kept")
        return file.read_text().strip()


def keep(page: Path, name: str, text: str) -> None:
    """Replace a benchmark's section of the page, or add it."""
    old = page.read_text() if page.exists() else ""
    parts = re.split(r"^## (\w+)\n", old, flags=re.MULTILINE)
    sections = dict(zip(parts[1::2], map(str.strip, parts[2::2]), strict=True))
    sections[name] = f"{machine()}\n\n{text}"
    present = sorted(sections.keys() & set(names()))
    page.write_text("\n".join([HEADER, *(f"## {n}\n\n{sections[n]}\n" for n in present)]))


def main() -> None:
    formatter = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("python -m benchmarks", description=__doc__,
                                     formatter_class=formatter)  # fmt: skip
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--list", action="store_true", help="say which there are")
    options = parser.parse_args()
    if options.list:
        print("\n".join(names()))
        return
    if unknown := set(options.names) - set(names()):
        parser.error(f"there is no benchmark {', '.join(sorted(unknown))}; see --list")
    for name in options.names or runnable():
        print(f"## {name}\n", flush=True)
        keep(PAGE, name, measured(name))


if __name__ == "__main__":
    main()
