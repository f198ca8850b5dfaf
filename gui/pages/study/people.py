"""The researcher's commands on volunteers: packets, what comes back, invitations, adjudicators, and "delete me"."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog

from annotation.study import StudyHandle, study_name
from engine.progress import Progress

from ...jobs import QUEUE
from ..ask_dialog import show_secret
from ..judging import checked_code
from . import work
from .asks import FORGET_LEAD, INVITE_LEAD, STUDIES, invite_fields, named, packet_fields, packet_file

if TYPE_CHECKING:
    from .desk import StudyDesk


class StudyPeople(QObject):
    """Asks what is needed, and does it in the desk's jobs."""

    def __init__(self, desk: "StudyDesk") -> None:
        super().__init__(desk)
        self.desk = desk

    def command(self, name: str, code: str) -> None:
        """A command of the overview of volunteers."""
        {"packet": self.send_packet, "merge": lambda _: self.take_in(), "invite": lambda _: self.invite(),
         "adjudicate": self.adjudicate, "forget": self.forget}[name](code)  # fmt: skip

    def send_packet(self, code: str = "") -> None:
        """Ask for whom, and write what that volunteer is asked into one file."""
        if not self.desk.has_study():
            return
        codes = tuple(row.code for row in self.desk.window.results.volunteers.rows)

        def check(values: Any) -> str:
            checked_code(values["code"])
            return named(values)

        folder, study = self.desk.folder, study_name(self.desk.handle.where)
        lead, fields = packet_fields(code, codes, folder, study)
        dialog = self.desk.ask("Send a packet", lead, fields, "Write the packet", check)
        dialog.follow("code", "file", lambda code: packet_file(code, folder, study))
        dialog.given.connect(lambda v: self.desk.run(
            "Packing", lambda h, p: work.packet(h, p, checked_code(v["code"]), Path(v["file"]), v["items"])))  # fmt: skip

    def take_in(self) -> None:
        """Ask for a returned packet or another copy of the study, and merge it."""
        if not self.desk.has_study():
            return
        start, kinds = str(self.desk.folder), STUDIES + ";;All files (*)"
        path, _ = QFileDialog.getOpenFileName(self.desk.window, "Take in a returned file", start, kinds)
        if path:
            self.desk.run("Taking in", lambda h, p: work.take_in(h, p, Path(path)))

    def invite(self) -> None:
        """Register a volunteer; on a server, make their personal address and show it once."""
        from annotation.server.invitations import invite, register
        from annotation.server.postgres import StudyServer

        if not self.desk.has_study():
            return
        handle = self.desk.handle

        def work(values: Any) -> str:
            if isinstance(handle, StudyServer):
                return invite(handle, values["code"], adjudicator=values["adjudicator"], again=values["again"])
            register(handle, values["code"], adjudicator=values["adjudicator"])
            return ""

        def done(values: Any, address: str) -> None:
            self.desk.say_done(f"{values['code']} may vote.")
            if address:
                show_secret(self.desk.window, f"Address of {values['code']}", INVITE_LEAD, f"concord vote '{address}'")

        fields = invite_fields(server=isinstance(handle, StudyServer))
        dialog = self.desk.ask("Invite a volunteer", "", fields, "Invite", lambda values: checked_code(values["code"]) and "")
        dialog.given.connect(lambda values: self.desk.jobs.start(
            "study", lambda _: work(values), lambda address: done(values, address), words="Inviting", policy=QUEUE))  # fmt: skip

    def adjudicate(self, code: str) -> None:
        """Let a volunteer judge what stays unresolved, or no longer."""
        from annotation.voting.volunteers import make_adjudicator

        rows = {row.code: row.adjudicates for row in self.desk.window.results.volunteers.rows}
        on = not rows.get(code, False)

        def work(handle: StudyHandle, _: Progress) -> str:
            make_adjudicator(handle, code, adjudicates=on)
            return f"{code} is asked about unresolved matches alone." if on else f"{code} is asked like everybody again."

        if code and self.desk.has_study():
            self.desk.run("Naming an adjudicator", work)

    def forget(self, code: str) -> None:
        """Ask once more, then delete a volunteer who asks for it."""
        if not code or not self.desk.has_study():
            return

        def check(values: Any) -> str:
            return "" if values["code"] == code else f"Write {code} to delete this volunteer."

        fields = invite_fields(server=False, forget=True)
        dialog = self.desk.ask(f"Delete {code}", FORGET_LEAD, fields, "Delete", check)
        dialog.given.connect(lambda v: self.desk.run("Deleting", lambda h, p: work.forgotten(h, p, code, v["votes"])))
