"""The researcher's commands in the window: making, opening, topping up, packets, merging, exports, and what may go wrong."""

import json
import sqlite3
import threading
from pathlib import Path

import pytest
from PySide6.QtWidgets import QDialog, QFileDialog, QLineEdit, QWidget
from research_world import judged_study, made_window, runs_of_bars, settle

from annotation import study
from annotation.results.proposals import add_run
from annotation.results.studyruns import Unasked, item_count
from engine.shapes.families.collection import off_text
from gui.pages.ask_dialog import AskDialog, Field
from gui.pages.study import work as study_work
from gui.pages.study.asks import formats_of, free_file, packet_fields, top_up_fields
from gui.pages.study.sources import Source
from gui.pages.study.watch import stamp
from gui.pages.study.wizard import STEPS, StudyWizard, Wanted


@pytest.fixture
def window(qtbot, tmp_path, monkeypatch):
    yield from made_window(qtbot, tmp_path, monkeypatch)


@pytest.fixture
def bars(window, qtbot, tmp_path, make_bar):
    """The window with a study of bars open: anna and ben differ on the second match."""
    path = tmp_path / "bars.db"
    votes = {"anna": dict.fromkeys(range(3), "correct"), "ben": {0: "correct", 1: "wrong"}}
    window.items = judged_study(path, make_bar, votes, votes=2, gold=0.0, practice=0)
    window.studies.open(path)
    qtbot.waitUntil(lambda: window.session.state.study == str(path))
    settle(window, qtbot)
    return window


def the_dialog(window, kind=QDialog):
    return [dialog for dialog in window.findChildren(kind) if dialog.isVisible()][-1]


def fill(window, **values):
    """Fill in the shown dialog and press its button; the sentence that it says, if it stays."""
    dialog = the_dialog(window, AskDialog)
    for name, value in values.items():
        editor = dialog.editors[name]
        if isinstance(editor, QLineEdit):
            editor.setText(str(value))
        elif hasattr(editor, "setCurrentText"):
            editor.setCurrentText(str(value))
        else:
            getattr(editor, "setChecked", getattr(editor, "setValue", None))(value)
    dialog.ok.click()
    return dialog.error.text()


def save_to(monkeypatch, path):
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, **__: (str(path), ""))


# --- making


def test_a_study_is_made_in_the_window_and_is_open_then(bars, qtbot, tmp_path, make_bar):
    bars.actions_by_id["new-study"].trigger()
    settle(bars, qtbot)
    wizard = the_dialog(bars, StudyWizard)
    assert wizard.sample.expected.seconds == pytest.approx(4.0)  # as the votes of the open study tell
    runs, shapes = runs_of_bars(make_bar)
    wizard.results.add(Source("bars", tuple(runs), tuple(shapes)))
    for _ in STEPS[1:]:
        wizard.forward()
    path = tmp_path / "made.concord"
    wizard.place.ways.buttons["folder"].click()
    wizard.place.path.line.setText(str(path))
    wizard.next.click()
    qtbot.waitUntil(lambda: bars.session.state.study.startswith(str(path)), timeout=20_000)
    settle(bars, qtbot)
    assert not [d for d in bars.findChildren(StudyWizard) if d.isVisible()]
    with study.open_study(path) as handle:
        assert item_count(handle) == 6
        assert study.about(handle).votes == 3
    assert (path / "backups").is_dir()


def test_a_study_that_cannot_be_made_says_why_and_the_wizard_stays(bars, qtbot, tmp_path, make_bar):
    bars.actions_by_id["new-study"].trigger()
    settle(bars, qtbot)
    wizard = the_dialog(bars, StudyWizard)
    wizard.results.add(Source("bars", tuple(runs_of_bars(make_bar)[0])))
    for _ in STEPS[1:]:
        wizard.forward()
    wizard.place.path.line.setText(str(tmp_path / "new.db"))
    (tmp_path / "new.db").write_text("not there when it was looked for")
    wizard.wanted.emit(Wanted(wizard.results.chosen(), wizard.design(), {}, wizard.place.place))
    settle(bars, qtbot)
    assert wizard.isVisible()
    assert "exists already" in wizard.place.path.error.text()
    assert bars.session.state.study == str(tmp_path / "bars.db")


# --- opening


