"""What simulations, states and histories say of themselves when they are printed."""

from __future__ import annotations

from typing import Any

from cadbem.overviews import size_text, source_text
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.tables import Overview, Row, brief, count, numbers

HEAD = ("body", "kind", "centre", "size")


def state_overview(state: Any) -> Overview:
    """Time, what the bodies are in, bodies with their centres, and what became of the run."""
    bodies = tuple(_row(number, b) for number, b in zip(state.numbers, state.bodies, strict=True))
    title = f"State at time {state.time:g}, {count(len(bodies), 'body')}"
    steps = f"{state.steps} steps, {state.evaluations} evaluations"
    gone = [brief(text) for text in state.left.values()][:3]
    stopped = f"ended: {brief(state.stopped)}" if state.stopped else ""
    return Overview(title, (flow_text(state.flow), steps, *gone, stopped), HEAD, bodies)


def history_overview(history: Any) -> Overview:
    """Its times, its bodies where they are at last, and how it ended."""
    last, times = history.last, history.times
    title = f"History: {count(len(times), 'state')} from time {times[0]:g} to {times[-1]:g}"
    view = state_overview(last)
    seconds = f"{history.seconds:.0f} CPU s"
    return Overview(title, (*view.facts, seconds), HEAD, view.rows)


def simulation_overview(simulation: Any) -> Overview:
    """What the bodies are in, how time goes on, and the bodies at the beginning."""
    start = simulation.start
    rows = tuple(_row(number, b) for number, b in zip(start.numbers, start.bodies, strict=True))
    repairs = [type(r).__name__ for r in (simulation.volume, simulation.mesh) if r is not None]
    facts = (
        flow_text(simulation.flow),
        f"{brief(simulation.choices.stepper)}, {brief(simulation.choices.contact)}",
        f"points move by {getattr(simulation.motion, '__name__', 'a rule')}, "
        f"repaired by {', '.join(repairs) or 'nothing'}",
    )
    return Overview(f"Simulation of {count(len(rows), 'body')}", facts, HEAD, rows)


def flow_text(flow: Any) -> str:
    """What bodies are in, on one line."""
    problem = getattr(flow, "problem", None)
    if problem is not None:
        return f"in a channel: {source_text(problem.boundary)}, {size_text(problem.boundary)}"
    return f"in unbounded fluid of viscosity {flow.viscosity:g}"


def _row(number: int, body: Any) -> Row:
    kind = "droplet" if isinstance(body, Droplet) else "particle"
    return (f"{number}", kind, numbers(body.centre), f"{body.size:.4g}")
