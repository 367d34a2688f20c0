"""What became of bodies, as tables to print."""

from __future__ import annotations

import numpy as np

from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.multibody.contact import Gap
from cadbem.suspension.multibody.measures import taylor_deformation
from cadbem.suspension.time.history import History
from cadbem.tables import text_table
from cadbem.units import UnitNames

TIMES = 14  # rows of a course


def bodies_report(run: History, units: UnitNames | None = None) -> str:
    """A table of all bodies: way, mean speed, largest D and where, last D, narrowest gap and to
    what, and whether they left; then what the run took.  ``units`` are named in its head."""
    head = ("body", _with("way", units, "{0.length}"), _with("speed", units, "{0.length}/{0.time}"),
            "largest D", _with("at x", units, "{0.length}"), "last D",
            _with("narrowest gap", units, "{0.length}"), "fate")  # fmt: skip
    rows = [_body_row(run, number) for number in run.numbers]
    return f"{text_table(head, rows)}\n{run.cost}"


def course_report(
    run: History,
    units: UnitNames | None = None,
    number: int = 1,
    ends: tuple[str, str] = ("inlet", "outlet"),
) -> str:
    """A table over time, at 14 times at most: place, D, speed, gap, and in a channel the extra
    pressure drop between two ``ends``; then what the run took."""
    course = run.course(number)
    columns = {
        _with("t", units, "{0.time}"): course.times,
        _with("x", units, "{0.length}"): course.centre[0],
        "D": course.deformation,
        _with("speed", units, "{0.length}/{0.time}"): course.speed,
    }
    if set(ends) <= course.extra_pressure.keys():
        columns[_with("extra pressure", units, "{0.pressure}")] = course.extra_drop(*ends)
    columns[_with("gap", units, "{0.length}")] = course.gap
    last = len(course.times) - 1
    shown = np.unique(np.linspace(0, last, TIMES).round().astype(int))
    rows = [[_number(values[k]) for values in columns.values()] for k in shown]
    return f"{text_table(tuple(columns), rows)}\n{run.cost}"


def _body_row(run: History, number: int) -> list[str]:
    times, centres = run.track(number)
    way = float(np.linalg.norm(np.diff(centres, axis=1), axis=0).sum())
    body = run.states[0].bodies[run.numbers.index(number)]
    if isinstance(body, Droplet):
        kind, found = "droplet", run.of(taylor_deformation, number)
        most = int(found.argmax())
        shape = [f"{found[most]:.3f}", f"{centres[0, most]:.2f}", f"{found[-1]:.3f}"]
    else:
        kind, shape = "particle", ["-", "-", "-"]
    gaps = [(gap, s.time) for s in run.states for gap in s.gaps if gap.body == number]
    place = ", ".join(f"{x:.2f}" for x in centres[:, -1].round(2) + 0.0)
    fate = run.last.left.get(number, f"at ({place}) at time {times[-1]:g}")
    speed = way / times[-1] if times[-1] else 0.0
    return [f"{number} {kind}", f"{way:.2f}", f"{speed:.2f}", *shape, _narrowest(gaps), fate]


def _narrowest(gaps: list[tuple[Gap, float]]) -> str:
    """The narrowest of a body's gaps, to what, and when."""
    gap, time = min(gaps, key=lambda pair: pair[0].length)
    return "-" if np.isinf(gap.length) else f"{gap.length:.3f} to {gap.other} at {time:.2f}"


def _with(label: str, units: UnitNames | None, unit: str) -> str:
    return label if units is None else f"{label} ({unit.format(units)})"


def _number(value: float) -> str:
    return f"{value:.3f}" if np.isfinite(value) else "-"