@pytest.mark.parametrize(
    ("content", "said"),
    [(b"", "empty"), (b"SQLite format 3\0 and no more", ""), (b"once upon a time" * 100, ""), (None, "")],
)
def test_what_is_no_study_is_one_sentence_and_the_open_one_stays(bars, qtbot, tmp_path, content, said):
    handle, path = bars.judging.handle, tmp_path / "strange.db"
    if content is not None:
        path.write_bytes(content)
    bars.studies.open(path)
    settle(bars, qtbot)
    sentence = bars.messages.text.text()
    assert said in sentence
    assert "strange.db" in sentence
    assert "Traceback" not in sentence
    assert bars.judging.handle is handle
    assert bars.session.state.study == str(tmp_path / "bars.db")


def test_a_study_of_a_newer_version_is_refused(bars, qtbot, tmp_path):
    path = tmp_path / "newer.db"
    study.create_study(path, name="newer").close()
    with sqlite3.connect(path) as raw:
        raw.execute("PRAGMA user_version = 99")
    bars.studies.open(path)
    settle(bars, qtbot)
    assert "newer" in bars.messages.text.text()
    assert bars.session.state.study == str(tmp_path / "bars.db")


def test_a_server_out_of_reach_is_one_sentence_and_no_password_shows(bars, qtbot, monkeypatch):
    bars.actions_by_id["open-server"].trigger()
    assert "postgresql://" in fill(bars, address="study.example.org", password="")
    assert the_dialog(bars, AskDialog).editors["password"].echoMode() == QLineEdit.EchoMode.Password
    assert fill(bars, address="postgresql://anna@127.0.0.1:1/none", password="hush-hush") == ""
    qtbot.waitUntil(lambda: bars.messages.isVisible(), timeout=30_000)
    settle(bars, qtbot)
    assert "hush-hush" not in bars.messages.text.text() + bars.messages.details + bars.windowTitle() + bars.session.state.study
    stored = Path(bars.studies.folder.parent / "data" / "window.ini")
    assert not stored.exists() or "hush-hush" not in stored.read_text()
    assert bars.session.state.study.endswith("bars.db")


def test_a_place_that_is_not_safe_is_told_once(window, qtbot, tmp_path, monkeypatch):
    folder = tmp_path / "Dropbox"
    folder.mkdir()
    study.create_study(folder / "a.db", name="a").close()
    window.studies.open(folder / "a.db")
    qtbot.waitUntil(lambda: window.session.state.study.endswith("a.db"))
    settle(window, qtbot)
    assert "Dropbox" in window.messages.text.text()
    window.messages.dismiss()
    window.judging.open()
    qtbot.waitUntil(lambda: window.session.state.study.endswith("my votes.db"))
    window.studies.open(folder / "a.db")
    qtbot.waitUntil(lambda: window.session.state.study.endswith("a.db"))
    settle(window, qtbot)
    assert not window.messages.isVisible()


def test_votes_of_another_window_are_read_without_being_asked(bars, qtbot):
    bars.show_page("results")
    settle(bars, qtbot)
    assert stamp(bars.judging.handle) == bars.studies.watch.seen[1]
    bars.studies.watch.timer.setInterval(20)
    with study.open_study(bars.session.state.study, backup=False) as other:
        study.record_vote(other, bars.items[3], "carla", "wrong")
    qtbot.waitUntil(lambda: bars.session.state.verdicts.get(bars.items[3]) == "wrong", timeout=10_000)
    settle(bars, qtbot)
    assert {row.wrong for row in bars.results.content.rows} == {1}


def test_a_project_folder_that_is_dropped_is_opened(window, qtbot, tmp_path):
    study.create_study(tmp_path / "a.concord", name="a").close()
    window.files.drop([str(tmp_path / "a.concord")])
    qtbot.waitUntil(lambda: "a.concord" in window.session.state.study)
    assert window.page == "shapes"


def test_a_disputed_match_opens_its_pair_with_the_match_selected(window, qtbot, tmp_path, make_bar):
    folder = tmp_path / "bars"
    folder.mkdir()
    files = []
    for sections, name in ((5, "long"), (4, "short")):
        files.append(folder / f"{name}.off")
        files[-1].write_text(off_text(make_bar(sections).mesh))
        files[-1].with_suffix(".seg").write_text("\n".join(map(str, make_bar(sections).segmentation.labels)))
    window.files.pair(*map(str, files))
    settle(window, qtbot)
    window.judging.enrol()
    settle(window, qtbot)
    disputed = window.session.state.result.ids[1]
    for code, answer in (("anna", "correct"), ("ben", "wrong")):
        study.record_vote(window.judging.handle, disputed, code, answer)
    window.session.update(selected="")
    window.show_page("results")
    window.results.choose("disputed")
    settle(window, qtbot)
    window.results.disputed.open_button.click()
    settle(window, qtbot)
    settle(window, qtbot)
    assert window.page == "shapes"
    assert window.session.state.selected == disputed
    files[0].unlink()
    window.show_page("results")
    settle(window, qtbot)
    window.results.disputed.open_button.click()
    settle(window, qtbot)
    assert "are not where they were" in window.messages.text.text()


