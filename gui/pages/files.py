"""Opening, dropping and exporting files: dialogs, and what follows from them."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QInputDialog

from engine.errors import ConcordError

from ..folders import settings

if TYPE_CHECKING:
    from ..main_window import MainWindow

MESHES = "Meshes and labels (*.off *.obj *.ply *.stl *.glb *.seg)"
LABELS = "Labels, one integer a face (*.seg *.txt);;All files (*)"
FIGURES = "PNG picture (*.png);;SVG drawing (*.svg);;PDF document (*.pdf)"


def sorted_drop(paths: Iterable[str]) -> tuple[list[str], list[str], list[str]]:
    """Dropped files as meshes, label files and study files, each in the given order."""
    kinds: tuple[list[str], list[str], list[str]] = ([], [], [])
    for path in paths:
        ending = Path(path).suffix.lower()
        kinds[{".seg": 1, ".db": 2, ".study": 2, ".packet": 2}.get(ending, 0)].append(path)
    return kinds


def labels_for(meshes: Iterable[str], labels: Iterable[str]) -> tuple[str | None, ...]:
    """The label file of each mesh: one that begins with its name first, else what is left in the given order."""
    left = list(labels)
    found: list[str | None] = []
    for mesh in meshes:
        same = next((label for label in left if Path(label).name.startswith(Path(mesh).stem + ".")), None)
        found.append(same)
        if same is not None:
            left.remove(same)
    return tuple(label if label is not None else (left.pop(0) if left else None) for label in found)


class Files(QObject):
    """The file commands of a window; everything that fails becomes a message."""

    def __init__(self, window: "MainWindow") -> None:
        super().__init__(window)
        self.window = window
        self.waiting = ""
        self.chosen: tuple[str | None, str | None] = (None, None)
        self._folder = str(settings().value("folder", str(Path.home())))

    @property
    def folder(self) -> str:
        """Where dialogs begin: the folder of what was opened last."""
        return self._folder

    def open(self) -> None:
        """Ask for two meshes, together or one after the other, with label files if they are not found by name."""
        paths, _ = QFileDialog.getOpenFileNames(self.window, "Open two meshes (or the source first)", self._folder, MESHES)
        if len(sorted_drop(paths)[0]) == 1:
            title = f"Open the target for {Path(sorted_drop(paths)[0][0]).name}"
            more, _ = QFileDialog.getOpenFileNames(self.window, title, self._near(paths[0]), MESHES)
            paths += more
        meshes, labels, _ = sorted_drop(paths)
        if len(meshes) == 2:
            first, second = labels_for(meshes, labels)
            self.pair(*meshes, (first, second))
        elif len(meshes) > 2:
            self.window.collection.open(paths)
        elif paths:
            self.window.say(f"Choose two meshes, together or one after the other; {len(meshes)} were chosen.")

    def labels(self, side: int) -> None:
        """Ask for the labels of one shape of the pair, and open the pair again with them."""
        state = self.window.session.state
        if state.source is None or state.target is None:
            self.window.say("There is no shape to label yet; open two meshes first.")
            return
        shapes = state.source, state.target
        title = f"Labels of {shapes[side].mesh.name}, one integer a face"
        path, _ = QFileDialog.getOpenFileName(self.window, title, str(Path(shapes[side].file).parent), LABELS)
        if path:
            self.relabel(side, path)

    def relabel(self, side: int, path: str) -> None:
        """Open the pair again with other labels for one of its shapes."""
        shapes = self.window.session.state.source, self.window.session.state.target
        chosen = list(self.chosen)
        chosen[side] = path
        self.pair(shapes[0].file, shapes[1].file, (chosen[0], chosen[1]))

    def pair(self, source: str, target: str, labels: tuple[str | None, str | None] = (None, None)) -> None:
        """Open two files by their names."""
        if not self.window.segments.may_leave():
            return
        self.waiting, self.chosen = "", labels
        self.window.messages.dismiss()
        self._near(source)
        self.window.show_page("shapes")
        self.window.matching.open_pair(str(Path(source).absolute()), str(Path(target).absolute()), labels)

    def drop(self, paths: list[str]) -> None:
        """Open what was dropped: two meshes at once or one after the other, with their labels, a study, a collection, or a
        puzzle."""
        from engine.shapes.meshfile import MESH_SUFFIXES

        if len(paths) == 1 and Path(paths[0]).suffix == ".concord":
            self.window.studies.open(paths[0])
            return
        if self.window.collection.takes(paths):
            self.window.collection.open(paths)
            return
        if self.window.puzzle.takes(paths):
            self.window.puzzle.drop(paths)
            return
        meshes, labels, studies = sorted_drop(paths)
        strange = [path for path in meshes if Path(path).suffix.lower() not in MESH_SUFFIXES]
        if strange:
            self.window.say(f"{Path(strange[0]).name} is nothing that Concord opens; drop meshes ({', '.join(MESH_SUFFIXES)}), "
                            "pictures or a folder of them.")  # fmt: skip
            return
        if studies:
            self.window.studies.open(studies[0])
        if self.waiting and len(meshes) == 1:
            meshes.insert(0, self.waiting)
        if len(meshes) == 1:
            self.waiting = meshes[0]
            self.window.say(f"{Path(meshes[0]).name} is the source; now drop the target.")
        elif len(meshes) == 2:
            first, second = labels_for(meshes, labels)
            self.pair(*meshes, (first, second))
        elif labels and not studies:
            self.window.say("A label file alone says nothing; drop it together with its mesh.")

    def export_figure(self) -> None:
        """Ask where to, and write what the view shows."""
        path, kind = QFileDialog.getSaveFileName(self.window, "Export the figure", f"{self._folder}/correspondences.png", FIGURES)
        if path:
            path = path if Path(path).suffix else path + kind[kind.index("*") + 1 : kind.index(")")]
            self.window.attempt(lambda: self.window.shapes.view.save_figure(path), f"Figure written to {path}")

    def export_result(self) -> None:
        """Ask for a folder, and write matches.json and its companions there."""
        if self.window.session.state.result is None:
            self.window.say("There are no matches to export yet; open two meshes first.")
            return
        folder = QFileDialog.getExistingDirectory(self.window, "Folder for matches.json, matches.csv and parameters.json", self._folder)
        if folder:
            self.write_result(Path(folder))

    def write_result(self, folder: Path) -> None:
        """Write matches.json and its companions into a folder."""
        from engine.matchfile import write_matches

        result = self.window.session.state.result
        self.window.attempt(lambda: write_matches(result, folder), f"Matches written to {folder}")
        if result.wishes:
            self.window.wish_files.write(folder / "wishes.json")

    def name_volunteer(self) -> None:
        """Ask for the code of who votes."""
        from .judging import checked_code

        now = self.window.session.state.volunteer
        text, given = QInputDialog.getText(self.window, "Who is voting", "Code of the volunteer (letters, digits, - and _)", text=now)
        if given:
            try:
                code = checked_code(text)
            except ConcordError as error:
                self.window.say(str(error))
                return
            settings().setValue("volunteer", code)
            self.window.session.update(volunteer=code)

    def _near(self, path: str) -> str:
        self._folder = str(Path(path).absolute().parent)
        settings().setValue("folder", self._folder)
        return self._folder
