"""Compiled functions: what is kept on disk, when it is forgotten, and what is compiled ahead."""

import ast
import json
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "cadbem"
FILES = sorted(p for p in PACKAGE.rglob("*.py") if "cadbem.compiled" in p.read_text())
MODULES = [".".join(p.relative_to(PACKAGE.parent).with_suffix("").parts) for p in FILES]
CALLED = """
from cadbem.compiled import compiled

@compiled
def inner(x):
    return {factor} * x
"""
CALLING = """
from cadbem.compiled import compiled
from pair.called import inner

@compiled
def outer(x):
    return inner(x) + 1.0
"""
USE = """
import json
from pair.calling import outer
result = outer(2.0)
stats = outer.stats
print(json.dumps([result, sum(stats.cache_hits.values()), stats.cache_path]))
"""


def used(folder, said="", **environment):
    """What `outer` of the package in a folder gives in a new process, how many times it came from
    the disk, and the folder of the cache; what is ``said`` on the way."""
    path = os.pathsep.join([str(folder), str(PACKAGE.parent)])
    kept = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", USE], env={**kept, "PYTHONPATH": path, **environment},
        check=True, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.stderr == said
    return json.loads(done.stdout)


@pytest.fixture
def pair(tmp_path):
    """A package of two files, a function of one of which calls one of the other's."""
    (tmp_path / "pair").mkdir()
    (tmp_path / "pair" / "__init__.py").write_text("")
    (tmp_path / "pair" / "called.py").write_text(CALLED.format(factor=3.0))
    (tmp_path / "pair" / "calling.py").write_text(CALLING)
    return tmp_path


def test_an_edit_of_a_called_function_is_noticed(pair):
    """f(x) = 3x + 1 at 2 is 7; after an edit of another file, f(x) = 5x + 1, it is 11.  Without an
    edit nothing is compiled again, and files of old code are overwritten."""
    assert used(pair)[:2] == [7.0, 0]
    assert used(pair)[:2] == [7.0, 1]
    files = sorted((pair / "pair" / "__pycache__").glob("*.nb?"))
    (pair / "pair" / "called.py").write_text("# another line\n" + CALLED.format(factor=5.0))
    assert used(pair)[:2] == [11.0, 0]
    assert used(pair)[:2] == [11.0, 1]
    assert sorted((pair / "pair" / "__pycache__").glob("*.nb?")) == files


def test_a_package_that_cannot_be_written_to(pair):
    """The code goes to the user's folder, and if that cannot be written to either, nowhere."""
    (pair / "pair" / "__pycache__").write_text("not a folder")
    home = pair / "home"
    for hits in (0, 1):
        result, found, cache = used(pair, HOME=str(home), XDG_CACHE_HOME=str(home))
        assert (result, found) == (7.0, hits)
        assert home in Path(cache).parents
    nowhere = str(pair / "pair" / "__pycache__")
    note = "compiled code is not kept for later runs: no folder to keep it in can be written to"
    note += "; set NUMBA_CACHE_DIR\n"
    assert used(pair, note, HOME=nowhere, XDG_CACHE_HOME=nowhere) == [7.0, 0, None]
    assert used(pair, note, HOME="~", XDG_CACHE_HOME="") == [7.0, 0, None]
    assert not Path("~").exists()


def flipped(content: bytes) -> bytes:
    """One bit in the middle is another."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.parametrize(
    "damage",
    [
        flipped,
        lambda content: content[: len(content) // 2],
        *[
            pytest.param(rest, marks=pytest.mark.long)
            for rest in (lambda _: b"", lambda content: content[:40], lambda _: None)
        ],
    ],
)
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_damaged_machine_code_is_made_anew(pair, damage, ending):
    """Truncated, empty, missing, or a bit of it another: the run after that finds it again."""
    assert used(pair)[:2] == [7.0, 0]
    for file in (pair / "pair" / "__pycache__").glob(f"*.{ending}"):
        content = damage(file.read_bytes())
        file.unlink() if content is None else file.write_bytes(content)
    assert used(pair)[:2] == [7.0, 0]
    assert used(pair)[:2] == [7.0, 1]


def test_a_cache_that_fills_up(pair):
    """Files may be no larger than a kilobyte: the code is used, and a note says that it is not
    kept."""
    resource = pytest.importorskip("resource")
    path = os.pathsep.join([str(pair), str(PACKAGE.parent)])
    done = subprocess.run(
        [sys.executable, "-B", "-c", USE], env={**os.environ, "PYTHONPATH": path},
        capture_output=True, text=True, timeout=120,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)),
    )  # fmt: skip
    assert json.loads(done.stdout)[:2] == [7.0, 0]
    assert done.stderr.count("\n") == 1
    assert "cannot be written to (File too large)" in done.stderr


def compiled_functions():
    """All compiled functions with their modules and names."""
    for name in MODULES:
        module = import_module(name)
        for key, value in vars(module).items():
            if hasattr(value, "py_func") and value.py_func.__module__ == name:
                yield module, key, value


def test_numbers_of_compiled_functions_stand_in_files_that_are_watched():
    """The cache forgets code when a file with compiled functions changes, and no other file."""
    for module, name, function in compiled_functions():
        tree = ast.parse(Path(module.__file__).read_text())
        imported = {
            alias.asname or alias.name: node.module
            for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }  # fmt: skip
        for key in imported.keys() & set(function.py_func.__code__.co_names):
            owner = imported[key]
            if isinstance(vars(module)[key], int | float | tuple | np.ndarray):
                watched = not owner.startswith("cadbem.") or owner in MODULES
                assert watched, f"{module.__name__}.{name} takes {key} from {owner}"


WARM_UP = """
import json
import numpy as np
from test_compiled import compiled_functions
from cadbem.warmup import _channel, warm_up

warm_up()
functions = [(m.__name__ + "." + n, f) for m, n, f in compiled_functions()
             if f.targetoptions.get("inline") != "always"]
missing = [name for name, function in functions if not function.signatures]
# more points than one task takes
_channel(3).solve().velocity_at(0.3 + 0.4 * np.random.default_rng(1).random((3, 2100)))
twice = []
for name, function in functions:
    kinds = [[str(a).rsplit(",", 1)[0] for a in s] for s in function.signatures]
    twice += [name for kind in kinds if kinds.count(kind) > 1]
print(json.dumps([missing, twice]))
"""


@pytest.mark.long
def test_warming_up_compiles_everything_once(tmp_path):
    """Every compiled function has been compiled, and none twice for arrays of one kind that lie
    differently in memory.  The cache is empty: what comes from there brings along what it calls.
    """
    path = os.pathsep.join([str(PACKAGE.parent), str(Path(__file__).parent)])
    done = subprocess.run(
        [sys.executable, "-c", WARM_UP],
        env={**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(tmp_path)},
        check=True, capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert json.loads(done.stdout) == [[], []]