# --- the open study


def test_a_packet_goes_out_and_comes_back(bars, qtbot, tmp_path, monkeypatch):
    packet = tmp_path / "for carla.db"
    bars.actions_by_id["send-packet"].trigger()
    assert "code" in fill(bars, code="no such code!", file=packet)
    assert fill(bars, code="carla", file=packet) == ""
    settle(bars, qtbot)
    assert packet.exists(), bars.messages.text.text()
    assert "for carla" in bars.status.text.text()
    with study.open_study(packet) as handle:
        assert handle.volunteer == "carla"
        item = study.open_items(handle, "carla")[0].item_id
        study.record_vote(handle, item, "carla", "wrong")
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_, **__: (str(packet), ""))
    bars.actions_by_id["take-in"].trigger()
    settle(bars, qtbot)
    assert "1 vote or undo" in bars.status.text.text()
    assert study.answers(bars.judging.handle, "carla") == {item: "wrong"}
    bars.actions_by_id["take-in"].trigger()
    settle(bars, qtbot)
    assert "nothing new" in bars.status.text.text()


def test_the_file_of_a_packet_is_named_after_its_volunteer_until_another_name_is_written(bars, tmp_path):
    bars.actions_by_id["send-packet"].trigger()
    dialog = the_dialog(bars, AskDialog)
    for code, name in (("anna", "bars for anna.db"), ("no/code", "bars for volunteer.db"), ("ben", "bars for ben.db")):
        dialog.editors["code"].setCurrentText(code)
        assert dialog.editors["file"].text() == str(tmp_path / name)
    dialog.editors["file"].setText("mine.db")
    dialog.editors["code"].setCurrentText("anna")
    assert dialog.editors["file"].text() == "mine.db"
    dialog.reject()


def test_a_file_is_asked_for_only_while_it_is_wanted(bars, qtbot):
    bars.actions_by_id["top-up"].trigger()
    settle(bars, qtbot)
    dialog = the_dialog(bars, AskDialog)
    assert not dialog.editors["file"].isEnabled()
    dialog.editors["apart"].setChecked(True)
    assert dialog.editors["file"].isEnabled()
    dialog.reject()


def test_what_failed_does_not_stand_beside_what_was_done_before(bars, qtbot, tmp_path):
    bars.studies.run("Packing", lambda handle, progress: study_work.archived(handle, progress, tmp_path / "one.zip", False))
    settle(bars, qtbot)
    assert "one.zip" in bars.status.text.text()
    bars.studies.run("Packing", lambda handle, progress: study_work.archived(handle, progress, tmp_path / "no" / "two.zip", False))
    settle(bars, qtbot)
    assert "two.zip" in bars.messages.text.text()
    assert "one.zip" not in bars.status.text.text()


def test_a_packet_of_another_study_is_refused_in_a_sentence(bars, qtbot, tmp_path, monkeypatch):
    study.create_study(tmp_path / "other.db", name="other").close()
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_, **__: (str(tmp_path / "other.db"), ""))
    bars.actions_by_id["take-in"].trigger()
    settle(bars, qtbot)
    assert "other.db" in bars.messages.text.text()
    assert item_count(bars.judging.handle) == 6


def test_a_packet_that_is_open_has_no_results_and_cannot_be_packed(bars, qtbot, tmp_path):
    packet = tmp_path / "p.db"
    bars.studies.run("Packing", lambda h, p: study_work.packet(h, p, "dora", packet, 1))
    settle(bars, qtbot)
    bars.studies.open(packet)
    qtbot.waitUntil(lambda: bars.session.state.study == str(packet))
    assert bars.session.state.volunteer == "dora"
    bars.show_page("results")
    assert "one volunteer" in bars.results.empty.text()
    bars.actions_by_id["send-packet"].trigger()
    assert "dora alone" in bars.messages.text.text()
    bars.judging.open()
    qtbot.waitUntil(lambda: bars.session.state.study.endswith("my votes.db"))
    assert bars.session.state.volunteer == "me"


