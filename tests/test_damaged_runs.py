"""Runs whose files are damaged, missing, crafted or not one's own."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

import cadbem as cb
from cadbem.cli import main
from cadbem.command import MEND
from cadbem.results.hdf5 import BLOCK, Writing, is_sound, reading
from cadbem.results.progress import BEFORE, CHECKPOINT, SETUP, frame_file

END, EVERY = 0.3, 0.05


def simulation() -> cb.Simulation:
    droplet = cb.Droplet(cb.spline_circle(points=24), cb.SurfaceTension(3.0), 2.0)
    return cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), droplet)


def gone_through(folder: Path, end: float = END, resume: bool = False) -> list[cb.State]:
    return list(cb.run_folder(folder, resume=resume).run(simulation(), end, EVERY))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that was not interrupted, nor touched."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    gone_through(folder)
    return folder


@pytest.fixture
def run(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "run"))


@pytest.fixture
def mending() -> Iterator[None]:
    token = MEND.set(True)
    yield
    MEND.reset(token)


def flipped(file: Path, place: int = -100) -> None:
    """One bit of a file is another."""
    content = bytearray(file.read_bytes())
    content[place] ^= 4
    file.write_bytes(content)


def cut_off(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


DAMAGES: list[Callable[[Path], None]] = [flipped, cut_off, Path.unlink]


def snapshot(folder: Path) -> dict[str, bytes]:
    """All files but the log and the lock, whose content or time is that of the attempt."""
    files = [f for f in folder.rglob("*") if f.is_file() and f.name not in ("log.txt", ".lock")]
    return {str(f.relative_to(folder)): f.read_bytes() for f in files}


def numbers(folder: Path) -> list[np.ndarray]:
    return [frame.shapes[1].coefficients for frame in cb.open_run(folder).frames]


def test_any_flipped_bit_is_found(run: Path):
    """In the digest, in its block, in HDF5's own data and in numbers."""
    file = run / CHECKPOINT
    content = file.read_bytes()
    for place in (0, 20, BLOCK - 1, BLOCK, BLOCK + 1, len(content) // 2, len(content) - 1):
        flipped(file, place)
        assert not is_sound(file), place
        file.write_bytes(content)
    assert is_sound(file)


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_checkpoint_is_replaced_by_the_one_before(run: Path, whole: Path, damage, capsys):
    """The run goes on to the same bits, and says so where a file is damaged."""
    damage(run / CHECKPOINT)
    assert 0 < len(cb.open_run(run).times) < len(cb.open_run(whole).times)
    gone_through(run, resume=True)
    assert is_sound(run / CHECKPOINT)
    for found, expected in zip(numbers(run), numbers(whole), strict=True):
        np.testing.assert_array_equal(found, expected)
    if damage is not Path.unlink:
        assert "checkpoint.h5 is damaged; goes on from" in capsys.readouterr().err
        assert "checkpoint.h5 is damaged" in (run / "log.txt").read_text()


@pytest.mark.parametrize("damage", DAMAGES)
def test_without_a_checkpoint_nothing_begins_anew_unasked(run: Path, damage):
    damage(run / CHECKPOINT)
    damage(run / BEFORE)
    before = snapshot(run)
    with pytest.raises(cb.ResultsError, match=r"checkpoint\.h5 is missing or damaged.*--mend"):
        gone_through(run, resume=True)
    assert snapshot(run) == before


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_run_is_mended_from_its_frames(run: Path, whole: Path, damage, mending):
    """A later end, to which an unbroken run comes with the same shape, within the error of steps;
    the frames before are the same to the last bit."""
    damage(run / CHECKPOINT)
    damage(run / BEFORE)
    damage(frame_file(run, 4))
    states = gone_through(run, resume=True)
    assert [s.time for s in states] == pytest.approx(cb.open_run(whole).times)
    found, expected = numbers(run), numbers(whole)
    for k in range(4):
        np.testing.assert_array_equal(found[k], expected[k])
    for k in range(4, 7):
        np.testing.assert_allclose(found[k], expected[k], atol=2e-3)
    table, usual = cb.open_run(run).run_table, cb.open_run(whole).run_table
    assert table["time"].tolist() == usual["time"].tolist()
    assert (np.diff(table["cpu_seconds"]) >= 0).all()


def test_checkpoints_after_damage_are_forgotten(run: Path, mending):
    """Those that are sound, too: they tell of frames that are to be computed again."""
    flipped(frame_file(run, 3))
    states = cb.run_folder(run, resume=True).run(simulation(), END, EVERY)
    assert next(states).time == 0.0
    states.close()
    assert not (run / BEFORE).exists()
    assert cb.open_run(run).times.tolist() == pytest.approx([0.0, EVERY, 2 * EVERY])


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_frame_is_named(run: Path, damage):
    damage(frame_file(run, 2))
    before = snapshot(run)
    with pytest.raises(cb.ResultsError, match=r"00002\.h5 is missing or damaged.*from frame 1"):
        gone_through(run, resume=True)
    with pytest.raises(cb.ResultsError, match=r"00002\.h5 is (missing|damaged)"):
        cb.open_run(run).frame(2)
    assert snapshot(run) == before
    assert cb.open_run(run).frame(1).time == EVERY


def test_all_frames_are_damaged(run: Path, whole: Path, mending):
    """Mended, it is the run from its beginning."""
    flipped(frame_file(run, 0))
    gone_through(run, resume=True)
    for found, expected in zip(numbers(run), numbers(whole), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("damage", DAMAGES)
def test_shapes_of_the_beginning_are_written_again(run: Path, whole: Path, damage):
    damage(run / SETUP)
    with pytest.raises(cb.ResultsError, match=r"setup\.h5 is (missing|damaged)"):
        cb.open_run(run).frame(0)
    gone_through(run, resume=True)
    assert (run / SETUP).read_bytes() == (whole / SETUP).read_bytes()


@pytest.mark.parametrize("table", ["run.csv", "bodies.csv"])
def test_a_damaged_table_is_named(run: Path, table: str, capsys):
    flipped(run / table)
    with pytest.raises(cb.ResultsError, match=f"{table} is damaged"):
        _ = (cb.open_run(run).run_table, cb.open_run(run).body_table)
    gone_through(run, end=END + EVERY, resume=True)
    assert f"{table} is damaged" in capsys.readouterr().err


def test_a_killed_beginning_is_no_damage(run: Path):
    """The first frame is written before the first checkpoint."""
    for file in [run / CHECKPOINT, run / BEFORE, *(frame_file(run, k) for k in range(1, 7))]:
        file.unlink()
    gone_through(run, resume=True)
    assert len(cb.open_run(run).times) == 7


def test_what_a_kill_leaves_is_cleaned_up(run: Path):
    """The script's copy comes back."""
    left = [run / ".script.py.new", run / "frames" / ".00003.h5.new", run / ".checkpoint.h5.new"]
    for file in left:
        file.write_bytes(b"half")
    (run / "script.py").unlink()
    gone_through(run, resume=True)
    assert not any(file.exists() for file in left)
    assert (run / "script.py").read_bytes() == Path(__file__).read_bytes()


# Refused requests


@pytest.mark.parametrize(
    ("request_", "error"),
    [
        (lambda folder: folder.run(simulation(), 0.05, EVERY), cb.ResultsError),  # an early end
        (lambda folder: folder.run(simulation(), np.nan, EVERY), cb.InputError),
        (lambda folder: folder.run(simulation(), END, 0.01), cb.ResultsError),
    ],
)
def test_a_refused_request_changes_nothing(run: Path, request_, error):
    before = snapshot(run)
    log = (run / "log.txt").read_text()
    with pytest.raises(error):
        list(request_(cb.run_folder(run, resume=True)))
    assert snapshot(run) == before
    assert (run / "log.txt").read_text() == log
    gone_through(run, resume=True)


def test_a_pause_is_kept_once(run: Path):
    """Of a script with several simulations, too; the summary is no pause."""
    asked = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(json.dumps(asked | {"began": "2020-02-02T02:02:02+00:00"}))
    folder = cb.run_folder(run, resume=True)
    list(folder.run(simulation(), END, EVERY))
    list(folder.run(simulation(), EVERY, EVERY, part="again"))
    folder.summary({"D": 1.0})
    asked = json.loads((run / "run.json").read_text())
    assert len(asked["pauses"]) == 1
    assert asked["began"] == "2020-02-02T02:02:02+00:00"
    assert (run / "log.txt").read_text().count("resumed") == 1


def test_nothing_is_written_while_another_process_writes(run: Path):
    states = cb.run_folder(run, resume=True).run(simulation(), END + EVERY, EVERY)
    next(states)
    before = snapshot(run)
    with pytest.raises(cb.ResultsError, match="another process is writing"):
        gone_through(run, resume=True)
    assert snapshot(run) == before
    states.close()


# Crafted files


def crafted(file: Path, change: Callable[[h5py.File], None]) -> None:
    """The file with a change, and a digest that is right."""
    plain = file.with_suffix(".plain")
    plain.write_bytes(file.read_bytes())
    with h5py.File(plain, "r+") as place:
        change(place)
    with h5py.File(plain) as old, Writing(file) as new:
        for name in old:
            if isinstance(old.get(name, getlink=True), h5py.HardLink):
                old.copy(name, new, expand_external=False)
            else:
                new[name] = old.get(name, getlink=True)
        new.attrs.update(old.attrs)
    plain.unlink()


def external_link(place: h5py.File) -> None:
    del place["times"]
    place["times"] = h5py.ExternalLink("/etc/hostname", "/times")


def soft_link(place: h5py.File) -> None:
    del place["times"]
    place["times"] = h5py.SoftLink("/slope")


def external_storage(place: h5py.File) -> None:
    del place["times"]
    place.create_dataset("times", (4,), "f8", external=[("/etc/passwd", 0, 32)])


def without_storage(place: h5py.File) -> None:
    """75 GiB in a file of some kilobytes."""
    del place["times"]
    place.create_dataset("times", (10**10,), "f8")


def compressed(place: h5py.File) -> None:
    del place["times"]
    place.create_dataset("times", (10**6,), "f8", data=np.zeros(10**6), compression="gzip")


def words(place: h5py.File) -> None:
    del place["times"]
    place["times"] = np.array([b"one", b"two"])


def not_finite(place: h5py.File) -> None:
    place["times"][0] = np.nan


def no_times(place: h5py.File) -> None:
    del place["times"]


def group(place: h5py.File) -> None:
    del place["times"]
    place.create_group("times")


def odd_columns(place: h5py.File) -> None:
    place.attrs["columns"] = "[" * 3000


def no_sizes(place: h5py.File) -> None:
    place.attrs["sizes"] = "many"


CRAFTS = [
    external_link, soft_link, external_storage, without_storage, compressed, words, not_finite,
    no_times, group, odd_columns, no_sizes,
]  # fmt: skip


@pytest.mark.parametrize("craft", CRAFTS)
def test_only_plain_numbers_are_read(run: Path, craft):
    crafted(run / CHECKPOINT, craft)
    with pytest.raises(
        cb.ResultsError, match=r"checkpoint\.h5 is not what a run writes"
    ) as refused:
        cb.open_run(run)
    assert "\n" not in str(refused.value)
    with pytest.raises(cb.ResultsError, match=r"checkpoint\.h5 is not what a run writes"):
        gone_through(run, resume=True)


def test_a_frame_of_something_else(run: Path):
    """Every data set and attribute of a frame left away, or another one."""
    file = frame_file(run, 1)
    sound = file.read_bytes()
    with h5py.File(file) as place:
        names: list[str] = []
        place.visit(names.append)
        attributes = list(place.attrs)
    for name in names:

        def without(place: h5py.File, name: str = name) -> None:
            del place[name]

        crafted(file, without)
        _opened(run)
        file.write_bytes(sound)
    for name in attributes:
        for value in ("odd", [1, 2, 3], -1, np.nan):

            def other(place: h5py.File, name: str = name, value: object = value) -> None:
                place.attrs[name] = value

            crafted(file, other)
            _opened(run)
            file.write_bytes(sound)


def _opened(run: Path) -> None:
    """Read, or refused in one line."""
    try:
        _ = cb.open_run(run).frames
    except cb.ResultsError as error:
        assert "\n" not in str(error)


def test_plain_files_are_read_by_others(run: Path):
    """The digest does not disturb HDF5."""
    with h5py.File(run / CHECKPOINT) as place, reading(run / CHECKPOINT) as ours:
        np.testing.assert_array_equal(place["slope"][:], ours["slope"][:])


# Odd manifests, and whose script is run

SCRIPT = """import cadbem as cb

def main(output: str = "run", points: int = 24, end: float = 0.1, resume: bool = False) -> None:
    folder = cb.run_folder(output, resume=resume)
    drop = cb.Droplet(cb.spline_circle(points=points), cb.SurfaceTension(3.0))
    states = folder.run(cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), drop), end, every=0.05)
    folder.summary({"D": cb.record(states).deformation[-1]})

if __name__ == "__main__":
    cb.run(main)
"""


@pytest.fixture
def scripted(tmp_path: Path) -> tuple[Path, Path]:
    """A script, and the folder of its run."""
    script, folder = tmp_path / "scripts" / "drop.py", tmp_path / "out"
    script.parent.mkdir()
    script.write_text(SCRIPT)
    assert main(["run", str(script), "-o", str(folder)]) == 0
    return script, folder


ODD = [
    "", "[]", "3", "null", "{", "{}", '{"script": 3}', "[" * 5000, '{"script": null}', "\ud800",
]  # fmt: skip


@pytest.mark.parametrize("text", ODD)
@pytest.mark.parametrize("name", ["run.json", "sweep.json"])
def test_odd_manifests_end_in_one_line(tmp_path: Path, text: str, name: str, capsys):
    (tmp_path / name).write_text(text, errors="surrogatepass")
    assert main(["resume", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert name in said


@pytest.mark.parametrize("name", ["script", "arguments", "inputs", "began", "versions"])
@pytest.mark.parametrize("value", [3, [3], {"file": 3}, {"a": [1]}, "\0", None, "x" * 5000])
def test_a_manifest_with_one_odd_value(scripted, name: str, value: object, capsys):
    """Refused in one line, or gone on with: an argument that is not the script's, too."""
    _, folder = scripted
    asked = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(asked | {name: value}))
    try:
        code = main(["resume", str(folder)])
    except SystemExit as ended:
        code = int(ended.code or 0)
    said = capsys.readouterr().err
    assert code == 0 or (code == 2 and said.count("\n") == 1), said


def test_a_refused_resume_leaves_the_folder_to_its_owner(scripted, capsys):
    """Other numbers of points are refused, and then it goes on as before."""
    _, folder = scripted
    before = snapshot(folder)
    with pytest.raises(SystemExit):
        main(["resume", str(folder), "--points", "40"])
    assert "holds the run of something else" in capsys.readouterr().err
    assert snapshot(folder) == before
    assert main(["resume", str(folder), "--end", "0.15"]) == 0


def test_a_script_that_has_changed_is_asked_for(scripted, capsys):
    script, folder = scripted
    script.write_text(SCRIPT + "\n# other\n")
    before = snapshot(folder)
    assert main(["resume", str(folder)]) == 2
    said = capsys.readouterr().err
    assert f"would run {script}, which has changed" in said
    assert "--trust" in said
    assert snapshot(folder) == before
    assert main(["resume", str(folder), "--trust"]) == 0
    assert main(["resume", str(folder)]) == 0  # it is the recorded one now


def test_a_script_that_came_with_the_folder_is_asked_for(scripted, capsys):
    _, folder = scripted
    asked = json.loads((folder / "run.json").read_text())
    asked["script"]["file"] = str(folder / "script.py")
    (folder / "run.json").write_text(json.dumps(asked))
    assert main(["resume", str(folder)]) == 2
    assert "script.py, which came with the folder" in capsys.readouterr().err
    assert main(["resume", str(folder), "--trust"]) == 0


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root gives away")
def test_a_script_of_somebody_else_is_asked_for(scripted, capsys):
    script, folder = scripted
    os.chown(script, 1234, 1234)
    assert main(["resume", str(folder)]) == 2
    assert "belongs to another user" in capsys.readouterr().err


def test_a_run_keeps_the_cores_that_it_began_with(scripted, tmp_path):
    """The last digits depend on their number; other ones are used if they are asked for."""
    script, folder = scripted

    def cores(folder: Path) -> tuple[int, int]:
        asked = json.loads((folder / "run.json").read_text())
        return asked["cores"], asked["threads"]

    command = [sys.executable, "-m", "cadbem"]
    one = tmp_path / "one"
    subprocess.run([*command, "run", "--cores", "1", script, "-o", one], check=True)
    assert cores(one) == (1, 1)
    subprocess.run([*command, "resume", one, "--end", "0.15"], check=True)
    assert cores(one) == (1, 1)
    subprocess.run([*command, "resume", one, "--end", "0.2", "--cores", "2"], check=True)
    assert cores(one) == (2, 2)
    assert "cores are 2, were 1: last digits may differ" in (one / "log.txt").read_text()


def test_mend_is_an_option(scripted, capsys):
    _, folder = scripted
    flipped(frame_file(folder, 1))
    with pytest.raises(SystemExit):
        main(["resume", str(folder)])
    assert "--mend" in capsys.readouterr().err
    assert main(["resume", str(folder), "--mend"]) == 0
    assert is_sound(frame_file(folder, 1))
    MEND.set(False)
