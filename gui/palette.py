"""Colours that are safe for colour-blind eyes: segments, judgements, and the light and the dark theme.

The table and the themes are plain constants, so that neither Qt nor glasbey is imported before it is needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from PySide6.QtGui import QPalette
    from PySide6.QtWidgets import QApplication

CORRECT, WRONG, UNDECIDED, TIE = "#0072B2", "#D55E00", "#8A8F98", "#A0569A"
SERIES = ("#2F8F7F", "#C98A00", "#7A6FD0", "#B8567F", "#5B8C2A", "#4A9CC9", "#8A8F98", "#A5673F")  # methods in plots; beside a symbol

# The segment table keeps away from papers and judgements; a prefix of it is as spread as it can be:
# glasbey.extend_palette(RESERVED, palette_size=261, grid_size=32, lightness_bounds=(45, 80), chroma_bounds=(20, 44),
#                        hue_bounds=(0, 360), colorblind_safe=True, optimize_palette=False)[5:]
RESERVED = ("#FAFAF7", "#1E2024", CORRECT, WRONG, UNDECIDED)
_TABLE = (
    "b5bd5a8cd6ffff9cc5b5735a63d6b59494deffc5adde9cde4aad84ef8c844abdc5ad6badd67b9cb58c3194e6e63194ad"
    "efc5eff7ce7394bd8cc584b563944a4ab5a59cde94b56b94ad737b009c84b5adf794c5c5949cbde6adadffa57b9c9c6b"
    "f7c5d6b5dec529a5a5de8c5adebdffd6737b8c7bbda5b5d6ce9cb55a946bb5cee6c58cd68cb5a56bb5ded6949cf79cd6"
    "94ad52b5733a8484a552a5c584d6a5ceb5d6add6ce6bcede8cadb5c5ad73ffb5dea584bdce7b5ad6c57be6ad948cad8c"
    "bd9cc5739c8c84e6f7ce73a5c5d6ad5aa56bf7adef6bb5734ac5bda584a5c59484c56b8c5a9c94849c4aefa55a73c5b5"
    "63c59ce68cc5b5c58cbd848c7bc5efdea5b5f7bdbd5a94c5948c5a9cc5adefce9473e6c5a5a5d66bd6d6c5d6ffb58ca5"
    "6bdeceb5bdefb59452d69c4a6394a563a5b5d6adc5849c7b73a5a58cbd73ff949c4a9494848c31e68cadbd6ba5ef9473"
    "bd6b6bce9ce6bdde848ce6add684ad5a947bb58473e6b5c5a5bdce9ca5efdebd5aadced642ad948494bdffb594b58cbd"
    "de7b734abd9cc59c73d6adffff9cb5c594a573bdd6bd73b57ba59c29a5849c84ce8cadc5a5ce73e6848ca594cef7bdff"
    "deadefd6a59473ad94c594b5c57b42d68cce84b5add6c5ef948cadffada5ffb56b5ab5b5b5a5639cd6bd9cad7b7ba5d6"
    "cea5c57bce8cad738c8ce6d6bda5d6947b9cadc59c849cadcece94ef94bd7bc5cece8c426bad7bb5dede738cb57bc5ad"
    "d6b5739cb5e68cd6ef31ada5ef94a5a5c5ff9cc5bdffade6b58494dea5d6bdadcebd8c6be6bdded68494d6a5846bbd8c"
    "639c7befadceaddeef63adc59cc5dee69c63b594b594bd9ca58c4a73dee6adb563199ca54a9cb58484ce739c5ace736b"
    "c56b7b7b946bbdbddeb59ce6c57b9ca57b94a57b4aa573bd84e6bd9cdeffd6738cb5a542a57badc5ade6ad7b2994b5c5"
    "299c738ca55aadd6b5c5de9cdebd94ce8c63ffadbdf794b59cd69cd6ce6b63945ab584ce9c9c42f7bd84b5b584ffadce"
    "bd8c84f79c8484bdbd9cc57bb5ceff009c8c73949c8c8c4a63cec5bd6b4aad846394ad6b63b58c7b94ceb57b7b5a9c8c"
)  # fmt: skip
SEGMENTS = np.frombuffer(bytes.fromhex(_TABLE), np.uint8).reshape(-1, 3)


def segment_colours(count: int) -> np.ndarray:
    """Colours (count, 3) uint8 of segments 0..count-1: stable by index, repeated after 256."""
    return SEGMENTS[np.arange(count) % len(SEGMENTS)]


def rgb(colour: str) -> np.ndarray:
    """The colour '#RRGGBB' as (3,) uint8."""
    return np.frombuffer(bytes.fromhex(colour[1:]), np.uint8)


@dataclass(frozen=True, slots=True)
class Theme:
    """The colours of one theme, as '#RRGGBB'."""

    dark: bool
    paper: str
    panel: str
    raised: str
    ink: str
    soft_ink: str
    line: str
    accent: str
    on_accent: str
    faded: str
    halo: str
    correct: str
    wrong: str
    undecided: str
    tie: str

    def state(self, state: str) -> str:
        """The colour of a judgement: 'correct', 'wrong', 'tie' or 'undecided'."""
        return {"correct": self.correct, "wrong": self.wrong, "tie": self.tie}.get(state, self.undecided)


LIGHT = Theme(
    dark=False, paper="#FAFAF7", panel="#F1F1EC", raised="#FFFFFF", ink="#22252A", soft_ink="#5E646E", line="#D5D5CE",
    accent="#2B7A6B", on_accent="#FFFFFF", faded="#DFE0DD", halo="#FFFFFF",
    correct=CORRECT, wrong=WRONG, undecided=UNDECIDED, tie=TIE,
)  # fmt: skip
DARK = Theme(
    dark=True, paper="#1E2024", panel="#26292E", raised="#2F3339", ink="#E6E6E3", soft_ink="#A3A8B0", line="#3D424A",
    accent="#62B8A6", on_accent="#14211E", faded="#4A4E55", halo="#F4F4F1",
    correct="#3E9BD6", wrong="#E8712A", undecided="#9A9FA8", tie="#C98BC4",
)  # fmt: skip


def theme(dark: bool) -> Theme:
    """The dark or the light theme."""
    return DARK if dark else LIGHT


def system_is_dark(app: QApplication) -> bool:
    """What the desktop asks for; light where it says nothing."""
    from PySide6.QtCore import Qt

    return app.styleHints().colorScheme() == Qt.ColorScheme.Dark


def apply_theme(app: QApplication, dark: bool | None = None) -> Theme:
    """Give the whole application the Fusion style in the wanted theme (the system's if None) and return the theme."""
    chosen = theme(system_is_dark(app) if dark is None else dark)
    app.setStyle("Fusion")
    app.setPalette(qt_palette(chosen))
    app.setStyleSheet(style_sheet(chosen))
    return chosen


def qt_palette(colours: Theme) -> QPalette:
    """The theme as a Qt palette, with soft ink for what is disabled."""
    from PySide6.QtGui import QColor, QPalette

    role = QPalette.ColorRole
    palette = QPalette()
    for roles, colour in (
        ((role.Window, role.AlternateBase), colours.panel),
        ((role.Base,), colours.paper),
        ((role.Button, role.ToolTipBase), colours.raised),
        ((role.WindowText, role.Text, role.ButtonText, role.ToolTipText, role.BrightText), colours.ink),
        ((role.PlaceholderText,), colours.soft_ink),
        ((role.Highlight, role.Link, role.Accent), colours.accent),
        ((role.HighlightedText,), colours.on_accent),
        ((role.Mid, role.Midlight, role.Dark), colours.line),
    ):
        for one in roles:
            palette.setColor(one, QColor(colour))
    for one in (role.WindowText, role.Text, role.ButtonText):
        palette.setColor(QPalette.ColorGroup.Disabled, one, QColor(colours.soft_ink))
    return palette


def style_sheet(colours: Theme) -> str:
    """What Fusion leaves too heavy, and what it does not show in the dark. Distances are multiples of 4 px."""
    from assets import folder

    tick, up, down = (f"{folder().as_posix()}/style/{name}-{'dark' if colours.dark else 'light'}.svg" for name in ("tick", "up", "down"))
    return f"""
    QCheckBox::indicator, QRadioButton::indicator, QAbstractItemView::indicator {{
        width: 14px; height: 14px; border: 1px solid {colours.soft_ink}; border-radius: 3px; background: {colours.raised}; }}
    QRadioButton::indicator {{ border-radius: 8px; }}
    QCheckBox::indicator:checked, QAbstractItemView::indicator:checked {{
        background: {colours.accent}; border-color: {colours.accent}; image: url("{tick}"); }}
    QRadioButton::indicator:checked {{ border: 4px solid {colours.accent}; width: 8px; height: 8px; background: {colours.raised}; }}
    QCheckBox::indicator:focus, QRadioButton::indicator:focus {{ border-color: {colours.accent}; }}
    QCheckBox::indicator:disabled, QRadioButton::indicator:disabled {{ border-color: {colours.line}; background: {colours.panel}; }}
    QDialog QLineEdit, QDialog QPlainTextEdit, QDialog QAbstractSpinBox, QDialog QComboBox {{
        border: 1px solid {colours.line}; border-radius: 4px; padding: 3px 6px; background: {colours.raised}; }}
    QDialog QLineEdit:focus, QDialog QPlainTextEdit:focus, QDialog QAbstractSpinBox:focus, QDialog QComboBox:focus {{
        border-color: {colours.accent}; }}
    QDialog QAbstractSpinBox QLineEdit, QDialog QComboBox QLineEdit, QDialog QAbstractItemView QLineEdit {{
        border: none; padding: 0px 0px 0px 4px; background: transparent; }}
    QDialog QAbstractSpinBox::up-button, QDialog QAbstractSpinBox::down-button, QDialog QComboBox::drop-down {{
        border: none; width: 18px; background: transparent; }}
    QDialog QAbstractSpinBox::up-arrow {{ image: url("{up}"); width: 10px; height: 10px; }}
    QDialog QAbstractSpinBox::down-arrow, QDialog QComboBox::down-arrow {{ image: url("{down}"); width: 10px; height: 10px; }}
    QToolTip {{ color: {colours.ink}; background: {colours.raised}; border: 1px solid {colours.line}; padding: 4px; }}
    QPushButton {{ background: {colours.raised}; border: 1px solid {colours.line}; border-radius: 4px;
                   padding: 4px 12px; }}
    QPushButton:hover {{ border-color: {colours.accent}; }}
    QPushButton:pressed, QPushButton:checked {{ background: {colours.line}; }}
    QPushButton:focus {{ border: 1px solid {colours.accent}; }}
    QPushButton:disabled {{ color: {colours.soft_ink}; background: {colours.panel}; }}
    QPushButton:default {{ background: {colours.accent}; color: {colours.on_accent}; border-color: {colours.accent}; }}
    QToolButton {{ border: none; border-radius: 4px; padding: 4px; }}
    QToolButton:hover {{ background: {colours.line}; }}
    QTabWidget::pane {{ border: none; border-top: 1px solid {colours.line}; }}
    QTabBar::tab {{ background: transparent; border: none; border-bottom: 2px solid transparent; padding: 8px 12px;
                    color: {colours.soft_ink}; }}
    QTabBar::tab:selected {{ color: {colours.ink}; border-bottom-color: {colours.accent}; }}
    QTabBar::tab:hover {{ color: {colours.ink}; }}
    QAbstractItemView {{ border: 1px solid {colours.line}; border-radius: 4px; outline: none; }}
    QHeaderView::section {{ background: {colours.panel}; color: {colours.soft_ink}; border: none;
                            border-bottom: 1px solid {colours.line}; padding: 4px 8px; }}
    QStatusBar {{ background: {colours.panel}; border-top: 1px solid {colours.line}; }}
    QStatusBar::item {{ border: none; }}
    QSplitter::handle {{ background: {colours.line}; }}
    QProgressBar {{ border: none; border-radius: 4px; background: {colours.line}; text-align: center;
                    max-height: 8px; }}
    QProgressBar::chunk {{ border-radius: 4px; background: {colours.accent}; }}
    """
