"""Every column of an export, declared once: files, their types and the data dictionary are made from this."""

from typing import Literal, NamedTuple

Type = Literal["text", "integer", "number", "boolean", "time", "json"]


class ColumnMeaning(NamedTuple):
    """One column: its type, what it means, its unit, and the values that it may have."""

    name: str
    type: Type
    meaning: str
    unit: str = ""
    range: str = ""


C = ColumnMeaning
_ITEM = C("item", "text", "The match: hash of its kind and its two parts, the same whoever proposed it.", "", "64 hexadecimal digits")
_KIND = C("kind", "text", "Whether the match is of two shapes or a join of two puzzle pieces.", "", "shape, puzzle")
_VOLUNTEER = C("volunteer", "text", "Code of who voted.", "", "1 to 40 letters, digits, - and _")
_RUN = C("run", "text", "The run: hash of what was run on what and of the matches that came out.", "", "64 hexadecimal digits")
_PAYLOAD = C("payload", "json", "What was shown: the two sides with their segments, or the places of two pieces (without pictures).")
_METHOD = C("method", "text", "Method that proposed the match; '(guided)' where people had pinned or forbidden some.")
_PRESET = C("preset", "text", "Name of the parameter set, or of the measure of a puzzle.")
_SET = C("set", "text", "Name of the set of pairs that the result was added under; empty where none was given.")
_PAIR = C("pair", "text", "The pair of inputs, the unit of sampling: a hash, the same in either direction.", "", "64 hexadecimal digits")
_ROLE_ANSWER = "correct, wrong"

VOTES = (
    _ITEM, _KIND, _VOLUNTEER,
    C("round", "integer", "0 for practice, which counts in no table; 1 for all else.", "", "≥ 0"),
    C("answer", "text", "The answer.", "", "correct, wrong, unsure"),
    C("state", "text", "Whether the vote counts, was replaced by a later one, or was undone.", "", "current, replaced, retracted"),
    C("comment", "text", "What the volunteer wrote about it."),
    C("clock", "integer", "Number of the vote among the volunteer's votes and undos in one copy of the study.", "", "≥ 1"),
    C("shown_ms", "integer", "Time from showing the match to the answer.", "ms", "≥ 0"),
    C("active_ms", "integer", "The same without pauses; empty where it was not measured.", "ms", "≥ 0"),
    C("created_at", "time", "When the vote was given; of deleted volunteers the day alone.", "UTC", "ISO 8601"),
    C("uuid", "text", "The vote itself, unique in all copies.", "", "UUID"),
    C("supersedes", "text", "The vote that this one replaces.", "", "UUID or empty"),
    _PAYLOAD,
)  # fmt: skip
ITEMS = (
    _ITEM, _KIND,
    C("asked", "boolean", "Whether volunteers are asked about the match."),
    C("stratum", "text", "Stratum of the sample; empty where none was drawn."),
    C("probability", "number", "Probability with which the match was drawn into the sample; empty where it was not drawn so.",
      "", "(0, 1]"),
    C("overlapped", "boolean", "Whether the match gets all votes in any case, to measure agreement on."),
    C("created_at", "time", "When the match was added to the study.", "UTC", "ISO 8601"),
    _PAYLOAD,
)  # fmt: skip
PROPOSALS = (
    _RUN, _ITEM, _METHOD, _PRESET, _SET, _PAIR,
    C("rank", "integer", "Place of the match in the result, the best being 1.", "", "≥ 1"),
    C("score", "number", "What the method thought of the match; of joins the confidence."),
    C("supporters", "integer", "Matches of the same result that voted for this one; of joins, whether a person confirmed it.", "", "≥ 0"),
    C("source_layer", "integer", "Layer of the first side: 1 for single segments.", "", "≥ 1 or empty"),
    C("target_layer", "integer", "The same of the second side.", "", "≥ 1 or empty"),
)  # fmt: skip
RUNS = (
    _RUN, _KIND, _METHOD, _PRESET, _SET, _PAIR,
    C("parameters", "json", "All parameters that the method was run with."),
    C("source", "json", "First input: file, hash, numbers of segments and faces, or the puzzle."),
    C("target", "json", "Second input; empty for a puzzle."),
    C("seconds", "json", "Time that each step took.", "s", "≥ 0"),
    C("app_version", "text", "Version of Concord that added the run."),
    C("added_at", "time", "When the run was last added; the newest of a method, set and pair counts in tables.", "UTC", "ISO 8601"),
)  # fmt: skip
VOLUNTEERS = (
    _VOLUNTEER,
    C("adjudicates", "boolean", "Whether the volunteer is asked about unresolved matches alone."),
    C("votes", "integer", "Votes that count, practice apart.", "votes", "≥ 0"),
    C("given", "integer", "Votes ever given, practice apart: with those replaced or undone.", "votes", "≥ 0"),
    C("first_at", "time", "When the first of them was given.", "UTC", "ISO 8601 or empty"),
    C("last_at", "time", "When the last of them was given.", "UTC", "ISO 8601 or empty"),
    C("created_at", "time", "When the volunteer was added.", "UTC", "ISO 8601"),
)  # fmt: skip
MAJORITY = (
    _ITEM,
    C("correct", "integer", "Votes that count and say correct.", "votes", "≥ 0"),
    C("wrong", "integer", "Votes that count and say wrong.", "votes", "≥ 0"),
    C("unsure", "integer", "Abstentions.", "votes", "≥ 0"),
    C("verdict", "text", "What most say; a tie stays a tie, and abstentions alone leave a match unjudged.", "",
      "correct, wrong, tie, unjudged"),
)  # fmt: skip
GOLD = (
    _ITEM,
    C("role", "text", "Whether the match checks attention or is for practice.", "", "gold, practice"),
    C("known", "text", "The answer that is known.", "", _ROLE_ANSWER),
    C("reason", "text", "What is told after a practice match."),
    C("volunteer", "text", "Code of who voted on it; empty where nobody has.", "", "a code or empty"),
    C("answer", "text", "That volunteer's answer.", "", "correct, wrong, unsure or empty"),
    C("agrees", "boolean", "Whether the answer is the known one; empty for 'unsure' and without a vote."),
)  # fmt: skip

