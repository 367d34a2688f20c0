"""The survey of a CAD file, face by face: its patches, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cadbem.boundary import Boundary, Patch
from cadbem.cad.body.between import Pick
from cadbem.cad.body.model import CadModel, open_model
from cadbem.cad.layout.face_patches import TOLERANCE
from cadbem.cad.read import check_crossings, oriented
from cadbem.errors import CadError
from cadbem.progress import progress


@dataclass(frozen=True, eq=False)
class CadSurvey:
    """The result for each face of `model`, by number; lengths in the file's unit.

    A face is in `patches` and `deviations` (largest distance of its patches from it), or in
    `refused` with the reason. `boundary` has all patches, turned into the fluid if they enclose
    one. `problems` are lines as in `CadReport`; there are none if `read_cad` works.
    """

    model: CadModel
    patches: dict[int, list[Patch]]
    deviations: dict[int, float]
    refused: dict[int, str]
    boundary: Boundary
    problems: tuple[str, ...]

    def complaints(self) -> list[str]:
        """A line for each defective face: which one it is, and what is wrong with it."""
        faces = {face.number: face for face in self.model.faces}
        reasons = self.model.defective_faces()
        lines = {n: f"{self.model.label(faces[n])}: {reason}" for n, reason in reasons.items()}
        return [line for _, line in sorted((lines | self.refused).items())]


def survey_cad(
    path: str | Path,
    *,
    fluid: int | str = "solid",
    between: Sequence[Pick] = (),
    names: str = "names",
    tolerance: float = TOLERANCE,
    sew: float = 0.0,
    time_limit: float = 60.0,
) -> CadSurvey:
    """Try to lay patches on every face of a STEP or IGES file; arguments as for `read_cad`.

    Raises CadError only if the file cannot be read at all or has no faces.
    """
    model = open_model(path, time_limit, names, fluid, between, sew)
    patches: dict[int, list[Patch]] = {}
    deviations: dict[int, float] = {}
    refused: dict[int, str] = {}
    for face in progress(model.faces, f"{model.file}: faces"):
        try:
            patches[face.number], deviations[face.number] = model.patches(face, tolerance)
        except CadError as error:
            refused[face.number] = str(error)
    everything = tuple(patch for group in patches.values() for patch in group)
    boundary = Boundary(everything, model.file, model.unit.name)
    problems = [*model.obstacles(), *(f"{model.file}: {reason}" for reason in refused.values())]
    if not problems:
        try:
            boundary = oriented(boundary)
            check_crossings(model, boundary)
        except CadError as error:
            problems.append(str(error))
    return CadSurvey(model, patches, deviations, refused, boundary, tuple(problems))
