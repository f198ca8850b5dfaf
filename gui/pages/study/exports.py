"""What leaves a study from the window: tables and reports, all votes for other programs, a datasheet, an archive."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog

from annotation.study import study_name

from . import work
from .asks import EXPORT_FIELDS, EXPORT_LEAD, archive_fields, formats_of, free_file, named

if TYPE_CHECKING:
    from .desk import StudyDesk

REPORTS = {"csv": "CSV tables (*.csv)", "markdown": "Markdown (*.md)", "latex": "LaTeX (*.tex)", "html": "Web pages (*.html)"}
FIGURES = "SVG pictures (*.svg);;PDF (*.pdf);;PNG pictures (*.png)"


class StudyExports(QObject):
    """Asks where to, and writes in the desk's jobs."""

    def __init__(self, desk: "StudyDesk") -> None:
        super().__init__(desk)
        self.desk = desk

    def report(self, style: str) -> None:
        """Ask where to, and write what the votes say."""
        if not self.desk.has_study():
            return
        page = self.desk.window.results
        ending = work.ENDINGS[style]
        start = self.desk.folder / f"{study_name(self.desk.handle.where)}.{ending}"
        path, _ = QFileDialog.getSaveFileName(self.desk.window, "Export the results", str(start), REPORTS[style])
        if path:
            path = path if Path(path).suffix else f"{path}.{ending}"
            self.desk.run("Writing", lambda h, p: work.report(h, p, Path(path), style, page.section, page.preset))

    def figure(self) -> None:
        """Ask where to, and write the plot of precision as a figure for a paper."""
        if not self.desk.has_study():
            return
        start = self.desk.folder / f"{study_name(self.desk.handle.where)} precision.svg"
        path, kind = QFileDialog.getSaveFileName(self.desk.window, "Export the plot", str(start), FIGURES)
        if path:
            named = Path(path if Path(path).suffix else path + (kind.partition("*")[2].rstrip(")") or ".svg"))
            self.desk.run("Drawing", lambda h, p: work.figure(h, p, named))

    def datasheet(self) -> None:
        """Ask where to, and write all that a Human Evaluation Datasheet asks and the study knows."""
        if not self.desk.has_study():
            return
        start = self.desk.folder / f"{study_name(self.desk.handle.where)} datasheet.md"
        path, _ = QFileDialog.getSaveFileName(self.desk.window, "Human Evaluation Datasheet", str(start), "Markdown (*.md);;JSON (*.json)")
        if path:
            self.desk.run("Writing", lambda h, p: work.datasheet(h, p, Path(path)))

    def export(self) -> None:
        """Ask for formats and a folder, and write all votes, matches and results as tables."""
        if not self.desk.has_study():
            return

        def check(values: Any) -> str:
            return "" if formats_of(values) else "Tick at least one kind of file."

        def go(values: Any) -> None:
            folder = QFileDialog.getExistingDirectory(self.desk.window, "Folder for the tables", str(self.desk.folder))
            if folder:
                self.desk.run("Exporting", lambda h, p: work.exported(h, p, Path(folder), formats_of(values), values["gold"]))

        dialog = self.desk.ask("Export votes and matches", EXPORT_LEAD, EXPORT_FIELDS, "Choose a folder…", check)
        dialog.given.connect(go)

    def archive(self) -> None:
        """Ask where to, and pack the whole study into one zip."""
        if not self.desk.has_study():
            return
        fields = archive_fields(free_file(self.desk.folder, study_name(self.desk.handle.where), ".zip"))
        dialog = self.desk.ask("Archive the study", fields[0], fields[1], "Pack", named)
        dialog.given.connect(lambda v: self.desk.run("Packing", lambda h, p: work.archived(h, p, Path(v["file"]), v["anonymous"])))
