"""One shape in one off-screen VTK window, drawn only when something changed and read back as an image."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the drawing back end)
from PySide6.QtGui import QImage
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import (
    VTK_FLOAT,
    reference,
    vtkFloatArray,
    vtkLogger,
    vtkPoints,
    vtkUnsignedCharArray,
)
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkLight,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
)
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

from ..palette import Theme, rgb
from .cameras import VIEW_ANGLE, Camera
from .scene import Scene, borders, colour_groups

# Without a display VTK warns that it falls back from X to EGL; only its errors are worth a line.
vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)

_HIDDEN_BY = 0.02
_SAMPLES_STILL = 4
_AMBIENT, _DIFFUSE = 0.38, 0.74
_THROUGH, _FOREMOST = 0.24, -65_000.0


class Surface(NamedTuple):
    """A scene with what VTK needs of it: the surface with its normals, and the tree that rays are cast through."""

    scene: Scene
    shown: vtkPolyData
    locator: vtkStaticCellLocator


def surface_of(scene: Scene) -> Surface:
    """A scene made ready for a pane; needs no graphics, so it may be called in a thread. Serves one pane only."""
    surface, locator, normals = _surface(scene.points, scene.faces), vtkStaticCellLocator(), vtkPolyDataNormals()
    locator.SetDataSet(surface)
    locator.BuildLocator()
    normals.SetInputData(surface)
    normals.SetFeatureAngle(38.0)
    normals.ConsistencyOff()
    normals.Update()
    return Surface(scene, normals.GetOutput(), locator)


class Pane:
    """An off-screen picture of a shape that can be turned and picked.

    Positions are in device pixels from the upper left corner. `close` must be called before the owner goes.
    """

    def __init__(self, theme: Theme) -> None:
        self.scene: Scene | None = None
        self._size, self._dirty, self._moving = (0, 0), True, False
        self._image: QImage | None = None
        self._depth: np.ndarray | None = None
        self._colours: np.ndarray | None = None
        self._actor, self._border = vtkActor(), vtkActor()
        self._hidden, self._through = vtkActor(), ((), None)
        self._rgb = vtkUnsignedCharArray()
        self._locator = vtkStaticCellLocator()
        self._start_window()
        self.set_theme(theme)

    def _start_window(self) -> None:
        self.renderer, self.window = vtkRenderer(), vtkRenderWindow()
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(0.35, 0.6, 1.0)
        self.renderer.AddLight(light)
        self.window.SetShowWindow(False)
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(_SAMPLES_STILL)
        self.window.SetAlphaBitPlanes(1)
        self.window.AddRenderer(self.renderer)
        self.renderer.GetActiveCamera().SetViewAngle(VIEW_ANGLE)
        self.interactor = vtkGenericRenderWindowInteractor()
        self.interactor.SetRenderWindow(self.window)
        self.interactor.EnableRenderOff()
        self.interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
        self.interactor.Enable()

    # --- what is shown

    def set_scene(self, surface: Scene | Surface) -> None:
        """Show a shape; its colours come with `set_colours`."""
        scene, shown, self._locator = surface if isinstance(surface, Surface) else surface_of(surface)
        self.scene, self._colours, self._through = scene, None, ((), None)
        self.renderer.RemoveAllViewProps()
        self._rgb = vtkUnsignedCharArray()
        self._rgb.SetNumberOfComponents(3)
        self._rgb.SetNumberOfTuples(len(scene.faces))
        shown.GetCellData().SetScalars(self._rgb)
        self._actor = _actor(shown)
        self._border = _actor(vtkPolyData())
        self._border.GetProperty().SetLighting(False)
        self.renderer.AddViewProp(self._actor)
        self._hidden = _actor(vtkPolyData())
        self.renderer.AddViewProp(self._border)
        self.renderer.AddViewProp(self._hidden)
        self._dirty = True

    def show_through(self, segments: Sequence[int], colour: np.ndarray | None = None) -> None:
        """Let segments shine faintly through whatever hides them, in a colour (3,) uint8; none of them ends it."""
        wanted = (tuple(segments), None if colour is None else tuple(np.asarray(colour).tolist()))
        if self.scene is None or wanted == self._through:
            return
        self._through = wanted
        rows = np.isin(self.scene.labels, list(segments))
        mapper, look = self._hidden.GetMapper(), self._hidden.GetProperty()
        mapper.SetInputDataObject(_surface(self.scene.points, self.scene.faces[rows]) if rows.any() else vtkPolyData())
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, _FOREMOST)
        look.SetLighting(False)
        look.SetOpacity(_THROUGH)
        look.SetColor(*(np.asarray(wanted[1] or (0, 0, 0)) / 255))
        self._dirty = True

    def set_colours(self, colours: np.ndarray) -> None:
        """Colour the segments, (s, 3) uint8; neighbours of equal colour show no border between them.

        The colours that it has already leave the picture as it is.
        """
        if self.scene is None or (self._colours is not None and np.array_equal(self._colours, colours)):
            return
        self._colours = np.array(colours, np.uint8)
        np.take(self._colours, self.scene.labels, axis=0, out=vtk_to_numpy(self._rgb))
        self._rgb.Modified()
        lines = _lines(self.scene.points, borders(self.scene, colour_groups(colours)))
        self._border.GetMapper().SetInputDataObject(lines)
        self._dirty = True

    def set_labels(self, labels: np.ndarray) -> None:
        """Cut the same surface up in another way, (m,) int; the colours come with `set_colours`."""
        if self.scene is not None:
            self.scene, self._colours = replace(self.scene, labels=labels), None

    def set_theme(self, theme: Theme, transparent: bool = False) -> None:
        """Paper and border colours; a transparent background for figures."""
        self.renderer.SetBackground(*(np.zeros(3) if transparent else rgb(theme.paper) / 255))
        self.renderer.SetBackgroundAlpha(0.0 if transparent else 1.0)
        self._border_colour = rgb("#22252A" if not theme.dark else "#0E0F11") / 255
        self._dirty = True

    # --- the picture

    @property
    def stale(self) -> bool:
        """Whether something changed since the last picture."""
        return self._dirty

    def image(self, width: int, height: int, *, scale: float = 1.0, moving: bool = False) -> QImage:
        """The picture in device pixels, drawn now only if something changed since the last call."""
        size = (max(1, width), max(1, height))
        if self._image is None or self._dirty or size != self._size or (self._moving and not moving):
            self._render(size, scale, moving)
        return self._image  # type: ignore[return-value]

    def _render(self, size: tuple[int, int], scale: float, moving: bool) -> None:
        self._size, self._moving, self._dirty = size, moving, False
        self.window.SetMultiSamples(0 if moving else _SAMPLES_STILL)
        self.window.SetSize(*size)
        self.interactor.SetSize(*size)
        self._border.GetProperty().SetLineWidth(1.4 * scale)
        self._border.GetProperty().SetColor(*self._border_colour)
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        pixels, depth = vtkUnsignedCharArray(), vtkFloatArray()
        self.window.GetRGBACharPixelData(0, 0, size[0] - 1, size[1] - 1, 0, pixels)
        flipped = vtk_to_numpy(pixels).reshape(size[1], size[0], 4)[::-1].copy()
        form = QImage.Format.Format_RGBA8888_Premultiplied
        self._image = QImage(flipped.data, size[0], size[1], 4 * size[0], form).copy()
        self.window.GetZbufferData(0, 0, size[0] - 1, size[1] - 1, depth)
        self._depth = vtk_to_numpy(depth).reshape(size[1], size[0])[::-1]

    def segment_map(self, width: int, height: int) -> np.ndarray:
        """Which segment each pixel shows, (height, width) int32, -1 beside the shape; the next picture is drawn anew."""
        assert self.scene is not None
        code = np.arange(1, self.scene.count + 1)
        np.take(np.stack([code >> 16, code >> 8 & 255, code & 255], axis=1).astype(np.uint8), self.scene.labels, axis=0,
                out=vtk_to_numpy(self._rgb))  # fmt: skip
        self._rgb.Modified()
        ground, alpha = self.renderer.GetBackground(), self.renderer.GetBackgroundAlpha()
        self._flat(True)
        self.renderer.SetBackground(0.0, 0.0, 0.0)
        self.renderer.SetBackgroundAlpha(1.0)
        self._render((max(1, width), max(1, height)), 1.0, moving=True)
        self._flat(False)
        self.renderer.SetBackground(*ground)
        self.renderer.SetBackgroundAlpha(alpha)
        colours, self._colours, self._dirty = self._colours, None, True
        pixels = np.frombuffer(self._image.constBits(), np.uint8).reshape(height, width, 4).astype(np.int32)  # type: ignore
        if colours is not None:
            self.set_colours(colours)
        return (pixels[..., 0] << 16) + (pixels[..., 1] << 8) + pixels[..., 2] - 1

    def _flat(self, on: bool) -> None:
        """Plain colours without light or borders, or the usual look."""
        look = self._actor.GetProperty()
        look.SetLighting(not on)
        look.SetAmbient(1.0 if on else _AMBIENT)
        look.SetDiffuse(0.0 if on else _DIFFUSE)
        self._border.SetVisibility(not on)

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where points (q, 3) lie in the picture: (q, 2) device pixels, and (q,) window depth in [0, 1]."""
        flat = np.c_[points, np.ones(len(points))] @ self._matrix().T
        ndc = flat[:, :3] / flat[:, 3:]
        xy = (ndc[:, :2] * [1, -1] + 1) / 2 * np.array(self._size)
        return xy, (ndc[:, 2] + 1) / 2

    def spots(self) -> tuple[np.ndarray, np.ndarray]:
        """Where links to each segment end: (s, 2) device pixels, and whether that is seen, (s,) bool.

        It is the most central of the segment's spots that nothing hides (of all, where all are hidden).
        """
        assert self.scene is not None
        places = self.scene.spots
        flat = places.reshape(-1, 3)
        xy, seen = self.project(flat)[0].reshape(*places.shape[:2], 2), self.visible(flat).reshape(places.shape[:2])
        chosen = most_central(xy, seen)
        return xy[np.arange(len(xy)), chosen], seen.any(axis=1)

    def visible(self, points: np.ndarray) -> np.ndarray:
        """Which points (q, 3) of the surface are seen, (q,) bool, by the depth of the last picture."""
        xy, z = self.project(points)
        if self._depth is None:
            return np.ones(len(points), bool)
        column, row = np.floor(xy).astype(int).T
        within = (column >= 0) & (row >= 0) & (column < self._size[0]) & (row < self._size[1])
        found = self._depth[np.clip(row, 0, self._size[1] - 1), np.clip(column, 0, self._size[0] - 1)]
        return within & (self._distance(z) <= self._distance(found) + _HIDDEN_BY)

    def pick(self, x: float, y: float) -> int | None:
        """The segment under a position, or None beside the shape."""
        face = self.pick_face(x, y)
        return None if face is None else int(self.scene.labels[face])  # type: ignore[union-attr]

    def pick_face(self, x: float, y: float) -> int | None:
        """The face under a position, or None beside the shape."""
        if self.scene is None or self._image is None:
            return None
        inverse = np.linalg.inv(self._matrix())
        ndc = np.array([(x + 0.5) / self._size[0] * 2 - 1, 1 - (y + 0.5) / self._size[1] * 2])
        near, far = (inverse @ [*ndc, z, 1.0] for z in (-1.0, 1.0))
        share, sub, cell = reference(0.0), reference(0), reference(-1)
        hit = self._locator.IntersectWithLine(
            near[:3] / near[3], far[:3] / far[3], 1e-9, share, [0.0] * 3, [0.0] * 3, sub, cell)  # fmt: skip
        return int(cell.get()) if hit else None

    # --- the camera

    @property
    def camera(self) -> Camera:
        """Where the picture is taken from."""
        c = self.renderer.GetActiveCamera()
        return Camera(np.array(c.GetPosition()), np.array(c.GetFocalPoint()), np.array(c.GetViewUp()))

    @camera.setter
    def camera(self, camera: Camera) -> None:
        c = self.renderer.GetActiveCamera()
        c.SetPosition(*camera.position)
        c.SetFocalPoint(*camera.focal)
        c.SetViewUp(*camera.up)
        self._dirty = True

    def mouse(self, event: str, x: float, y: float, shift: bool = False) -> None:
        """Hand on an event of VTK's trackball, for instance 'LeftButtonPressEvent'."""
        self.interactor.SetEventInformationFlipY(round(x), round(y), 0, int(shift), chr(0), 0, None)
        self.interactor.InvokeEvent(event)
        self._dirty = True

    def zoom(self, factor: float) -> None:
        """Come nearer (above 1) or move away (below 1), within sensible distances."""
        c = self.renderer.GetActiveCamera()
        c.Dolly(float(np.clip(factor, c.GetDistance() / 40.0, c.GetDistance() / 0.15)))
        self._dirty = True

    def close(self) -> None:
        """Give the window back; the pane cannot draw afterwards."""
        self.renderer.RemoveAllViewProps()
        self.interactor.SetInteractorStyle(None)
        self.interactor.SetRenderWindow(None)
        self.window.RemoveRenderer(self.renderer)
        self.window.Finalize()

    def _matrix(self) -> np.ndarray:
        aspect = self._size[0] / max(1, self._size[1])
        matrix = self.renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(aspect, -1, 1)
        return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])

    def _distance(self, z: np.ndarray) -> np.ndarray:
        near, far = self.renderer.GetActiveCamera().GetClippingRange()
        return near * far / (far - z * (far - near))


