"""The page of a pair of shapes: the two shapes and their links, the list, the reasons, the answers, the parameters."""

from collections.abc import Iterable, Sequence
from html import escape

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from engine.errors import ConcordError
from engine.shapes.parameters import PRESETS, MatchParameters

from ...folders import settings
from ...palette import rgb, segment_colours, theme
from ...parameter_form import ParameterForm
from ...session import Session, State
from ...views.mesh_pair import MeshPairView
from ...views.scene import Link, layer_colours, layer_nodes, link_of
from ..judging import Judging, checked_code
from .arrange import SHOWN, any_known, forbidden, listed, short_notes, short_union, smallest_with, state_of
from .automatic import AutomaticBar
from .layers import LayerBar, Place, node_list, step_layer, step_node
from .match_list import MatchList
from .matching import Matching
from .panels import JudgeStrip, WhyPanel, WishStrip
from .support import LeastSupport

PANEL_WIDTH, PANEL_MARGIN = 340, 8


def as_tip(lines: Iterable[str]) -> str:
    """Plain lines as a tool tip that wraps."""
    return "".join(f"<p>{escape(line)}</p>" for line in lines)


def links_of(state: State) -> list[Link]:
    """The links to draw: those that the list shows, or those of the layer that is walked through; best on top.

    A single node of a layer is shown without links, and so is what is forbidden.
    """
    rows = [m for m in listed(state, "score") if not forbidden(m)]
    if state.layer and state.node >= 0:
        return []
    if state.layer:
        rows = [m for m in rows if state.layer in (m.source_layer, m.target_layer)]
    known = {m.id: value for m in rows if (value := state.support.get(m.id, 1.0)) == value}  # not NaN
    return [link_of(m, state_of(m.id, state.verdicts), known.get(m.id, 1.0)) for m in reversed(rows)]


