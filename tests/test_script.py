"""Options of scripts: what --help says of each."""

import ast
from pathlib import Path

import pytest

import cadbem as cb
from cadbem.script import ALWAYS, explained

WORKFLOWS = sorted((Path(__file__).parents[1] / "workflows").glob("*.py"))
LONGEST = 60  # lines of a workflow


def main(
    output: str = "",
    radius: float = 0.36,
    width: str = "2 mm",
    height: str = "1 mm",
    share: str = "50 %",
    levels: int | None = None,
    graded: bool = False,
    resume: bool = False,
) -> float:
    """Not read by anybody.

    A sentence: no option has this name.

    radius: of the droplet at first, which may be
        as wide as the throat (mm)
    width, height: of the channel
    graded: smaller elements at the edges
    """
    return radius


def test_help_explains_options(capsys):
    with pytest.raises(SystemExit) as end:
        cb.run(main, ["--help"])
    assert end.value.code == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert (
        "--radius RADIUS of the droplet at first, which may be as wide as the throat (mm) "
        "(default: 0.36)"
    ) in printed
    assert "--width WIDTH of the channel (default: 2 mm)" in printed
    assert "--height HEIGHT of the channel (default: 1 mm)" in printed
    assert "--share SHARE default: 50 %" in printed
    assert "--levels LEVELS default: none" in printed
    assert "--no-graded smaller elements at the edges (default: no)" in printed
    assert f"{ALWAYS['output']} (default: '')" in printed
    assert printed.endswith(f"{ALWAYS['resume']} (default: no)")
    assert cb.run(main, ["--radius", "2"]) == 2.0


def test_explanations_end_where_the_text_goes_on():
    lines = "First line.", "", "a: one,", "    two; d: four", "b, c: three; 0: not more"
    texts = explained("\n".join([*lines, "No more", "    of it"]))
    assert texts == {
        "a": "one, two", "d": "four", "b": "three; 0: not more", "c": "three; 0: not more"
    }  # fmt: skip
    assert explained("") == {}


def main_of(path: Path) -> ast.FunctionDef:
    """The function main of a script."""
    body = ast.parse(path.read_text()).body
    return next(f for f in body if isinstance(f, ast.FunctionDef) and f.name == "main")


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_workflows_are_short_and_explain_their_options(path):
    """Each option has an explanation, and no explanation lacks its option."""
    assert len(path.read_text().splitlines()) <= LONGEST
    function = main_of(path)
    names = {argument.arg for argument in function.args.args}
    texts = explained(ast.get_docstring(function) or "")
    assert names == set(texts) | (names & ALWAYS.keys())
