"""Nothing that a volunteer's window holds, says or writes tells who proposed a match, what is gold, or what others think."""

import contextlib
import gc
import io
import logging
import random

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, Qt
from PySide6.QtGui import QAction, QContextMenuEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget
from test_volunteer import current, press, windows  # noqa: F401  (the fixture)
from voting_world import SECRETS, make_study, settle

from annotation import study
from gui.pages.voting.questions import JoinQuestion, Question

K = Qt.Key
ACTIONS = 160  # 500 with other seeds were tried, too; they take 20 s


def texts(root):
    """Every word that a widget can show, say or hand on."""
    found = [QApplication.clipboard().text(), QApplication.applicationName(), QApplication.applicationDisplayName()]
    for widget in [root, *root.findChildren(QWidget), *QApplication.topLevelWidgets()]:
        for name in ("text", "toolTip", "windowTitle", "accessibleName", "accessibleDescription", "placeholderText", "title",
                     "statusTip", "whatsThis", "objectName", "plainText", "windowFilePath", "styleSheet"):  # fmt: skip
            say = getattr(widget, name, None)
            if callable(say):
                found.append(str(say()))
        for name in widget.dynamicPropertyNames():
            with contextlib.suppress(RuntimeError):  # one of Qt's own, of no type that Python knows
                found.append(f"{name.data().decode()}={widget.property(name.data().decode())}")
        found += [action.text() + action.toolTip() for action in widget.actions()]
    return found


def reachable(*roots):
    """All texts in what objects hold, as deep as it goes, but for the study's own handle and what is not data."""
    seen, left, found = set(), list(roots), []
    while left:
        one = left.pop()
        if id(one) in seen or isinstance(one, type) or (callable(one) and not isinstance(one, QObject)):
            continue
        seen.add(id(one))
        if isinstance(one, str):
            found.append(one)
        elif isinstance(one, dict):
            left += [*one.keys(), *one.values()]
        elif isinstance(one, list | tuple | set | frozenset):
            left += one
        elif type(one).__module__.split(".")[0] in ("gui", "annotation", "engine"):
            slots = [name for kind in type(one).__mro__ for name in getattr(kind, "__slots__", ())]
            names = [*getattr(one, "__dict__", ()), *slots]
            left += [getattr(one, name, None) for name in names if name != "handle"]
    return found


def test_no_secret_reaches_the_window_its_output_or_its_files(qtbot, windows, tmp_path, make_bar, monkeypatch, capfd):  # noqa: F811
    (tmp_path / "home").mkdir()
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "home"))
    log = io.StringIO()
    handler = logging.StreamHandler(log)
    logging.getLogger().addHandler(handler)
    level = logging.getLogger().level
    logging.getLogger().setLevel(logging.DEBUG)
    path = tmp_path / "bars.study"
    ids = make_study(path, make_bar)
    said = []
    try:
        window = windows(path, start=False)
        qtbot.waitUntil(lambda: window.screen.notice.heading.text() == "Welcome", timeout=20_000)

        def look():
            said.extend(texts(window))
            said.extend(reachable(window.desk, window.screen, window.screen.view, window.screen.join_view))

        def also(*keys):
            for key in keys:
                press(qtbot, window, key)
                look()

        look()
        also(K.Key_Return, K.Key_F, K.Key_Return, K.Key_J, K.Key_Return)
        for _ in range(5):
            also(K.Key_J)
        also(K.Key_Backspace, K.Key_C)
        qtbot.keyClicks(window.screen.comment.line, "mine")
        qtbot.keyClick(window.screen.comment.line, K.Key_Return)
        also(K.Key_F, K.Key_G, K.Key_G, K.Key_N, K.Key_R, K.Key_T, K.Key_T, K.Key_Escape, K.Key_Space)
        while window.desk.question is not None:
            also(K.Key_J)
        assert window.screen.notice.heading.text() == "All done, thank you!"
        look()
        voted = {item for (item, round_), _ in current(path).items() if round_}
        assert set(ids["gold"]) <= voted  # gold was among what was asked
        assert window.menuWidget() is None
        assert not window.findChildren(QAction)
    finally:
        logging.getLogger().removeHandler(handler)
        logging.getLogger().setLevel(level)
    out, err = capfd.readouterr()
    files = [file.read_bytes().decode("utf-8", "replace") for file in (tmp_path / "home").rglob("*") if file.is_file()]
    everything = "\n".join([*said, out, err, log.getvalue(), *files])
    assert "Ends go with ends." in everything  # it did look
    for name, secret in SECRETS.items():
        assert secret not in everything, name
    assert "gold" not in "\n".join([*said, out, err, *files]).lower()


