"""A Human Evaluation Datasheet: its questions in short, answers with what is left to people, as Markdown and JSON.

The numbers and the order are those of Shimorina and Belz, The Human Evaluation Datasheet (HumEval 2022), pp. 54-75.
"""

import json
from collections.abc import Mapping
from typing import NamedTuple

SECTIONS = {
    "1": "Paper and supplementary resources", "2": "Evaluated systems", "3.1": "Sample of outputs", "3.2": "Evaluators",
    "3.3": "Experimental design", "4.1": "Quality criterion: properties", "4.2": "Quality criterion: mode of evaluation",
    "4.3": "Quality criterion: how responses are elicited", "5": "Ethics",
}  # fmt: skip
QUESTIONS = {
    "1.1": "Link to the paper, and which of its experiments this sheet is about",
    "1.2": "Link to the resources of the experiment",
    "1.3": "Name, affiliation and address of who fills in this sheet, and of the contact author",
    "2.1": "Type of input of the systems",
    "2.2": "Type of output of the systems",
    "2.3": "Task of the systems",
    "2.4": "Languages of the input",
    "2.5": "Languages of the output",
    "3.1.1": "How many outputs are evaluated per system",
    "3.1.2": "How the outputs were selected",
    "3.1.3": "Statistical power of the sample",
    "3.2.1": "How many evaluators",
    "3.2.2": "Kind of evaluators: experts or not, paid or not, known to the authors or not, authors among them or not",
    "3.2.3": "How evaluators were recruited",
    "3.2.4": "Training and practice before the evaluation",
    "3.2.5": "Other characteristics of the evaluators",
    "3.3.1": "Whether the design was preregistered, and where",
    "3.3.2": "How responses are collected",
    "3.3.3": "Methods of quality assurance",
    "3.3.4": "What evaluators see",
    "3.3.5": "How free evaluators are about when and how quickly they work",
    "3.3.6": "Whether evaluators may ask questions and give feedback",
    "3.3.7": "Conditions under which evaluators work",
    "3.3.8": "How these conditions vary",
    "4.1.1": "Type of quality: correctness, goodness, or a feature",
    "4.1.2": "Aspect assessed: form, content, or both",
    "4.1.3": "Frame of reference: the output itself, the input, or something outside",
    "4.2.1": "Objective or subjective judgement",
    "4.2.2": "Absolute or relative judgement",
    "4.2.3": "Intrinsic or extrinsic evaluation",
    "4.3.1": "Name of the criterion towards evaluators",
    "4.3.2": "Definition given to evaluators",
    "4.3.3": "Number of values of the rating instrument",
    "4.3.4": "The values",
    "4.3.5": "How the instrument is presented",
    "4.3.6": "The task, where there is no rating instrument",
    "4.3.7": "The question that evaluators see, word for word",
    "4.3.8": "Form of eliciting a response",
    "4.3.9": "How responses become scores",
    "4.3.10": "Methods for effect size and significance",
    "4.3.11": "Agreement between and within evaluators",
    "5.1": "Approval by a research ethics committee",
    "5.2": "Personal data (GDPR Art. 4), and what was done about it",
    "5.3": "Special categories of personal data (GDPR Art. 9)",
    "5.4": "Impact assessments",
}  # fmt: skip
BLANK = "TO BE FILLED IN"


class Known(NamedTuple):
    """What the study knows of a question, what is left to a person, and a text word for word; "" for nothing."""

    known: str = ""
    left: str = ""
    verbatim: str = ""


class Answer(NamedTuple):
    """A question of the sheet with its answer."""

    number: str
    question: str
    known: str
    left: str
    verbatim: str

    @property
    def blank(self) -> bool:
        """Whether the study knows nothing of it."""
        return not (self.known or self.verbatim)


class Sheet(NamedTuple):
    """All questions in order; `study` and `made_with` say of what and by what."""

    study: str
    made_with: str
    answers: tuple[Answer, ...]


def sheet_of(study: str, made_with: str, known: Mapping[str, Known]) -> Sheet:
    """The sheet with these answers; questions that are not among them are blank."""
    answers = (Answer(number, question, *known.get(number, Known())) for number, question in QUESTIONS.items())
    return Sheet(study, made_with, tuple(answers))


def as_markdown(sheet: Sheet) -> str:
    """The sheet for people; blanks are marked."""
    lines = [f"# Human Evaluation Datasheet: {_plain(sheet.study)}", "",
             f"Made with {sheet.made_with}. After Shimorina and Belz (2022), https://aclanthology.org/2022.humeval-1.6. "
             f"What is marked **[{BLANK}]** only people know."]  # fmt: skip
    section = ""
    for answer in sheet.answers:
        if _section(answer.number) != section:
            section = _section(answer.number)
            lines += ["", f"## {section}. {SECTIONS[section]}"]
        lines += ["", f"### {answer.number} {answer.question}", ""]
        parts = [answer.known, quoted(answer.verbatim) if answer.verbatim else ""]
        if answer.left or answer.blank:
            parts.append(f"**[{BLANK}{': ' + answer.left if answer.left else ''}]**")
        lines.append("\n\n".join(filter(None, parts)))
    return "\n".join(lines) + "\n"


def as_json(sheet: Sheet) -> str:
    """The sheet for programs: `answer` is null where it is blank, `to_fill_in` says what is left, null for nothing."""
    answers = [
        {"number": a.number, "section": SECTIONS[_section(a.number)], "question": a.question,
         "answer": "\n\n".join(filter(None, (a.known, a.verbatim))) or None,
         "to_fill_in": a.left or (BLANK if a.blank else None)}
        for a in sheet.answers
    ]  # fmt: skip
    content = {"schema": "concord.datasheet/1", "study": sheet.study, "made_with": sheet.made_with, "answers": answers}
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def quoted(text: str) -> str:
    """A person's text, as it is, in a block that no line of it ends."""
    fence = "```"
    while fence in text:
        fence += "`"
    return f"{fence}\n{text}\n{fence}"


def _section(number: str) -> str:
    return next(name for name in (number.rsplit(".", 1)[0], number[0]) if name in SECTIONS)


def _plain(text: str) -> str:
    return " ".join(text.split())
