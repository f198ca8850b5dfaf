"""The steps of a new study after its results: question, votes, sample, checks, and where it is kept."""

import os
from pathlib import Path
from typing import Any, NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QButtonGroup,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from annotation.design.designing import Design

from .design_form import DesignForm

CAPTIONS = {
    "question": "Question", "guideline": "Guideline", "unsure": "Volunteers may answer “unsure”", "votes": "Votes for each match",
    "adaptive": "Ask no further once a majority is sure", "overlap": "Share that gets all votes anyway", "most": "Most matches asked",
    "seed": "Seed", "gold": "Gold matches", "gold_least": "But at least", "practice": "Practice matches", "name": "Name",
}  # fmt: skip
LONGEST = 200  # bytes of a file's name, with room for the endings that stand beside it
WAYS = (("file", "One file"), ("folder", "A project folder, with room for results and backups"),
        ("server", "A PostgreSQL server, for people who vote at the same time"))  # fmt: skip
KNOWN = (("none", "No answers are known"), ("csv", "Answers in a CSV file (item, answer, reason)"),
         ("truth", "What came along: classes of faces (.sem files) beside the meshes, pictures of cut puzzles"),
         ("own", "My own votes in the study that is open now"))  # fmt: skip


class FormStep(QWidget):
    """Some fields of the design, and nothing else."""

    changed = Signal()

    def __init__(self, names: tuple[str, ...], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.form = DesignForm(Design, names, self, CAPTIONS)
        self.form.edited.connect(lambda _: self.changed.emit())
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.form)
        column.addStretch(1)

    def values(self) -> dict[str, Any]:
        """The values by name."""
        return self.form.values()


