"""States, checkpoints and shapes as HDF5, to the last bit."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from cadbem.boundary import Boundary, Patch
from cadbem.errors import ResultsError
from cadbem.files import write_whole
from cadbem.spline.basis import Array
from cadbem.spline.closed import ClosedBasis, ClosedSpline
from cadbem.spline.nurbs import Nurbs
from cadbem.suspension.bodies.body import Body
from cadbem.suspension.bodies.droplet import Droplet
from cadbem.suspension.bodies.particle import RigidParticle
from cadbem.suspension.rigid.pose import Pose
from cadbem.suspension.time.checkpoint import Checkpoint
from cadbem.suspension.time.simulation import Simulation
from cadbem.suspension.time.state import State
from cadbem.suspension.time.stepping import Lengths

Shape = ClosedSpline | Boundary
Fields = Mapping[int, Mapping[str, Array]]
COUNTS = ("time", "steps", "evaluations", "length", "drift", "stopped")


class Writing:
    """``with Writing(path) as file``: an HDF5 file that appears at once when the block ends."""

    def __init__(self, path: Path) -> None:
        self._path, self._memory = path, BytesIO()

    def __enter__(self) -> h5py.File:
        self._file = h5py.File(self._memory, "w")
        return self._file

    def __exit__(self, kind: object, *reference: object) -> None:
        self._file.close()
        if kind is None:
            write_whole(self._path, self._memory.getvalue())


def reading(path: Path) -> h5py.File:
    """The file, to read; raises ``ResultsError`` when it is missing or damaged."""
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise ResultsError(f"{path} is missing or damaged; start the run anew") from error


def write_state(place: h5py.Group, state: State) -> None:
    """Write a state, without its simulation."""
    for name in COUNTS:
        place.attrs[name] = getattr(state, name)
    place.attrs["left"] = json.dumps(state.left)
    place.attrs["numbers"] = np.array(state.numbers, dtype=np.int64)
    for number, body in zip(state.numbers, state.bodies, strict=True):
        _write_coordinates(place, f"body_{number}/coordinates", body)
    for k, guess in enumerate(state.guess):
        place[f"guess/{k}"] = guess


def _write_coordinates(place: h5py.Group, name: str, body: Body) -> None:
    """A body's coordinates; a droplet's with the basis that it has by then."""
    place[name] = body.coordinates
    if isinstance(body, Droplet):
        basis = body.shape.basis
        place[name].attrs.update(degree=basis.degree, points=basis.shape)


def _body(start: Body, coordinates: h5py.Dataset) -> Body:
    """A body with coordinates that were written, from what it was at the start."""
    if isinstance(start, Droplet):
        return start.moved(_spline(start.shape, coordinates))
    return start.at(coordinates[:])


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
        simulation.environment,
        bodies=tuple(_body(starts[n - 1], place[f"body_{n}/coordinates"]) for n in numbers),
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
        int(n): {k: v[:] for k, v in place[f"body_{n}"].items() if k != "coordinates"}
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

    def at(self, coordinates: h5py.Dataset) -> Shape:
        """The shape with a body's coordinates, as they were written."""
        if isinstance(self.shape, ClosedSpline):
            return _spline(self.shape, coordinates)
        assert self.centre is not None
        pose = Pose.of(coordinates[:], self.shape.dimension)
        return self.shape.transformed(pose.matrix, pose.position - pose.matrix @ self.centre)


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
