"""What problems and solutions say of themselves when they are printed."""

from __future__ import annotations

from typing import Any

from cadbem.overviews import named_areas, size_text, source_text
from cadbem.tables import Overview, Row, brief, numbers, rounded

DRIVES = ("Inflow", "Pressure", "Traction")  # kinds of conditions of openings


def problem_overview(problem: Any) -> Overview:
    """The boundary in brief, the material, and the condition of each name."""
    rows = tuple((name, condition_text(c)) for name, c in problem.conditions.items())
    return Overview(_title(problem), _facts(problem), ("name", "condition"), rows)


def flow_summary(solution: Any) -> Overview:
    """A solved flow: its problem in brief, and of each opening, or of each name where there are
    none, area, flow rate into the fluid and mean pressure, or the force of the fluid."""
    problem = solution.problem
    kinds = {name: type(c).__name__ for name, c in problem.conditions.items()}
    openings = [name for name, kind in kinds.items() if kind in DRIVES]
    areas = named_areas(solution.space.boundary)
    head: Row = ("opening", "condition", "area", "flow rate", "mean pressure")
    known = vars(solution).get("accuracy")  # it is not worked out for being printed
    rates = rounded(solution.flow_rate(name) for name in openings)
    pressures = rounded(solution.mean_pressure(name) for name in openings)
    if known is not None:
        rates, pressures = (
            [_within(v, known.error(kind, n)) for v, n in zip(values, openings, strict=True)]
            for kind, values in (("flow rate", rates), ("mean pressure", pressures))
        )
    rows: list[Row] = [
        (name, condition_text(problem.conditions[name]), f"{areas[name]:.4g}", rate, pressure)
        for name, rate, pressure in zip(openings, rates, pressures, strict=True)
    ]
    if not openings:
        head = ("name", "condition", "force of the fluid")
        rows = [(n, condition_text(c), numbers(solution.force(n))) for n, c in
                problem.conditions.items()]  # fmt: skip
    solved = f"solved in {solution.iterations} iterations" if solution.iterations else "solved"
    if solution.seconds:
        solved += f" in {solution.seconds:.1f} CPU s"
    return Overview(f"{_title(problem)}, {solved}", _facts(problem), head, tuple(rows))


def _within(value: str, error: float) -> str:
    """A number with its estimated error, if there is one."""
    return f"{value} ± {error:.1g}" if error > 0 else value


def heat_summary(solution: Any) -> Overview:
    """A solved conduction problem: its problem in brief, and of each name area, condition and the
    heat that enters."""
    areas = named_areas(solution.space.boundary)
    conditions = solution.problem.conditions
    rates = rounded(solution.heat_rate(name) for name in conditions)
    rows = [
        (name, condition_text(condition), f"{areas[name]:.4g}", rate)
        for (name, condition), rate in zip(conditions.items(), rates, strict=True)
    ]
    head = ("name", "condition", "area", "heat that enters")
    title = f"{_title(solution.problem)}, solved"
    return Overview(title, _facts(solution.problem), head, tuple(rows))


def condition_text(condition: Any) -> str:
    """A condition with those of its data that are given."""
    given = ", ".join(f"{k}={v!r}" for k, v in vars(condition).items() if v is not None)
    return brief(f"{type(condition).__name__}({given})")


def _title(problem: Any) -> str:
    kind = "Stokes flow" if hasattr(problem, "viscosity") else "Heat conduction"
    return f"{kind} in {problem.boundary.dimension}D: {source_text(problem.boundary)}"


def _facts(problem: Any) -> tuple[str, ...]:
    if hasattr(problem, "viscosity"):
        material = f"viscosity {problem.viscosity:.4g}"
    else:
        source = "no source" if problem.source is None else f"source {brief(problem.source)}"
        material = f"conductivity {problem.conductivity:.4g}, {source}"
    return (f"{material}, {brief(problem.quadrature)}", size_text(problem.boundary))
