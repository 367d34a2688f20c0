"""CAD text that was made to be slow, huge or harmful to a terminal."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

import cadbem as cb
from cadbem.cad.body.model import file_unit
from cadbem.cad.text.iges_syntax import words
from cadbem.cad.text.source import read_source
from cadbem.errors import printable

ROOT = Path(__file__).resolve().parents[1]
CHANNEL = ROOT / "geometries" / "square_channel.step"
LARGE = 400_000  # letters of a text that was made to be slow
SECONDS = 3.0  # of CPU for each; texts of this length took minutes or hours


def step(data: str, before: str = "") -> str:
    """A STEP text around the statements of its data section."""
    return f"{before}ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n"


def repeated(text: str) -> str:
    return text * (LARGE // len(text))


SLOW = {
    "comments in front": repeated("/**/") + "x",
    "comments in front of it": step("", repeated("/* */ ")),
    "comments without an end": step(repeated("/*")),
    "no semicolon": step(repeated("#1=A()")),
    "apostrophes": step("#1=A(" + repeated("'") + ");"),
    "blanks": step("#1=A(" + repeated(" ") + "x);"),
    "a number": step("#1=A(" + repeated("1") + "x);"),
    "a number with points": step("#1=A(" + repeated("1.") + ");"),
    "a keyword": step("#1=" + repeated("A") + ";"),
    "brackets": step("#1=" + repeated("A(") + ";"),
    "commas": step("#1=A(" + repeated("$,") + ");"),
    "an entity's number": step("#" + repeated("1") + "=A();"),
    "a reference": step("#1=A(#" + repeated("1") + ");"),
    "styles in a name": step("#1=A('" + repeated("STYLED_ITEM(''") + "');"),
    "representations in a name": step("#1=A('" + repeated("REPRESENTATION(''") + "');"),
    "splines in a name": step("#1=A('" + repeated("BEZIER_CURVE(''',1") + "');"),
    "measures in a name": step("#1=A('" + repeated("LENGTH_MEASURE(") + "');"),
    "faces in a name": step("#1=ADVANCED_FACE('" + repeated("ADVANCED_FACE(''") + "',(#1));"),
    "escapes in a name": step("#1=ADVANCED_FACE('" + repeated("\\X2\\0041") + "',());"),
    "nothing but a beginning": repeated("ISO-10303-21 "),
}


@pytest.mark.parametrize("kind", SLOW)
def test_every_text_is_read_in_linear_time(kind: str, tmp_path: Path):
    path = tmp_path / "slow.step"
    path.write_text(SLOW[kind])
    start = time.process_time()
    with pytest.raises(cb.CadError) as refused:
        file_unit(read_source(path))
        raise cb.CadError("it is sound")  # then the kernel says what it is not
    assert time.process_time() - start < SECONDS
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 400


def test_the_file_of_121_bytes(tmp_path: Path):
    (tmp_path / "small.step").write_text("/**/" * 30 + "x")
    start = time.process_time()
    with pytest.raises(cb.CadError, match="the content is not STEP"):
        cb.read_cad(tmp_path / "small.step")
    assert time.process_time() - start < 0.5


@pytest.mark.parametrize(
    "record", ["1," * (LARGE // 2), "1," * (LARGE // 2) + ";", "3Habc," * (LARGE // 6), " " * LARGE]
)
def test_records_of_iges_are_read_in_linear_time(record: str):
    start = time.process_time()
    words(record, ",", ";")
    assert time.process_time() - start < SECONDS


def test_words_of_iges():
    """Strings may hold separators; blanks around numbers count for nothing."""
    assert words("126, 3,4H,;ab,  ,1.0 ;5,", ",", ";") == ["126", "3", "',;ab", "", "1.0"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.5,", "1.E+" + "9" * 5000 + ",", "not a finite number below 1e100"),
        ("0.5,", "1.E+299,", "not a finite number below 1e100"),
        ("0.5,", "1.E99,", "cannot handle|damaged|contradict|times as long|kernel|close|off"),
        ("0.5,", "9" * 400 + ".,", "not a finite number below 1e100"),
        ("#10 =", "#" + "1" * 5000 + " =", "not STEP|below 1e100"),
        ("#11,", "#" + "1" * 5000 + ",", "not STEP|below 1e100"),
    ],
)
def test_numbers_beyond_all_measure(old: str, new: str, message: str, tmp_path: Path):
    text = CHANNEL.read_text()
    assert old in text
    (tmp_path / "huge.step").write_text(text.replace(old, new, 1))
    with pytest.raises(cb.CadError, match=message) as refused:
        cb.read_cad(tmp_path / "huge.step")
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[31mred\x1b[0m", "�[31mred�[0m"),
        ("a\nb\tc\r", "a b c "),
        ("right\u202eleft", "right�left"),
        ("\x9b2J", "�2J"),
        ("Größe 5 µm, 流体", "Größe 5 µm, 流体"),
    ],
)
def test_what_a_terminal_would_obey_is_not_printed(text: str, shown: str):
    """The name of a face, of a file, and the text of errors and warnings."""
    assert printable(text) == shown
    patch = cb.Patch(cb.box()[0], text)
    boundary = cb.Boundary((patch,), source=text, unit=text)
    assert patch.name == boundary.source == boundary.unit == shown
    assert text == shown or text not in repr(boundary) + boundary._repr_html_()
    assert str(cb.CadbemError(text)) == str(cb.CadWarning(text)) == shown


def test_names_in_a_file_are_cleaned(tmp_path: Path):
    text = CHANNEL.read_text().replace("ADVANCED_FACE('inlet'", "ADVANCED_FACE('in\x1b[2Jlet'")
    path = tmp_path / "bad\x1b[2Jname.step"
    path.write_text(text)
    channel = cb.read_cad(path)
    assert "in�[2Jlet" in channel.names
    assert "\x1b" not in repr(channel)
    report = subprocess.run(
        [sys.executable, "-m", "cadbem", "info", str(path)], capture_output=True, text=True
    )
    assert report.returncode == 0
    assert "\x1b[2J" not in report.stdout + report.stderr


def test_the_kernel_has_no_more_than_its_share_of_memory():
    """Half of this machine's memory is not enough for all of it."""
    child = ROOT / "cadbem" / "cad" / "kernel" / "_child.py"
    program = (
        "import os, runpy, sys\n"
        f"child = runpy.run_path({str(child)!r})\n"
        "whole = os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES')\n"
        "child['limit_memory'](0.5)\n"
        "try:\n    bytearray(whole)\nexcept MemoryError:\n    sys.exit(7)\n"
    )
    assert subprocess.run([sys.executable, "-c", program]).returncode == 7


def test_large_files_are_refused(tmp_path: Path):
    with (tmp_path / "large.step").open("wb") as file:
        file.truncate(2**29)
    with pytest.raises(cb.CadError, match="above 256 MB"):
        cb.read_cad(tmp_path / "large.step")
