"""`concord study publish`, `invite` and `uninvite`: studies on a server, and who may vote there with which address."""

from shlex import join

from cyclopts import App

from engine.errors import BadInput

from ..storage.handle import StudyHandle
from ..study import open_study, shown_place
from ..voting.answering import checked_code
from . import invitations, publishing
from .postgres import StudyServer


def mount(app: App) -> None:
    """Add the commands to the application of studies."""
    app.command(publish)
    app.command(invite)
    app.command(uninvite)


def publish(study: str, address: str, /) -> None:
    """Copy STUDY, with all its votes, into an empty database on a server.

    The file stays as it is; merge either one into the other later, as often as you like.

    Parameters
    ----------
    study
        The study: a file, or a project folder.
    address
        The address of an empty database, postgresql://USER:PASSWORD@HOST:PORT/DATABASE
    """
    with open_study(study, backup=False, writable=False) as handle:
        publishing.publish(handle, address)
    print(f"{shown_place(study)} is on {shown_place(address)} now; invite volunteers with `concord study invite`.")


def invite(study: str, volunteer: str = "", /, *, adjudicator: bool = False, researcher: bool = False, again: bool = False) -> None:
    """Register VOLUNTEER; on a server, make a login and print its personal address, once.

    With that address one can vote as the volunteer and see the matches to be judged, and nothing else.

    Parameters
    ----------
    study
        The study: a file, or an address postgresql://…
    volunteer
        Code of the volunteer: 1 to 40 letters, digits, - and _.
    adjudicator
        Ask about unresolved matches alone.
    researcher
        Make a login that may do everything but change votes and invite; takes no volunteer.
    again
        Make a new password for one who was invited before; the old one ends.
    """
    if researcher == bool(volunteer):
        raise BadInput("Say who is invited: the code of a volunteer, or --researcher.")
    with open_study(study, backup=False) as handle:
        if isinstance(handle, StudyServer):
            print("\n".join(_invited(handle, volunteer, adjudicator=adjudicator, again=again)))
        elif researcher or again:
            raise BadInput(f"{handle.where} is a file, which has no logins; leave out --researcher and --again.")
        else:
            invitations.register(handle, volunteer, adjudicator=adjudicator)
            code = checked_code(volunteer)
            print(f"{code} may vote on {handle.where}: {join(['concord', 'vote', study, '--volunteer', code])}")
            packet = join(["concord", "study", "packet", study, code, "--out", f"{code}.packet"])
            print(f"To vote on another computer, hand over a packet: {packet}")


def _invited(server: StudyServer, volunteer: str, *, adjudicator: bool, again: bool) -> list[str]:
    """What is printed of a new login."""
    if volunteer:
        address = invitations.invite(server, volunteer, adjudicator=adjudicator, again=again)
        said = [f"{checked_code(volunteer)} votes with this command. The address holds the password and is shown only now:", "",
                f"  concord vote '{address}'", ""]  # fmt: skip
    else:
        address = invitations.invite_researcher(server)
        said = ["The address of a researcher, which holds the password and is shown only now:", "", f"  {address}", ""]
    if server.url.host in (None, "", "localhost", "127.0.0.1", "::1"):
        said.append("On another computer, put the name of this one in place of its host (it is that of this computer alone).")
    return said


def uninvite(study: str, volunteer: str, /) -> None:
    """End the login of VOLUNTEER on a server at once; the votes stay.

    Parameters
    ----------
    study
        The address of the study, postgresql://…
    volunteer
        Code of the volunteer.
    """
    with open_study(study, backup=False) as handle:
        server = _server(handle)
        invitations.uninvite(server, volunteer)
        print(f"{checked_code(volunteer)} can no longer reach {server.where}; the votes stay.")


def _server(handle: StudyHandle) -> StudyServer:
    if not isinstance(handle, StudyServer):
        raise BadInput(f"{handle.where} is a file, which has no logins; give the address of a study on a server.")
    return handle
