"""Opening, dropping and exporting puzzles: dialogs, and what follows from them."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLabel,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from ...folders import settings
from .solving import Cut, check_droppable
from .state import PuzzleState

if TYPE_CHECKING:
    from .desk import PuzzleDesk

PICTURES = "Pictures (*.png *.jpg *.jpeg *.tif *.tiff *.bmp *.webp *.gif *.ppm)"
WISHES = "Locks, rejections and pins (*.json)"
KIND_WORDS = {"squares": "Squares", "merged": "Merged squares", "rectangles": "Rectangles", "triangles": "Triangles and squares"}
PREVIEW = 240


class CutDialog(QDialog):
    """Asks how a picture is cut."""

    def __init__(self, image: np.ndarray, name: str, how: Cut, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Cut a picture into pieces")
        self.kind = QComboBox(self)
        for kind, words in KIND_WORDS.items():
            self.kind.addItem(words, kind)
        self.kind.setCurrentIndex(list(KIND_WORDS).index(how.kind))
        self.pieces, self.seed = QSpinBox(self), QSpinBox(self)
        self.pieces.setRange(2, 30_000)
        self.pieces.setValue(how.pieces)
        self.seed.setRange(0, 2**31 - 1)
        self.seed.setValue(how.seed)
        self.seed.setToolTip("The same seed cuts and shuffles in the same way")
        self.turned = QCheckBox("Turn the pieces by quarter turns", self)
        self.turned.setChecked(how.turned)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel, self)
        buttons.button(QDialogButtonBox.StandardButton.Ok).setText("Cut")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form = QFormLayout()
        form.setHorizontalSpacing(16)
        form.setVerticalSpacing(8)
        for words, widget in (("Pieces", self.kind), ("How many", self.pieces), ("", self.turned), ("Seed", self.seed)):
            form.addRow(words, widget)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 16)
        column.setSpacing(12)
        column.addWidget(self._preview(image))
        h, w = image.shape[:2]
        size = QLabel(f"{name}  ·  {w} × {h} pixels", self, alignment=Qt.AlignmentFlag.AlignCenter)
        size.setObjectName("soft")
        column.addWidget(size)
        column.addLayout(form)
        column.addWidget(buttons)

    def _preview(self, image: np.ndarray) -> QLabel:
        """The picture, small."""
        h, w = image.shape[:2]
        step = max(1, max(h, w) // (2 * PREVIEW))
        small = np.ascontiguousarray(image[::step, ::step])
        shown = QImage(small.data, small.shape[1], small.shape[0], 3 * small.shape[1], QImage.Format.Format_RGB888)
        label = QLabel(self, alignment=Qt.AlignmentFlag.AlignCenter)
        label.setPixmap(QPixmap.fromImage(shown).scaled(
            PREVIEW, PREVIEW, Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation))  # fmt: skip
        return label

    def how(self) -> Cut:
        """What was chosen."""
        return Cut(self.kind.currentData(), self.pieces.value(), self.turned.isChecked(), self.seed.value())


class PuzzleFiles(QObject):
    """The file commands of the puzzle page; everything that fails becomes a message."""

    def __init__(self, desk: "PuzzleDesk") -> None:
        super().__init__(desk)
        self.desk = desk
        self._folder = str(settings().value("puzzle-folder", str(Path.home())))
        self._how = Cut()

    def open_picture(self) -> None:
        """Ask for a picture and how to cut it."""
        path, _ = QFileDialog.getOpenFileName(self.desk.window, "Open a picture as a puzzle", self._folder, PICTURES)
        if path:
            self.ask_cut(path)

    def ask_cut(self, path: str) -> None:
        """Read a picture, ask how to cut it, and cut it."""
        self._near(str(Path(path).absolute().parent))
        self.desk.open(lambda: self.desk.solving.look_at_picture(
            path, lambda image: QTimer.singleShot(0, lambda: self._ask(image, path))))  # fmt: skip

    def _ask(self, image: np.ndarray, path: str) -> None:
        dialog = CutDialog(image, Path(path).name, self._how, self.desk.window)
        if dialog.exec() == QDialog.DialogCode.Accepted:
            self._how = dialog.how()
            self.desk.solving.open_picture(image, self._how, path)
        dialog.deleteLater()

    def open_folder(self) -> None:
        """Ask for a folder of pieces."""
        path = QFileDialog.getExistingDirectory(self.desk.window, "Folder with the images of the pieces", self._folder)
        if path:
            self.folder(path)

    def folder(self, path: str) -> None:
        """Open a folder of pieces."""
        self._near(str(Path(path).absolute().parent))
        self.desk.open(lambda: self.desk.solving.open_folder(path))

    def drop(self, paths: list[str]) -> None:
        """Open what was dropped: a picture, after asking how to cut it, or a folder of pieces."""
        self.desk.window.show_page("puzzle")
        kind, path = check_droppable(paths)
        if kind == "folder":
            self.folder(path)
        else:
            self.ask_cut(path)

    # --- export

    def export_picture(self) -> None:
        """Ask where to, and write the assembled picture."""
        state = self._solved()
        if state is None:
            return
        start = f"{self._folder}/{state.puzzle.name}-assembled.png"
        path, _ = QFileDialog.getSaveFileName(self.desk.window, "Export the assembled picture", start, "PNG picture (*.png)")
        if path:
            self.write_picture(Path(path) if Path(path).suffix else Path(path + ".png"))

    def write_picture(self, path: Path) -> None:
        """Write the assembled picture, several pictures side by side in files of their own."""
        from engine.puzzles.imagefile import png_bytes
        from engine.puzzles.rendering import assembled
        from engine.store import write_atomically

        state: PuzzleState = self.desk.session.state

        def write() -> None:
            for k in range(int(state.solution.picture.max()) + 1):
                name = path if k == 0 else path.with_name(f"{path.stem}-{k + 1}{path.suffix}")
                write_atomically(name, png_bytes(assembled(state.puzzle, state.solution, k)))

        self.desk.window.attempt(write, f"Picture written to {path}")

    def open_wishes(self) -> None:
        """Ask for a file of locks, rejections and pins."""
        if self.desk.session.state.puzzle is None:
            self.desk.window.say("There is no puzzle yet that locks could belong to; open its pieces first.")
            return
        path, _ = QFileDialog.getOpenFileName(self.desk.window, "Open locks, rejections and pins", self._folder, WISHES)
        if path:
            self.read_wishes(path)

    def read_wishes(self, path: str) -> None:
        """Take the locks, rejections and pins of a file instead of the present ones."""
        from engine.puzzles.wishfile import read_wishes

        session = self.desk.session
        self.desk.window.attempt(lambda: session.update(wishes=read_wishes(path, session.state.puzzle), preview=None),
                                 f"Locks read from {path}")  # fmt: skip

    def export_solution(self) -> None:
        """Ask for a folder, and write solution.json, joins.csv and the wishes there."""
        if self._solved() is not None:
            title = "Folder for solution.json, joins.csv and assembled.png"
            folder = QFileDialog.getExistingDirectory(self.desk.window, title, self._folder)
            if folder:
                self.write_solution(Path(folder))

    def write_solution(self, folder: Path) -> None:
        """Write positions, joins and, where there are some, the locks into a folder."""
        from engine.puzzles.solutionfile import write_solution
        from engine.puzzles.wishfile import write_wishes

        state: PuzzleState = self.desk.session.state
        scores, right = (None, None) if state.marks is None else (state.marks.scores, state.marks.joins)

        def write() -> None:
            write_solution(folder, state.puzzle, state.solution, scores=scores, right=right)
            if state.wishes:
                write_wishes(folder / "locks.json", state.wishes)

        self.desk.window.attempt(write, f"Solution written to {folder}")

    def _solved(self) -> PuzzleState | None:
        state: PuzzleState = self.desk.session.state
        if state.solution is None or not state.solution.placed.any():
            self.desk.window.say("There is no picture to export yet; open a puzzle and solve it first.")
            return None
        return state

    def _near(self, folder: str) -> None:
        self._folder = folder
        settings().setValue("puzzle-folder", folder)


