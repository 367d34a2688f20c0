"""Layers and colours of faces in a STEP file (ISO 10303-46: presentation)."""

from __future__ import annotations

import re

from cadbem.cad.text.step_syntax import decoded, references, without_strings

_LAYER = re.compile(r"PRESENTATION_LAYER_ASSIGNMENT\('((?:[^']|'')*)',(?:'(?:[^']|'')*'|\$),\(")
_STYLED = re.compile(r"(OVER_RIDING_)?STYLED_ITEM\(,?\(([#\d,]*)\),#(\d+)")  # without strings
_RGB = re.compile(r"COLOUR_RGB\('(?:[^']|'')*',([^,]*),([^,]*),([^,)]*)\)")
_PRE_DEFINED = re.compile(r"PRE_DEFINED_COLOUR\('([^']*)'\)")
_STANDARD = {
    "black": "#000000", "white": "#ffffff", "red": "#ff0000", "green": "#00ff00",
    "blue": "#0000ff", "yellow": "#ffff00", "magenta": "#ff00ff", "cyan": "#00ffff",
}  # fmt: skip
_STYLES = re.compile(
    r"PRESENTATION_STYLE_(ASSIGNMENT|BY_CONTEXT)|SURFACE_STYLE_(USAGE|FILL_AREA|RENDERING)"
    r"|SURFACE_SIDE_STYLE|FILL_AREA_STYLE"
)
_FACES = ("ADVANCED_FACE", "FACE_SURFACE")
_BODIES = re.compile(
    r"(MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS|FACETED_BREP|(ORIENTED_)?(CLOSED|OPEN)_SHELL"
    r"|SHELL_BASED_SURFACE_MODEL|FACE_BASED_SURFACE_MODEL|CONNECTED_FACE_SET|ORIENTED_FACE"
    r"|MAPPED_ITEM|REPRESENTATION_MAP|\w*REPRESENTATION|(OVER_RIDING_)?STYLED_ITEM)\("
)


def colour_code(red: float, green: float, blue: float) -> str:
    """Shares from 0 to 1 as "#rrggbb"."""
    parts = [round(255 * min(max(share, 0.0), 1.0)) for share in (red, green, blue)]
    return "#" + "".join(f"{part:02x}" for part in parts)


def faces_of(entities: dict[int, str], item: int) -> frozenset[int]:
    """The faces of a face, shell, solid or representation, by number."""
    faces, seen, waiting = set(), {item}, [item]
    while waiting:
        number = waiting.pop()
        body = entities.get(number, "")
        if body.startswith(_FACES):
            faces.add(number)
        elif _BODIES.match(body):
            parts = [part for part in references(body) if part not in seen]
            seen.update(parts)
            waiting += parts
    return frozenset(faces)


def layers(entities: dict[int, str]) -> dict[int, str]:
    """Names of layers by number of face; what says something of fewer faces counts more."""
    found = []
    for body in entities.values():
        layer = _LAYER.match(body)
        if layer and layer[1]:
            for item in references(body[layer.end() :]):
                found.append((faces_of(entities, item), decoded(layer[1])))
    return _spread(sorted(found, key=lambda pair: -len(pair[0])))


def colours(entities: dict[int, str]) -> dict[int, str]:
    """Colours by number of face; one that overrides, or is of fewer faces, counts more."""
    found = []
    for body in entities.values():
        style = _STYLED.search(without_strings(body))
        colour = _colour(entities, references(style[2])) if style else ""
        if style and colour:
            found.append((faces_of(entities, int(style[3])), colour, bool(style[1])))
    found.sort(key=lambda item: (-len(item[0]), item[2]))
    return _spread([item[:2] for item in found])


def _spread(found: list[tuple[frozenset[int], str]]) -> dict[int, str]:
    return {face: text for faces, text in found for face in faces}


def _colour(entities: dict[int, str], styles: list[int]) -> str:
    """The first colour of a surface among the styles and what they consist of."""
    waiting, seen = styles[::-1], set(styles)
    while waiting:
        body = entities.get(waiting.pop(), "")
        rgb, named = _RGB.match(body), _PRE_DEFINED.search(body)
        if rgb:
            return colour_code(*(float(share) for share in rgb.groups()))
        if named and named[1].lower() in _STANDARD:
            return _STANDARD[named[1].lower()]
        if _STYLES.match(body):
            parts = [part for part in references(body) if part not in seen]
            seen.update(parts)
            waiting += parts[::-1]
    return ""
