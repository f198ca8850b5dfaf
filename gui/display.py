"""Can Qt open a window here? It ends the process where it cannot, so what it needs is looked at first."""

import ctypes
import importlib.util
import os
import sys
from collections.abc import Mapping

NO_GUI = "The window needs more packages; in Concord's folder run: pip install '.[gui]' (or make setup)."
NO_DISPLAY = (
    "There is no display to open a window on; run concord on a desktop (or under xvfb-run), "
    "or use it without a window: concord match --help."
)
X_LIBRARIES = {
    "libxcb-cursor.so.0": "libxcb-cursor0", "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-keysyms.so.1": "libxcb-keysyms1", "libxcb-shape.so.0": "libxcb-shape0", "libxcb-xkb.so.1": "libxcb-xkb1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
}  # fmt: skip


def problem() -> str | None:
    """One sentence that says what keeps a window from opening, or None."""
    if missing_packages():
        return NO_GUI
    try:
        import PySide6.QtWidgets  # noqa: F401
    except ImportError as error:
        return (f"The window cannot open because a system library is missing ({error}); on Debian and Ubuntu run: "
                "apt install libgl1 libegl1 libglib2.0-0 libfontconfig1 libdbus-1-3 libxkbcommon0.")  # fmt: skip
    return display_problem(os.environ) if sys.platform.startswith("linux") else None


def missing_packages() -> list[str]:
    """Names of the Python packages of the window that are not installed."""
    return [name for name in ("PySide6", "vtkmodules", "qtawesome") if importlib.util.find_spec(name) is None]


def display_problem(environment: Mapping[str, str]) -> str | None:
    """What is wrong with the display that these variables name, on Linux."""
    platform = environment.get("QT_QPA_PLATFORM", "")
    if platform.split(":")[0] in ("offscreen", "minimal", "vnc", "linuxfb", "eglfs"):
        return None
    if environment.get("WAYLAND_DISPLAY") and not platform.startswith("xcb"):
        return None
    if not environment.get("DISPLAY"):
        return NO_DISPLAY
    missing = [package for library, package in X_LIBRARIES.items() if not _loads(library)]
    if missing:
        return f"The window cannot open because libraries of X are missing; run: apt install {' '.join(missing)}."
    if not _answers(environment["DISPLAY"]):
        return f"The display {environment['DISPLAY']} does not answer; check the variable DISPLAY. {NO_DISPLAY}"
    return None


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _answers(display: str) -> bool:
    """Whether an X server takes a connection; True where that cannot be asked."""
    try:
        xcb = ctypes.CDLL("libxcb.so.1")
    except OSError:
        return True
    xcb.xcb_connect.restype = ctypes.c_void_p
    connection = ctypes.c_void_p(xcb.xcb_connect(display.encode(), None))
    bad = xcb.xcb_connection_has_error(connection)
    xcb.xcb_disconnect(connection)
    return bad == 0