class Choice(QWidget):
    """One of several ways, each a line."""

    changed = Signal()

    def __init__(self, ways: tuple[tuple[str, str], ...], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.buttons: dict[str, QRadioButton] = {}
        self.group = QButtonGroup(self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        for name, words in ways:
            button = self.buttons[name] = QRadioButton(words, self)
            self.group.addButton(button)
            column.addWidget(button)
        self.buttons[ways[0][0]].setChecked(True)
        self.group.buttonToggled.connect(lambda _, on: self.changed.emit() if on else None)

    @property
    def choice(self) -> str:
        """The name of the chosen way."""
        return next(name for name, button in self.buttons.items() if button.isChecked())


class PathLine(QWidget):
    """A path to type or to choose, and what is wrong with it."""

    changed = Signal()

    def __init__(self, button: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.line, self.button = QLineEdit(self), QPushButton(button, self, autoDefault=False)
        self.line.textChanged.connect(lambda _: self.changed.emit())
        self.error = QLabel("", self, wordWrap=True)
        self.error.setObjectName("field-error")
        self.error.setTextFormat(Qt.TextFormat.PlainText)
        self.error.hide()
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(self.line, 1)
        row.addWidget(self.button)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addLayout(row)
        column.addWidget(self.error)

    def show_error(self, sentence: str) -> None:
        """Say what is wrong, or nothing."""
        self.error.setText(sentence)
        self.error.setVisible(bool(sentence))


class ChecksStep(QWidget):
    """Where known answers come from, and how many gold and practice matches are made of them."""

    changed = Signal()

    def __init__(self, own: bool, folder: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.folder = folder
        self.source = Choice(KNOWN, self)
        self.source.buttons["own"].setEnabled(own)
        self.source.buttons["own"].setToolTip("" if own else "No study with votes of yours is open")
        self.path = PathLine("Choose…", self)
        self.path.line.setPlaceholderText("answers.csv")
        self.path.button.clicked.connect(self._ask)
        self.told = QLabel("", self, wordWrap=True)
        self.told.setObjectName("summary")
        self.form = DesignForm(Design, ("gold", "gold_least", "practice"), self, CAPTIONS)
        for signal in (self.source.changed, self.path.changed):
            signal.connect(self._tell)
        self.form.edited.connect(lambda _: self.changed.emit())
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(16)
        for widget in (self.source, self.path, self.told, self.form):
            column.addWidget(widget)
        column.addStretch(1)
        self._tell()

    def _ask(self) -> None:
        path, _ = QFileDialog.getOpenFileName(self, "Known answers", self.folder, "CSV files (*.csv)")
        if path:
            self.path.line.setText(path)

    def _tell(self) -> None:
        self.path.setVisible(self.source.choice == "csv")
        self.told.setVisible(self.source.choice == "truth")
        self.form.setVisible(self.source.choice != "none")
        self.path.show_error("")
        self.changed.emit()

    def values(self) -> dict[str, Any]:
        """The values by name; without known answers there are neither gold nor practice matches."""
        return self.form.values() if self.source.choice != "none" else {"gold": 0.0, "gold_least": 0, "practice": 0}


class Place(NamedTuple):
    """Where a study is to be kept: a way and a path, or an address with its password."""

    way: str
    path: str

    def problem(self) -> str:
        """Why nothing can be kept there, or ''."""
        if not self.path.strip():
            return {"server": "Give the address of a database: postgresql://USER@HOST:PORT/DATABASE."}.get(
                self.way, "Choose where the study is kept.")  # fmt: skip
        if self.way == "server":
            return ""
        path = Path(self.path)
        if os.path.exists(path):
            return f"{path} exists already; choose another name."
        if len(os.fsencode(path.name)) > LONGEST:
            return "This name is too long for a file; choose a shorter one."
        return "" if path.absolute().parent.is_dir() else f"There is no folder {path.absolute().parent}; choose another one."


class PlaceStep(QWidget):
    """The name, where the study is kept, and in a few lines what it will be."""

    changed = Signal()

    def __init__(self, folder: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.folder, self._typed = folder, False
        self.form = DesignForm(Design, ("name",), self, CAPTIONS)
        self.ways = Choice(WAYS, self)
        self.path = PathLine("Choose…", self)
        self.path.button.clicked.connect(self._ask)
        self.path.line.textEdited.connect(self._type)
        self.password = QLineEdit(self, placeholderText="Password", echoMode=QLineEdit.EchoMode.Password)
        self.password.setFixedWidth(240)
        self.summary = QLabel("", self, wordWrap=True)
        self.summary.setObjectName("summary")
        self.summary.setTextFormat(Qt.TextFormat.PlainText)
        self.form.edited.connect(self._name)
        self.ways.changed.connect(self._name)
        for signal in (self.path.changed, self.password.textChanged):
            signal.connect(lambda *_: self.changed.emit())
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(12)
        for widget in (self.summary, self.form, self.ways, self.path, self.password):
            column.addWidget(widget)
        column.addStretch(1)
        self._name()

    def _type(self, _: str) -> None:
        self._typed = True

    def _name(self, *_: object) -> None:
        """The path follows the name until somebody types or chooses another one."""
        way = self.ways.choice
        self.path.button.setVisible(way != "server")
        self.password.setVisible(way == "server")
        self.path.line.setPlaceholderText("postgresql://USER@HOST:PORT/DATABASE" if way == "server" else "")
        if way == "server":
            if not self.path.line.text().startswith("postgres"):
                self.path.line.setText("")
        elif not self._typed:
            self.path.line.setText(suggested(self.folder, self.form.rows["name"].value, way))
        else:
            self.path.line.setText(ending_for(self.path.line.text(), way))
        self.changed.emit()

    def _ask(self) -> None:
        way = self.ways.choice
        path, _ = QFileDialog.getSaveFileName(self, "New study", self.path.line.text() or self.folder,
                                              "Project folders (*.concord)" if way == "folder" else "Studies (*.db)",
                                              options=QFileDialog.Option.DontConfirmOverwrite)  # fmt: skip
        if path:
            self._typed = True
            self.path.line.setText(ending_for(path, way))

    @property
    def place(self) -> Place:
        """What was chosen; an address holds its password."""
        text = self.path.line.text().strip()
        if self.ways.choice != "server":
            return Place(self.ways.choice, ending_for(text, self.ways.choice))
        return Place("server", with_password(text, self.password.text()))

    def values(self) -> dict[str, Any]:
        """The values by name."""
        return self.form.values()


def suggested(folder: str, name: str, way: str) -> str:
    """A path that is free, by the name of the study."""
    stem = "".join(c if c.isalnum() or c in " -_" else "-" for c in name).strip()[:60].strip() or "study"
    ending = ".concord" if way == "folder" else ".db"
    for number in range(1, 1000):
        path = Path(folder) / (stem + (f" {number}" if number > 1 else "") + ending)
        if not os.path.exists(path):
            return str(path)
    return ""


def ending_for(path: str, way: str) -> str:
    """The path with the ending of its way."""
    if not path:
        return ""
    stem = path[: -len(Path(path).suffix)] if Path(path).suffix in (".concord", ".db", ".study") else path
    kept = Path(path).suffix if way == "file" and Path(path).suffix in (".db", ".study") else ""
    return stem + (".concord" if way == "folder" else kept or ".db")


def with_password(address: str, password: str) -> str:
    """The address of a server with a password in it, where one was given."""
    if not password or not address:
        return address
    from annotation.server.postgres import server_url

    return server_url(address).set(password=password).render_as_string(hide_password=False)
