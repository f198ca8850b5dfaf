"""Walking through the layers of the two multi-layer graphs, and through the nodes of a layer one by one."""

from typing import NamedTuple

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QWidget

from engine.shapes.multilayer import MultiLayerGraph


class Place(NamedTuple):
    """A layer (0: none, the matches are shown) and the row of a node in its list (-1: all)."""

    layer: int
    node: int


def nodes_of(graph: MultiLayerGraph, layer: int) -> np.ndarray:
    """Rows of the nodes of a layer, (n,) int64."""
    return np.flatnonzero(graph.layer == layer)


def node_list(source: MultiLayerGraph, target: MultiLayerGraph, layer: int) -> list[tuple[int, int]]:
    """(side, row) of all nodes of a layer, the source's first."""
    return [(side, int(row)) for side, graph in enumerate((source, target)) for row in nodes_of(graph, layer)]


def step_layer(place: Place, by: int, layers: int) -> Place:
    """The next or previous layer of 0..layers, without going around."""
    return Place(min(layers, max(0, place.layer + by)), -1)


def step_node(place: Place, by: int, nodes: int) -> Place:
    """The next or previous node of the layer; all nodes at once lie before the first and after the last."""
    return Place(place.layer, (place.node + 1 + by) % (nodes + 1) - 1) if nodes else Place(place.layer, -1)


def layer_words(place: Place, layers: int, here: int, there: int) -> str:
    """'layer 3 of 8 · 41 + 38 nodes', or what is shown without a layer."""
    if not place.layer:
        return f"matches   ▸ layers 1–{layers}" if layers else ""
    return f"layer {place.layer} of {layers} · {here} + {there} nodes"


class LayerBar(QWidget):
    """◀ layer 3 of 8 · 41 + 38 nodes ▶   ◂ node 5 of 79 ▸"""

    layer_stepped = Signal(int)
    node_stepped = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.back, self.on = self._button("◀", "The layer below; the first is the matches"), self._button("▶", "The layer above")
        self.node_back, self.node_on = self._button("◂", "Previous node of the layer"), self._button("▸", "Next node")
        self.words, self.node_words = QLabel("matches", self), QLabel("", self)
        self.words.setMinimumWidth(196)
        self.node_words.setMinimumWidth(128)
        for label in (self.words, self.node_words):
            label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        for widget in (self.back, self.words, self.on, self.node_back, self.node_words, self.node_on):
            row.addWidget(widget)
        for button, signal, by in ((self.back, self.layer_stepped, -1), (self.on, self.layer_stepped, 1),
                                   (self.node_back, self.node_stepped, -1), (self.node_on, self.node_stepped, 1)):  # fmt: skip
            button.clicked.connect(lambda _=False, signal=signal, by=by: signal.emit(by))
        self.show_place(Place(0, -1), None, None)

    def _button(self, text: str, tip: str) -> QToolButton:
        button = QToolButton(self, text=text, toolTip=tip, autoRaise=True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setAutoRepeat(True)
        button.setFixedSize(28, 28)
        return button

    def show_place(self, place: Place, source: MultiLayerGraph | None, target: MultiLayerGraph | None,
                   union: str = "") -> None:  # fmt: skip
        """Say where the walk is, and the `union` that the node stands for; without graphs there is nothing to walk."""
        ready = source is not None and target is not None
        layers = max(source.layers, target.layers) if ready else 0
        here, there = (len(nodes_of(g, place.layer)) for g in (source, target)) if ready and place.layer else (0, 0)
        self.words.setText(layer_words(place, layers, here, there))
        self.back.setEnabled(ready and place.layer > 0)
        self.on.setEnabled(ready and place.layer < layers)
        for widget in (self.node_back, self.node_words, self.node_on):
            widget.setVisible(bool(place.layer) and here + there > 0)
        at = "all nodes" if place.node < 0 else f"node {place.node + 1} of {here + there}"
        self.node_words.setText(f"{at} · {union}" if union else at)
