"""Makes docs/verification.md: each table and figure of the thesis beside ours and the truth.

    python docs/verification.py          all checks (some minutes)
    python docs/verification.py --fast   without the long ones

Pictures come from docs/make.py and docs/verification_figures.py.
"""

import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from verification_items import ITEMS, Item

import cadbem as cb
from cadbem.verification import Result, all_checks, run_checks
from cadbem.verification.report import number, summary

HERE = Path(__file__).parent
HEAD = "what", "ours", "truth", "thesis", "error", "allowed", "truth from"
PIVOT = ("integral", "exact", "ours", "error", "whole, thesis's way", "printed", "cut or polar",
         "parts", "printed")  # fmt: skip


def main() -> None:
    results = list(run_checks(all_checks(full="--fast" not in sys.argv)))
    unknown = {r.check.place for r in results} - {item.place for item in ITEMS}
    assert not unknown, f"no item for {unknown}"
    parts = [section(item, [r for r in results if r.check.place == item.place]) for item in ITEMS]
    (HERE / "verification.md").write_text("\n".join([introduction(results), *parts]))


def introduction(results: Sequence[Result]) -> str:
    return f"""# Verification

Each table and figure of the thesis, in order: what cadbem gives, what is true, and what the thesis
prints. Made by `python docs/verification.py`, cadbem {cb.__version__}: {summary(results)}.
`cadbem verify` computes the same numbers on your machine.

The truth is a closed form, a series, or a computation by other means, as the last column says; the
thesis's own value stands beside it and decides nothing. Errors are relative, and absolute where
the truth is 0. Blocks of text are from [Results](results.md), with the machine and the times.
"""


def section(item: Item, results: Sequence[Result]) -> str:
    title = item.place if item.place != "Beyond" else "Beyond the thesis"
    lines = [f"## {title}: {item.shows}\n"]
    if results and item.place.startswith("Table 2"):
        lines.append(table(PIVOT, pivoted(results)))
    elif results:
        lines.append(table(HEAD, map(row, results)))
    lines += [f"![{item.shows}](pictures/{name}.png)\n" for name in item.pictures]
    lines += [f"```\n{block(*where)}\n```\n" for where in item.blocks]
    lines += [f"{item.remark}\n"] if item.remark else []
    return "\n".join(lines)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def row(result: Result) -> tuple[str, ...]:
    check = result.check
    verdict = f"{check.tolerance:.0e}" + ("" if result.passed else " **FAILED**")
    return (check.what, number(result.computed), number(check.reference), number(check.printed),
            f"{result.error:.1e}", verdict, check.source)  # fmt: skip


def pivoted(results: Sequence[Result]) -> list[tuple[str, ...]]:
    """One row an integral, its ways side by side."""
    found: dict[str, dict[str, Result]] = {}
    for result in results:
        integral, way = re.split(r", (?=ours|polar|\d+ ×)", result.check.what)
        found.setdefault(integral, {})[way] = result
    return [pivot(integral, ways) for integral, ways in found.items()]


def pivot(integral: str, ways: dict[str, Result]) -> tuple[str, ...]:
    ours, whole = ways.pop("ours"), ways.pop("1 × 1 parts", None)
    way, cut = next(iter(ways.items()), ("", None))
    return (integral, number(ours.check.reference), number(ours.computed), f"{ours.error:.0e}",
            *pair(whole), *pair(cut)[:1], way.removesuffix(" parts"), *pair(cut)[1:])  # fmt: skip


def pair(result: Result | None) -> tuple[str, str]:
    """Computed and printed."""
    return (number(result.computed), number(result.check.printed)) if result else ("", "")


def block(title: str, first: str) -> str:
    """Lines of a section of docs/results.md, from those first words to the next empty line."""
    text = (HERE / "results.md").read_text()
    found = re.search(rf"^## {re.escape(title)}\n\n```\n+(.*?)```", text, re.MULTILINE | re.DOTALL)
    assert found, title
    start = re.search(rf"^{re.escape(first)}", found[1], re.MULTILINE)
    assert start, f"{title}: no line begins with {first}"
    rest = found[1][start.start() :]
    return rest.rstrip() if not first else rest.split("\n\n")[0].rstrip()


if __name__ == "__main__":
    main()
