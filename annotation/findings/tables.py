"""What a study's votes say as tables for people, one or two a section, and as values for programs."""

import textwrap
from collections.abc import Callable, Sequence
from typing import Literal

from engine.evaluation.tables import NOTHING, Table
from engine.evaluation.thesis_tables import set_averages, set_table

from .agreement import OVERLAPPED
from .comparing import Compared, Method
from .gathering import Findings
from .tabletext import PRECISION_HEAD, marked_name, number, plain_table, precision_values, shown_range

Section = Literal["all", "precision", "recall", "agreement", "volunteers", "compared", "sensitivity", "disputed"]
Values = tuple[tuple[str, ...], list[tuple[object, ...]]]
"""The heads of columns, and rows of plain values: shares of 1, None for what is not known."""

CHOSEN = ("Votes, people's wishes or a truth had a part in what these methods propose; such figures flatter, and are not to be "
          "set beside those of fixed parameters.")  # fmt: skip
CHOSEN_ELSEWHERE = ("Votes, people's wishes or a truth had a part in what these methods propose. These pairs were held out: figures of "
                    "parameters that were chosen without them are fair; where people guided a method they flatter even so.")  # fmt: skip
RECALL = ("Of the distinct correct matches that any method of the study found, those that this one found, on pairs where several "
          "methods ran and every proposal of each has been seen. What no method proposed is not in it.")  # fmt: skip
AGREEMENT = ("Pairs of answers to the same match; abstentions are left out. Alpha is Krippendorff's for nominal answers; it is not "
             "defined where all answers are equal.")  # fmt: skip
ADAPTIVE = (" Where the first volunteers differ another one is asked, so disputed matches have more answers than others: that shifts "
            "alpha over all matches")  # fmt: skip
QUOTE = (", and the overlapped ones, which get all votes, are the figure to quote.",
         "; no match was marked to get all votes even so, which would tell.")  # fmt: skip
VOLUNTEERS = ("With the majority of the others: matches on which the others are tied are left out. Pairwise: each own vote beside each "
              "of another on the same match.")  # fmt: skip
THIRD = " One who is asked where two others differ agrees less with the others, through no fault."
SKILL = (" Sensitivity and specificity are shares of correct matches called correct and of wrong ones called wrong, by the model of "
         "Dawid and Skene (1979) from the votes alone.")  # fmt: skip
COMPARED = ("Difference of precision in points, second less first, on pairs where both have one; p of the permutation of methods "
            "within pairs and of Wilcoxon's signed ranks, two-sided, adjusted after Holm for the number of sets (the row of all sets "
            "is not adjusted). The last two columns are about recall: of the matches known to be correct, how many the first and the "
            "second finds alone, on pairs where all proposals of both have been seen, and McNemar's exact test of these two "
            "numbers, adjusted likewise; it takes matches as independent, which those of one pair seldom are. No p below 6 "
            "pairs.")  # fmt: skip
TUNED = " † Parameters chosen on votes or a truth: the figure flatters."
TUNED_ELSEWHERE = " † Parameters chosen on votes or a truth; the figure is fair if these pairs had no part in it."
SENSITIVITY = "The range of precision when each volunteer in turn is left out, and whose leaving moves it most."
MODEL = (" The model of Dawid and Skene weighs volunteers by their reliability; its figure is the mean probability of being correct of "
         "all matches with a vote for or against, ties too.")  # fmt: skip
DISPUTED = "Votes for and against, the most evenly divided matches first."
_COMMENT = 60  # characters of the comments on a match; the report's pictures and CSV have all
THESIS = "Precision as in Tables 3.1 and 3.2 of the thesis"


def tables(found: Findings, section: Section = "all") -> list[Table]:
    """The tables of a section, or of all; those that have nothing to say are left out, but for that of precision."""
    names = list(_TABLES) if section == "all" else [section]
    made = [table for name in names for table in _TABLES[name](found)]
    return [table for k, table in enumerate(made) if table.rows or (k == 0 and names[0] == "precision") or section != "all"]


def values(found: Findings, section: Section = "precision") -> Values:
    """One section as plain values; those of precision where all are asked for."""
    return _VALUES["precision" if section == "all" else section](found)


