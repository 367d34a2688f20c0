"""Pictures one after the other into a movie file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from cadbem.errors import CadbemError
from cadbem.post.files.palette import Palette
from cadbem.progress import progress

PACE = 70  # milliseconds that a frame is shown
REST = 1500  # milliseconds that the last one of a GIF is shown, before it starts again
BLOCK = 16  # pixels: widths and heights that encoders of MP4 work with are multiples
QUALITY = 7  # of 10, of MP4: lines and letters stay sharp


@dataclass(frozen=True, eq=False)
class Shots:
    """``count`` pictures that are drawn one at a time, for the movie ``name``; colours
    (n, 3) of the ``scale`` in them, if there is one, which a GIF has to keep."""

    name: str
    count: int
    take: Callable[[int], Image.Image]
    scale: NDArray[np.uint8] | None = None

    def __iter__(self) -> Iterator[Image.Image]:
        return map(self.take, progress(range(self.count), self.name))


def encoder(target: Path) -> Callable[[Path, Shots], None]:
    """The writer of a movie in the format of the ending.

    Raises ``CadbemError`` for endings other than .mp4 and .gif, and without an encoder.
    """
    if target.suffix == ".gif":
        return _write_gif
    if target.suffix != ".mp4":
        raise CadbemError(f"{target}: a movie is written to a file that ends in .mp4 or .gif")
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError) as error:
        raise CadbemError(
            f"{target}: there is no encoder for MP4; type: pip install imageio-ffmpeg, "
            "or write a file that ends in .gif"
        ) from error
    return _write_mp4


def _write_gif(target: Path, shots: Shots) -> None:
    last = shots.count - 1
    palette = Palette.of([shots.take(k) for k in sorted({0, (last + 1) // 2, last})], shots.scale)
    images = map(palette.applied, shots)
    first = next(images)
    times = [PACE] * last + [REST]
    first.save(target, save_all=True, append_images=images, duration=times, loop=0)


def _write_mp4(target: Path, shots: Shots) -> None:
    import imageio_ffmpeg

    writer = None
    for image in shots:
        pixels = _in_blocks(np.asarray(image))
        if writer is None:
            size = pixels.shape[1], pixels.shape[0]
            writer = imageio_ffmpeg.write_frames(
                str(target), size, fps=1000 / PACE, quality=QUALITY, macro_block_size=BLOCK
            )
            writer.send(None)
        writer.send(pixels)
    if writer is not None:
        writer.close()


def _in_blocks(pixels: np.ndarray) -> np.ndarray:
    """A picture with white added on the right and below up to whole blocks."""
    height, width = pixels.shape[:2]
    room = [(0, -height % BLOCK), (0, -width % BLOCK), (0, 0)]
    return np.ascontiguousarray(np.pad(pixels, room, constant_values=255))
