"""Off-screen rendering: the check whether it is possible, and the settings of pyvista.

VTK draws without a screen through EGL or OSMesa.  When neither is installed it ends the process
with a segmentation fault instead of an error, so the libraries are tried out first.
"""

from __future__ import annotations

import ctypes
import os
from typing import Any

from cadbem.errors import DisplayError

REMEDY = "apt-get install libegl1 libgl1"
EGL, OPENGL = "libEGL.so.1", "libGL.so.1"
OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


def require_display() -> None:
    """Make sure that pictures can be drawn off screen, before anything of VTK is loaded.

    Raises ``DisplayError``, which names the missing system library and the remedy.
    """
    if _loads(EGL):
        if not _loads(OPENGL):
            raise DisplayError(_message(OPENGL))
        window = "vtkEGLRenderWindow"
    elif any(map(_loads, OSMESA)):
        window = "vtkOSOpenGLRenderWindow"
    else:
        raise DisplayError(_message(f"{EGL} (or libOSMesa)"))
    # without this VTK tries X11 first and complains on stderr that there is no screen
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", window)


def load_pyvista() -> Any:
    """The ``pyvista`` module, set to draw off screen; raises ``DisplayError`` if it cannot."""
    require_display()
    import pyvista

    pyvista.OFF_SCREEN = True
    return pyvista


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _message(library: str) -> str:
    return f"cannot draw pictures: the system library {library} is missing; type: {REMEDY}"
