"""What the list of matches says and in which order: texts, states, filters and sorting, without any widget."""

import math
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from engine.shapes.result import Match, MatchResult

if TYPE_CHECKING:
    from ...session import State

SHOWN = {"main": "Main matches", "all": "All matches", "single": "One-to-one", "merged": "Merged",
         "wishes": "Pinned, forbidden"}  # fmt: skip
ORDERS = ("state", "match", "score", "votes", "layers", "support")
SYMBOLS = {"correct": "✓", "wrong": "✗", "tie": "=", "undecided": "○", "unsure": "?"}


def union_text(names: Sequence[int | str], segments: Iterable[int]) -> str:
    """A union of segments by the names that they have in the input: '4' or '{2, 3}'."""
    texts = [str(names[k]) for k in segments]
    return texts[0] if len(texts) == 1 else "{" + ", ".join(texts) + "}"


def short_union(names: Sequence[int | str], segments: Sequence[int]) -> str:
    """A union in little room: '4', '{2,3,5}', '{2,3,+4}'."""
    texts = [str(names[k]) for k in segments]
    if len(texts) == 1:
        return texts[0]
    return "{" + ",".join(texts if len(texts) <= 3 else [*texts[:2], f"+{len(texts) - 2}"]) + "}"


def short_text(match: Match, result: MatchResult) -> str:
    """'1→{2,3}', for the list."""
    source, target = result.source.segments, result.target.segments
    return f"{short_union(source, match.source)}→{short_union(target, match.target)}"


def match_text(match: Match, result: MatchResult) -> str:
    """'1 → {2, 3}'."""
    source, target = result.source.segments, result.target.segments
    return f"{union_text(source, match.source)} → {union_text(target, match.target)}"


def merged(match: Match) -> bool:
    """Whether either side unites several segments."""
    return len(match.source) > 1 or len(match.target) > 1


def forbidden(match: Match) -> bool:
    """Whether a match is shown only because it is forbidden: it was not found, so its nodes are of no layer."""
    return not match.source_layer


def state_of(match_id: str, verdicts: Mapping[str, str]) -> str:
    """'correct', 'wrong', 'tie' or 'undecided' by the majority."""
    verdict = verdicts.get(match_id, "undecided")
    return verdict if verdict in ("correct", "wrong", "tie") else "undecided"


def main_ids(result: MatchResult) -> frozenset[str]:
    """The matches to show first: one-to-one ones, merged ones that do not follow from smaller ones nor overlap, and what
    is pinned."""
    from ...views.links import main_links

    pinned = (i for i, told in zip(result.ids, result.pinned.tolist(), strict=True) if told)
    return frozenset([*(link.id for link in main_links(result)), *pinned])


def shows(match: Match, shown: str, main: Container[str]) -> bool:
    """Whether a filter shows a match."""
    if shown == "main":
        return match.id in main
    if shown == "wishes":
        return match.pinned
    return shown == "all" or merged(match) == (shown == "merged")


def listed(state: "State", order: str = "") -> list[Match]:
    """The matches that the list of a state shows, in its order (or another)."""
    chosen = [m for m in state.matches() if shows(m, state.shown, state.main)]
    if state.shown == "wishes":
        return arranged([*chosen, *state.forbidden()], order or state.order, state.verdicts, state.support)
    if state.least_support > 0 and any_known((m.id for m in state.matches()), state.support):
        chosen = [m for m in chosen if state.support.get(m.id, math.nan) >= state.least_support]
    return arranged(chosen, order or state.order, state.verdicts, state.support)


def empty_words(state: "State") -> str:
    """Why the list shows nothing, and what to do; '' where it does show something, or nothing was matched yet."""
    if state.result is None or listed(state):
        return ""
    if state.shown == "wishes":
        return "Nothing is pinned or forbidden yet. Select a match and press K to pin it, X to forbid it."
    if not state.matches():
        return "No matches with these parameters."
    if any(shows(m, state.shown, state.main) for m in state.matches()):
        return "The other shapes support no match so well; move the slider to the left."
    return f"None of the matches is of this kind; choose {SHOWN['all']} above."


def any_known(ids: Iterable[str], support: Mapping[str, float]) -> bool:
    """Whether the support of any of these matches is known."""
    return any(not math.isnan(support.get(match_id, math.nan)) for match_id in ids)


def support_text(match_id: str, support: Mapping[str, float]) -> str:
    """'.93', or a dash where nothing is known."""
    value = support.get(match_id, math.nan)
    return "–" if math.isnan(value) else share_text(value)


