"""One droplet's response, for tests that bring their own layers."""

from cadbem.operators.closed.layers import ClosedLayers
from cadbem.suspension.bodies.droplet import Droplet, PlacedDroplet, Response
from cadbem.suspension.multibody.multibody import velocity_responses
from cadbem.suspension.surroundings.surroundings import Surroundings


def alone(flow: Surroundings, droplet: Droplet, layers: ClosedLayers) -> Response:
    return velocity_responses(flow, [PlacedDroplet(droplet, layers)])[0]