TABLES: dict[str, tuple[ColumnMeaning, ...]] = {
    "votes": VOTES, "items": ITEMS, "proposals": PROPOSALS, "runs": RUNS, "volunteers": VOLUNTEERS, "majority": MAJORITY,
    "gold": GOLD,
}  # fmt: skip
ABOUT = {
    "votes": "Every vote ever given, also those replaced or undone.",
    "items": "Every distinct match of the study.",
    "proposals": "Which run proposed which match, and what it thought of it.",
    "runs": "Every run of a method on a pair, with its parameters.",
    "volunteers": "Everybody who has a code.",
    "majority": "What the votes that count say of each match.",
    "gold": "Matches whose answer was known, and what volunteers said of them; only where it is asked for.",
}


def names(table: str) -> tuple[str, ...]:
    """The columns of a table, in order."""
    return tuple(column.name for column in TABLES[table])


def dictionary(tables: "tuple[str, ...]") -> dict[str, object]:
    """The data dictionary of these tables, for programs."""
    return {
        "schema": "concord.dictionary/1",
        "tables": {name: {"about": ABOUT[name], "columns": [c._asdict() for c in TABLES[name]]} for name in tables},
    }


def dictionary_text(tables: "tuple[str, ...]") -> str:
    """The data dictionary of these tables as Markdown, for people."""
    lines = ["# Data dictionary", "", "Empty cells mean that a value is not known or does not apply. In CSV, text that a "
             "spreadsheet would take for a formula starts with an apostrophe; JSON Lines and Parquet hold it as it is."]  # fmt: skip
    for name in tables:
        lines += ["", f"## {name}", "", ABOUT[name], "", "| column | type | unit | values | meaning |", "|---|---|---|---|---|"]
        lines += [f"| {c.name} | {c.type} | {c.unit} | {c.range} | {c.meaning} |" for c in TABLES[name]]
    return "\n".join(lines) + "\n"