def test_an_adjudicator_is_named_and_unnamed(bars, qtbot):
    bars.show_page("results")
    bars.results.choose("volunteers")
    settle(bars, qtbot)
    page = bars.results.volunteers
    assert not page.buttons["adjudicate"].isEnabled()
    page.table.selectRow(0)
    page.buttons["adjudicate"].click()
    settle(bars, qtbot)
    assert [v.adjudicates for v in study.volunteers(bars.judging.handle)] == [True, False]
    assert page.chosen == "anna"
    assert "No longer" in page.buttons["adjudicate"].text().replace("&", "")
    page.buttons["adjudicate"].click()
    settle(bars, qtbot)
    assert not any(v.adjudicates for v in study.volunteers(bars.judging.handle))


def test_deleting_a_volunteer_takes_the_code_written_once_more(bars, qtbot):
    bars.show_page("results")
    bars.results.choose("volunteers")
    settle(bars, qtbot)
    bars.results.volunteers.table.selectRow(1)
    bars.results.volunteers.buttons["forget"].click()
    assert "ben" in fill(bars, code="anna")
    assert len(study.volunteers(bars.judging.handle)) == 2
    assert fill(bars, code="ben") == ""
    settle(bars, qtbot)
    assert "ben was deleted" in bars.status.text.text(), bars.messages.text.text()
    assert "ben" not in [v.code for v in study.volunteers(bars.judging.handle)]


def test_a_volunteer_gets_a_code(bars, qtbot):
    bars.actions_by_id["invite"].trigger()
    assert "code" in fill(bars, code="")
    assert fill(bars, code="emil", adjudicator=True) == ""
    settle(bars, qtbot)
    assert [v.adjudicates for v in study.volunteers(bars.judging.handle) if v.code == "emil"] == [True]


def test_a_top_up_asks_what_is_new_and_keeps_votes(bars, qtbot, tmp_path, make_bar):
    new, _ = runs_of_bars(make_bar, pairs=3)
    add_run(bars.judging.handle, new[5])  # three matches of a pair that was not there
    before = len(study.current_votes(bars.judging.handle))
    bars.actions_by_id["top-up"].trigger()
    qtbot.waitUntil(lambda: bars.findChildren(AskDialog) != [])
    assert "3 matches of the study's results are not asked yet" in the_dialog(bars, AskDialog).lead.text()
    assert fill(bars, most=2) == ""
    settle(bars, qtbot)
    assert "2 new matches are asked" in bars.status.text.text()
    assert len(study.current_votes(bars.judging.handle)) == before


def test_what_nobody_has_judged_becomes_a_study_of_its_own(bars, qtbot, tmp_path):
    bars.actions_by_id["top-up"].trigger()
    qtbot.waitUntil(lambda: bars.findChildren(AskDialog) != [])
    assert fill(bars, apart=True, file=tmp_path / "rest.db") == ""
    settle(bars, qtbot)
    with study.open_study(tmp_path / "rest.db") as rest:
        assert item_count(rest) == 3
    assert bars.session.state.study.endswith("bars.db")


# --- exports


@pytest.mark.parametrize(
    ("style", "ending", "holds"),
    [("csv", "csv", "micro_precision"), ("markdown", "md", "| careful"), ("latex", "tex", r"\begin{tab"), ("html", "html", "<table")],
)
def test_tables_are_written_in_every_style(bars, qtbot, tmp_path, monkeypatch, style, ending, holds):
    path = tmp_path / f"table.{ending}"
    save_to(monkeypatch, path)
    bars.actions_by_id[f"report-{style}"].trigger()
    settle(bars, qtbot)
    assert holds in path.read_text(), bars.messages.text.text()
    assert str(path) in bars.status.text.text()


def test_the_section_that_is_shown_is_the_one_that_is_written(bars, qtbot, tmp_path, monkeypatch):
    save_to(monkeypatch, tmp_path / "t.csv")
    bars.show_page("results")
    bars.results.choose("agreement")
    settle(bars, qtbot)
    bars.actions_by_id["report-csv"].trigger()
    settle(bars, qtbot)
    assert (tmp_path / "t.csv").read_text().startswith("of,matches,votes,raw,alpha")


def test_the_overview_leaves_as_it_is_shown(bars, qtbot, tmp_path, monkeypatch):
    save_to(monkeypatch, tmp_path / "who.csv")
    bars.show_page("results")
    bars.results.choose("volunteers")
    settle(bars, qtbot)
    bars.actions_by_id["report-csv"].trigger()
    settle(bars, qtbot)
    lines = (tmp_path / "who.csv").read_text().splitlines()
    assert lines[0].startswith("volunteer,adjudicates,judged")
    assert [line.split(",")[0] for line in lines[1:]] == ["anna", "ben"]


