"""How Sphinx makes the documentation: bin/docs, without network."""

import argparse
import re
from pathlib import Path

from docutils.nodes import SkipNode
from latex2mathml.converter import convert
from sphinx.application import Sphinx

import cadbem
from cadbem.cli.commands import _parser

HERE = Path(__file__).parent
GENERATED = HERE / "_generated"

project = "cadbem"
author = copyright = "The cadbem developers"
version = release = cadbem.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary"]
exclude_patterns = ["_build", "_templates"]
templates_path = ["_templates"]
html_theme = "furo"
html_title = f"cadbem {version}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["math.css"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
autosummary_ignore_module_all = False
autodoc_typehints = "none"
autodoc_preserve_defaults = True
default_role = "code"
smartquotes = False


def setup(app: Sphinx) -> None:
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    app.connect("builder-inited", write_commands)
    app.connect("autodoc-process-docstring", plain)


def inline(writer, node) -> None:
    """Formulas as MathML, which browsers draw by themselves: no script, nothing to load."""
    writer.body.append(convert(node.astext()))
    raise SkipNode


def display(writer, node) -> None:
    writer.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
    raise SkipNode


def plain(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]):
    """Docstrings are prose: bars, stars and trailing underscores mean nothing in them."""
    lines[:] = [re.sub(r"(``.*?``)|([|*]|(?<=\w)_(?=\W|$))", escaped, line) for line in lines]


def escaped(found: re.Match) -> str:
    return found[1] or f"\\{found[2]}"


def write_commands(app: Sphinx) -> None:
    """The page of the command line, from what --help says."""
    parser = _parser()
    parts = ["# Command line\n", fenced(parser.format_help())]
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                parts += [f"## cadbem {name}\n", fenced(command.format_help())]
    GENERATED.mkdir(exist_ok=True)
    (GENERATED / "commands.md").write_text("\n".join(parts))


def fenced(text: str) -> str:
    return f"```text\n{text.rstrip()}\n```\n"
