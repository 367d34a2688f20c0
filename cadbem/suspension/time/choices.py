"""What the accuracy that is asked of a run chooses."""

from __future__ import annotations

from dataclasses import dataclass

from cadbem.checks import within
from cadbem.suspension.interface.points import AdaptivePoints
from cadbem.suspension.multibody.contact import Contact, StopAtError, StopAtGap
from cadbem.suspension.multibody.elements import AdaptiveElements
from cadbem.suspension.time.stepping import Adaptive, Stepper

FINEST, COARSEST = 1e-6, 0.1


@dataclass(frozen=True)
class Choices:
    """How time goes on, when a narrow gap ends a run, and whether the points of droplets and the
    elements of walls and particles are chosen anew."""

    stepper: Stepper
    contact: Contact
    points: AdaptivePoints | None
    elements: AdaptiveElements | None


def choices(
    accuracy: float | None,
    stepper: Stepper | None,
    contact: Contact | None,
    points: AdaptivePoints | None,
) -> Choices:
    """What is given, and for the rest what goes with the accuracy.

    Raises InputError for an accuracy that is not between 1e-6 and 0.1.
    """
    if accuracy is None:
        return Choices(
            Adaptive() if stepper is None else stepper,
            StopAtGap() if contact is None else contact,
            points,
            None,
        )
    within("accuracy", accuracy, FINEST, COARSEST)
    return Choices(
        Adaptive(accuracy) if stepper is None else stepper,
        StopAtError() if contact is None else contact,
        AdaptivePoints(accuracy) if points is None else points,
        AdaptiveElements.for_accuracy(accuracy),
    )
