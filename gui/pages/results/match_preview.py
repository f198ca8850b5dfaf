"""One match of a study, large enough to judge it again: two shapes with the parts lit up, or the two pieces."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QStackedLayout, QVBoxLayout, QWidget

from annotation import study
from annotation.study import StudyHandle
from engine.errors import ConcordError

from ...palette import theme
from ...views.join import JoinPicture, JoinView, join_picture
from ...views.voting_pair import ReadyPair, VotingPairView, ready_pair
from ..voting.questions import Shapes, found_again

PICK = "Pick a match in the list to see it."
Shown = ReadyPair | JoinPicture | str
"""A match made ready to be drawn, or a sentence on why it cannot be."""


def read_match(handle: StudyHandle, item_id: str, kept: Shapes) -> Shown:
    """A match made ready to be drawn (in a thread), the source on the left, or a sentence on why that cannot be."""
    try:
        item = study.item(handle, item_id)
        if item.kind == "puzzle":
            return join_picture(item.payload)
        first, second = found_again(handle, item, kept)
        return ready_pair((first[0], second[0]), (first[1], second[1]))
    except ConcordError as error:
        return str(error)


class MatchPreview(QWidget):
    """Shows what it is given; the view of shapes is made when the first shape comes."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.dark = False
        self.shown: Shown = PICK
        self.pair: VotingPairView | None = None
        self.join = JoinView(self)
        self.words = QLabel(PICK, self, wordWrap=True, alignment=Qt.AlignmentFlag.AlignCenter)
        self.words.setObjectName("soft")
        self.words.setTextFormat(Qt.TextFormat.PlainText)
        self.stage = QStackedLayout()
        self.stage.addWidget(self.words)
        self.stage.addWidget(self.join)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(self.stage, 1)

    def show_match(self, found: Shown) -> None:
        """Show a match, or a sentence in its place."""
        self.shown = found
        if isinstance(found, str):
            self.words.setText(found)
            self.stage.setCurrentWidget(self.words)
        elif isinstance(found, JoinPicture):
            self.join.set_picture(found)
            self.stage.setCurrentWidget(self.join)
        else:
            if self.pair is None:
                self.pair = VotingPairView(self)
                self.pair.set_theme(theme(self.dark))
                self.stage.addWidget(self.pair)
            self.stage.setCurrentWidget(self.pair)
            self.pair.present(found)

    def set_dark(self, dark: bool) -> None:
        """Follow the theme."""
        self.dark = dark
        self.join.set_theme(theme(dark))
        if self.pair is not None:
            self.pair.set_theme(theme(dark))

    def shutdown(self) -> None:
        """Give back what the view holds of the graphics system."""
        if self.pair is not None:
            self.pair.shutdown()


def files_of(payload: Mapping[str, Any]) -> tuple[str, str] | None:
    """The two mesh files that an item names, if both are there."""
    paths = [str(payload.get(side, {}).get("file", "")) for side in ("source", "target")]
    return (paths[0], paths[1]) if all(path and Path(path).is_file() for path in paths) else None
