"""What hands do to segments: choosing, merging, splitting, painting, the automatic segmentation, saving, going back."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QMessageBox

from engine.errors import ConcordError
from engine.progress import Progress
from engine.shapes import editing
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.segmentationparameters import CONVEX, DEFAULT
from engine.store import default_cache, write_atomically

from ...jobs import FOLLOW, SUPERSEDE
from ...session import Session
from ...views.segment_canvas import BRUSH, CUT, SELECT
from .page import SegmentsPage
from .state import EditState

if TYPE_CHECKING:
    from ...main_window import MainWindow

CHANNEL = "segments"
SEG_FILES = "Segment labels, one integer a face (*.seg)"
NOT_SAVED = "The segments of {} were edited here and are in no file yet."
SMALLEST_BRUSH, LARGEST_BRUSH, BRUSH_STEP = 0.003, 0.3, 1.25


class SegmentDesk(QObject):
    """Owns the state of the editor and its page; the pair in the window is changed only by `done`."""

    def __init__(self, window: "MainWindow") -> None:
        super().__init__(window)
        self.window = window
        self.cache = default_cache()
        self.session = Session(EditState(dark=window.session.state.dark), self)
        self.page = SegmentsPage(self.session, self)
        self.written: set[Path] = set()
        self.ask: Callable[[str, str, dict[str, str]], str] = self._ask
        window.session.changed.connect(self._followed)

    # --- beginning and ending

    @property
    def state(self) -> EditState:
        """What is edited."""
        return self.session.state

    def edit(self, side: int) -> None:
        """Open one shape of the pair in the editor; where it is being edited already, go on."""
        pair = self.window.session.state
        shape = pair.target if side else pair.source
        if shape is None:
            self.window.say("There is no shape to edit yet; open two meshes first.")
            return
        if self.state.shape is shape and self.state.side == side:
            self.window.show_page("segments")
            return
        if not self.may_leave():
            return

        def work(progress: Progress) -> tuple[Any, Any]:
            from engine.shapes.facegraph import face_graph

            from ...views.scene import prepare

            progress(0.1, "Reading the surface")
            graph = face_graph(shape.mesh)
            progress(0.6, "Reading the surface")
            return graph, prepare(shape)

        self.window.jobs.start(CHANNEL, work, lambda found: self._begin(shape, side, *found), words="Opening the segments")

    def _begin(self, shape: SegmentedShape, side: int, graph: Any, scene: Any) -> None:
        labels = shape.segmentation.labels
        parameters = DEFAULT.changed(segments=min(200, max(2, shape.segmentation.count)))
        state = EditState(shape, side, graph, scene, labels, dict(enumerate(shape.segmentation.names)), labels,
                          parameters=parameters, by_hand=not shape.automatic, dark=self.window.session.state.dark,
                          radius=self.state.radius)  # fmt: skip
        self.session.restart(state)
        self.window.show_page("segments")

    def done(self) -> None:
        """Give the segments to the pair, which is then matched again; unsaved ones are asked about first."""
        state = self.state
        if state.shape is None:
            self.window.show_page("shapes")
            return
        pair = self.window.session.state
        if (pair.target if state.side else pair.source) is not state.shape:
            self.window.say(f"{state.shape.mesh.name} is not in the pair any more; save its segments, then open it again.")
            return
        if state.unsaved and state.by_hand:
            answer = self.ask("These segments are in no file yet.", "Matches and votes can only be found again with their labels.",
                              {"save": "Save", "use": "Use without saving", "stay": "Go on editing"})  # fmt: skip
            if answer == "stay" or (answer == "save" and not self.save()):
                return
        self._hand_over(self.state)
        self.window.show_page("shapes")

    def _hand_over(self, state: EditState) -> None:
        """Put the edited shape in the place of the one that the pair has."""
        pair, shape = self.window.session.state, state.shape
        shapes = [pair.source, pair.target]
        if np.array_equal(state.labels, shape.segmentation.labels):
            return
        note = () if not state.by_hand or state.file else (NOT_SAVED.format(shape.mesh.name),)
        made = SegmentedShape(shape.mesh, state.segmentation(), shape.file, note, automatic=not state.by_hand)
        labels = made.segmentation.labels
        names = dict(enumerate(made.segmentation.names))
        shapes[state.side] = made
        self.session.restart(EditState(made, state.side, state.graph, state.scene, labels, names, labels, state.file,
                                       state.by_hand, state.parameters, dark=state.dark, radius=state.radius))  # fmt: skip
        self.window.matching.show_pair(shapes[0], shapes[1], set_name=pair.set_name)

    def may_leave(self) -> bool:
        """Whether edited segments may be given up: they are saved, or somebody says so."""
        if not (self.state.unsaved and self.state.by_hand):
            return True
        name = self.state.shape.mesh.name
        answer = self.ask(f"The edited segments of {name} are in no file yet.", "They are lost unless they are saved.",
                          {"save": "Save", "discard": "Discard them", "stay": "Cancel"})  # fmt: skip
        if answer == "discard":
            self.session.restart(EditState(dark=self.state.dark, radius=self.state.radius))
        return answer == "discard" or (answer == "save" and self.save())

    def _ask(self, text: str, more: str, answers: dict[str, str]) -> str:
        box = QMessageBox(QMessageBox.Icon.Question, "Concord", text, parent=self.window)
        box.setInformativeText(more)
        roles = (QMessageBox.ButtonRole.AcceptRole, QMessageBox.ButtonRole.DestructiveRole, QMessageBox.ButtonRole.RejectRole)
        buttons = {box.addButton(words, role): answer for (answer, words), role in zip(answers.items(), roles, strict=True)}
        box.exec()
        return buttons.get(box.clickedButton(), "stay")

    # --- what a hand does

    def attempt(self, change: Callable[[], np.ndarray], select: Callable[[np.ndarray], tuple[int, ...]], merge: str = "") -> None:
        """Change the labels as one step, or say why not."""
        before = self.state.labels
        if before is None:
            return
        try:
            labels = change()
        except ConcordError as error:
            self.window.say(str(error))
            return
        self.window.messages.dismiss()
        self.window.jobs.cancel(CHANNEL)
        self.session.update(merge=merge, labels=labels, by_hand=True, selected=select(labels))

    def pick(self, face: int, add: bool) -> None:
        """A click: choose the segment of a face, add it, take it out again, or choose none."""
        if self.state.labels is None:
            return
        if face < 0:
            self.deselect()
            return
        label, chosen = int(self.state.labels[face]), self.state.selected
        if add:
            chosen = tuple(k for k in chosen if k != label) if label in chosen else (*chosen, label)
        else:
            chosen = (label,)
        self.choose(chosen)

    def choose(self, labels: tuple[int, ...]) -> None:
        """Select segments; the last one is what the brush paints."""
        self.session.update(selected=labels, active=labels[-1] if labels else self.state.active)

    def deselect(self) -> None:
        """Select nothing."""
        self.session.update(selected=())

    def merge(self) -> None:
        """Make the selected segments one."""
        chosen = self.state.selected
        self.attempt(lambda: editing.merged(self.state.labels, chosen), lambda _: (min(chosen),))

    def split(self) -> None:
        """Split the selected segment into patches."""
        state = self.state
        if len(state.selected) != 1:
            self.window.say("Click the one segment that is to be split.")
            return
        before = set(np.unique(state.labels).tolist())
        self.attempt(lambda: editing.split_by_patches(state.graph, state.labels, state.selected[0], state.parts),
                     lambda labels: (*state.selected, *sorted(set(np.unique(labels).tolist()) - before)))  # fmt: skip

    def cut(self, height: np.ndarray, face: int) -> None:
        """Cut the selected segment, else the one under the middle of the line."""
        state = self.state
        if len(state.selected) != 1 and face < 0:
            self.window.say("Draw the line across the segment that is to be cut.")
            return
        segment = state.selected[0] if len(state.selected) == 1 else int(state.labels[face])
        self.attempt(lambda: editing.split_by_plane(state.graph, state.labels, segment, height), lambda _: ())

    def paint(self, faces: list[int]) -> None:
        """Paint around faces with the active segment; without one, with that under the brush."""
        state = self.state
        if state.labels is None or state.graph is None:
            return
        if state.active < 0:
            self.session.update(active=int(state.labels[faces[0]]))
        active = self.state.active
        near = np.unique(np.concatenate([editing.grown(state.graph, face, state.radius) for face in faces]))
        near = near[state.labels[near] != active]
        if len(near):
            self.attempt(lambda: editing.repainted(state.labels, near, active), lambda _: (active,), merge="stroke")

    def new_segment(self) -> None:
        """Paint a segment of its own from now on."""
        if self.state.labels is not None:
            self.session.update(active=editing.next_label(self.state.labels), selected=(), tool=BRUSH)

    def choose_tool(self, tool: str) -> None:
        """Select, paint or cut; the brush paints the selected segment, else the one that it first touches."""
        changes: dict[str, Any] = {"tool": SELECT if tool == self.state.tool else tool}
        if tool == BRUSH and changes["tool"] == BRUSH:
            changes["active"] = self.state.selected[-1] if self.state.selected else -1
        if tool == CUT and len(self.state.selected) > 1:
            changes["selected"] = ()
        self.session.update(**changes)

    def resize_brush(self, by: int) -> None:
        """A larger or a smaller brush."""
        self.set_brush(self.state.radius * BRUSH_STEP**by)

    def set_brush(self, radius: float) -> None:
        """The radius of the brush, in diagonals of the shape."""
        self.session.update(radius=min(LARGEST_BRUSH, max(SMALLEST_BRUSH, radius)))

    # --- automatic

    def edit_parameter(self, name: str, value: Any, settled: bool) -> None:
        """Change the automatic segmentation and follow it."""
        state = self.state
        if state.shape is None:
            return
        try:
            parameters = state.parameters.changed(**{name: value})
        except ConcordError as error:
            self.window.say(str(error))
            self.page.show_parameters()
            return
        self.session.update(merge=name, parameters=parameters)
        if settled:
            self.session.settle()
        self.segment()

    def segment(self) -> None:
        """Segment the shape automatically with the present parameters."""
        state = self.state
        if state.shape is None:
            return
        parameters, mesh, cache = state.parameters, state.shape.mesh, self.cache

        def work(progress: Progress) -> np.ndarray:
            from engine.shapes.segmenting import auto_segment

            return auto_segment(mesh, parameters, progress=progress, cache=cache).labels

        def done(labels: np.ndarray) -> None:
            now = self.state
            if now.shape is state.shape and now.parameters is parameters:
                names = dict(enumerate(range(int(labels.max()) + 1)))
                self.session.update(record=False, labels=labels, names=names, by_hand=False, selected=(), active=-1)

        policy = SUPERSEDE if parameters.method == CONVEX else FOLLOW
        self.window.jobs.start(CHANNEL, work, done, words="Segmenting", policy=policy)

    # --- saving

    def save(self) -> bool:
        """Write the labels beside the mesh, or where they were written before; whether that was done."""
        state = self.state
        if state.shape is None:
            return False
        if not state.file and not state.shape.file:
            return self.save_as()
        path = Path(state.file or Path(state.shape.file).with_suffix(".seg"))
        if path.exists() and path not in self.written:
            answer = self.ask(f"{path.name} is there already.", f"Saving replaces the labels in {path.parent}.",
                              {"replace": "Replace", "as": "Save as…", "stay": "Cancel"})  # fmt: skip
            if answer != "replace":
                return answer == "as" and self.save_as()
        return self.write(path)

    def save_as(self) -> bool:
        """Ask where to write the labels."""
        state = self.state
        if state.shape is None:
            return False
        start = str(Path(state.file or Path(state.shape.file or state.shape.mesh.name).with_suffix(".seg")))
        path, _ = QFileDialog.getSaveFileName(self.window, "Save the segments", start, SEG_FILES)
        return bool(path) and self.write(Path(path if Path(path).suffix else path + ".seg"))

    def write(self, path: Path) -> bool:
        """Write the labels whole; whether that was done."""
        from engine.shapes.segmenting import segment_file_text

        found = self.state.segmentation()
        try:
            write_atomically(path, segment_file_text(found.labels, found.names))
        except ConcordError as error:
            self.window.say(str(error))
            return False
        self.written.add(path)
        self.session.update(saved=self.state.labels, file=str(path))
        self.window.status.text.setText(f"Segments written to {path}")
        return True

    # --- following

    def _followed(self, _old: Any, state: Any, names: frozenset[str]) -> None:
        if "dark" in names:
            self.session.update(dark=state.dark)

    def page_changed(self) -> None:
        """Let the window show what the page has come to."""
        if self.window.furnished and self.window.page == "segments":
            self.show_status()
            self.window.show_history()

    def show_status(self) -> None:
        """What the status line says while segments are edited."""
        state = self.state
        lost = state.unsaved and state.by_hand
        words = "Segments edited, not saved" if lost else f"Segments saved in {state.file}" if state.file and not state.unsaved else ""
        self.window.status.text.setText(words)
