"""Settings for tests of the window, made before Qt or VTK is imported: no screen is needed."""

import os

for _name, _value in (
    ("QT_QPA_PLATFORM", "offscreen"),
    ("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow"),
    ("QT_API", "pyside6"),
):
    os.environ.setdefault(_name, _value)
