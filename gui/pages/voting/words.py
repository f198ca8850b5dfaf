"""What the voting screen says: pure functions and plain texts."""

from html import escape
from typing import NamedTuple

from annotation.records import Practice, VotingProgress

ANSWER_KEYS = {"wrong": ("✗  Wrong", "F"), "unsure": ("?  Unsure", "Space"), "correct": ("✓  Correct", "J")}
SPOKEN = {"wrong": "Wrong, key F", "unsure": "Unsure, key Space", "correct": "Correct, key J"}
TOOLS = (
    ("undo", "Take back", "Backspace"), ("skip", "Skip", "N"), ("comment", "Comment", "C"), ("reset", "Reset view", "R"),
    ("turn", "Turn", "T"), ("guide", "Help", "?"),
)  # fmt: skip
AT_LENGTH = {
    "undo": "Take back the last answer, and the ones before it", "skip": "Skip: the question comes back at the end",
    "comment": "Write a comment that goes with your answer", "reset": "See the shapes as they were shown at first",
    "turn": "Turn the shapes by themselves, or stop", "guide": "Help: the guideline and these keys",
}  # fmt: skip
ABOUT = (
    "You will see two shapes, each with one part marked in colour, or two pieces of a picture, and one question about them. There "
    "are no tricks: answer what you think. Every answer is saved at once, so you can stop at any time and go on later where "
    "you stopped."
)
SEEN = (
    "Drag a shape to turn it; the wheel or two fingers zoom. What is hidden of a coloured part shines through, paler."
)
NO_CODE = "This code is kept with your answers, so that you can go on later where you stopped."
LEAVE = "Everything is saved. When you come back, you go on where you stopped."


class Feedback(NamedTuple):
    """What is said after a practice item."""

    right: bool
    heading: str
    reason: str


def feedback(given: str, known: Practice) -> Feedback:
    """Whether a practice answer was right, what is, and why."""
    if given == known.answer:
        return Feedback(True, "Right!", known.reason)
    right, yours = (ANSWER_KEYS[answer][0].split("  ")[1] for answer in (known.answer, given))
    return Feedback(False, f"Not quite: you said {yours}, the right answer is {right}.", known.reason)


def progress_text(progress: VotingProgress) -> str:
    """'37 of 240, about 25 min left'."""
    text = f"{progress.done} of {progress.total}"
    if progress.seconds_left is None or progress.done >= progress.total:
        return text
    minutes = progress.seconds_left / 60
    return f"{text}, " + (f"about {minutes:.0f} min left" if minutes >= 1.5 else "about a minute left")


def welcome_text(practice: int, progress: VotingProgress) -> str:
    """How much there is to do, in a sentence or two."""
    left = progress.total - progress.done
    parts = [f"You have answered {progress.done} of {progress.total}; you go on where you stopped."] if progress.done else []
    if practice:
        parts.append(f"First {_count(practice, 'example')} to practise on, with the right answer after each.")
    if not progress.done:
        parts.append(f"{'Then' if practice else 'There are'} {_count(left, 'question')}.")
    return " ".join(parts)


def done_text(answered: int, hidden: int) -> str:
    """What is read at the end."""
    lines = [f"You have answered {_count(answered, 'question')}. Everything is saved; you can close this window."] if answered else []
    if hidden:
        tell = "" if answered else " Please tell whoever gave you this."
        lines.append(f"{_count(hidden, 'match')} cannot be shown here.{tell}")
    return "\n\n".join(lines or ["Everything is saved; you can close this window."])


def keys_html(unsure: bool, shapes: bool = True) -> str:
    """The keys as a small table."""
    answers = [(key, words.split("  ")[1]) for answer, (words, key) in ANSWER_KEYS.items() if unsure or answer != "unsure"]
    tools = [(key, AT_LENGTH[name]) for name, _, key in TOOLS if shapes or name not in ("reset", "turn")]
    cells = "".join(f"<tr><td>{escape(key)}</td><td style='padding-left:24px'>{escape(words)}</td></tr>"
                    for key, words in [*answers[::-1], *tools, ("Esc", "Leave; everything is saved")])  # fmt: skip
    mouse = f"<p>{SEEN}</p>" if shapes else ""
    return f"<p><b>Keys</b></p><table cellspacing=4>{cells}</table>{mouse}"


def guideline_html(guideline: str) -> str:
    """The guideline as plain text, whatever it holds."""
    return f"<p style='white-space:pre-wrap'>{escape(guideline)}</p>" if guideline.strip() else ""


def _count(number: int, word: str) -> str:
    plural = "es" if word.endswith("ch") else "s"
    return f"{number} {word}" + ("" if number == 1 else plural)
