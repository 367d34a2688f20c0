"""Makes the table of docs/cad.md: how CAD files become patches.

    python docs/cad_table.py                 the files in geometries/
    python docs/cad_table.py FOLDER ...      also the STEP and IGES files in these folders
"""

import os
import sys
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.cad import CadReport, inspect_cad

HERE = Path(__file__).parent
GEOMETRIES = HERE.parent / "geometries"
ENDINGS = (".step", ".stp", ".igs", ".iges")
LOOSER = 1e-4  # tolerance of a second try
HEAD = (
    "file", "faces", "patches", "deviation", "gap", "area", "volume", "angle",
    "CPU s, or why refused",
)  # fmt: skip


def cpu_seconds() -> float:
    """Of this process and of the CAD kernel's."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def rows_of(path: Path) -> list[tuple[str, ...]]:
    """One row; two if the file asks for a looser tolerance."""
    rows = [row_of(path, {})]
    if "tolerance" in rows[0][-1]:
        rows.append(row_of(path, {"tolerance": LOOSER}))
    return rows


def row_of(path: Path, options: dict[str, float]) -> tuple[str, ...]:
    said = "".join(f", {key} {value:g}" for key, value in options.items())
    name = f"{path.name.replace('__', ': ')}{said}"
    start = cpu_seconds()
    try:
        report = inspect_cad(path, time_limit=120, **options)  # type: ignore[arg-type]
    except cb.CadbemError as error:
        return name, "", "", "", "", "", "", "", f"refused: {reason(path, str(error))}"
    seconds = cpu_seconds() - start
    kinds = Counter(face.kind for face in report.faces)
    faces = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    if report.problems:
        return name, faces, "", "", "", "", "", "", f"refused: {reason(path, report.problems[0])}"
    return name, faces, *measures(report), f"{seconds:.1f}"


def reason(path: Path, problem: str) -> str:
    return problem.removeprefix(f"{path.name}: ")


def measures(report: CadReport) -> tuple[str, ...]:
    size = float(np.ptp(report.bounds, axis=0).max())
    return (
        str(sum(face.patches for face in report.faces)),
        f"{report.deviation / size:.0e}" if report.deviation else "exact",
        f"{report.gap / size:.0e}",
        f"{abs(report.area / report.exact_area - 1):.0e}",
        f"{abs(report.volume / report.exact_volume - 1):.0e}",
        f"{min(face.angle for face in report.faces):.0f}°",
    )


def main(folders: list[str]) -> None:
    warnings.simplefilter("ignore", cb.CadWarning)
    rows = []
    for folder in (GEOMETRIES, *map(Path, folders)):
        for path in sorted(folder.iterdir()):
            if path.suffix.lower() in ENDINGS:
                rows += rows_of(path)
                print(*rows[-1], sep=" | ", flush=True)
    lines = [HEAD, ("---",) * len(HEAD), *rows]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    page = HERE / "cad.md"
    kept, mark, _ = page.read_text().partition("<!-- table -->\n")
    page.write_text(f"{kept}{mark}\n{table}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
