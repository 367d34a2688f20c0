"""Over two hundred damaged files: each is refused in one line, or read as what it was.

The undamaged files are four of `geometries/`, and a quarter of a ring of radii 1, 2 and height 1,
written here: its area is 2 × 3π/4 + π/2 + π + 2 = 3π + 2, its volume 3π/4.
`damage.py` spoils them, seeded by the case's name.

A damaged file may pass only if area and volume are right to 1e-6, or with a CadWarning. This may be
asked because in these files every number that shapes the solid is written twice or more: a corner
of a box lies on three edges and three planes, each with numbers of its own; a radius stands in the
surface and in the circles that end it. A digit changed in one place contradicts the others, the
edge leaves its face or its vertex, and that shows (`fit.py`). What does not contradict does not
matter: where on a line its origin is, how a plane is turned in itself, how long a direction is. A
number of a spline surface that no edge shares, such as a control point within, cannot be known
to be wrong, the result is another sound solid; the spline surfaces in these files are extruded from
their edges, so that they have no such number. Nor can a name or a unit that is another one.
"""

import os
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import pi
from pathlib import Path
from random import Random
from time import monotonic, sleep

import damage as d
import gmsh
import pytest

from cadbem.cad import read_cad
from cadbem.errors import CadError

GEOMETRIES = Path(__file__).resolve().parents[1] / "geometries"
LIMIT = 20.0
CHANNELS = ("square_channel.step", "square_channel.igs")
CURVED = ("ring.step", "ring.igs", "constriction.step", "constriction.igs")
ALL = (*CHANNELS, *CURVED)
STEP = tuple(name for name in ALL if name.endswith(".step"))
SIZES = {"square_channel": (10.0, 2.0), "ring": (3 * pi + 2, 0.75 * pi)}  # area, volume
PLAN = [  # damage, files, how often
    (d.truncated, ALL, 7),
    (d.truncated_with_end, ALL, 2),
    (d.byte_flipped, ALL, 3),
    (d.digit_changed, ALL, 3),
    (d.sign_changed, ALL, 1),
    (d.lines_shuffled, ALL, 1),
    (d.line_deleted, ALL, 2),
    (d.line_doubled, ALL, 2),
    (d.lines_swapped, ALL, 1),
    (d.references_exchanged, ALL, 2),
    (d.reference_redirected, ALL, 2),
    (d.flag_turned, STEP, 2),
    (d.section_removed, ALL, 1),
    (d.header_removed, ALL, 1),
    (d.nested, CHANNELS, 1),
    (d.null_bytes, ALL, 1),
    (d.not_ascii, ALL, 1),
    (d.utf_16, CHANNELS, 1),
    (d.crlf, CHANNELS, 1),
    (d.marked, CHANNELS, 1),
    (d.tail_of_nulls, CHANNELS, 1),
    *[(d.number_replaced(word), ALL, 1) for word in (b"NaN", b"Inf", b"1.E308")],
    *[(d.number_replaced(word), CHANNELS, 1) for word in (b"1.E99", b"1.E15", b"0.", b"-1.E-300")],
    *[(d.count_made(word), CURVED, 1) for word in (b"-1", b"0", b"99999999")],
]
HARMLESS = (d.crlf, d.marked, d.tail_of_nulls)


@dataclass(frozen=True)
class Case:
    file: str
    damage: d.Damage
    number: int

    @property
    def name(self) -> str:
        return f"{self.damage.__name__.replace('.', '_')}-{self.number}-{self.file}"


@dataclass(frozen=True)
class Outcome:
    case: Case
    sizes: tuple[float, float] | None  # area and volume, None if refused
    error: BaseException | None
    seconds: float


