"""What a workflow drew."""

from pathlib import Path

ENDINGS = {".png", ".gif", ".mp4", ".vtu"}


def pictures_in(folder: Path) -> set[str]:
    """Names of the pictures, movies and ParaView files in a run's folder itself."""
    return {path.name for path in folder.iterdir() if path.suffix in ENDINGS}
