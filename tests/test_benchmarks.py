"""The page of benchmarks: tables as Markdown, and sections that are replaced one by one."""

from pathlib import Path

import pytest

from benchmarks import __main__ as program
from benchmarks.table import Table, least


def test_a_table_as_markdown():
    """Words by hand: the first column flush left, numbers flush right."""
    table = Table("Speed", "\nOf things.\n", ("thing", "s"), [("one", "1.0"), ("two", "2.5")])
    assert table.markdown() == (
        "### Speed\n\nOf things.\n\n| thing | s |\n| --- | ---: |\n| one | 1.0 |\n| two | 2.5 |\n"
    )


def test_the_least_of_rounds():
    """Each number by itself: 1 of (3, 1), 2 of (2, 5)."""
    assert least([{"a": 3.0, "b": 2.0}, {"a": 1.0, "b": 5.0}]) == {"a": 1.0, "b": 2.0}


def test_a_section_is_replaced_and_the_others_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sections come in the order of the alphabet; one of a benchmark that is gone goes too."""
    page = tmp_path / "page.md"
    monkeypatch.setattr(program, "names", lambda: ["cad", "runs"])
    monkeypatch.setattr(program, "machine", lambda: "monday")
    program.keep(page, "runs", "old")
    program.keep(page, "gone", "lost")
    monkeypatch.setattr(program, "machine", lambda: "tuesday")
    program.keep(page, "runs", "new")
    program.keep(page, "cad", "read")
    text = page.read_text()
    assert text == program.HEADER + "\n## cad\n\ntuesday\n\nread\n\n## runs\n\ntuesday\n\nnew\n"


def test_the_machine_says_what_matters() -> None:
    """Versions of what the numbers depend on."""
    words = program.machine()
    assert all(name in words for name in ("numba", "numpy", "scipy", "cores", "Python"))
    assert {"cad", "first_result", "runs"} <= set(program.names())
