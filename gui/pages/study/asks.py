"""What the researcher's dialogs ask for, in words; no widget here."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from annotation.results.studyruns import Unasked

from ..ask_dialog import Field
from .sources import Source, counts_text, plural

SERVER_LEAD = "The address is what whoever keeps the server gave you. The password is used for this once and kept nowhere."
SERVER_FIELDS = (Field("address", "Address", help="postgresql://USER@HOST:PORT/DATABASE"), Field("password", "Password", "secret"))
INVITE_LEAD = ("This command is for that volunteer alone: the address in it holds the password and is shown only now. "
               "With it one can vote and see the matches, and nothing else.")  # fmt: skip
FORGET_LEAD = ("For volunteers who ask for it. The code leaves the study and its backups for good, and no later merge brings it "
               "back. This cannot be undone.")  # fmt: skip
EXPORT_LEAD = "Every vote, match, result and majority as a table for other programs, and a dictionary of what each column means."
EXPORT_FIELDS = (
    Field("csv", "CSV, for spreadsheets and R", "switch", True), Field("jsonl", "JSON Lines", "switch"),
    Field("parquet", "Parquet, for pandas and DuckDB", "switch"),
    Field("gold", "With the known answers of gold matches", "switch", help="Keep these from whoever is still to vote."),
)  # fmt: skip
STUDIES = "Studies (*.db *.study *.packet)"


def formats_of(values: Mapping[str, Any]) -> list[str]:
    """The formats that were ticked."""
    return [name for name in ("csv", "jsonl", "parquet") if values[name]]


def named(values: Mapping[str, Any]) -> str:
    """Why nothing can be written to the file that was named, or ''."""
    if not values["file"]:
        return "Choose the file that is written."
    path = Path(values["file"])
    if os.path.exists(path):
        return f"{path} exists already; choose another name."
    return "" if path.absolute().parent.is_dir() else f"There is no folder {path.absolute().parent}; choose another one."


def archive_fields(file: str) -> tuple[str, tuple[Field, ...]]:
    """Words and fields for an archive."""
    return ("One zip with the study, its exports and what each file hashes to; unpacked anywhere, Concord opens the study.db in it.",
            (Field("file", "File", "save", file),
             Field("anonymous", "Without anything that leads back to volunteers", "switch",
                   help="Codes are replaced, comments and times of the day are left out. To publish.")))  # fmt: skip


def free_file(folder: Path, stem: str, ending: str = ".db") -> str:
    """A name in a folder that no file has yet."""
    for number in range(1, 1000):
        path = folder / (stem + (f" {number}" if number > 1 else "") + ending)
        if not os.path.exists(path):
            return str(path)
    return ""


def packet_file(code: str, folder: Path, study: str) -> str:
    """A free name for the packet of a volunteer, who may not be named yet."""
    known = code if code and all(c.isalnum() or c in "-_" for c in code) else "volunteer"
    return free_file(folder, f"{study} for {known[:40]}")


def packet_fields(code: str, codes: Sequence[str], folder: Path, study: str) -> tuple[str, tuple[Field, ...]]:
    """Words and fields for a packet."""
    lead = ("One file with what a volunteer is asked, and nothing else: no method, score, known answer or vote of others. "
            "When it comes back, take it in.")  # fmt: skip
    file = packet_file(code, folder, study)
    return lead, (
        Field("code", "Volunteer", "choice", code, "A code: letters, digits, - and _; a new one is registered.", tuple(codes)),
        Field("items", "Most matches (0: all that are open)", "number", 0),
        Field("file", "File", "save", file),
    )


def top_up_fields(sources: Sequence[Source], found: Unasked, file: str) -> tuple[str, tuple[Field, ...]]:
    """Words and fields for a top-up."""
    shown = f"The window shows {counts_text(sources)}; what the study has already keeps its votes. " if sources else ""
    left = f"{plural(found.matches, 'match', 'matches')} of the study's results {'is' if found.matches == 1 else 'are'} not asked yet. "
    sampled = "This study asks a sample: say how many more are drawn." if found.sampled else ""
    fields = (
        Field("most", "Most new matches (0: all)", "number", 0),
        Field("apart", "Make a study of its own of what nobody has judged yet", "switch",
              help="To hand out apart; merge it back when it is done."),
        Field("file", "File of that study", "save", file, needs="apart"),
    )  # fmt: skip
    return (shown + (left if found.matches else "") + sampled).strip() or "Nothing new is shown in the window.", fields


def invite_fields(*, server: bool, forget: bool = False) -> tuple[Field, ...]:
    """Fields for a new volunteer, or for one who is deleted."""
    if forget:
        return (Field("code", "Write the code to be sure"),
                Field("votes", "Delete the votes too", "switch",
                      help="Otherwise they stay under another name, without comments."))  # fmt: skip
    more = (Field("again", "Was invited before: a new address, which ends the old one", "switch"),) if server else ()
    return (Field("code", "Code", help="1 to 40 letters, digits, - and _."),
            Field("adjudicator", "Is asked about unresolved matches alone", "switch"), *more)  # fmt: skip
