"""The floors of the house: who may import whom (docs/architecture.md)."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "cadbem"
FLOORS = (
    {"errors", "progress", "command"},
    {"compiled", "files", "units"},
    {"spline", "quadrature", "kernels"},
    {"boundary", "extension", "points", "closed_points", "refinement"},
    {"cad", "space"},
    {"operators"},
    {"problems"},
    {"suspension"},
    {"post", "warmup", "design"},
    {"results", "verification"},
    {"sweep"},
    {"script", "__init__"},
    {"cli"},
    {"__main__"},
)
FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
OWNERS = {"gmsh": "cad", "pyvista": "post", "vtk": "post", "vtkmodules": "post"}
FILES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in PACKAGE.rglob("*.py")
}


def imports(path: Path) -> set[str]:
    """Modules a file imports, inside functions too, but not for types alone."""
    tree, found = ast.parse(path.read_text()), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            node.body = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports are not used here"
            full = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= (full & FILES.keys()) or {str(node.module)}
    return found


def room(module: str) -> str:
    """Folder or top-level file of a module, '__init__' for the package itself."""
    return [*module.split("."), "__init__"][1]


def test_every_room_has_a_floor():
    assert {room(name) for name in FILES} <= FLOOR.keys(), "give the new room a floor here"


def test_imports_go_down():
    for name, path in FILES.items():
        for imported in imports(path) & FILES.keys():
            below = FLOOR[room(imported)] < FLOOR[room(name)]
            level = FLOOR[room(imported)] == FLOOR[room(name)]
            same_folder = FILES[imported].parent == path.parent
            assert below or (level and same_folder), f"{name} must not import {imported}"


def test_no_cycles():
    graph = {name: imports(path) & FILES.keys() for name, path in FILES.items()}
    tuple(TopologicalSorter(graph).static_order())  # raises CycleError with the cycle


def test_heavy_libraries_stay_in_their_room():
    for name, path in FILES.items():
        for imported in imports(path):
            owner = OWNERS.get(imported.split(".")[0])
            assert owner in (None, room(name)), f"{name} must not import {imported}"
