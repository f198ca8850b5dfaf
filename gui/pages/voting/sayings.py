"""The pages of words around the questions: welcome, help, a vote that is not saved, thanks."""

from collections.abc import Callable
from typing import NamedTuple

from PySide6.QtCore import Qt

from .desk import VotingDesk
from .notice import Choice
from .words import ABOUT, LEAVE, done_text, guideline_html, keys_html, welcome_text

K = Qt.Key
ENTER = (K.Key_Return, K.Key_Enter)
NEXT = (*ENTER, K.Key_Space)
NOTHING = "There is nothing to be answered here just now. Come back later, or ask whoever gave you this."
UNSAVED = "Your last answer is not saved yet"

Act = Callable[[], object]


class Saying(NamedTuple):
    """What a page of words says, and its buttons."""

    heading: str
    text: str
    choices: tuple[Choice, ...]
    more: str = ""
    trouble: str = ""


def welcome(desk: VotingDesk, start: Act) -> Saying:
    """What awaits somebody who is new; only what is left, for somebody who comes back."""
    count = welcome_text(desk.left_to_practise, desk.progress)
    if desk.progress.done:
        return Saying("Welcome back", count, (Choice("Go on", NEXT, "Enter", start),))
    more = guideline_html(desk.guideline) + keys_html(desk.unsure)
    return Saying("Welcome", f"{ABOUT}\n\n{count}", (Choice("Start", NEXT, "Enter", start),), more)


def help_page(desk: VotingDesk, back: Act) -> Saying:
    """The study's guideline, and the keys."""
    words = guideline_html(desk.guideline)
    choice = Choice("Back", (*NEXT, K.Key_Escape, K.Key_G, K.Key_Question), "Enter", back)
    return Saying("Guideline" if words else "Help", "", (choice,), words + keys_html(desk.unsure))


def done(desk: VotingDesk, undo: Act, close: Act | None) -> Saying:
    """Thanks, and a way to take the last answer back; or that there was nothing to do."""
    answered, hidden = desk.progress.done, desk.hidden
    shut = () if close is None else (Choice("Close", (*ENTER, K.Key_Escape), "Enter", close),)
    if not answered and not desk.practised_any:
        return Saying("Nothing to do", done_text(0, hidden) if hidden else NOTHING, shut)
    back = Choice("Take back the last answer", (K.Key_Backspace,), "Backspace", undo)
    return Saying("All done, thank you!", done_text(answered, hidden), (*shut, back))


def leaving(desk: VotingDesk, leave: Act, stay: Act) -> Saying:
    """That everything is saved, before the window closes."""
    return Saying("See you later", LEAVE, (Choice("Leave", (K.Key_Escape, *ENTER), "Esc", leave),
                                           Choice("Go on", (K.Key_Space,), "Space", stay)))  # fmt: skip


def unsaved(trouble: str, again: Act, give_up: Act) -> Saying:
    """That the last answer would be lost, before the window closes."""
    return Saying(UNSAVED, "", (Choice("Try again", NEXT, "Enter", again),
                                Choice("Leave without it", (K.Key_Escape,), "Esc", give_up)), trouble=trouble)  # fmt: skip


def stuck(trouble: str, again: Act, leave: Act, copy: Act | None) -> Saying:
    """Why the next question cannot be shown."""
    copying = () if copy is None else (Choice("Copy details", (), "", copy),)
    return Saying("One moment", "", (Choice("Try again", NEXT, "Enter", again), *copying,
                                     Choice("Leave", (K.Key_Escape,), "Esc", leave)), trouble=trouble)  # fmt: skip
