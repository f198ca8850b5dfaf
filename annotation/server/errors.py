"""One sentence for a person, for what PostgreSQL or the network says. No sentence ever holds a password."""

import re

LOCK_SECONDS = 30

_BY_STATE = (  # beginnings of SQLSTATE codes (PostgreSQL's documentation, appendix A), the more special first
    ("25006", "is read-only (a standby, or set so), so nothing was saved; connect to the server that takes writes."),
    ("53100", "cannot take the vote because the disk of the server is full; make room there and try again."),
    ("53300", "has no connection left; close other windows, or let the server have more, and try again."),
    ("53", "is out of resources, so nothing was saved; try again later."),
    ("55P03", f"is held by another program for longer than {LOCK_SECONDS} s, so nothing was saved; try again."),
    ("40", "was written by two at the same moment, so nothing was saved; try again."),
    ("57014", "took too long, so nothing was saved; try again."),
    ("28", "does not let this user in (wrong name or password); check the address, or ask to be invited again."),
    ("3D000", "does not exist on that server; create the database there, or check its name."),
    ("3F000", "holds no study; create one there with `concord study create`, or check the name of the database."),
    ("42P01", "holds no study; create one there with `concord study create`, or check the name of the database."),
    ("42703", "holds no study that Concord can read; check the name of the database."),
    ("22003", "cannot keep a number as large as that; check the clock of this computer and try again."),
    ("22", "cannot keep this text (it holds a character that no text may hold); change it and try again."),
    ("XX", "is damaged, says its server; restore the database from a backup."),
)
_BY_WORDS = (  # a connection that never came about has no SQLSTATE
    (r'database ".*" does not exist', "3D000"),
    (r'authentication failed|no password supplied|pg_hba\.conf|role ".*" does not exist|permission denied|not permitted', "28"),
    (r"too many|connection slots", "53300"),
)  # fmt: skip
_NOT_INTO_VIEWS = ("0A000", "55000")  # what is blind can be read only
LOST = "lost the connection before that was confirmed; try again once the server can be reached."
UNREACHABLE = "cannot be reached; check the address, the network, and that the server runs."


def explained(where: str, error: Exception, *, opened: bool = True, volunteer: str | None = None) -> str:
    """The sentence; `opened` says that the study had been reached before."""
    original = getattr(error, "orig", None) or error
    unsent = "22" if type(original).__name__ == "DataError" else ""  # refused by psycopg, before the server saw it
    state = str(getattr(original, "sqlstate", None) or unsent)
    if state == "42501" or (volunteer is not None and state in _NOT_INTO_VIEWS):
        return f"{where} {_forbidden(opened, volunteer)}"
    if not state or state.startswith(("08", "57P")) or getattr(error, "connection_invalidated", False):
        state = next((code for words, code in _BY_WORDS if re.search(words, str(original))), "")
        return f"{where} {_sentence(state) or (LOST if opened else UNREACHABLE)}"
    first = str(original).strip().splitlines()[0] if str(original).strip() else type(original).__name__
    return f"{where} {_sentence(state) or f'refused ({first}), so nothing was saved; try again.'}"


def _sentence(state: str) -> str:
    return next((sentence for code, sentence in _BY_STATE if state.startswith(code)), "") if state else ""


def _forbidden(opened: bool, volunteer: str | None) -> str:
    if volunteer is not None:
        return f"lets {volunteer} vote with that address and do nothing else; ask the researcher."
    if opened:
        return "does not let this user do that; connect as the user who created the study."
    return "does not let this user in; ask to be invited, or connect as the user who may create studies there."
