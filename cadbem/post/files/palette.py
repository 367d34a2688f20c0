"""The 256 colours of an animated GIF, one choice for all its frames, so that nothing flickers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import cKDTree

COUNT = 256
EXACT = 48  # colours that are kept as they are, the most frequent ones
LEVELS = 64  # of red, green and blue that are told apart among the others


@dataclass(frozen=True, eq=False)
class Palette:
    """``colours`` (256, 3), and by ``places`` (64³,) the one to take for rounded colours."""

    colours: NDArray[np.uint8]
    places: NDArray[np.uint8]

    @staticmethod
    def of(images: Sequence[Image.Image], scale: NDArray[np.uint8] | None = None) -> Palette:
        """The most frequent colours, those of a colour ``scale`` (n, 3), and others wherever there
        are colours: a small body has as many shades as a large one."""
        kept = np.empty((0, 3), dtype=np.uint8) if scale is None else scale
        pixels = np.concatenate([np.asarray(image).reshape(-1, 3) for image in images])
        codes = pixels @ np.array([65536, 256, 1])
        found, counts = np.unique(codes, return_counts=True)
        ranked = found[np.argsort(-counts, kind="stable")]
        ranked = np.stack([ranked >> 16, ranked >> 8 & 255, ranked & 255], 1).astype(np.uint8)
        rest = COUNT - EXACT - len(kept)
        others = Image.fromarray(ranked[None]).quantize(rest).getpalette() or []
        colours = np.concatenate([ranked[:EXACT], kept, np.reshape(others, (-1, 3))[:rest]])
        levels = (np.indices((LEVELS,) * 3).reshape(3, -1).T + 0.5) * 256 / LEVELS
        places = cKDTree(colours).query(levels)[1]
        exact = ranked[:EXACT][::-1]  # the most frequent one of several last
        places[_rounded(exact)] = np.arange(len(exact))[::-1]
        return Palette(colours.astype(np.uint8), places.astype(np.uint8))

    def applied(self, image: Image.Image) -> Image.Image:
        """The image in the colours of the palette."""
        indexed = Image.fromarray(self.places[_rounded(np.asarray(image))])
        indexed.putpalette(self.colours.ravel().tolist())
        return indexed


def _rounded(pixels: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Places of colours (..., 3) among 64³."""
    return pixels // (256 // LEVELS) @ np.array([LEVELS**2, LEVELS, 1])