def test_a_gold_match_is_asked_like_any_other(qtbot, windows, tmp_path, make_bar):  # noqa: F811
    path = tmp_path / "bars.study"
    ids = make_study(path, make_bar, practice=0, gold=3, joins=0)
    window, shapes = windows(path), {}
    while window.desk.question is not None:
        one = window.desk.question
        shapes[one.asked.item_id] = (type(one), one._fields, one.asked.round, one.words, type(one.pair), window.screen.small.counter.text())
        press(qtbot, window, K.Key_J)
    kinds = {role: {shapes[i][:5] for i in ids[role]} for role in ("gold", "judged")}
    assert kinds["gold"] == kinds["judged"]
    assert len(shapes) == 8


def test_a_packet_opens_under_its_own_code(qtbot, windows, tmp_path, make_bar):  # noqa: F811
    from annotation.exchange.packets import make_packet

    path = tmp_path / "bars.study"
    make_study(path, make_bar, votes=2)
    with study.open_study(path) as handle:
        make_packet(handle, "anna", tmp_path / "anna.packet")
    window = windows(tmp_path / "anna.packet", "")
    assert window.desk.code == "anna"
    assert window.desk.question is not None
    press(qtbot, window, K.Key_J)
    assert list(current(tmp_path / "anna.packet")) == [(window.desk.question.asked.item_id, 0)]
    other = windows(tmp_path / "anna.packet", "ben", start=False)
    qtbot.waitUntil(lambda: other.screen.notice.trouble.text() != "", timeout=20_000)
    assert other.screen.notice.trouble.text().startswith("This is for another volunteer than ben;")
    assert len(other.screen.notice.buttons) == 2  # nobody new can take part in a packet


class Hands:
    """What a volunteer may press, in any order."""

    KEYS = (K.Key_J, K.Key_F, K.Key_Space, K.Key_Backspace, K.Key_N, K.Key_R, K.Key_T, K.Key_C, K.Key_G, K.Key_Question,
            K.Key_Escape, K.Key_Return, K.Key_Tab, K.Key_Backtab, K.Key_Up, K.Key_Q, K.Key_F5, K.Key_Delete)  # fmt: skip

    def __init__(self, window, rng):
        self.window, self.rng = window, rng

    def __call__(self):
        self.rng.choice((self.key, self.key, self.key, self.click, self.drag, self.wheel, self.menu, self.size, self.theme, self.read))()

    def key(self):
        focus = QApplication.focusWidget()
        QTest.keyClick(focus if focus is not None and self.rng.random() < 0.6 else self.window.screen, self.rng.choice(self.KEYS))

    def click(self):
        seen = [one for one in self.window.findChildren(QWidget) if one.isVisible()]
        QTest.mouseClick(self.rng.choice(seen), Qt.MouseButton.LeftButton)

    def drag(self):
        view = self.window.screen.view
        QTest.mousePress(view, Qt.MouseButton.LeftButton, pos=QPoint(50, 50))
        QTest.mouseMove(view, QPoint(self.rng.randint(0, 200), 80))
        QTest.mouseRelease(view, Qt.MouseButton.LeftButton, pos=QPoint(90, 70))

    def wheel(self):
        at, flags = QPointF(40, 40), (Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase)
        QApplication.sendEvent(self.window.screen.view, QWheelEvent(at, at, QPoint(), QPoint(0, 120), *flags, False))

    def menu(self):
        QApplication.sendEvent(self.window.screen, QContextMenuEvent(QContextMenuEvent.Reason.Mouse, QPoint(5, 5), QPoint(5, 5)))

    def size(self):
        self.window.resize(self.rng.randint(720, 1300), self.rng.randint(520, 800))

    def theme(self):
        self.window.set_dark(self.rng.random() < 0.5)

    def read(self):
        self.window.desk.refresh()


def test_hundreds_of_random_keys_and_clicks_lose_nothing(qtbot, windows, tmp_path, make_bar, monkeypatch):  # noqa: F811
    path = tmp_path / "bars.study"
    make_study(path, make_bar)
    unexpected = []
    window = windows(path)
    monkeypatch.setattr("sys.excepthook", lambda kind, error, trace: unexpected.append(error))
    window.screen.left.disconnect()  # it stays open
    window.desk.failed.connect(unexpected.append)
    act, widgets = Hands(window, random.Random(11)), []
    for step in range(ACTIONS):
        act()
        QApplication.processEvents()
        assert unexpected == [], f"step {step}"
        if step % 40 == 39:
            settle(qtbot, window.desk)
            QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
            gc.collect()
            widgets.append(len(window.findChildren(QWidget)))
    assert widgets[-1] <= widgets[0] + 3, widgets
    monkeypatch.undo()
    answered = current(path)
    assert answered
    assert window.desk.progress.done == sum(round_ == 1 for _, round_ in answered)
    press(qtbot, window, K.Key_Escape)
    assert isinstance(window.desk.question, Question | JoinQuestion | None)
