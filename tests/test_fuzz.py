"""Texts and files with random damage: one-line errors only, or a result.

The seed is the day, so that every day looks at other ones; a message names it.  The default run
takes at most a minute; ``-m long`` looks at all 2000 mutations, through the CAD kernel, too.
"""

import json
import shutil
import warnings
from collections.abc import Callable, Iterator
from datetime import date
from pathlib import Path
from random import Random
from time import monotonic

import damage as d
import h5py
import numpy as np
import pytest

import cadbem as cb
from cadbem.cad.body.model import file_unit
from cadbem.cad.text.source import read_source
from cadbem.files import read_json
from cadbem.results.folder import read_manifest
from cadbem.results.hdf5 import BLOCK, Writing
from cadbem.results.progress import CHECKPOINT, SETUP, frame_file
from cadbem.sweep.sweep import resume_sweep

GEOMETRIES = Path(__file__).resolve().parents[1] / "geometries"
SEED = date.today().toordinal()
CAD = [
    GEOMETRIES / f"{name}.{kind}"
    for name in ("square_channel", "constriction", "round_pipe", "t_junction")
    for kind in ("step", "igs")
]
WORDS = (
    b"1.E+299", b"-1.E99", b"1.E-320", b"0.", b"nan", b"1", b"#1", b"#999999", b"$", b"*", b"''",
    b"(", b")", b",", b";", b"/*", b"*/", b"'", b"\\X2\\", b"\x1b[2J", b"\0", b"99999999999", b"-1",
)  # fmt: skip
CAD_DAMAGES: list[d.Damage] = [
    d.byte_flipped, d.digit_changed, d.sign_changed, d.lines_shuffled, d.line_deleted,
    d.line_doubled, d.lines_swapped, d.references_exchanged, d.reference_redirected, d.truncated,
    d.truncated_with_end,
]  # fmt: skip


def spliced(text: bytes, kind: str, random: Random) -> bytes:
    """A word put into any place, or in the place of some bytes."""
    place = random.randrange(len(text))
    return text[:place] + random.choice(WORDS) + text[place + random.choice((0, 1, 8)) :]


def flipped(content: bytes, random: Random) -> bytes:
    """Some bits are others."""
    damaged = bytearray(content)
    for _ in range(random.choice((1, 1, 2, 9))):
        damaged[random.randrange(len(damaged))] ^= 1 << random.randrange(8)
    return bytes(damaged)