def most_central(xy: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """For each row of places (s, k, 2) the index (s,) of the seen one nearest to the mean of those that are seen."""
    counted = np.where(seen.any(axis=1, keepdims=True), seen, True)
    mean = (xy * counted[..., None]).sum(axis=1) / counted.sum(axis=1)[:, None]
    return np.argmin(np.where(counted, np.linalg.norm(xy - mean[:, None], axis=2), np.inf), axis=1)


def _surface(points: np.ndarray, faces: np.ndarray) -> vtkPolyData:
    data, place, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    place.SetData(numpy_to_vtk(points, deep=True, array_type=VTK_FLOAT))
    cells.SetData(faces.shape[1], numpy_to_vtkIdTypeArray(np.ascontiguousarray(faces, np.int64).ravel(), deep=True))
    data.SetPoints(place)
    (data.SetPolys if faces.shape[1] == 3 else data.SetLines)(cells)
    return data


def _lines(points: np.ndarray, edges: np.ndarray) -> vtkPolyData:
    used, renumbered = np.unique(edges, return_inverse=True)
    return _surface(points[used], renumbered.reshape(-1, 2)) if len(edges) else vtkPolyData()


def _actor(data: vtkPolyData) -> vtkActor:
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputDataObject(data)
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -4.0)
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetAmbient(_AMBIENT)
    look.SetDiffuse(_DIFFUSE)
    look.SetSpecular(0.06)
    look.SetSpecularPower(20)
    return actor
