"""What the voting screen says: pure functions and plain texts."""

from html import escape
from typing import NamedTuple

from annotation.records import Practice, VotingProgress

ANSWER_KEYS = {"wrong": ("✗  Wrong", "F"), "unsure": ("?  Unsure", "Space"), "correct": ("✓  Correct", "J")}
SPOKEN = {"wrong": "Wrong, key F", "unsure": "Unsure, key Space", "correct": "Correct, key J"}
TOOLS = (
    ("undo", "Take back", "Backspace"), ("skip", "Skip", "N"), ("comment", "Comment", "C"), ("reset", "Reset view", "R"),
    ("turn", "Turn", "T"), ("guide", "Guideline", "?"),
)  # fmt: skip
ABOUT = (
    "You will see two shapes, or two pieces of a picture, and one question about them. There are no tricks: answer what "
    "you think. Every answer is saved at once, so you can stop at any time and go on later where you stopped."
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
    return Feedback(False, f"Not quite: this one is {known.answer}.", known.reason)


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
    lines = [f"You have answered {_count(answered, 'question')}. Everything is saved; you can close this window."]
    if hidden:
        lines.append(f"{_count(hidden, 'match')} cannot be shown here.")
    return "\n\n".join(lines)


def unknown_trouble(sentence: str) -> str:
    """What to say of a fault that has no sentence of its own, without its technical part."""
    if "should not have" not in sentence:
        return sentence
    return "The study cannot be reached just now; please try again in a moment."


def keys_html(unsure: bool, shapes: bool = True) -> str:
    """The keys as a small table."""
    rows = [(key, words.split("  ")[1]) for answer, (words, key) in ANSWER_KEYS.items() if unsure or answer != "unsure"]
    rows = rows[::-1] + [(key, words) for name, words, key in TOOLS if shapes or name not in ("reset", "turn")]
    cells = "".join(f"<tr><td>{escape(key)}</td><td style='padding-left:24px'>{escape(words)}</td></tr>"
                    for key, words in [*rows, ("Esc", "Leave (everything is saved)")])  # fmt: skip
    mouse = "<p>Drag a shape to turn it; the wheel or two fingers zoom.</p>" if shapes else ""
    return f"<p><b>Keys</b></p><table cellspacing=4>{cells}</table>{mouse}"


def guideline_html(guideline: str) -> str:
    """The guideline as plain text, whatever it holds."""
    return f"<p style='white-space:pre-wrap'>{escape(guideline)}</p>" if guideline.strip() else ""


def _count(number: int, word: str) -> str:
    plural = "es" if word.endswith("ch") else "s"
    return f"{number} {word}" + ("" if number == 1 else plural)
