"""Everything behind the page of a collection: opening, matching in a worker, showing a pair, exporting."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog, QVBoxLayout, QWidget

from engine.errors import BadInput, ConcordError
from engine.progress import Progress, share
from engine.shapes.collection_parameters import CollectionParameters

from ...session import Session
from ..status import seconds_text
from .state import CollectionState, changed_values, row_of, status_text, support_by_id

if TYPE_CHECKING:
    from engine.shapes.collection_result import CollectionResult

    from ...main_window import MainWindow

LIVE = ("support", "part_from")


class Lazy(QWidget):
    """A page that is made when it is first shown."""

    failed = Signal(str, str)

    def __init__(self, make: Callable[[], QWidget], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._make = make
        self.made: QWidget | None = None

    def begin(self) -> None:
        """Make the page now."""
        if self.made is None:
            self.made = self._make()
            column = QVBoxLayout(self)
            column.setContentsMargins(0, 0, 0, 0)
            column.addWidget(self.made)

    def shutdown(self) -> None:
        """Give back what the page holds."""
        if self.made is not None:
            self.made.shutdown()


class CollectionDesk(QObject):
    """What the window needs of collections: a page, commands, and a line of status."""

    def __init__(self, window: "MainWindow") -> None:
        super().__init__(window)
        self.window = window
        self.session = Session(CollectionState(dark=window.session.state.dark), self)
        self.page = Lazy(self._make, window)
        self.shapes: tuple[Any, ...] = ()
        self.failures: tuple[str, ...] = ()
        self._scenes: dict[int, Any] = {}
        self.seconds = ""
        self.session.changed.connect(self._changed)
        window.session.changed.connect(self._follow)
        window.jobs.started.connect(lambda _: self.show_status())
        window.jobs.idle.connect(self.show_status)

    def _make(self) -> QWidget:
        from .page import CollectionPage

        page = CollectionPage(self.session, self.window)
        page.folder_wanted.connect(self.open_folder)
        page.meshes_wanted.connect(self.open_meshes)
        page.example_wanted.connect(self.open_example)
        page.pair_wanted.connect(self.show_pair)
        page.shape_clicked.connect(self.choose)
        page.least_moved.connect(lambda least: self.window.session.update(least_support=least))
        page.edited.connect(self.edit)
        return page

    # --- opening

    def takes(self, paths: list[str]) -> bool:
        """Whether what was dropped is a collection: a folder of meshes, or three and more meshes."""
        from engine.shapes.collection_inputs import meshes_in
        from engine.shapes.meshfile import MESH_SUFFIXES

        folders = [path for path in map(Path, paths) if path.is_dir()]
        try:
            found = sum(len(meshes_in(folder)) for folder in folders)
        except ConcordError:
            return False
        return bool(found) or sum(Path(path).suffix.lower() in MESH_SUFFIXES for path in paths) > 2

    def open(self, paths: list[str]) -> None:
        """Read the meshes of a collection, show them, and match all pairs; what was shown before stays if none can be read."""
        from engine.shapes.collection_inputs import collection_files

        self.window.messages.dismiss()
        self.window.show_page("collection")
        try:
            files = collection_files(paths)
        except ConcordError as error:
            self.window.say(str(error))
            return

        cache = self.window.matching.cache

        def read(progress: Progress) -> tuple[Any, ...]:
            from engine.shapes.collection_inputs import load_collection
            from engine.shapes.collection_matching import unique_names

            from ...views.scene import prepare

            shapes, failures = load_collection(files, progress=share(progress, 0.0, 0.5), cache=cache)
            if len(shapes) < 2:
                raise BadInput(" ".join(["A collection needs at least two shapes that can be read.", *failures]))
            scenes = []
            for row, shape in enumerate(shapes):
                progress(0.5 + 0.5 * row / len(shapes), f"reading {shape.mesh.name}")
                scenes.append(prepare(shape))
            return tuple(shapes), unique_names([shape.mesh.name for shape in shapes]), tuple(scenes), tuple(failures)

        self.window.jobs.start("collection", read, self._show, words="Reading the collection")

    def open_folder(self) -> None:
        """Ask for a folder of meshes."""
        folder = QFileDialog.getExistingDirectory(self.window, "Folder of shapes", self.window.files.folder)
        if folder:
            self.open([folder])

    def open_meshes(self) -> None:
        """Ask for several meshes, and their label files where these are not found by name."""
        from ..files import MESHES

        paths, _ = QFileDialog.getOpenFileNames(self.window, "Open the meshes of a collection", self.window.files.folder, MESHES)
        if paths:
            self.open(paths)

    def open_example(self) -> None:
        """Open the bundled lamps."""
        from assets import example_pairs

        self.open([str(path) for name, *pair in example_pairs() if name.startswith("lamps") for path in pair])

    def again(self) -> None:
        """Match the collection again with the parameters of the window."""
        if not self.shapes:
            self.window.say("There is no collection to match yet; open a folder of shapes or several meshes first.")
            return
        state, own, cache = self.window.session.state, self.session.state.parameters, self.window.matching.cache
        matching, chosen, shapes, failures = state.parameters, state.preset, self.shapes, self.failures
        scenes = self._scenes

        def work(progress: Progress) -> tuple[Any, tuple[Any, ...]]:
            from engine.shapes.collection_matching import match_collection

            from ...views.aligning import aligned

            found = match_collection(shapes, matching, own, preset=chosen, failures=failures, progress=progress, cache=cache)
            return found, aligned([scenes[id(shape)] for shape in found.shapes], found.parts)

        self.window.jobs.start("collection", work, self._take, words="Matching the collection", failed=self._failed)

    def _show(self, answer: tuple[Any, ...]) -> None:
        """Show what was read, then match it."""
        self.shapes, names, scenes, self.failures = answer
        self._scenes = {id(shape): scene for shape, scene in zip(self.shapes, scenes, strict=True)}
        self.session.update(found=None, names=names, scenes=scenes, part=-1, chosen=())
        self.again()

    def _take(self, answer: tuple["CollectionResult", tuple[Any, ...]]) -> None:
        found, scenes = answer
        if found.parameters != self.session.state.parameters:
            found = found.changed(self.session.state.parameters)  # a live one has moved meanwhile
        self.seconds = seconds_text(sum(found.seconds.values()))
        self.window.session.update(support=support_by_id(found))
        self.session.update(found=found, names=found.names, scenes=scenes, part=-1, chosen=())
        if found.failures:
            self.window.say(" ".join(found.failures))

    def stopped(self) -> None:
        """Go back to the parameters of what is shown, where matching with others was stopped or failed."""
        if self.session.state.found is not None:
            self.session.update(parameters=self.session.state.found.parameters)

    def _failed(self, sentence: str, details: str) -> None:
        self.stopped()
        self.window.jobs.failed.emit(sentence, details)

    # --- what a hand does

    def edit(self, name: str, value: Any, settled: bool) -> None:
        """Change a parameter of the collection: live ones are followed, others match again when let go."""
        try:
            parameters = self.session.state.parameters.changed(**{name: value})
        except ConcordError as error:
            self.window.say(str(error))
            return
        self.session.update(parameters=parameters)
        found = self.session.state.found
        if found is None:
            self.again() if self.shapes and settled else None
            return
        if set(changed_values(found.parameters, parameters)) <= set(LIVE):
            self._show_live(found, parameters)
        elif settled:
            self.again()

    def _show_live(self, found: "CollectionResult", parameters: CollectionParameters) -> None:
        new = found.changed(parameters)
        if parameters.support != found.parameters.support:
            self.window.session.update(support=support_by_id(new))
        self.session.update(found=new, part=min(self.session.state.part, new.part_count - 1))

    def choose(self, shape: int) -> None:
        """Choose a shape for a pair; the second one opens the pair on the page of shapes."""
        chosen = self.session.state.chosen
        if self.session.state.found is None:
            return
        if shape in chosen:
            self.session.update(chosen=tuple(k for k in chosen if k != shape))
        elif len(chosen) != 1:
            self.session.update(chosen=(shape,))
        else:
            both = (chosen[0], shape)
            self.session.update(chosen=both)
            row = row_of(self.session.state.found, both)
            if row >= 0:
                self.show_pair(row)
            else:
                names = " and ".join(self.session.state.found.names[k] for k in both)
                self.window.say(f"{names} were not matched with each other; raise the number of partners to match more pairs.")

    def show_pair(self, row: int) -> None:
        """Show a pair with its matches and their support on the page of shapes."""
        from ..shapes.arrange import main_ids

        found = self.session.state.found
        a, b = found.pairs[row]
        result = found.results[row]
        self.session.update(chosen=(a, b))
        self.window.matching.cancel()
        self.window.session.update(
            source=found.shapes[a], target=found.shapes[b], set_name=Path(found.shapes[a].file).resolve().parent.name,
            parameters=found.match_parameters, preset=found.preset or self.window.session.state.preset, proposals=None,
            prepared_with=None, result=result, main=main_ids(result), selected="", layer=0, node=-1,
            support=support_by_id(found))  # fmt: skip
        self.window.show_page("shapes")
        self.window.matching.prepare()

    def step_part(self, by: int) -> None:
        """Light up the next or previous part."""
        if self.page.made is not None:
            self.page.made.step_part(by)

    def export(self) -> None:
        """Ask for a folder and write the files of the collection there."""
        if self.session.state.found is None:
            self.window.say("There is no collection to export yet; open a folder of shapes or several meshes first.")
            return
        folder = QFileDialog.getExistingDirectory(self.window, "Folder for collection.json, report.html and the pairs",
                                                  self.window.files.folder)  # fmt: skip
        if folder:
            self.write(Path(folder))

    def write(self, folder: Path) -> None:
        """Write the files of the collection into a folder."""
        from engine.collection_report import collection_page
        from engine.collectionfile import write_collection

        from ...views.collection_pictures import collection_pictures

        found = self.session.state.found
        self.window.attempt(lambda: write_collection(found, folder, report=collection_page(found, collection_pictures(found))),
                            f"Collection written to {folder}")  # fmt: skip

    # --- following

    def show_status(self) -> None:
        """What the status line says while the page is shown."""
        if self.window.page == "collection":
            self.window.status.text.setText(status_text(self.session.state, self.window.jobs.busy("collection")))
            self.window.status.seconds.setText(self.seconds)

    def _changed(self, _old: CollectionState, _state: CollectionState, _names: frozenset[str]) -> None:
        self.show_status()

    def _follow(self, _old: Any, state: Any, names: frozenset[str]) -> None:
        if names & {"dark", "least_support"}:
            self.session.update(dark=state.dark, least=state.least_support)
