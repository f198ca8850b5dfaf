"""Everything that can be done from the keyboard and the menus, in one table."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup, QIcon, QKeySequence
from PySide6.QtWidgets import QMenu

if TYPE_CHECKING:
    from .main_window import MainWindow


class Action(NamedTuple):
    """One command: the menu it stands in, its text, keys, icon, what it does with the window, and on which pages.

    Two commands may have the same key if they belong to different pages; without `pages` it belongs to all.
    """

    id: str
    menu: str
    text: str
    keys: tuple[str, ...]
    icon: str
    handler: Callable[["MainWindow"], object]
    checkable: bool = False
    pages: tuple[str, ...] = ()


PUZZLE, OTHERS, COLLECTION = ("puzzle",), ("shapes", "study", "results"), ("collection",)
SHAPES = ("shapes",)
EDITOR = ("segments",)
EXPORT = "E&xport"
MENUS = ("&File", "&Edit", "&View", "&Judge", "Se&gments", "&Puzzle", "&Study", EXPORT, "&Help")
INSIDE = {EXPORT: "&Study"}  # menus that stand in another one
SEPARATOR_BEFORE = {"open-folder", "open-picture", "export-figure", "export-picture", "quit", "next-match", "next-layer",
                    "link-cameras", "dark", "undo-vote", "merge-segments", "save-segments", "pin-match", "next-join", "truth",
                    "enrol", "send-packet", "export-votes", "volunteer"}  # fmt: skip
TABLE = (
    Action("open", "&File", "&Open two meshes…", ("Ctrl+O",), "mdi6.folder-open-outline", lambda w: w.files.open()),
    Action("source-labels", "&File", "&Labels of the source…", (), "", lambda w: w.files.labels(0)),
    Action("target-labels", "&File", "Labels of the &target…", (), "", lambda w: w.files.labels(1)),
    Action("open-folder", "&File", "Open a &folder of shapes as a collection…", ("Ctrl+K",), "mdi6.folder-multiple-outline",
           lambda w: w.collection.open_folder()),
    Action("open-meshes", "&File", "Open &several meshes as a collection…", ("Ctrl+Shift+K",), "",
           lambda w: w.collection.open_meshes()),
    Action("open-picture", "&File", "Open a picture as a &puzzle…", ("Ctrl+P",), "mdi6.image-plus-outline",
           lambda w: w.puzzle.files.open_picture()),
    Action("open-pieces", "&File", "Open a folder of p&ieces…", ("Ctrl+Shift+P",), "mdi6.folder-image",
           lambda w: w.puzzle.files.open_folder()),
    Action("export-figure", "&File", "Export &figure…", ("Ctrl+E",), "mdi6.image-outline",
           lambda w: w.files.export_figure(), pages=OTHERS),
    Action("export-result", "&File", "Export &matches…", ("Ctrl+Shift+E",), "mdi6.export",
           lambda w: w.files.export_result(), pages=OTHERS),
    Action("export-collection", "&File", "Export the &collection…", ("Ctrl+Shift+E",), "mdi6.export",
           lambda w: w.collection.export(), pages=COLLECTION),
    Action("export-picture", "&File", "Export the assembled pi&cture…", ("Ctrl+E",), "mdi6.image-outline",
           lambda w: w.puzzle.files.export_picture(), pages=PUZZLE),
    Action("export-solution", "&File", "Export positions and &joins…", ("Ctrl+Shift+E",), "mdi6.export",
           lambda w: w.puzzle.files.export_solution(), pages=PUZZLE),
    Action("quit", "&File", "&Quit", ("Ctrl+Q",), "", lambda w: w.close()),
    Action("undo", "&Edit", "&Undo", ("Ctrl+Z",), "mdi6.undo", lambda w: w.undo()),
    Action("redo", "&Edit", "&Redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "mdi6.redo", lambda w: w.undo(1)),
    Action("match-again", "&Edit", "&Match again", ("F5",), "", lambda w: w.match_again(), pages=OTHERS),
    Action("match-collection", "&Edit", "Match the collection &again", ("F5",), "", lambda w: w.collection.again(),
           pages=COLLECTION),
    Action("stop", "&Edit", "&Stop the running work", ("Esc",), "mdi6.stop", lambda w: w.stop()),
    Action("page-shapes", "&View", "&Shapes", ("Ctrl+1",), "mdi6.vector-link", lambda w: w.show_page("shapes")),
    Action("page-collection", "&View", "&Collection", ("Ctrl+2",), "mdi6.view-grid-outline", lambda w: w.show_page("collection")),
    Action("page-puzzle", "&View", "&Puzzle", ("Ctrl+3",), "mdi6.puzzle-outline", lambda w: w.show_page("puzzle")),
    Action("page-study", "&View", "S&tudy (voting screen)", ("Ctrl+4",), "mdi6.vote-outline", lambda w: w.show_page("study")),
    Action("page-results", "&View", "&Results", ("Ctrl+5",), "mdi6.table", lambda w: w.show_page("results")),
    Action("next-match", "&View", "&Next match", ("N",), "", lambda w: w.step_match(1), pages=OTHERS),
    Action("previous-match", "&View", "&Previous match", ("P",), "", lambda w: w.step_match(-1), pages=OTHERS),
    Action("next-part", "&View", "&Next part", ("N",), "", lambda w: w.collection.step_part(1), pages=COLLECTION),
    Action("previous-part", "&View", "&Previous part", ("P",), "", lambda w: w.collection.step_part(-1), pages=COLLECTION),
    Action("next-layer", "&View", "Layer &above", ("PgUp",), "", lambda w: w.shapes.step_layer(1), pages=OTHERS),
    Action("previous-layer", "&View", "Layer &below", ("PgDown",), "", lambda w: w.shapes.step_layer(-1), pages=OTHERS),
    Action("next-node", "&View", "Next node of the layer", ("]",), "", lambda w: w.shapes.step_node(1), pages=OTHERS),
    Action("previous-node", "&View", "Previous node of the layer", ("[",), "", lambda w: w.shapes.step_node(-1), pages=OTHERS),
    Action("link-cameras", "&View", "&Link cameras", ("L",), "", lambda w: w.toggle_linked(), pages=OTHERS),
    Action("reset-view", "&View", "R&eset the view", ("R",), "", lambda w: w.reset_view()),
    Action("turntable", "&View", "&Turn the shapes slowly", ("T",), "", lambda w: w.turn(), True, OTHERS),
    Action("inspect-source", "&View", "&Inspect the source by itself", ("Ctrl+I",), "", lambda w: w.inspect(0), pages=OTHERS),
    Action("inspect-target", "&View", "Inspect the target by itself", ("Ctrl+Shift+I",), "", lambda w: w.inspect(1), pages=OTHERS),
    Action("panel", "&View", "Ri&ght panel", ("F9",), "", lambda w: w.toggle_panel()),
    Action("alone", "&View", "Page &alone (no menus)", ("F11",), "", lambda w: w.toggle_alone()),
    Action("dark", "&View", "&Dark", ("Ctrl+D",), "", lambda w: w.toggle_dark()),
    Action("correct", "&Judge", "&Correct", ("J",), "", lambda w: w.answer("correct")),
    Action("wrong", "&Judge", "&Wrong", ("F",), "", lambda w: w.answer("wrong")),
    Action("unsure", "&Judge", "&Unsure", ("Space",), "", lambda w: w.answer("unsure")),
    Action("comment", "&Judge", "Co&mment on the question…", ("C",), "", lambda w: w.comment(), pages=OTHERS),
    Action("undo-vote", "&Judge", "&Take back the last vote", ("Backspace",), "", lambda w: w.undo_vote()),
    Action("pin-match", "&Judge", "Pin the match (&keep it)", ("K",), "mdi6.pin-outline", lambda w: w.wishing.pin(), pages=SHAPES),
    Action("forbid-match", "&Judge", "&Forbid the match", ("X",), "mdi6.cancel", lambda w: w.wishing.forbid(), pages=SHAPES),
    Action("bind-answers", "&Judge", "Use my &answers: correct pins, wrong forbids", (), "",
           lambda w: w.wishing.bind(not w.session.state.bound), True, SHAPES),
    Action("votes-as-pins", "&Judge", "Use the &votes as anchors", (), "mdi6.vote-outline", lambda w: w.wishing.use_votes(), pages=SHAPES),
    Action("open-pins", "&Judge", "&Open pinned and forbidden…", (), "", lambda w: w.wish_files.open(), pages=SHAPES),
    Action("save-pins", "&Judge", "&Save pinned and forbidden…", (), "", lambda w: w.wish_files.save(), pages=SHAPES),
    Action("clear-pins", "&Judge", "For&get pinned and forbidden", (), "", lambda w: w.wishing.clear(), pages=SHAPES),
    Action("edit-source", "Se&gments", "Edit segments of the &left shape…", ("Ctrl+G",), "mdi6.shape-outline",
           lambda w: w.segments.edit(0), pages=("shapes", *EDITOR)),
    Action("edit-target", "Se&gments", "Edit segments of the &right shape…", ("Ctrl+Shift+G",), "",
           lambda w: w.segments.edit(1), pages=("shapes", *EDITOR)),
    Action("merge-segments", "Se&gments", "&Merge the selected", ("M",), "mdi6.merge", lambda w: w.segments.merge(), pages=EDITOR),
    Action("split-segment", "Se&gments", "&Split the selected", ("S",), "mdi6.call-split", lambda w: w.segments.split(), pages=EDITOR),
    Action("knife", "Se&gments", "&Knife: cut along a line", ("X",), "mdi6.box-cutter", lambda w: w.segments.choose_tool("cut"),
           pages=EDITOR),
    Action("brush", "Se&gments", "&Brush: paint faces", ("B",), "mdi6.brush", lambda w: w.segments.choose_tool("brush"), pages=EDITOR),
    Action("new-segment", "Se&gments", "&New segment under the brush", ("N",), "mdi6.plus", lambda w: w.segments.new_segment(),
           pages=EDITOR),
    Action("larger-brush", "Se&gments", "Larger brush", ("]",), "", lambda w: w.segments.resize_brush(1), pages=EDITOR),
    Action("smaller-brush", "Se&gments", "Smaller brush", ("[",), "", lambda w: w.segments.resize_brush(-1), pages=EDITOR),
    Action("segment-again", "Se&gments", "Segment &automatically", ("F5",), "", lambda w: w.segments.segment(), pages=EDITOR),
    Action("save-segments", "Se&gments", "Sa&ve as .seg beside the mesh", ("Ctrl+S",), "mdi6.content-save-outline",
           lambda w: w.segments.save(), pages=EDITOR),
    Action("save-segments-as", "Se&gments", "Save &elsewhere…", ("Ctrl+Shift+S",), "", lambda w: w.segments.save_as(), pages=EDITOR),
    Action("segments-done", "Se&gments", "&Done: match again with these", ("Ctrl+Return",), "mdi6.check",
           lambda w: w.segments.done(), pages=EDITOR),
    Action("solve", "&Puzzle", "&Solve, or solve again", ("F5",), "mdi6.puzzle-check-outline", lambda w: w.puzzle.solve(), pages=PUZZLE),
    Action("next-join", "&Puzzle", "&Next most doubtful join", ("N",), "", lambda w: w.puzzle.page.step_join(1), pages=PUZZLE),
    Action("previous-join", "&Puzzle", "Join &before", ("P",), "", lambda w: w.puzzle.page.step_join(-1), pages=PUZZLE),
    Action("lock", "&Puzzle", "&Lock the join or piece", ("L",), "mdi6.lock-outline", lambda w: w.puzzle.hands.lock(), pages=PUZZLE),
    Action("reject", "&Puzzle", "Re&ject the join or piece", ("X",), "mdi6.close", lambda w: w.puzzle.hands.reject(), pages=PUZZLE),
    Action("turn-piece", "&Puzzle", "Turn the piece by a &quarter", (".",), "mdi6.rotate-right", lambda w: w.puzzle.hands.turn(),
           pages=PUZZLE),
    Action("clear-wishes", "&Puzzle", "&Forget locks, rejections and pins", (), "", lambda w: w.puzzle.hands.clear(), pages=PUZZLE),
    Action("open-wishes", "&Puzzle", "&Open locks and pins…", (), "", lambda w: w.puzzle.files.open_wishes(), pages=PUZZLE),
    Action("contrast", "&Puzzle", "Spread the &tones of the close-up", ("C",), "", lambda w: w.puzzle.page.join.contrast.toggle(),
           pages=PUZZLE),
    Action("truth", "&Puzzle", "&Compare with the truth", ("T",), "", lambda w: w.puzzle.page.toggle_truth(), pages=PUZZLE),
    Action("new-study", "&Study", "&New study…", ("Ctrl+N",), "", lambda w: w.studies.new_study()),
    Action("open-study", "&Study", "&Open study…", ("Ctrl+Shift+O",), "", lambda w: w.studies.open_study()),
    Action("open-project", "&Study", "Open a &project folder…", (), "", lambda w: w.studies.open_folder()),
    Action("open-server", "&Study", "Open on a &server…", (), "", lambda w: w.studies.open_server()),
    Action("own-study", "&Study", "My own &votes", (), "", lambda w: w.judging.open()),
    Action("enrol", "&Study", "&Add these matches to the study", (), "", lambda w: w.enrol()),
    Action("top-up", "&Study", "&Top up…", (), "", lambda w: w.studies.top_up()),
    Action("send-packet", "&Study", "Send a pac&ket…", (), "", lambda w: w.studies.people.send_packet()),
    Action("take-in", "&Study", "Ta&ke in a returned file…", (), "", lambda w: w.studies.people.take_in()),
    Action("invite", "&Study", "&Invite a volunteer…", (), "", lambda w: w.studies.people.invite()),
    Action("report-csv", EXPORT, "Section as &CSV…", (), "", lambda w: w.studies.exports.report("csv")),
    Action("report-markdown", EXPORT, "Tables as &Markdown…", (), "", lambda w: w.studies.exports.report("markdown")),
    Action("report-latex", EXPORT, "Tables as &LaTeX…", (), "", lambda w: w.studies.exports.report("latex")),
    Action("report-html", EXPORT, "Report with pictures (&HTML)…", (), "", lambda w: w.studies.exports.report("html")),
    Action("report-figure", EXPORT, "Plot as a &figure (SVG, PDF, PNG)…", (), "", lambda w: w.studies.exports.figure()),
    Action("export-votes", EXPORT, "Votes and matches as &tables…", (), "", lambda w: w.studies.exports.export()),
    Action("datasheet", EXPORT, "&Datasheet…", (), "", lambda w: w.studies.exports.datasheet()),
    Action("archive", EXPORT, "&Archive…", (), "", lambda w: w.studies.exports.archive()),
    Action("volunteer", "&Study", "&Who is voting…", (), "", lambda w: w.files.name_volunteer()),
    Action("keys", "&Help", "&Keys", ("F1", "?"), "", lambda w: w.show_keys()),
    Action("about", "&Help", "&About Concord", (), "", lambda w: w.show_about()),
)


MOUSE = {
    "segments": (("Click", "select a segment"), ("Shift click", "select another as well"), ("Drag", "turn, paint or cut, by the tool"),
                 ("Right drag", "turn the shape with every tool"), ("Wheel", "zoom"),
                 ("Double click beside the shape", "usual view")),
    "shapes": (("Drag", "turn a shape"), ("Shift or right drag", "move it"), ("Wheel, two fingers", "zoom"),
               ("Double click", "usual view"), ("Click", "select a match or a segment's smallest match")),
    "collection": (("Drag", "turn all shapes"), ("Click a part", "light it up in all shapes"),
                   ("Click two names", "see the matches of these two shapes")),
    "puzzle": (("Drag a piece", "put it elsewhere; it snaps to its neighbours and stays"),
               ("Drag the ground, or with the right button", "move the view"), ("Wheel", "zoom"),
               ("Click between two pieces", "see their join from close by"),
               ("Click a piece in the tray", "see its best partner, once more for its next side")),
}  # fmt: skip


def make_actions(window: "MainWindow") -> dict[str, QAction]:
    """One QAction for each row, with its keys valid in the whole window."""
    made: dict[str, QAction] = {}
    for row in TABLE:
        action = QAction(row.text, window, checkable=row.checkable)
        action.setShortcuts([QKeySequence(keys) for keys in row.keys])
        action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        action.triggered.connect(lambda _=False, row=row: row.handler(window))
        window.addAction(action)
        made[row.id] = action
    return made


def enable_for(actions: dict[str, QAction], page: str) -> None:
    """Enable what belongs to a page, so that its keys mean what they mean there."""
    for row in TABLE:
        if row.pages:
            actions[row.id].setEnabled(page in row.pages)


def add_icons(actions: dict[str, QAction], colour: str) -> None:
    """Static icons in one colour; reading the icon font costs a moment, so this comes after the first paint."""
    for row in TABLE:
        if row.icon:
            actions[row.id].setIcon(icon(row.icon, colour))


def icon(name: str, colour: str) -> QIcon:
    """One icon of the font, in a colour."""
    import qtawesome

    return qtawesome.icon(name, color=colour)


def fill_menus(window: "MainWindow", actions: dict[str, QAction]) -> dict[str, QMenu]:
    """The menu bar, from the table."""
    menus = {name: window.menuBar().addMenu(name) for name in MENUS if name not in INSIDE}
    for row in TABLE:
        if row.menu not in menus:
            menus[row.menu] = menus[INSIDE[row.menu]].addMenu(row.menu)
        if row.id in SEPARATOR_BEFORE:
            menus[row.menu].addSeparator()
        menus[row.menu].addAction(actions[row.id])
    return menus


def add_choices(menu: QMenu, texts: list[str], chosen: Callable[[str], object], group: QActionGroup | None = None) -> None:
    """Entries that hand their text to one function; with a group, one of them is ticked."""
    for text in texts:
        action = menu.addAction(text)
        action.triggered.connect(lambda _=False, text=text: chosen(text))
        if group is not None:
            action.setCheckable(True)
            group.addAction(action)


def submenu(menu: QMenu, text: str, before: QAction) -> QMenu:
    """A menu inside another, above an action."""
    made = QMenu(text, menu)
    menu.insertMenu(before, made)
    return made


def keys_table(page: str = "") -> str:
    """The keys of a page, or all of them, as an HTML table, by menu."""
    rows = []
    for menu in MENUS:
        here = [row for row in TABLE if row.menu == menu and row.keys and (not page or not row.pages or page in row.pages)]
        if here:
            rows.append(f"<tr><td colspan=2 style='padding-top:8px'><b>{menu.replace('&', '')}</b></td></tr>")
        for row in here:
            text = row.text.replace("&", "").rstrip("…")
            rows.append(f"<tr><td style='padding-right:24px'>{text}</td><td>{' or '.join(row.keys)}</td></tr>")
    mouse = MOUSE.get(page, MOUSE["shapes"]) if page else sum(MOUSE.values(), ())
    rows.append("<tr><td colspan=2 style='padding-top:8px'><b>Mouse</b></td></tr>")
    rows += [f"<tr><td style='padding-right:24px'>{what[0].upper()}{what[1:]}</td><td>{how}</td></tr>" for how, what in mouse]
    return "<table>" + "".join(rows) + "</table>"