def checked(what: str, action: Callable[[], object]) -> bool:
    """Whether it gives a result; an error must be ours, and one line."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            action()
        except cb.CadbemError as error:
            said = str(error)
            assert "\n" not in said and "\x1b" not in said and len(said) < 600, (what, said)
            return False
        except Exception as error:  # what the test is for
            raise AssertionError(f"{what}, seed {SEED}: {error!r}") from error
    return True


def rounds(count: int, seconds: float) -> Iterator[tuple[int, Random]]:
    """A generator of random numbers for each mutation, as long as there is time."""
    end = monotonic() + seconds
    for number in range(count):
        if monotonic() > end:
            return
        yield number, Random(f"{SEED} {number}")


def mutated(folder: Path, number: int, random: Random) -> Path:
    """A CAD file with one to three kinds of damage."""
    sound = random.choice(CAD)
    kind, text = sound.suffix[1:], sound.read_bytes()
    for _ in range(random.choice((1, 1, 2, 3))):
        try:
            text = random.choice([spliced, spliced, *CAD_DAMAGES])(text, kind, random)
        except (ValueError, IndexError, StopIteration):
            break  # nothing is left of what this kind of damage looks for
    path = folder / f"damaged_{number}{sound.suffix}"
    path.write_bytes(text)
    return path


def fuzz_texts(folder: Path, count: int, seconds: float) -> int:
    done = 0
    for number, random in rounds(count, seconds):
        path = mutated(folder, number, random)
        checked(path.name, lambda path=path: file_unit(read_source(path)))
        path.unlink()
        done += 1
    return done


def fuzz_kernel(folder: Path, count: int, seconds: float) -> int:
    done = 0
    for number, random in rounds(count, seconds):
        path = mutated(folder, number, random)
        checked(path.name, lambda path=path: cb.read_cad(path, time_limit=20.0))
        path.unlink()
        done += 1
    return done


VALUES = (None, -1, 1e300, "", "\0", "x" * 5000, [], {}, [[[]]], True, "\x1b[2J", {"file": 3})


def mutated_json(text: str, random: Random) -> bytes:
    """Bits, or a value anywhere in it that is another one."""
    if random.random() < 0.5:
        return flipped(text.encode(), random)
    values = json.loads(text)
    inner = values
    while isinstance(inner, dict | list) and inner:
        key = random.choice(list(inner) if isinstance(inner, dict) else range(len(inner)))
        if random.random() < 0.5 or not isinstance(inner[key], dict | list):
            inner[key] = random.choice(VALUES)
            break
        inner = inner[key]
    return json.dumps(values).encode("utf-8", "surrogatepass")


def fuzz_json(folder: Path, count: int, seconds: float) -> int:
    """Manifests of runs and sweeps, and descriptions of simulations."""
    sweep = {
        "script": str(folder / "nowhere.py"), "sha256": "0", "swept": {"x": ["1", "2"]},
        "others": ["--a=b"], "start": str(folder), "jobs": 1, "cluster": None,
    }  # fmt: skip
    (folder / "sweep.json").write_text(json.dumps(sweep))
    texts = {n: (folder / n).read_text() for n in ("run.json", "simulation.json", "sweep.json")}
    done = 0
    for number, random in rounds(count, seconds):
        name = random.choice(list(texts))
        (folder / name).write_bytes(mutated_json(texts[name], random))
        if name == "run.json":
            checked(f"{name} {number}", lambda: read_manifest(folder))
        elif name == "sweep.json":
            checked(f"{name} {number}", lambda: resume_sweep(folder))
        else:
            checked(f"{name} {number}", lambda: gone_on(folder))
        (folder / name).write_text(texts[name])
        done += 1
    return done


def simulation() -> cb.Simulation:
    drop = cb.Droplet(cb.spline_circle(points=16), cb.SurfaceTension(3.0), 2.0)
    return cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), drop)


def gone_on(folder: Path) -> None:
    _ = read_json(folder / "simulation.json")
    list(cb.run_folder(folder, resume=True).run(simulation(), 0.1, 0.05))


def other_numbers(path: Path, random: Random) -> None:
    """An array or attribute of a sound file left away, or with other numbers, type or shape; with a
    digest that is right."""
    plain = path.with_suffix(".plain")
    plain.write_bytes(path.read_bytes())
    with h5py.File(plain, "r+") as place:
        names: list[str] = []
        place.visit(names.append)
        item = place[random.choice(names)] if names and random.random() < 0.7 else place
        attributes = list(item.attrs)
        numbers = (np.nan, -1, 10**9, "odd", [1.5, 2], np.zeros((0, 3)), "[" * 999, "\x1b[2J")
        if attributes and random.random() < 0.5:
            item.attrs[random.choice(attributes)] = random.choice(numbers)
        elif isinstance(item, h5py.Dataset):
            name = item.name
            old, how = item[()], random.randrange(5)
            del place[name]
            if how == 1:
                place[name] = np.asarray(old).ravel()[:-1]
            elif how == 2:
                place[name] = np.asarray(old) * random.choice((np.nan, 0.0, 1e300))
            elif how == 3:
                place[name] = np.asarray(old).astype("S8")
            elif how == 4:
                place.create_group(name)
    with h5py.File(plain) as old_file, Writing(path) as new:
        for name in old_file:
            old_file.copy(name, new)
        new.attrs.update(old_file.attrs)
    plain.unlink()


def fuzz_hdf5(folder: Path, count: int, seconds: float) -> int:
    """Bits of files, and other contents behind a digest that is right."""
    files = [folder / CHECKPOINT, folder / SETUP, frame_file(folder, 1)]
    sound = {file: file.read_bytes() for file in files}
    done = 0
    for number, random in rounds(count, seconds):
        file = random.choice(files)
        if random.random() < 0.3:
            file.write_bytes(flipped(sound[file], random))
            assert sound[file][:BLOCK]
        else:
            other_numbers(file, random)
        checked(f"{file.name} {number}", lambda: cb.open_run(folder).frames)
        if number % 4 == 0:
            checked(f"{file.name} {number}", lambda: gone_on(folder))
        shutil.rmtree(folder)
        shutil.copytree(folder.with_name("whole"), folder)
        done += 1
    return done


@pytest.fixture
def run(tmp_path: Path) -> Path:
    list(cb.run_folder(tmp_path / "whole").run(simulation(), 0.1, 0.05))
    return Path(shutil.copytree(tmp_path / "whole", tmp_path / "run"))


FAST = [(fuzz_texts, 1200, 20.0), (fuzz_kernel, 200, 15.0), (fuzz_json, 300, 8.0),
        (fuzz_hdf5, 300, 10.0)]  # fmt: skip


@pytest.mark.parametrize(("fuzz", "count", "seconds"), FAST)
def test_random_damage_within_a_minute(fuzz, count: int, seconds: float, run: Path):
    assert fuzz(run, count, seconds) > 0


@pytest.mark.long
@pytest.mark.parametrize(("fuzz", "count"), [(fuzz, count) for fuzz, count, _ in FAST])
def test_two_thousand_mutations(fuzz, count: int, run: Path):
    assert fuzz(run, count, np.inf) == count