def _precision(found: Findings) -> list[Table]:
    chosen = plain_table("Precision of methods whose parameters or results were chosen with help", found.chosen)
    told = CHOSEN_ELSEWHERE if found.held_out else CHOSEN
    extra = [chosen._replace(remark=f"{told} {chosen.remark}")] if found.chosen else []
    if found.preset == "thesis":
        table = set_table(THESIS, found.sets, digits=3)
        remark = f"{table.remark} Averages leave out sets without a decided match." if found.sets else "The study has no results yet."
        return [table._replace(remark=remark), *extra]
    return [plain_table("Precision by majority of the votes", found.rows), *extra]


def _recall(found: Findings) -> list[Table]:
    marked = _marked(found)
    rows = [(marked[r[:2]], r.set_name or NOTHING, f"{r.recall_pairs} of {r.pairs}", number(r.recall))
            for r in (*found.rows, *found.chosen) if r.recall_pairs]  # fmt: skip
    return [Table("Pooled recall", ("method", "set", "pairs fully seen", "recall %"), rows, 2, RECALL + tuned_note(found))]


def _agreement(found: Findings) -> list[Table]:
    rows = [(row.of, str(row.items), str(row.votes), number(row.raw), NOTHING if row.raw is None else _alpha(row.alpha))
            for row in found.agreement]  # fmt: skip
    head = ("of", "matches with two votes", "votes", "raw %", "alpha")
    told = ADAPTIVE + QUOTE[0 if found.agreement[0].of == OVERLAPPED else 1] if found.adaptive else ""
    return [Table("Agreement", head, rows, 1, AGREEMENT + told)]


def _volunteers(found: Findings) -> list[Table]:
    skill = _skill(found)
    head = ("volunteer", "votes", "compared", "with majority %", "pairwise %", *(("sensitivity %", "specificity %") if skill else ()))
    rows = [
        (row.volunteer, str(row.votes), str(row.compared), number(row.with_majority), number(row.pairwise),
         *(map(number, skill.get(row.volunteer, (None, None))) if skill else ()))
        for row in found.volunteers
    ]  # fmt: skip
    return [Table("Volunteers", head, rows, 1, VOLUNTEERS + (THIRD if found.adaptive else "") + (SKILL if skill else ""))]


def _compared(found: Findings) -> list[Table]:
    head = ("first", "second", "set", "pairs", "better / worse / equal", "difference", "p (permutation)", "p (Wilcoxon)",
            "correct, found alone", "p (McNemar)")  # fmt: skip
    marked = _marked(found)
    rows = [
        (marked[c.first], marked[c.second], c.set_name or NOTHING, str(c.test.pairs),
         f"{c.test.better} / {c.test.worse} / {c.test.equal}", f"{100 * c.test.difference:+.1f}", _p(c.holm_permutation),
         _p(c.holm_wilcoxon), *_found_alone(c))
        for c in found.compared
        if c.test.pairs
    ]  # fmt: skip
    return [Table("Methods compared, pair by pair", head, rows, 3, COMPARED + tuned_note(found))]


def _sensitivity(found: Findings) -> list[Table]:
    model, marked = {row[:3]: row.model for row in found.modelled}, _marked(found)
    rows = [
        (marked[row[:2]], row.set_name or NOTHING, number(row.micro), shown_range(row.low, row.high), row.volunteer or NOTHING,
         *((number(model.get(row[:3])),) if model else ()))
        for row in found.left_out
    ]  # fmt: skip
    head = ("method", "set", "precision %", "without one volunteer", "moved most by", *(("Dawid-Skene %",) if model else ()))
    return [Table("How far the figures hang on single volunteers", head, rows, 2,
                  SENSITIVITY + (MODEL if model else "") + tuned_note(found))]  # fmt: skip


def _disputed(found: Findings) -> list[Table]:
    said = any(d.comments for d in found.disputed)
    rows = [
        (d.item[:12], d.pair, ", ".join(d.sets), *((_shortened(" | ".join(d.comments)),) if said else ()), str(d.majority.correct),
         str(d.majority.wrong), str(d.majority.unsure))
        for d in found.disputed
    ]  # fmt: skip
    head = ("match", "pair", "set", *(("comments",) if said else ()), "correct", "wrong", "unsure")
    return [Table("The most disputed matches", head, rows, 4 if said else 3, DISPUTED)]


def tuned_note(found: Findings) -> str:
    """What the mark of methods with chosen parameters says, where one has it."""
    if not any(marked_name(row).endswith("†") for row in found.chosen):
        return ""
    return TUNED_ELSEWHERE if found.held_out else TUNED


