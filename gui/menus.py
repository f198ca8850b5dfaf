"""The menus of the window: the table of actions, recent files, examples and presets."""

from typing import TYPE_CHECKING

from PySide6.QtGui import QActionGroup
from PySide6.QtWidgets import QMenu

from . import actions
from .folders import recent_pairs

if TYPE_CHECKING:
    from .main_window import MainWindow


def furnish_menus(window: "MainWindow") -> None:
    """Make the actions of a window and its menu bar."""
    from engine.shapes.parameters import PRESETS

    window.actions_by_id = actions.make_actions(window)
    menus = actions.fill_menus(window, window.actions_by_id)
    before = window.actions_by_id["source-labels"]
    window.recent_menu = actions.submenu(menus["&File"], "Open &recent", before)
    window.recent_menu.aboutToShow.connect(lambda: _fill_recent(window, window.recent_menu))
    _fill_examples(window, actions.submenu(menus["&File"], "Open an e&xample", before))
    window.preset_group = QActionGroup(window)
    window.preset_menu = menus["&Edit"].addMenu("&Preset")
    actions.add_choices(window.preset_menu, list(PRESETS), window.matching.choose_preset, window.preset_group)
    window.status.preset.setMenu(window.preset_menu)
    window.status.preset.show()


def furnish_wishes(window: "MainWindow") -> None:
    """The menu of the button beside Pin and Forbid."""
    menu = QMenu(window.shapes.wish.more)
    for name in ("bind-answers", "votes-as-pins", "open-pins", "save-pins", "clear-pins"):
        menu.addAction(window.actions_by_id[name])
    window.shapes.wish.more.setMenu(menu)


def furnish_exports(window: "MainWindow") -> None:
    """The menu of the button on the page of results: the same as in the menu of studies."""
    for row in actions.TABLE:
        if row.menu == actions.EXPORT:
            if row.id in actions.SEPARATOR_BEFORE:
                window.results.export_menu.addSeparator()
            window.results.export_menu.addAction(window.actions_by_id[row.id])


def _fill_examples(window: "MainWindow", menu: QMenu) -> None:
    from assets import example_pairs

    for name, _source, _target in example_pairs():
        menu.addAction(name).triggered.connect(lambda _=False, name=name: window.open_example(name))
    menu.addSeparator()
    menu.addAction("puzzle").triggered.connect(lambda _=False: window.puzzle.open_example())


def _fill_recent(window: "MainWindow", menu: QMenu) -> None:
    menu.clear()
    for source, target in recent_pairs():
        names = " – ".join(path.rpartition("/")[2] for path in (source, target))
        action = menu.addAction(names)
        action.setToolTip(f"{source}\n{target}")
        action.triggered.connect(lambda _=False, pair=(source, target): window.files.pair(*pair))
    if menu.isEmpty():
        menu.addAction("Nothing was opened yet").setEnabled(False)
