"""A message where the eye is: one sentence in a bar above the page, with the details to copy."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QToolButton, QWidget


class MessageBar(QFrame):
    """Hidden until `show_message`; stays until it is closed or replaced."""

    closed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("message-bar")
        self.details = ""
        self.sign = QLabel("⚠", self)
        self.text = QLabel("", self, wordWrap=True)
        self.text.setTextFormat(Qt.TextFormat.PlainText)
        self.text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.copy = QPushButton("Copy details", self)
        self.copy.clicked.connect(self._copy)
        self.close_button = QToolButton(self, text="✕", autoRaise=True, toolTip="Close this message")
        self.close_button.clicked.connect(self.dismiss)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 8, 8, 8)
        row.setSpacing(8)
        row.addWidget(self.sign, 0)
        row.addWidget(self.text, 1)
        row.addWidget(self.copy, 0)
        row.addWidget(self.close_button, 0)
        self.hide()

    def show_message(self, sentence: str, details: str = "") -> None:
        """Show one sentence; `details` is what "Copy details" puts on the clipboard."""
        self.details = details
        self.text.setText(sentence)
        self.copy.setVisible(bool(details))
        self.copy.setText("Copy details")
        self.show()

    def dismiss(self) -> None:
        """Take the message away."""
        self.hide()
        self.closed.emit()

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(f"{self.text.text()}\n\n{self.details}")
        self.copy.setText("Copied")
