"""Round pipes of radius 1 along x, with their middle at the origin."""

import numpy as np
from shapes import ARC, ARC_WEIGHTS, LINEAR, QUADRATIC

import cadbem as cb
from cadbem.boundary import Boundary, Patch
from cadbem.spline import Nurbs
from cadbem.spline.shapes import cylinder


def ends(half_length):
    """Both ends of a pipe, four quarters each that meet in the centre."""
    rim = np.insert(ARC, 0, 0.0, axis=1)
    points, weights = np.stack([0 * rim, rim]), np.stack([ARC_WEIGHTS] * 2)
    quarter = Nurbs((1, 2), (LINEAR, QUADRATIC), points, weights)
    quarter = quarter.elevated((4, 4)).inserted([[1 / 3, 2 / 3], []])
    shift, patches = np.array([half_length, 0, 0]), []
    for cosine, sine in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        turn = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
        patches.append(Patch(quarter.transformed(turn, -shift), "inlet"))
        patches.append(Patch(quarter.transformed(turn, shift).swapped(), "outlet"))
    return patches


def pipe(half_length=4.0, size=1.0, fine_to=2.0, outer=0.7):
    """Elements of a ``size`` along the wall for |x| < ``fine_to``, about ``outer`` beyond."""
    fine = np.linspace(-fine_to, fine_to, int(np.ceil(2 * fine_to / size)) + 1)
    rest = np.linspace(fine_to, half_length, int(np.ceil((half_length - fine_to) / outer)) + 1)
    places = np.concatenate([-rest[:0:-1], fine, rest[1:]])
    along = (places[1:-1] + half_length) / (2 * half_length)
    side = cylinder(1.0, 2 * half_length, (-half_length, 0, 0))
    wall = [Patch(s.elevated((4, 4)).inserted([along, [0.5]]), "wall") for s in side]
    return Boundary((*wall, *ends(half_length)))


def flow_in(boundary):
    """Flow of mean velocity 1 and viscosity 1 through a pipe."""
    conditions = {"wall": cb.NoSlip(), "inlet": cb.Inflow(mean_velocity=1.0)}
    problem = cb.StokesProblem(boundary, 1.0, conditions | {"outlet": cb.Pressure(0.0)})
    return cb.ChannelFlow(problem)