def arranged(
    matches: Iterable[Match], order: str, verdicts: Mapping[str, str], support: Mapping[str, float] | None = None
) -> list[Match]:
    """The matches in an order; equal ones stay best first. A leading '-' turns the order."""
    known = support or {}
    states = list(SYMBOLS)
    keys = {
        "state": lambda m: states.index(state_of(m.id, verdicts)),
        "match": lambda m: (m.source, m.target),
        "score": lambda m: -m.score,
        "votes": lambda m: -m.votes,
        "layers": lambda m: (m.source_layer + m.target_layer, m.source_layer),
        "support": lambda m: -known[m.id] if any_known([m.id], known) else 1.0,
    }
    turned = order.startswith("-")
    return sorted(matches, key=keys.get(order.lstrip("-"), keys["score"]), reverse=turned)


def next_unanswered(matches: Sequence[Match], current: str, answered: Mapping[str, str]) -> str:
    """Id of the first match after the current one, around the list, that has no answer yet; '' if all have."""
    ids = [m.id for m in matches]
    start = ids.index(current) + 1 if current in ids else 0
    return next((i for i in ids[start:] + ids[:start] if i not in answered and i != current), "")


def smallest_with(matches: Iterable[Match], side: int, segment: int) -> str:
    """Id of the match with the fewest segments among those that hold a segment on a side; '' if there is none."""
    holding = [m for m in matches if segment in (m.source, m.target)[side]]
    return min(holding, key=lambda m: (len(m.source) + len(m.target), -m.score)).id if holding else ""


def short_notes(notes: Iterable[str], elided: Callable[[str], str], most: int = 3) -> str:
    """Notes as a few lines, each cut to the room that there is; how many more there are stands last."""
    lines = [f"· {note}" for note in dict.fromkeys(notes)]
    if len(lines) > most:
        lines = [*lines[: most - 1], f"· and {len(lines) - most + 1} more; point here to read them"]
    return "\n".join(elided(line) for line in lines)


def share_text(value: float) -> str:
    """A share with two digits as it is printed in tables: '.93', '1.00'."""
    return f"{value:.2f}".removeprefix("0") if 0 <= value < 0.995 else f"{value:.2f}"


_PI = "of the best match's confidence π"
_AGREE = "mean agreement with the others"
_SCORES = {
    "thesis": _PI,
    "bottom": _PI,
    "diffusion": _PI,
    "hungarian": "what is left of the largest distance allowed",
    "spectral": "of the greatest entry in the principal eigenvector",
    "shed": "mean affinity with the others",
    "top-down": _AGREE,
    "learned": "probability that the match is right",
}
_FITTED = "from 0 to 1, as fitted to shapes whose true matches are known"


def score_help(method: str) -> str:
    """What the score of a method is, in a sentence."""
    meaning = _SCORES.get(method, _AGREE)
    if method == "learned":
        return f"Score: the {meaning}, {_FITTED}"
    return f"Score: share {meaning}" if meaning.startswith("of ") else f"Score: {meaning}, from 0 to 1"


def reasons(match: Match, result: MatchResult) -> list[tuple[str, str]]:
    """Why a match was kept, as (heading, text) rows."""
    p = result.parameters
    similarity = share_text(match.similarity)
    meaning = _SCORES.get(p.method, _AGREE)
    if meaning == _PI:
        similarity += f"  (at least {share_text(p.lfd_threshold)} is asked)"
    score = f"{share_text(match.score)}  {meaning}"
    votes = f"{match.votes}  " + ("match contains it on both sides" if match.votes == 1 else "matches contain it on both sides")
    if match.pinned:
        score = f"{share_text(match.score)}  pinned; it comes in any case"
    if forbidden(match):
        return [("Source", _segments(result.source.segments, match.source)),
                ("Target", _segments(result.target.segments, match.target)),
                ("Score", "forbidden; it does not come")]  # fmt: skip
    return [
        ("Source", _side(result.source.segments, match.source, match.source_layer)),
        ("Target", _side(result.target.segments, match.target, match.target_layer)),
        ("Similarity", similarity),
        ("Score", score),
        ("Votes", votes),
    ]


def _side(names: Sequence[int | str], segments: Sequence[int], layer: int) -> str:
    return f"{_segments(names, segments)}  ·  layer {layer}"


def _segments(names: Sequence[int | str], segments: Sequence[int]) -> str:
    noun = "segment" if len(segments) == 1 else "segments"
    return f"{noun} {', '.join(str(names[k]) for k in segments)}"
