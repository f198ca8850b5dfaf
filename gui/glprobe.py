"""Can VTK draw here? Without OpenGL it ends the process instead of raising, so a child process tries it first."""

import hashlib
import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

import platformdirs

_TRIAL = """
import sys
from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetShowWindow(False)
window.SetOffScreenRendering(1)
window.SetSize(16, 16)
renderer = vtkRenderer()
renderer.SetBackground(1, 0, 0)
window.AddRenderer(renderer)
window.Render()
sys.stdout.write("drawn" if tuple(window.GetSize()) == (16, 16) else "size")
sys.stdout.flush()
"""
NO_VTK = "The shapes cannot be drawn because VTK is not installed; in Concord's folder run: pip install '.[gui]' (or make setup)."
NO_GL = (
    "The shapes cannot be drawn because VTK finds no OpenGL on this computer; install the graphics driver or software"
    " rendering (Debian and Ubuntu: apt install libgl1 libegl1), then start Concord again."
)


def problem() -> str | None:
    """None where VTK can draw off screen; otherwise one sentence that says what to install.

    The first call on a machine takes a second or two; a good answer is kept in the user's cache folder until VTK, the
    display settings or the driver files change. A bad answer is never kept, so that an installation helps at once.
    """
    mark = _mark_file()
    if mark is not None and mark.exists():
        return None
    answer = trial()
    if answer is None and mark is not None:
        try:
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.touch()
        except OSError:
            pass  # a read-only home costs the next start two seconds
    return answer


def trial(timeout: float = 60.0) -> str | None:
    """Draw sixteen pixels in a child process; None if that worked, else the sentence."""
    try:
        child = subprocess.run([sys.executable, "-c", _TRIAL], capture_output=True, text=True, timeout=timeout)
    except (OSError, subprocess.TimeoutExpired):
        return NO_GL
    if child.returncode == 0 and child.stdout.strip().endswith("drawn"):
        return None
    return NO_VTK if "ModuleNotFoundError" in child.stderr else NO_GL


def _mark_file() -> Path | None:
    """Where a good answer is kept: its name is a hash of all that the answer depends on."""
    try:
        version = importlib.metadata.version("vtk")
    except importlib.metadata.PackageNotFoundError:
        return None
    settings = [os.environ.get(name, "") for name in
                ("DISPLAY", "WAYLAND_DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW", "LIBGL_ALWAYS_SOFTWARE")]  # fmt: skip
    word = "\0".join([version, sys.executable, *settings, *_driver_files()])
    folder = Path(os.environ.get("CONCORD_CACHE") or platformdirs.user_cache_dir("concord"))
    return folder / "graphics" / hashlib.sha256(word.encode()).hexdigest()[:24]


def _driver_files() -> list[str]:
    """Names and times of the OpenGL libraries, where they lie in the usual folders."""
    folders = ("/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib")
    names = ("libGL.so.1", "libEGL.so.1", "libOSMesa.so.8")
    found = [f for folder in folders for name in names if (f := Path(folder) / name).exists()]
    return [f"{f}:{f.stat().st_mtime_ns}" for f in found]
