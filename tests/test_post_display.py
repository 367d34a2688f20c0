"""Missing system libraries are noticed before VTK is loaded."""

import ctypes
import os

import pytest

from cadbem.errors import DisplayError
from cadbem.post import require_display


def pretend(monkeypatch, *installed):
    """Let only these libraries load."""

    def load(name, *_, **__):
        if not name.startswith(installed):
            raise OSError(name)
        return object()

    monkeypatch.setattr(ctypes, "CDLL", load)
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW", raising=False)


def test_nothing_installed(monkeypatch):
    pretend(monkeypatch, "none of them")
    with pytest.raises(DisplayError, match=r"libEGL\.so\.1.*apt-get install libegl1") as caught:
        require_display()
    assert "\n" not in str(caught.value)


def test_opengl_missing(monkeypatch):
    pretend(monkeypatch, "libEGL")
    with pytest.raises(DisplayError, match=r"libGL\.so\.1 is missing.*apt-get install"):
        require_display()


@pytest.mark.parametrize(
    ("installed", "window"),
    [(("libEGL", "libGL"), "vtkEGLRenderWindow"), (("libOSMesa",), "vtkOSOpenGLRenderWindow")],
)
def test_window_without_a_screen(monkeypatch, installed, window):
    pretend(monkeypatch, *installed)
    require_display()
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"] == window
