"""One droplet's response, for tests that bring their own layers."""

from cadbem.operators.closed import ClosedLayers
from cadbem.suspension.droplet import Droplet, PlacedDroplet, Response
from cadbem.suspension.surroundings import Surroundings
from cadbem.suspension.together import respond_together


def alone(flow: Surroundings, droplet: Droplet, layers: ClosedLayers) -> Response:
    return respond_together(flow, [PlacedDroplet(droplet, layers)])[0]
