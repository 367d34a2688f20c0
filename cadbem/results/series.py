"""Every scalar measure of a state: rows of the tables ``run.csv`` and ``bodies.csv``."""

from __future__ import annotations

from typing import Any

from cadbem.post.fields.frames import Frame
from cadbem.spline.basis import Array
from cadbem.suspension.bodies.droplet import Droplet, PlacedDroplet
from cadbem.suspension.bodies.particle import RigidParticle
from cadbem.suspension.interface.resolution import Resolution
from cadbem.suspension.multibody.measures import Measures
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.state import State

Row = dict[str, Any]
AXES = "xyz"
SCALARS = (
    "volume", "area", "deformation", "inclination", "longest", "shortest", "inertia_deformation",
    "power", "dissipation", "smallest_angle", "size_ratio",
)  # fmt: skip


def run_row(state: State, seconds: float) -> Row:
    """The whole: time, steps so far, mean pressure and flow rate at each opening of a channel;
    ``seconds`` of CPU time spent on the run, without its pauses."""
    row: Row = {
        "time": state.time,
        "bodies": len(state.numbers),
        "steps": state.steps,
        "evaluations": state.evaluations,
        "step_length": state.length,
        "volume_drift": state.drift,
        "iterations": max((r.iterations for r in state.responses), default=0),
        "cpu_seconds": seconds,
    }
    flow = state.flow
    if isinstance(flow, ChannelFlow):
        for name in flow.problem.openings:
            row[f"pressure {name}"] = state.walls.mean_pressure(name)
            row[f"flow_rate {name}"] = state.walls.flow_rate(name)
    return row


def body_rows(state: State) -> list[Row]:
    """A row for each body."""
    measures, resolutions = iter(state.measures), state.resolutions
    parts = zip(state.numbers, state.bodies, state.responses, state.velocities, strict=True)
    rows = []
    for number, body, response, velocity in parts:
        row: Row = {
            "time": state.time,
            "body": number,
            "kind": "droplet" if isinstance(body, Droplet) else "particle",
            **_vector("", body.centre),
            "gap": state.gap(number),
            **_vector("velocity_", velocity),
        }
        if isinstance(body, Droplet):
            shape = _droplet(next(measures)) | _points(body, resolutions[number])
        else:
            shape = _particle(body, response)
        rows.append(row | shape)
    return rows


def _droplet(found: Measures) -> Row:
    row: Row = {name: getattr(found, name) for name in SCALARS}
    for k, length in enumerate(found.semi_axes, 1):
        row[f"semi_axis_{k}"] = float(length)
    return row


def _points(body: Droplet, found: Resolution) -> Row:
    """Their number, by how much the surface may be displaced, and the net flux through it."""
    row: Row = {"points": body.shape.basis.count, "uncertainty": found.uncertainty}
    return row | {"net_flux": found.flux}


def _particle(body: Any, response: Any) -> Row:
    spin = response.angular_velocity
    row = _vector("angular_velocity_", spin) if len(spin) == 3 else {"angular_velocity": spin[0]}
    turn = body.pose.turn
    if len(turn) == 1:
        return row | {"turn": float(turn[0])}
    return row | {f"turn_{axis}": float(v) for axis, v in zip("xyzw", turn, strict=True)}


def _vector(name: str, values: Array) -> Row:
    return {f"{name}{axis}": float(value) for axis, value in zip(AXES, values, strict=False)}


def frame_of(state: State) -> Frame:
    """The bodies with velocity and jump of the traction, or the traction of a particle, for
    pictures and ParaView: coefficients."""
    fields = {}
    parts = zip(state.numbers, state.bodies, state.placed, state.responses, strict=True)
    for number, body, placed, response in parts:
        if isinstance(body, RigidParticle):
            fields[number] = {"traction": body.pose.matrix @ response.traction.coefficients}
        elif isinstance(placed, PlacedDroplet):
            layers, basis = placed.layers, placed.body.shape.basis
            jump = response.jump(layers.targets).reshape(-1, *basis.shape)
            fields[number] = {"velocity": response.velocity, "traction jump": basis.fit(jump)}
    return Frame(state.time, state.shapes, fields)