CASES = [Case(f, damage, n) for damage, files, count in PLAN for f in files for n in range(count)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Undamaged files in a folder, and all temporary files in another, "temporary"."""
    folder = tmp_path_factory.mktemp("damaged")
    (folder / "temporary").mkdir()
    for name in (*CHANNELS, "constriction.step", "constriction.igs"):
        (folder / name).write_bytes((GEOMETRIES / name).read_bytes())
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    line = gmsh.model.occ.addLine(*[gmsh.model.occ.addPoint(x, 0, 0) for x in (1, 2)])
    face = gmsh.model.occ.revolve([(1, line)], 0, 0, 0, 0, 0, 1, pi / 2)[1]
    gmsh.model.occ.extrude([face], 0, 0, 1)
    gmsh.model.occ.remove([face])
    gmsh.model.occ.synchronize()
    for suffix in ("step", "igs"):
        gmsh.write(str(folder / f"ring.{suffix}"))
    gmsh.finalize()
    tempfile.tempdir = str(folder / "temporary")
    yield folder
    tempfile.tempdir = None


@pytest.fixture(scope="module")
def outcomes(folder: Path) -> tuple[list[Outcome], set[str]]:
    """What became of every case, and the names of files that were warned about."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda case: _outcome(folder, case), CASES))
    return found, {str(warning.message).split(":")[0] for warning in caught}


def _outcome(folder: Path, case: Case) -> Outcome:
    sound = (folder / case.file).read_bytes()
    kind = case.file.rpartition(".")[2]
    (folder / case.name).write_bytes(case.damage(sound, kind, Random(case.name)))
    start = monotonic()
    try:
        sizes, error = _sizes(folder / case.name), None
    except BaseException as raised:
        sizes, error = None, raised
    return Outcome(case, sizes, error, monotonic() - start)


def _sizes(path: Path) -> tuple[float, float]:
    boundary = read_cad(path, time_limit=LIMIT)
    return boundary.area(), boundary.volume()


def test_there_are_over_two_hundred_cases():
    assert len({case.name for case in CASES}) == len(CASES) > 200


def test_damaged_files_raise_nothing_but_cad_errors_in_one_line(outcomes):
    wrong = [
        (o.case.name, repr(o.error))
        for o in outcomes[0]
        if o.error is not None and (not isinstance(o.error, CadError) or not _is_plain(o))
    ]
    assert wrong == []


def _is_plain(outcome: Outcome) -> bool:
    message = str(outcome.error)
    return outcome.case.name in message and "\n" not in message and len(message) < 500


def test_no_damaged_file_gives_another_shape_in_silence(folder: Path, outcomes):
    """Area and volume in closed form; those of the constriction from the undamaged file."""
    found, warned = outcomes
    expected = SIZES | {"constriction": _sizes(folder / "constriction.step")}
    wrong = [
        (o.case.name, o.sizes)
        for o in found
        if o.sizes and o.case.name not in warned
        and o.sizes != pytest.approx(expected[o.case.file.rpartition(".")[0]], rel=1e-6)
    ]  # fmt: skip
    assert wrong == []


def test_what_is_no_damage_is_read(outcomes):
    """Ends of lines, a byte-order mark, zeros after the end."""
    harmless = [o for o in outcomes[0] if o.case.damage in HARMLESS]
    assert len(harmless) == 6
    assert [o.case.name for o in harmless if o.sizes is None] == []


def test_damaged_files_take_no_longer_than_the_limit(outcomes):
    assert max(o.seconds for o in outcomes[0]) < LIMIT + 10


def test_nothing_is_left_behind(folder: Path, outcomes):
    """No temporary folder, nothing beside the files, no child, dead or alive."""
    assert list((folder / "temporary").iterdir()) == []
    names = {"temporary", *ALL, *(case.name for case in CASES)}
    assert {path.name for path in folder.iterdir()} == names
    assert _children() == []


def _children() -> list[str]:
    tasks = Path("/proc/self/task")  # Linux; elsewhere there is nothing to look at
    lists = [path.read_text().split() for path in tasks.glob("*/children")]
    commands = [Path(f"/proc/{pid}/cmdline") for pids in lists for pid in pids]
    found = [path.read_text() if path.exists() else "" for path in commands]
    return [command for command in found if command == "" or "_child.py" in command]


SLEEPER = """#!/bin/sh
echo $$ > {pid}.new
mv {pid}.new {pid}
exec sleep 100
"""


def sleeping_kernel(folder: Path) -> tuple[Path, Path]:
    """A program to be run instead of Python that never ends, and the file that will hold its id."""
    program, pid = folder / "sleeper", folder / "pid"
    program.write_text(SLEEPER.format(pid=pid))
    program.chmod(0o700)
    return program, pid


def is_gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_the_kernel_is_killed_when_its_time_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    program, pid = sleeping_kernel(tmp_path)
    monkeypatch.setattr(sys, "executable", str(program))
    with pytest.raises(CadError, match="not done after 2 s"):
        read_cad(GEOMETRIES / CHANNELS[0], time_limit=2.0)
    assert is_gone(int(pid.read_text()))


def test_an_interruption_ends_the_kernel_too(tmp_path: Path):
    """Ctrl-C while the kernel works: neither the child nor its folder outlives the program."""
    program, pid = sleeping_kernel(tmp_path)
    (tmp_path / "temporary").mkdir()
    script = (
        "import signal, sys, tempfile\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"tempfile.tempdir = {str(tmp_path / 'temporary')!r}\n"
        "from cadbem import read_cad\n"
        f"sys.executable = {str(program)!r}\n"
        f"read_cad({str(GEOMETRIES / CHANNELS[0])!r})\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.PIPE) as process:
        end = monotonic() + 30
        while not pid.exists() and monotonic() < end:
            sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30)
    assert b"KeyboardInterrupt" in errors
    assert process.returncode != 0
    assert is_gone(int(pid.read_text()))
    assert list((tmp_path / "temporary").iterdir()) == []
