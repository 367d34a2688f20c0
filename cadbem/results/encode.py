"""States, checkpoints and shapes as HDF5, to the last bit."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import astuple, dataclass, replace
from typing import Any

import h5py
import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.elements.pieces import Pieces
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline
from cadbem.spline.nurbs import Nurbs
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.bodies.particle import RigidParticle
from cadbem.suspension.multibody.environment import Environment
from cadbem.suspension.rigid.pose import Pose
from cadbem.suspension.surroundings.channel_flow import ChannelFlow
from cadbem.suspension.time.checkpoint import Checkpoint
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Lengths

Shape = ClosedSpline | Boundary
Fields = Mapping[int, Mapping[str, Array]]
ELEMENTS = "elements"
GEOMETRY = ("coordinates", ELEMENTS)
COUNTS = ("time", "steps", "evaluations", "length", "error", "drift", "stopped")


def write_state(place: h5py.Group, state: State) -> None:
    """Write a state, without its simulation."""
    for name in COUNTS:
        place.attrs[name] = getattr(state, name)
    place.attrs["left"] = json.dumps(state.left)
    place.attrs["numbers"] = np.array(state.numbers, dtype=np.int64)
    if isinstance(state.flow, ChannelFlow):
        _write_pieces(place, state.flow.pieces)
    for number, body in zip(state.numbers, state.bodies, strict=True):
        _write_coordinates(place.create_group(f"body_{number}"), body)
    for k, guess in enumerate(state.guess):
        place[f"guess/{k}"] = guess


def _write_coordinates(place: h5py.Group, body: Body) -> None:
    """A body's coordinates; a droplet's with the basis that it has by then, a particle's with its
    elements."""
    place["coordinates"] = body.coordinates
    if isinstance(body, Droplet):
        basis = body.shape.basis
        place["coordinates"].attrs.update(degree=basis.degree, points=basis.shape)
    elif isinstance(body, RigidParticle):
        _write_pieces(place, body.pieces)


def _write_pieces(place: h5py.Group, pieces: Pieces | None) -> None:
    """Elements that were chosen anew."""
    if pieces is not None:
        part = place.create_group(ELEMENTS)
        part["patch"], part["box"], part["degree"] = pieces.patch, pieces.box, pieces.degree


def _pieces(place: h5py.Group) -> Pieces | None:
    """The elements that were written, if they were."""
    part = place.get(ELEMENTS, None)
    if part is None:
        return None
    return Pieces(part["patch"][:], part["box"][:], part["degree"][:])


def _body(start: Body, place: h5py.Group) -> Body:
    """A body as it was written, from what it was at the start."""
    if isinstance(start, Droplet):
        return start.moved(_spline(start.shape, place["coordinates"]))
    if isinstance(start, RigidParticle) and (pieces := _pieces(place)) is not None:
        start = start.with_pieces(pieces)
    return start.at(place["coordinates"][:])


def _environment(place: h5py.Group, start: Environment) -> Environment:
    """The surroundings on the elements that were written."""
    pieces = _pieces(place)
    if pieces is None or not isinstance(start.flow, ChannelFlow):
        return start
    return replace(start, flow=start.flow.with_pieces(pieces))


def _spline(start: ClosedSpline, coordinates: h5py.Dataset) -> ClosedSpline:
    """A spline with coordinates that were written, on the basis that was written with them.

    The basis of the start is kept where it is the same, with the tables that it has."""
    basis = start.basis
    if "points" in coordinates.attrs:
        shape = tuple(int(n) for n in coordinates.attrs["points"])
        written = ClosedBasis(int(coordinates.attrs["degree"]), shape)
        basis = basis if written == basis else written
    return ClosedSpline(basis, coordinates[:].reshape(start.dimension, *basis.shape))


def read_state(place: h5py.Group, simulation: Simulation) -> State:
    """The state of a simulation."""
    numbers = tuple(int(n) for n in place.attrs["numbers"])
    starts = simulation.start.bodies
    guess = place.get("guess", {})
    return State(
        _environment(place, simulation.environment),
        bodies=tuple(_body(starts[n - 1], place[f"body_{n}"]) for n in numbers),
        numbers=numbers,
        left={int(n): text for n, text in json.loads(place.attrs["left"]).items()},
        guess=tuple(guess[str(k)][:] for k in range(len(guess))),
        **{name: _plain(place.attrs[name]) for name in COUNTS},
    )


def write_checkpoint(place: h5py.Group, checkpoint: Checkpoint) -> None:
    """A checkpoint, from which the run can go on."""
    write_state(place.create_group("state"), checkpoint.state)
    place["slope"] = checkpoint.slope
    place.attrs["lengths"] = astuple(checkpoint.lengths)


def read_checkpoint(place: h5py.Group, simulation: Simulation) -> Checkpoint:
    """The checkpoint of a simulation."""
    state = read_state(place["state"], simulation)
    lengths = Lengths(*(float(length) for length in place.attrs["lengths"]))
    return Checkpoint(state, place["slope"][:], lengths)


def write_fields(place: h5py.Group, fields: Fields) -> None:
    """Coefficients of fields on bodies, by number and name."""
    for number, values in fields.items():
        for name, coefficients in values.items():
            place[f"body_{number}/{name}"] = coefficients


def read_fields(place: h5py.Group) -> dict[int, dict[str, Array]]:
    """The fields that were written, by number and name of the body."""
    return {
        int(n): {k: v[:] for k, v in place[f"body_{n}"].items() if k not in GEOMETRY}
        for n in place.attrs["numbers"]
    }


@dataclass(frozen=True, eq=False)
class ReferenceShape:
    """The shape of a body before its coordinates are applied: a ``shape``, and the ``centre`` about
    which a rigid one turns, None for a droplet."""

    shape: Shape
    centre: Array | None = None

    @classmethod
    def of(cls, body: Body) -> ReferenceShape:
        """The reference shape of a droplet or particle."""
        if isinstance(body, RigidParticle):
            return cls(body.shape, body.resistance.centre)
        return cls(body.shape)  # type: ignore[attr-defined]

    def at(self, place: h5py.Group) -> Shape:
        """The shape of a body as it was written."""
        coordinates = place["coordinates"]
        if isinstance(self.shape, ClosedSpline):
            return _spline(self.shape, coordinates)
        assert self.centre is not None
        pose, pieces = Pose.of(coordinates[:], self.shape.dimension), _pieces(place)
        shape = self.shape if pieces is None else pieces.of(self.shape)
        return shape.transformed(pose.matrix, pose.position - pose.matrix @ self.centre)


def write_reference_shape(place: h5py.Group, reference: ReferenceShape) -> None:
    """Write a reference shape."""
    if isinstance(reference.shape, ClosedSpline):
        place.attrs["degree"] = reference.shape.basis.degree
        place["coefficients"] = reference.shape.coefficients
    else:
        write_boundary(place, reference.shape)
        place["centre"] = reference.centre


def read_reference_shape(place: h5py.Group) -> ReferenceShape:
    """The reference shape that was written."""
    if "coefficients" in place:
        coefficients = place["coefficients"][:]
        basis = ClosedBasis(int(place.attrs["degree"]), coefficients.shape[1:])
        return ReferenceShape(ClosedSpline(basis, coefficients))
    return ReferenceShape(read_boundary(place), place["centre"][:])


def write_boundary(place: h5py.Group, boundary: Boundary) -> None:
    """Patches with their names."""
    place.attrs.update(source=boundary.source, unit=boundary.unit, patches=len(boundary.patches))
    for i, patch in enumerate(boundary.patches):
        part = place.create_group(f"patch_{i}")
        part.attrs.update(name=patch.name, face=patch.face, port=patch.port)
        part.attrs["degrees"] = patch.surface.degrees
        part["points"], part["weights"] = patch.surface.points, patch.surface.weights
        for d, knots in enumerate(patch.surface.knots):
            part[f"knots_{d}"] = knots


def read_boundary(place: h5py.Group) -> Boundary:
    """The boundary that was written."""
    patches = tuple(_patch(place[f"patch_{i}"]) for i in range(place.attrs["patches"]))
    return Boundary(patches, place.attrs["source"], place.attrs["unit"])


def _patch(part: h5py.Group) -> Patch:
    degrees = tuple(int(degree) for degree in part.attrs["degrees"])
    knots = tuple(part[f"knots_{d}"][:] for d in range(len(degrees)))
    surface = Nurbs(degrees, knots, part["points"][:], part["weights"][:])
    port = bool(part.attrs.get("port", False))
    return Patch(surface, part.attrs["name"], int(part.attrs["face"]), port)


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else value
