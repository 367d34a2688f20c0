"""The pose of a rigid body: its position and orientation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from cadbem.spline.basis import Array

ROUNDING = 1e-15  # a length of 1 within this is 1


@dataclass(frozen=True, eq=False)
class Pose:
    """The ``position`` (dim,) of a body's centre, and its ``turn`` from how it was drawn.

    The turn is a unit quaternion (x, y, z, w); in a plane the angle (1,), counter-clockwise.
    """

    position: Array
    turn: Array

    @classmethod
    def of(cls, coordinates: Array, dimension: int) -> Pose:
        """From flat coordinates; a quaternion need not be of unit length.

        One that is, but for rounding, stays as it is: stored poses come back to the last bit.
        """
        turn = coordinates[dimension:]
        if dimension == 3 and abs((length := float(np.linalg.norm(turn))) - 1.0) > ROUNDING:
            turn = turn / length
        return cls(coordinates[:dimension], turn)

    @property
    def coordinates(self) -> Array:
        """Both in one array."""
        return np.concatenate([self.position, self.turn])

    @property
    def matrix(self) -> Array:
        """Rotation (dim, dim) from the body's axes to the world's."""
        if len(self.position) == 3:
            return Rotation.from_quat(self.turn).as_matrix()
        cosine, sine = np.cos(self.turn[0]), np.sin(self.turn[0])
        return np.array([[cosine, -sine], [sine, cosine]])

    def rate(self, velocity: Array, angular_velocity: Array) -> Array:
        """Rate of the coordinates: q' = (ω, 0) q / 2 for a quaternion."""
        if len(self.position) == 2:
            return np.concatenate([velocity, angular_velocity])
        vector, scalar = self.turn[:3], self.turn[3]
        change = scalar * angular_velocity + np.cross(angular_velocity, vector)
        return np.concatenate([velocity, 0.5 * change, [-0.5 * angular_velocity @ vector]])


def unturned(position: Array) -> Pose:
    """A pose without a turn."""
    return Pose(position, np.eye(4)[3] if len(position) == 3 else np.zeros(1))


def rigid_motions(arm: Array) -> Array:
    """Unit translations and rotations at ``arm`` (dim, N) from the centre: (3 or 6, dim, N)."""
    dim = len(arm)
    shifts = np.broadcast_to(np.eye(dim)[:, :, None], (dim, *arm.shape))
    if dim == 2:
        return np.concatenate([shifts, [np.stack([-arm[1], arm[0]])]])
    turns = [np.cross(axis, arm, axisa=0, axisb=0, axisc=0) for axis in np.eye(3)]
    return np.concatenate([shifts, turns])