def test_votes_leave_as_tables_with_a_dictionary(bars, qtbot, tmp_path, monkeypatch):
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_, **__: str(tmp_path / "out"))
    bars.actions_by_id["export-votes"].trigger()
    assert "Tick" in fill(bars, csv=False)
    assert fill(bars, csv=True, jsonl=True) == ""
    settle(bars, qtbot)
    assert {"votes.csv", "votes.jsonl", "dictionary.md"} <= {path.name for path in (tmp_path / "out").iterdir()}
    assert "gold.csv" not in {path.name for path in (tmp_path / "out").iterdir()}


def test_archive_and_datasheet(bars, qtbot, tmp_path, monkeypatch):
    bars.actions_by_id["archive"].trigger()
    assert "Choose" in fill(bars, file="")
    assert "exists already" in fill(bars, file=tmp_path / "bars.db")
    assert "no folder" in fill(bars, file=tmp_path / "no" / "a.zip")
    assert fill(bars, file=tmp_path / "a.zip", anonymous=True) == ""
    settle(bars, qtbot)
    assert (tmp_path / "a.zip").exists(), bars.messages.text.text()
    save_to(monkeypatch, tmp_path / "sheet.json")
    bars.actions_by_id["datasheet"].trigger()
    settle(bars, qtbot)
    assert json.loads((tmp_path / "sheet.json").read_text())["study"] == "Bars"


def test_a_file_that_cannot_be_written_is_a_sentence(bars, qtbot, tmp_path, monkeypatch):
    save_to(monkeypatch, tmp_path / "nowhere" / "t.md")
    bars.actions_by_id["report-markdown"].trigger()
    settle(bars, qtbot)
    assert bars.messages.isVisible()
    assert "Traceback" not in bars.messages.text.text()


def test_long_work_can_be_stopped(bars, qtbot):
    held = threading.Event()

    def work(_handle, progress):
        while not held.wait(0.005):
            progress(0.5, "held")
        return "done"

    bars.studies.run("Waiting", work)
    qtbot.waitUntil(lambda: bars.status.bar.isVisible(), timeout=5000)
    bars.stop()
    settle(bars, qtbot)
    qtbot.waitUntil(lambda: bars.status.text.text() == "Stopped.", timeout=5000)
    held.set()


def test_what_could_not_be_stopped_in_time_is_told_as_done(bars, qtbot, tmp_path):
    began, go_on = threading.Event(), threading.Event()

    def deaf(handle, progress):
        began.set()
        go_on.wait(20)
        return "one.zip is written."

    bars.studies.run("Packing", deaf)
    assert began.wait(20)
    bars.stop()
    assert bars.status.text.text() == "Stopping …"
    go_on.set()
    qtbot.waitUntil(lambda: bars.status.text.text() != "Stopping …", timeout=20_000)
    assert bars.status.text.text() == "It was done before it could be stopped. one.zip is written."
    settle(bars, qtbot)


def test_without_a_study_commands_say_what_to_do(window):
    handle, window.judging.handle = window.judging.handle, None
    for name in ("top-up", "send-packet", "take-in", "invite", "export-votes", "archive", "datasheet", "report-csv"):
        window.messages.dismiss()
        window.actions_by_id[name].trigger()
        assert "New study" in window.messages.text.text(), name
        assert window.messages.isVisible()
    window.judging.handle = handle


# --- words


def test_words_of_dialogs(tmp_path):
    assert formats_of({"csv": True, "jsonl": False, "parquet": True}) == ["csv", "parquet"]
    (tmp_path / "a.db").write_text("")
    assert free_file(tmp_path, "a") == str(tmp_path / "a 2.db")
    _, fields = packet_fields("anna", ("anna", "ben"), tmp_path, "s")
    assert fields[0].value == "anna"
    assert "s for anna.db" in fields[2].value
    assert top_up_fields([], Unasked(0, False), "f")[0] == "Nothing new is shown in the window."
    assert "say how many" in top_up_fields([], Unasked(4, True), "f")[0]


def test_a_dialog_keeps_a_password_as_it_is(qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    dialog = AskDialog(parent, "t", "", (Field("a", "A"), Field("b", "B", "secret")), "Go")
    dialog.editors["a"].setText(" x ")
    dialog.editors["b"].setText(" y ")
    assert dialog.values() == {"a": "x", "b": " y "}
