"""The documents: links and pictures exist, and every public name is documented."""

import re
from pathlib import Path

import pytest

import cadbem

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def anchors(page: Path) -> set[str]:
    """What headings of a page are called in links."""
    headings = HEADING.findall(FENCED.sub("", page.read_text()))
    plain = (re.sub(r"[^\w\s-]", "", heading.lower()) for heading in headings)
    return {heading.strip().replace(" ", "-") for heading in plain}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    """Relative ones: to files, and to headings in them."""
    for link in LINK.findall(FENCED.sub("", page.read_text())):
        if re.match(r"https?://", link):
            continue
        file, _, anchor = link.partition("#")
        target = page.parent / file if file else page
        assert target.exists(), f"{page.name} links to {link}"
        assert not anchor or anchor in anchors(target), f"{page.name}: no heading {link}"


def listed() -> list[str]:
    """Names in the tables of the API page."""
    text = (ROOT / "docs" / "api.md").read_text()
    blocks = re.findall(r":nosignatures:\n\n(.*?)\n```", text, re.DOTALL)
    return [name.strip() for block in blocks for name in block.splitlines()]


def test_api_page_has_every_public_name_once():
    public = [name for name in dir(cadbem) if not name.startswith("_")]
    assert sorted(listed()) == sorted(public)


def test_pages_are_in_the_table_of_contents():
    text = (ROOT / "docs" / "index.md").read_text()
    missing = [
        page.stem for page in (ROOT / "docs").glob("*.md")
        if page.stem != "index" and not re.search(rf"^{page.stem}$", text, re.MULTILINE)
    ]  # fmt: skip
    assert not missing


def test_public_names_have_docstrings():
    for name in listed():
        text = getattr(cadbem, name).__doc__
        assert text and not text.startswith(f"{name}("), f"{name} has no docstring"


def test_files_of_the_glossary_exist():
    rows = re.findall(r"^\| .* \|$", (ROOT / "docs" / "glossary.md").read_text(), re.MULTILINE)
    words = [row for row in rows if not row.startswith("| word ")]
    assert len(words) > 30
    for row in words:
        file = re.search(r"`([^`]+)` \|$", row)
        assert file and (ROOT / file[1]).is_file(), f"no such file: {row}"


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/architecture.md"])
def test_paths_on_pages_exist(page):
    """Paths from the repository, from the package, or from one of its rooms."""
    text = (ROOT / page).read_text()
    for path in re.findall(r"`([\w/.]+/[\w.]*)`", text):
        places = [ROOT / path, ROOT / "cadbem" / path, *(ROOT / "cadbem").glob(f"*/{path}")]
        of_a_run = path.startswith("frames/")
        assert of_a_run or any(place.exists() for place in places), f"{page}: no {path}"