def _marked(found: Findings) -> dict[Method, str]:
    """The methods' names, marked where they stand beside others."""
    return {row[:2]: marked_name(row) for row in (*found.rows, *found.chosen)}


def _shortened(text: str) -> str:
    """A person's words in one short line."""
    return textwrap.shorten(text, _COMMENT, placeholder=" …") if text else ""


def _skill(found: Findings) -> dict[str, tuple[float, float]]:
    """Sensitivity and specificity of each volunteer by the model; nothing without one."""
    m = found.model
    return {} if m is None else dict(
        zip(m.volunteers, zip(m.sensitivity.tolist(), m.specificity.tolist(), strict=True), strict=True))  # fmt: skip


def _volunteer_values(found: Findings) -> Values:
    head = ("volunteer", "votes", "compared", "with_majority", "pairs_of_votes", "pairwise", "sensitivity", "specificity")
    skill = _skill(found)
    return head, [(*row, *skill.get(row.volunteer, (None, None))) for row in found.volunteers]


def _compared_values(found: Findings) -> Values:
    head = ("first", "first_preset", "second", "second_preset", "set", "pairs", "better", "worse", "equal", "mean_difference",
            "p_permutation", "p_wilcoxon", "p_permutation_holm", "p_wilcoxon_holm", "fully_seen_pairs", "first_alone_correct",
            "second_alone_correct", "p_mcnemar", "p_mcnemar_holm")  # fmt: skip
    return head, [
        (*c.first, *c.second, c.set_name, *c.test[:4], c.test.difference if c.test.pairs else None, *c.test[5:], *c[4:])
        for c in found.compared
    ]


def _sensitivity_values(found: Findings) -> Values:
    model = {row[:3]: (row.model, row.matches) for row in found.modelled}
    head = ("method", "preset", "set", "micro_precision", "lowest_without_one", "highest_without_one", "moved_most_by",
            "dawid_skene_precision", "dawid_skene_matches")  # fmt: skip
    return head, [(*row, *model.get(row[:3], (None, None))) for row in found.left_out]


def _precision_values(found: Findings) -> Values:
    if found.preset != "thesis":
        return PRECISION_HEAD, [precision_values(row) for row in (*found.rows, *found.chosen)]
    shown: list[tuple[object, ...]] = [
        (s.method, s.set_name, None if s.precision != s.precision else s.precision, s.pairs, s.layers or None, None)
        for s in found.sets
    ]
    averages = [(method, "(average)", mean, None, None, deviation) for method, mean, deviation in set_averages(found.sets)]
    return ("method", "set", "precision", "pairs", "layers", "deviation"), shown + averages


def _alpha(alpha: float | None) -> str:
    return "not defined" if alpha is None else f"{alpha:.3f}"


def _p(value: float | None) -> str:
    return NOTHING if value is None else "< .001" if value < 0.001 else f"{value:.3f}".removeprefix("0")


def _found_alone(row: Compared) -> tuple[str, str]:
    """What each of the two alone finds of the correct matches, and the p of it."""
    return f"{row.first_alone} : {row.second_alone}" if row.seen_pairs else NOTHING, _p(row.holm_mcnemar)


_TABLES: dict[str, Callable[[Findings], Sequence[Table]]] = {
    "precision": _precision, "recall": _recall, "agreement": _agreement, "volunteers": _volunteers, "compared": _compared,
    "sensitivity": _sensitivity, "disputed": _disputed,
}  # fmt: skip
_VALUES: dict[str, Callable[[Findings], Values]] = {
    "precision": _precision_values,
    "recall": lambda f: (("method", "preset", "set", "pairs", "fully_seen_pairs", "pooled_recall"), [
        (*r[:3], r.pairs, r.recall_pairs, r.recall) for r in (*f.rows, *f.chosen)]),
    "agreement": lambda f: (("of", "matches", "votes", "raw", "alpha"), [tuple(row) for row in f.agreement]),
    "volunteers": _volunteer_values,
    "compared": _compared_values,
    "sensitivity": _sensitivity_values,
    "disputed": lambda f: (("match", "kind", "sets", "pair", "correct", "wrong", "unsure", "comments"), [
        (d.item, d.kind, "; ".join(d.sets), d.pair, *d.majority[:3], " | ".join(d.comments)) for d in f.disputed]),
}  # fmt: skip