class ShapesPage(QWidget):
    """Draws the state of the session; what a hand does goes to the session, the matching and the judging."""

    failed = Signal(str, str)

    def __init__(self, session: Session, matching: Matching, judging: Judging, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.matching, self.judging = session, matching, judging
        self.view = MeshPairView(self)
        self.layers = LayerBar(self)
        self.automatic = AutomaticBar(self)
        self.linked = QPushButton("", self, checkable=True, toolTip="Turn both shapes together, or each on its own (L)")
        self.linked.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.list, self.why, self.judge = MatchList(self), WhyPanel(self), JudgeStrip(self)
        self.wish = WishStrip(self)
        self.form = ParameterForm(MatchParameters, self)
        self.filter, self.presets = self._combo(SHOWN.values()), self._combo(PRESETS)
        self.least = LeastSupport(self)
        self.count, self.notes = QLabel("", self), QLabel("", self)
        self.panel = self._panel()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addLayout(self._middle(), 1)
        row.addWidget(self.panel)
        self._connect()
        self.apply(State(), session.state, frozenset(State.__slots__))

    def _combo(self, texts: object) -> QComboBox:
        combo = QComboBox(self)
        combo.addItems(list(texts))
        combo.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        return combo

    def _middle(self) -> QVBoxLayout:
        low = QHBoxLayout()
        low.setContentsMargins(8, 4, 8, 4)
        low.addWidget(self.layers)
        low.addStretch(1)
        low.addWidget(self.linked)
        column = QVBoxLayout()
        column.setSpacing(0)
        column.addWidget(self.view, 1)
        column.addWidget(self.automatic)
        column.addLayout(low)
        return column

    def _panel(self) -> QTabWidget:
        tabs = QTabWidget(self)
        tabs.setFixedWidth(PANEL_WIDTH)
        tabs.setDocumentMode(True)
        tabs.tabBar().setDrawBase(False)
        tabs.tabBar().setFocusPolicy(Qt.FocusPolicy.TabFocus)
        tabs.addTab(self._matches_tab(), "Matches")
        tabs.addTab(self._parameters_tab(), "Parameters")
        return tabs

    def _matches_tab(self) -> QWidget:
        self.notes.setObjectName("soft")
        self.notes.setTextFormat(Qt.TextFormat.PlainText)
        self.notes.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        self.count.setObjectName("soft")
        self.filter.setToolTip("Main: the one-to-one matches, and merged ones that do not follow from smaller ones")
        head = QHBoxLayout()
        head.addWidget(self.filter)
        head.addStretch(1)
        head.addWidget(self.count)
        tab = QWidget(self)
        column = QVBoxLayout(tab)
        column.setContentsMargins(*[PANEL_MARGIN] * 4)
        column.setSpacing(8)
        column.addLayout(head)
        column.addWidget(self.least)
        column.addWidget(self.list, 1)
        for widget in (self.why, self.wish, self.judge, self.notes):
            column.addWidget(widget)
        return tab

    def _parameters_tab(self) -> QWidget:
        area = QScrollArea(self, widgetResizable=True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setWidget(self.form)
        head = QHBoxLayout()
        head.setContentsMargins(8, 8, 8, 4)
        head.setSpacing(8)
        head.addWidget(QLabel("Preset", self))
        head.addWidget(self.presets, 1)
        tab = QWidget(self)
        column = QVBoxLayout(tab)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(head)
        column.addWidget(area, 1)
        return tab

    def _connect(self) -> None:
        update = self.session.update
        self.session.changed.connect(self.apply)
        self.view.link_clicked.connect(lambda match_id: update(selected=match_id))
        self.view.segment_clicked.connect(self._segment)
        self.view.background_clicked.connect(lambda: update(selected="", node=-1))
        self.list.picked.connect(self._picked)
        self.list.ordered.connect(lambda order: update(order=order))
        self.filter.activated.connect(lambda row: update(shown=list(SHOWN)[row]))
        self.least.moved.connect(lambda least: update(least_support=least))
        self.presets.textActivated.connect(self.matching.choose_preset)
        self.form.edited.connect(self._edited)
        self.linked.toggled.connect(lambda on: update(linked=on))
        self.layers.layer_stepped.connect(self.step_layer)
        self.layers.node_stepped.connect(self.step_node)
        self.judge.answered.connect(self.judging.answer)
        self.judge.named.connect(self.name_volunteer)
        self.judging.saved.connect(self.judge.state.setText)

    # --- what a hand does

    def _picked(self, match_id: str) -> None:
        self.session.update(selected=match_id)
        self.frame()

    def frame(self) -> None:
        """Turn both shapes so that the selected match is seen."""
        match = self.session.state.match(self.session.state.selected)
        if match is not None:
            self.view.frame_match(match.source, match.target)

    def _segment(self, side: int, segment: int) -> None:
        state = self.session.state
        found = smallest_with(listed(state), side, segment)
        if found:
            self.session.update(selected=found)
        else:
            found = smallest_with(state.matches(), side, segment)
            self.session.update(selected=found, shown="all" if found else state.shown)
        if not found:
            self.judge.state.setText("")
            self.view.set_highlight(*(((segment,), ()) if side == 0 else ((), (segment,))),
                                    segment_colours(segment + 1)[segment])  # fmt: skip

    def _edited(self, name: str, value: object, settled: bool) -> None:
        try:
            self.matching.edit(name, value, settled)
        except ConcordError as error:
            self.failed.emit(str(error), "")
            self._show_parameters(self.session.state)

    def name_volunteer(self, text: str) -> None:
        """Vote under a code from now on."""
        try:
            code = checked_code(text)
        except ConcordError as error:
            self.failed.emit(str(error), "")
            self.judge.code.setText(self.session.state.volunteer)
            return
        settings().setValue("volunteer", code)
        self.session.update(volunteer=code)

    def step_layer(self, by: int) -> None:
        """Show the next or previous layer; below the first are the matches."""
        graphs = self._graphs()
        if graphs:
            place = step_layer(self._place(), by, max(g.layers for g in graphs))
            self.session.update(layer=place.layer, node=place.node, selected="")

    def step_node(self, by: int) -> None:
        """Show the next or previous node of the layer."""
        graphs = self._graphs()
        if graphs and self.session.state.layer:
            place = step_node(self._place(), by, len(node_list(*graphs, self.session.state.layer)))
            self.session.update(node=place.node, selected="")

    def step_match(self, by: int) -> None:
        """Select the next or previous match of the list, around its ends."""
        state = self.session.state
        ids = [m.id for m in listed(state)]
        if ids:
            here = ids.index(state.selected) if state.selected in ids else (-1 if by > 0 else 0)
            self._picked(ids[(here + by) % len(ids)])

    def _place(self) -> Place:
        return Place(self.session.state.layer, self.session.state.node)

    def _graphs(self) -> tuple:
        proposals = self.session.state.proposals
        return () if proposals is None else (proposals.source.layers, proposals.target.layers)

    # --- what the state says

    def apply(self, old: State, state: State, names: frozenset[str]) -> None:
        """Draw the difference between two states."""
        if "dark" in names:
            self.view.set_theme(theme(state.dark))
        shapes = bool(names & {"source", "target"})
        if shapes and state.source is not None and state.target is not None:
            self.view.set_shapes(state.source, state.target)
            self.show_automatic()
            self.view.set_linked_cameras(state.linked)
        if "linked" in names:
            self.view.set_linked_cameras(state.linked)
            self.linked.setChecked(state.linked)
            self.linked.setText("Cameras linked" if state.linked else "Cameras free")
        if names & {"result", "shown", "verdicts", "layer", "node", "source", "target", "support", "least_support", "wishes"}:
            self.view.set_links(links_of(state))
        if shapes or names & {"layer", "node", "selected", "result", "dark", "proposals"}:
            self._show_place(state)
        if names & {"result", "shown", "order", "selected", "verdicts", "answers", "dark", "source", "target", "support",
                    "least_support", "wishes", "bound"}:  # fmt: skip
            self._show_list(state, names)
        if names & {"parameters", "preset"}:
            self._show_parameters(state)
        if "selected" in names and state.selected and state.selected != old.selected and self.judging.advancing:
            self.frame()

    def _show_place(self, state: State) -> None:
        graphs = self._graphs()
        union_words = ""
        colours: list = [None, None]
        source, target, colour = (), (), None
        match = state.match(state.selected)
        if match is not None:
            source, target = match.source, match.target
        elif graphs and state.layer:
            faded = rgb(theme(state.dark).faded)
            nodes = node_list(*graphs, state.layer)
            if 0 <= state.node < len(nodes):
                side, row = nodes[state.node]
                union = tuple(graphs[side].members[row].nonzero()[0].tolist())
                source, target = (union, ()) if side == 0 else ((), union)
                colour = segment_colours(union[0] + 1)[union[0]]
                names = (state.source, state.target)[side].segmentation.names
                union_words = f"{('source', 'target')[side]} {short_union(names, union)}"
            colours = [layer_colours(layer_nodes(g, state.layer), segment_colours(g.members.shape[1]), faded)
                       for g in graphs]  # fmt: skip
        self.layers.show_place(Place(state.layer, state.node), *(graphs or (None, None)), union_words)
        self.view.set_layer_colours(*colours)
        self.view.set_selected(state.selected or None)
        self.view.set_highlight(source, target, colour)

    def _show_list(self, state: State, names: frozenset[str]) -> None:
        moved = names & {"result", "shown", "order", "source", "target", "support", "least_support", "wishes"}
        self.list.show_state(state, bool(moved or ("verdicts" in names and state.order.endswith("state"))))
        self.why.show_state(state)
        self.wish.show_state(state)
        self.judge.show_state(state)
        found, rows = len(state.matches()), len(self.list.rows.rows)
        self.count.setText(f"{rows} of {found}" if rows != found else f"{found} matches" if found != 1 else "1 match")
        self.least.setVisible(any_known((m.id for m in state.matches()), state.support))
        self.least.show_value(state.least_support)
        self.filter.setCurrentIndex(list(SHOWN).index(state.shown))
        self._show_notes(state.result.notes if state.result is not None else ())

    def _show_notes(self, notes: Sequence[str]) -> None:
        metrics, room = self.notes.fontMetrics(), PANEL_WIDTH - 2 * PANEL_MARGIN
        self.notes.setText(short_notes(notes, lambda line: metrics.elidedText(line, Qt.TextElideMode.ElideRight, room)))
        self.notes.setToolTip(as_tip(dict.fromkeys(notes)))
        self.notes.setVisible(bool(notes))

    def show_automatic(self) -> None:
        """Let the sliders of shapes without labels stand where the shapes are."""
        self.automatic.show_pair(self.session.state.source, self.session.state.target)

    def _show_parameters(self, state: State) -> None:
        self.presets.setCurrentText(state.preset)
        self.form.show_values(state.parameters, PRESETS[state.preset])

    def shutdown(self) -> None:
        """Give back what the view holds of the graphics system."""
        self.view.shutdown()
