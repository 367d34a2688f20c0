"""The floors of the house: who may import whom (docs/architecture.md)."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "cadbem"
FLOORS = (
    {"errors", "progress", "command", "tables"},
    {"checks"},
    {"compiled", "files", "units", "overviews"},
    {"spline", "quadrature", "kernels"},
    {"points", "refinement"},
    {"boundary", "closed_points"},
    {"extension", "elements"},
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
# wings of a room from below; "" is the room's own files
WINGS = {
    "cad": ("text", "kernel", "faces", "drawings", "layout", "labels", "body", "export", ""),
    "operators": ("", "far", "closed", "compressed"),
    "suspension": ("surroundings", "rigid", "interface", "bodies", "multibody", "time"),
    "verification": ("", "figures"),
    "post": ("files", "style", "fields", "scene", "plane", "bodies", "channel", ""),
}
FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
OWNERS = {
    "gmsh": "cad", "ezdxf": "cad", "gdstk": "cad",
    "pyvista": "post", "vtk": "post", "vtkmodules": "post",
}  # fmt: skip
FILES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in PACKAGE.rglob("*.py")
}
PUBLIC = "cadbem"  # it names everything for type checkers, and imports nothing by itself


def imports(path: Path) -> Iterator[tuple[str, str]]:
    """Modules that a file imports, inside functions and for types too, and the imported name."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from ((alias.name, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports are not used here"
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                yield (full if full in FILES else str(node.module)), alias.name


ARROWS = [
    (name, imported, thing)
    for name, path in FILES.items()
    for imported, thing in imports(path)
    if imported in FILES and imported != name
]


def room(module: str) -> str:
    """Folder or top-level file of a module, '__init__' for the package itself."""
    return [*module.split("."), "__init__"][1]


def wing(module: str) -> str:
    """Folder of a module within its room, '' for the room's own files."""
    return module.split(".")[2] if (FILES[module].parent.parent.parent == PACKAGE) else ""


def height(module: str) -> tuple[int, int]:
    """Floor of a module's room, and of its wing there."""
    wings = WINGS.get(room(module), ("",))
    return FLOOR[room(module)], wings.index(wing(module))


def test_every_room_and_wing_has_a_floor():
    assert {room(name) for name in FILES} <= FLOOR.keys(), "give the new room a floor here"
    for name in FILES:
        wings = WINGS.get(room(name), ("",))
        assert wing(name) in (*wings, ""), f"give the wing of {name} a floor here"


def test_imports_go_down():
    """No arrow runs up: to a higher floor, a neighbour on the same one, or a higher wing."""
    upward = []
    for name, imported, thing in ARROWS:
        is_front = FILES[name].name == "__init__.py" and imported.startswith(f"{name}.")
        if not is_front and name != PUBLIC:
            here, there = height(name), height(imported)
            below = there <= here if room(name) == room(imported) else there[0] < here[0]
            if not below:
                upward.append(f"{name} must not import {imported} ({thing})")
    assert not upward, "\n".join(upward)


def test_no_circle_of_files():
    """Imports for type annotations count as well."""
    graph: dict[str, set[str]] = {name: set() for name in FILES}
    for name, imported, _ in ARROWS:
        if name != PUBLIC:
            graph[name].add(imported)
    try:
        tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        circle = error.args[1][::-1]
        things = [
            f"{a} imports {thing} from {b}"
            for a, b in zip(circle, circle[1:], strict=False)
            for name, imported, thing in ARROWS
            if (name, imported) == (a, b)
        ]
        pytest.fail("\n".join(things))


def test_heavy_libraries_stay_in_their_room():
    for name, path in FILES.items():
        for imported, _ in imports(path):
            owner = OWNERS.get(imported.split(".")[0])
            assert owner in (None, room(name)), f"{name} must not import {imported}"
