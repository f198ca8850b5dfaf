"""`concord study packet`, `export`, `forget`, `archive` and `unpack`: what leaves a study and what comes back."""

from pathlib import Path
from shlex import join
from typing import Annotated

from cyclopts import App, Parameter

from engine.cli import results_folder, whole_number
from engine.errors import BadParameter

from ..study import open_study, shown_place, volunteers
from ..voting.volunteers import check_known
from .anonymising import Anonymous
from .archive import archive as write_archive
from .archive import unpack as take_apart
from .exporting import FORMATS
from .exporting import export as write_export
from .forgetting import forget as forget_volunteer
from .packets import make_packet

Whole = Annotated[int | None, Parameter(converter=whole_number)]
Flag = Annotated[bool, Parameter(negative=())]


def mount(app: App) -> None:
    """Add the commands to the application of studies."""
    for command in (packet, export, forget, archive, unpack):
        app.command(command)


def packet(study: str, volunteer: str, /, *, out: Path, items: Whole = None, new: Flag = False) -> None:
    """Write a file that holds what VOLUNTEER is still to be asked and nothing else; merge it when it comes back.

    Parameters
    ----------
    study
        The study: a file, a project folder, or an address postgresql://…
    volunteer
        Code of the volunteer, who alone may vote in the packet.
    out
        The file to make; an existing one is never replaced.
    items
        Most matches to be judged; all that are open if left out.
    new
        Take a code that the study does not know as that of somebody new.
    """
    with open_study(study) as handle:
        if not new:
            check_known(handle, volunteer)
        made = make_packet(handle, volunteer, out, items)
    more = f" and {made.practice} to practise on" if made.practice else ""
    print(f"{out}: {_count(made.items, 'match', 'matches')}{more} for {volunteer}, {out.stat().st_size / 1e6:.1f} MB.")
    print(f"Voting: {join(['concord', 'vote', str(out)])}")
    print(f"When it is back: {join(['concord', 'study', 'merge', shown_place(study), str(out)])}")


def export(study: str, /, *, out: Path, format: str = "csv", gold: Flag = False) -> None:
    """Write votes, matches, proposals, runs, volunteers and majorities as tables, with a dictionary of their columns.

    Parameters
    ----------
    study
        The study.
    out
        The folder to write to.
    format
        One or more of csv, jsonl, parquet, joined by commas.
    gold
        Add the table of known answers, not to be seen by anybody who is still to vote.
    """
    formats = [name.strip() for name in format.split(",") if name.strip()]
    if not formats:
        raise BadParameter(f"Name a format to export to, of {', '.join(FORMATS)}.")
    with open_study(study, backup=False, writable=False) as handle, results_folder(out):
        files = write_export(handle, out, formats, gold=gold)
    print(f"{out}: {', '.join(file.name for file in files)}.")


def forget(study: str, volunteer: str, /, *, votes_too: Flag = False) -> None:
    """Delete VOLUNTEER from a study and its backups for good; votes stay under another code, without comments.

    Parameters
    ----------
    study
        The study.
    volunteer
        Code of who asked to be deleted.
    votes_too
        Delete the votes too; tables and intervals then change.
    """
    with open_study(study, backup=False) as handle:
        gone = forget_volunteer(handle, volunteer, votes_too=votes_too)
    if votes_too:
        left = _count(gone.removed, "vote or undo is gone", "votes and undos are gone")
    else:
        left = f"{_count(gone.kept, 'vote or undo stays', 'votes and undos stay')} as {gone.pseudonym}"
    print(f"{shown_place(study)}: the volunteer is deleted; {left}.")
    for words, files in (("Rewritten", gone.backups.rewritten), ("Removed", gone.backups.removed)):
        if files:
            print(f"{words}: {', '.join(str(file) for file in files)}")
    if gone.mentions:
        print(f"The code still stands in {_count(gone.mentions, 'text', 'texts')} that people wrote; look at comments and question.")
    print("Packets and copies elsewhere still name the volunteer; when they are merged, the study leaves that out.")


def archive(study: str, /, *, out: Path, anonymous: Flag = False, comments: Flag = False) -> None:
    """Write a whole study with its exports as one zip, as it is or without anything that leads back to volunteers.

    Parameters
    ----------
    study
        The study.
    out
        The zip to make; an existing one is never replaced.
    anonymous
        Codes become v01, v02, …; comments, times of the day and folders go.
    comments
        Keep the comments even so.
    """
    if comments and not anonymous:
        raise BadParameter("Comments are kept anyway; --comments goes with --anonymous.")
    with open_study(study, backup=False, writable=False) as handle:
        changing = Anonymous([one.code for one in volunteers(handle)], comments=comments) if anonymous else None
        made = write_archive(handle, out, changing)
    print(f"{out}: {_count(len(made.sums), 'file', 'files')}, {out.stat().st_size / 1e6:.1f} MB.")


def unpack(file: Path, /, *, out: Path) -> None:
    """Take an archive apart into a new folder, and check every file of it.

    Parameters
    ----------
    file
        The zip that `concord study archive` wrote.
    out
        The folder to make.
    """
    print(f"{take_apart(file, out)}: the study is whole.")


def _count(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}"
