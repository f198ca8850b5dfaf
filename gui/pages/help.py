"""Small windows of text: the keys, and what Concord is."""

from html import escape
from importlib.metadata import version

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QLabel, QScrollArea, QVBoxLayout, QWidget


def show_keys(parent: QWidget, table: str, guideline: str) -> None:
    """All keys, below the guideline of the study where there is one (shown as plain text, whatever it holds)."""
    show_text(parent, "Keys", (f"<p style='white-space:pre-wrap'>{escape(guideline)}</p>" if guideline else "") + table)


def show_about(parent: QWidget) -> None:
    """What this is."""
    show_text(parent, "About Concord", f"<h3>Concord {version('concord-correspondences')}</h3><p>Finds, shows and judges "
              "consistent correspondences between segmented shapes.<br>MIT licence.</p>")  # fmt: skip


def show_text(parent: QWidget, title: str, html: str) -> None:
    """A window with formatted text and one button."""
    dialog = QDialog(parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.setWindowTitle(title)
    text = QLabel(html, dialog, textFormat=Qt.TextFormat.RichText)
    text.setContentsMargins(16, 16, 16, 16)
    area = QScrollArea(dialog, widgetResizable=True)
    area.setWidget(text)
    buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, dialog)
    buttons.rejected.connect(dialog.reject)
    column = QVBoxLayout(dialog)
    column.addWidget(area, 1)
    column.addWidget(buttons)
    dialog.resize(min(text.sizeHint().width() + 56, 640), min(text.sizeHint().height() + 80, 640))
    dialog.open()
