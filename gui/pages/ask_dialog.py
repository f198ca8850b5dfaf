"""A small dialog that asks for a few things at once and says at the place what is wrong with them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from engine.errors import ConcordError


class Field(NamedTuple):
    """One thing that is asked for: 'text', 'secret', 'number', 'switch', 'choice', or 'save' (a file to make).

    One that `needs` a switch can be given only while that is on.
    """

    name: str
    caption: str
    kind: str = "text"
    value: Any = ""
    help: str = ""
    choices: tuple[str, ...] = ()
    needs: str = ""


class AskDialog(QDialog):
    """Gives the values (`given`) once `check` finds nothing wrong with them; it returns a sentence otherwise."""

    given = Signal(object)

    def __init__(self, parent: QWidget, title: str, lead: str, fields: Sequence[Field], button: str,
                 check: Callable[[Mapping[str, Any]], str] = lambda _: "") -> None:  # fmt: skip
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(title)
        self.setObjectName("calm")
        self.check = check
        self.editors: dict[str, QWidget] = {}
        self.heading, self.lead = QLabel(title, self), QLabel(lead, self, wordWrap=True)
        self.heading.setObjectName("page-heading")
        self.lead.setObjectName("soft")
        self.lead.setTextFormat(Qt.TextFormat.PlainText)
        self.lead.setVisible(bool(lead))
        self.error = QLabel("", self, wordWrap=True)
        self.error.setObjectName("field-error")
        self.error.setTextFormat(Qt.TextFormat.PlainText)
        self.error.hide()
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 16)
        column.setSpacing(12)
        column.addWidget(self.heading)
        column.addWidget(self.lead)
        for field in fields:
            column.addLayout(self._row(field))
        column.addWidget(self.error)
        column.addStretch(1)
        self.ok, cancel = QPushButton(button, self, default=True), QPushButton("Cancel", self, autoDefault=False)
        self.ok.clicked.connect(self.give)
        cancel.clicked.connect(self.reject)
        low = QHBoxLayout()
        low.setSpacing(8)
        low.addStretch(1)
        low.addWidget(cancel)
        low.addWidget(self.ok)
        column.addLayout(low)
        self.setMinimumWidth(480)

    def _row(self, field: Field) -> QVBoxLayout:
        column = QVBoxLayout()
        column.setSpacing(4)
        editor = self.editors[field.name] = self._editor(field)
        editor.setAccessibleName(field.caption)
        if field.kind != "switch":
            caption = QLabel(field.caption, self)
            caption.setBuddy(editor)
            column.addWidget(caption)
        if field.kind == "save":
            line, choose = QHBoxLayout(), QPushButton("Choose…", self, autoDefault=False)
            choose.clicked.connect(lambda: self._choose(field, editor))
            line.setSpacing(8)
            line.addWidget(editor, 1)
            line.addWidget(choose)
            column.addLayout(line)
            self._bind(field.needs, choose)
        else:
            column.addWidget(editor, 0, Qt.AlignmentFlag.AlignLeft if field.kind in ("number", "choice") else Qt.AlignmentFlag(0))
        self._bind(field.needs, editor)
        if field.help:
            told = QLabel(field.help, self, wordWrap=True)
            told.setObjectName("soft")
            column.addWidget(told)
        return column

    def _bind(self, switch: str, widget: QWidget) -> None:
        """Enable a widget only while a switch above it is on."""
        if switch:
            widget.setEnabled(self.editors[switch].isChecked())
            self.editors[switch].toggled.connect(widget.setEnabled)

    def follow(self, chosen: str, file: str, name: Callable[[str], str]) -> None:
        """Let the name of a file follow what is chosen, until somebody writes another one."""
        line = self.editors[file]
        suggested = line.text()

        def rename(text: str) -> None:
            nonlocal suggested
            if line.text() == suggested:
                suggested = name(text.strip())
                line.setText(suggested)

        self.editors[chosen].currentTextChanged.connect(rename)

    def _editor(self, field: Field) -> QWidget:
        if field.kind == "switch":
            return QCheckBox(field.caption, self, checked=bool(field.value))
        if field.kind == "number":
            box = QSpinBox(self)
            box.setRange(0, 1_000_000)
            box.setValue(int(field.value or 0))
            box.setFixedWidth(112)
            box.setAlignment(Qt.AlignmentFlag.AlignRight)
            return box
        if field.kind == "choice":
            combo = QComboBox(self, editable=True)
            combo.addItems(list(field.choices))
            combo.setCurrentText(str(field.value))
            combo.setMinimumWidth(240)
            return combo
        echo = QLineEdit.EchoMode.Password if field.kind == "secret" else QLineEdit.EchoMode.Normal
        return QLineEdit(str(field.value), self, echoMode=echo)

    def _choose(self, field: Field, editor: QLineEdit) -> None:
        path, _ = QFileDialog.getSaveFileName(self, field.caption, editor.text(), options=QFileDialog.Option.DontConfirmOverwrite)
        if path:
            editor.setText(path)

    def values(self) -> dict[str, Any]:
        """What stands in the fields, by name."""
        found: dict[str, Any] = {}
        for name, editor in self.editors.items():
            if isinstance(editor, QCheckBox):
                found[name] = editor.isChecked()
            elif isinstance(editor, QSpinBox):
                found[name] = editor.value()
            elif isinstance(editor, QComboBox):
                found[name] = editor.currentText().strip()
            else:
                found[name] = editor.text() if editor.echoMode() == QLineEdit.EchoMode.Password else editor.text().strip()
        return found

    def give(self) -> None:
        """Hand the values on, or say what is wrong."""
        values = self.values()
        try:
            sentence = self.check(values)
        except ConcordError as error:
            sentence = str(error)
        self.error.setText(sentence)
        self.error.setVisible(bool(sentence))
        if not sentence:
            self.given.emit(values)
            self.accept()


def show_secret(parent: QWidget, title: str, lead: str, secret: str) -> QDialog:
    """Show a text that is shown this once, with a button that copies it."""
    from PySide6.QtGui import QGuiApplication

    dialog = QDialog(parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.setWindowTitle(title)
    dialog.setObjectName("calm")
    heading, words = QLabel(title, dialog), QLabel(lead, dialog, wordWrap=True)
    heading.setObjectName("page-heading")
    words.setObjectName("soft")
    line = QLineEdit(secret, dialog, readOnly=True)
    line.setCursorPosition(0)
    copy, done = QPushButton("Copy", dialog, autoDefault=False), QPushButton("Done", dialog, default=True)
    copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(secret))
    done.clicked.connect(dialog.accept)
    row, low = QHBoxLayout(), QHBoxLayout()
    row.addWidget(line, 1)
    row.addWidget(copy)
    low.addStretch(1)
    low.addWidget(done)
    column = QVBoxLayout(dialog)
    column.setContentsMargins(24, 20, 24, 16)
    column.setSpacing(12)
    column.addWidget(heading)
    column.addWidget(words)
    column.addLayout(row)
    column.addLayout(low)
    dialog.setMinimumWidth(560)
    dialog.open()
    return dialog
