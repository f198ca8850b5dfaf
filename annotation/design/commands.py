"""`concord study create`, `add`, `top-up`, `gold`, `practice`, `adjudicate` and `plan`: how a study is designed."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, NamedTuple

from cyclopts import App, Parameter

from engine.cli import progress_bar, whole_number
from engine.errors import BadInput, BadParameter
from engine.progress import Progress, share

from ..records import Run
from ..results.proposals import insert_run
from ..results.resultfiles import FoundShapes, ResultFile, find_results, find_shapes, read_all
from ..server.postgres import is_url
from ..storage.blobs import keep_shapes
from ..storage.handle import StudyHandle
from ..storage.location import warn_of_place
from ..storage.places import keep_result
from ..study import open_study
from ..voting.answering import known_volunteer, make_adjudicator
from . import knownanswers
from .designing import Design, create_design, judged_counts
from .flags import unresolved
from .planning_command import plan
from .topup import name_gold, name_practice, top_up, top_up_study

SetName = Annotated[str, Parameter(name="--set", help="Name of the set (a row group of the table).")]
Results = Annotated[list[str] | None, Parameter(negative=())]
Many = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]
Whole = Annotated[int | None, Parameter(converter=whole_number)]
Tables = Annotated[list[Path] | None, Parameter(negative="", consume_multiple=True)]
Options = Annotated[Design, Parameter(name="*")]
DEFAULT = Design()
_SHOWN = 3  # how many missing shapes a sentence names


def mount(app: App) -> None:
    """Add the commands to the application of studies, those to begin with first."""
    app.command(create)
    app.command(add)
    app.command(top_up_command, name="top-up")
    for command in (gold, practice, adjudicate, plan):
        app.command(command)


def create(
    file: str,
    results: Results = None,
    /,
    *,
    set_name: SetName = "",
    design: Options = DEFAULT,
    guideline_file: Path | None = None,
    gold_answers: Tables = None,
    gold_from: Many = None,
    practice_answers: Tables = None,
    practice_from: Many = None,
    truth: Annotated[bool, Parameter(negative="")] = False,
    shapes: Tables = None,
) -> None:
    """Make a study FILE (or folder NAME.concord, or on a server postgresql://…) of RESULTS.

    Every distinct match is asked once, whoever proposed it. Answers that are known already make gold and practice
    matches; practice ones count in no table.

    Parameters
    ----------
    file
        The study to make; an existing one is never replaced.
    results
        Files matches.json of shapes and solution.json of puzzles, folders of them, or SET=FILE and SET=FOLDER. In a
        folder, each sub-folder with results is a set, unless --set names one.
    guideline_file
        A text file with the guideline, in place of --guideline.
    gold_answers
        CSV tables of known answers: the columns item, answer (correct or wrong) and, for practice, reason.
    gold_from
        STUDY or STUDY:CODE, whose majority or whose volunteer's answers are taken as known.
    practice_answers
        The same, for practice alone; without it, practice takes what gold leaves.
    practice_from
        The same, for practice alone.
    truth
        Take as known what .sem files beside the meshes and the pictures of cut puzzles tell.
    shapes
        Folders in which the meshes are looked for, to be kept in the study.
    """
    if guideline_file is not None:
        design = design.changed(guideline=_text(guideline_file, design))
    with progress_bar() as progress:
        read = _read(results or (), set_name, shapes or (), share(progress, 0.0, 0.7))
        told = [*map(knownanswers.read_known, gold_answers or ()), *map(_answers_of, gold_from or ())]
        if truth:
            told.append(read.truth(share(progress, 0.7, 0.8)))
        taught = [*map(knownanswers.read_known, practice_answers or ()), *map(_answers_of, practice_from or ())]
        known, notes = knownanswers.merged(*told), _unknown([*told, *taught], read.runs)
        handle = create_design(
            file, read.runs, design, gold=known, practice=knownanswers.merged(*taught), shapes=read.found.shapes.values(),
            tell=notes.append, progress=share(progress, 0.8, 1.0),
        )  # fmt: skip
    with handle:
        warn_of_place(handle.where)
        _keep_files(handle, read.files)
        matches = len({p.item.id for run in read.runs for p in run.proposals})
        print(f"{handle.where}: {_count(matches, 'match', 'matches')} of {_count(len(read.runs), 'result')}.")
        print(*notes, *_missing(read.found), sep="\n", end="\n" if notes or read.found.missing else "")


def add(file: str, results: list[str], /, *, set_name: SetName = "", shapes: Tables = None) -> None:
    """Add RESULTS to a study; votes already given stay, and matches judged already keep theirs.

    New matches of a study that asks what it was designed to ask are listed as unjudged; see `top-up`.

    Parameters
    ----------
    file
        The study.
    results
        Results to add, as for `create`; what is known already is not added twice.
    shapes
        Folders in which the meshes are looked for, to be kept in the study.
    """
    with progress_bar() as progress:
        read = _read(results, set_name, shapes or (), share(progress, 0.0, 0.9))
        with _opened(file) as handle:
            warn_of_place(handle.where)
            with handle.writing() as connection:
                runs = {insert_run(connection, run) for run in read.runs}
            keep_shapes(handle, read.found.shapes.values())
            _keep_files(handle, read.files)
            counts = [count for count in judged_counts(handle) if count.run_id in runs]
    print(f"{handle.where}: {_count(len(read.runs), 'result')} added.")
    matches, judged, asked = (sum(getattr(count, name) for count in counts) for name in ("matches", "judged", "asked"))
    print(f"{judged} of their {_count(matches, 'match', 'matches')} judged.")
    if asked < matches:
        print(f"{matches - asked} of them are not asked; `concord study top-up` asks them too.")
    for line in _missing(read.found):
        print(line)


def top_up_command(file: str, new: str | None = None, /, *, most: Whole = None, name: str = "") -> None:
    """Ask the matches of a study that are not asked yet, or make a study NEW of all that have no vote.

    Matches judged already keep their votes and are not asked again. NEW can be merged back with `concord study merge`.

    Parameters
    ----------
    file
        The study.
    new
        The study to make; without it, the matches are asked in the study itself.
    most
        How many new matches to draw at most; 0 for all.
    name
        Name of the new study.
    """
    with _opened(file) as handle:
        if new is None:
            if name:
                raise BadParameter("--name is for a new study; give its file too, or leave out --name.")
            print(f"{handle.where}: {_count(top_up(handle, most=most), 'more match', 'more matches')} asked.")
            return
        made, left = top_up_study(handle, new, name=name, most=most)
        with made:
            print(f"{made.where}: {_count(left, 'match', 'matches')} of {handle.where} without a vote.")


def gold(
    file: str, answers: Path | None = None, /, *, from_study: Annotated[str, Parameter(name="--from")] = "", most: Whole = None
) -> None:
    """Make matches of a study gold: everybody is asked about them, and who fails is flagged.

    Parameters
    ----------
    file
        The study.
    answers
        CSV table of known answers: the columns item, answer (correct or wrong).
    from_study
        STUDY or STUDY:CODE, whose majority or whose volunteer's answers are taken as known.
    most
        How many to draw at most.
    """
    _name_known(file, answers, from_study, most, name_gold, "gold")


def practice(
    file: str, answers: Path | None = None, /, *, from_study: Annotated[str, Parameter(name="--from")] = "", most: Whole = None
) -> None:
    """Make matches without a vote practice items: everybody begins with them, and they count in no table.

    Parameters
    ----------
    file
        The study.
    answers
        CSV table of known answers: the columns item, answer (correct or wrong), reason (told after the answer).
    from_study
        STUDY or STUDY:CODE, whose answers are taken as known, and whose comments as reasons.
    most
        How many to draw at most.
    """
    _name_known(file, answers, from_study, most, name_practice, "practice")


def adjudicate(file: str, code: str, /, *, end: Annotated[bool, Parameter(negative="")] = False) -> None:
    """Make the volunteer CODE one who is asked about unresolved matches alone, as blind as everybody.

    Parameters
    ----------
    file
        The study.
    code
        The volunteer, made if new.
    end
        Make an adjudicator an ordinary volunteer again.
    """
    with _opened(file) as handle:
        if end:
            known_volunteer(handle, code)
        made = make_adjudicator(handle, code, adjudicates=not end)
        waiting = sum(one.for_adjudicator for one in unresolved(handle))
    if end:
        print(f"{made.code} is asked as everybody is.")
    else:
        print(f"{made.code} adjudicates: {_count(waiting, 'match is', 'matches are')} unresolved now.")


@contextmanager
def _opened(file: str) -> Iterator[StudyHandle]:
    """A whole study, open; raises `BadInput` for a packet, or the address of a volunteer, which no design goes into."""
    with open_study(file) as handle:
        if handle.volunteer is not None:
            raise BadInput(f"{handle.where} is for {handle.volunteer} alone; give the study itself.")
        yield handle


class _Read(NamedTuple):
    """Results and the shapes that they are of."""

    files: tuple[ResultFile, ...]
    runs: tuple[Run, ...]
    found: FoundShapes

    def truth(self, progress: Progress) -> knownanswers.Known:
        """What the truths that came along tell."""
        return knownanswers.known_by_truth(self.files, self.runs, self.found.shapes, progress=progress)


def _read(results: Sequence[str], set_name: str, folders: Sequence[Path], progress: Progress) -> _Read:
    for folder in folders:
        if not folder.is_dir():
            raise BadInput(f"{folder} is no folder; give one that the meshes lie in with --shapes.")
    files = find_results(results, set_name)
    runs = read_all(files, progress=share(progress, 0.0, 0.5))
    return _Read(files, runs, find_shapes(files, runs, folders, progress=share(progress, 0.5, 1.0)))


def _name_known(
    file: str, answers: Path | None, source: str, most: int | None, name: Callable[..., int], what: str
) -> None:
    if (answers is None) == (not source):
        raise BadParameter("Give known answers: either a CSV table, or --from STUDY:CODE.")
    if most is not None and most < 0:
        raise BadParameter(f"{most} matches cannot be drawn; give a number from 0 on with --most.")
    known = knownanswers.read_known(answers) if answers is not None else _answers_of(source)
    with _opened(file) as handle:
        made = name(handle, known, most)
    print(f"{handle.where}: {_count(made, f'{what} match', f'{what} matches')} more, of {_count(len(known), 'known answer')}.")


def _answers_of(text: str) -> knownanswers.Known:
    """What a study, or one of its volunteers, answered."""
    place, colon, code = text.rpartition(":")
    told = bool(colon) and re.fullmatch(r"[\w-]{1,40}", code) is not None and not Path(text).exists()
    if is_url(text) and "/" not in place.partition("://")[2]:
        told = False
    with open_study(place if told else text, backup=False, writable=False) as handle:
        return knownanswers.known_by_votes(handle, code if told else "")


def _unknown(known: Sequence[knownanswers.Known], runs: Sequence[Run]) -> list[str]:
    """A sentence where known answers are about no match of the results."""
    items, named = {p.item.id for run in runs for p in run.proposals}, {item for one in known for item in one}
    strange = len(named - items)
    if not strange:
        return []
    return [f"{strange} of {_count(len(named), 'known answer')} {'is' if strange == 1 else 'are'} about no match of these results."]


def _text(path: Path, design: Design) -> str:
    if design.guideline:
        raise BadParameter("The guideline is given twice; leave out --guideline or --guideline-file.")
    try:
        return path.read_text(encoding="utf-8-sig").strip()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "it is no text in UTF-8"
        raise BadInput(f"{path} cannot be read as a guideline ({why}); give a text file.") from None


def _keep_files(handle: StudyHandle, files: Sequence[ResultFile]) -> None:
    """Copy the results into the project folder, where the study is one."""
    for file in files:
        keep_result(handle, file.path)


def _missing(found: FoundShapes) -> list[str]:
    """A sentence about shapes that are not kept in the study."""
    if not found.missing:
        return []
    named = "; ".join(found.missing[:_SHOWN]) + (" …" if len(found.missing) > _SHOWN else "")
    count = len(found.missing)
    return [f"{_count(count, 'shape is', 'shapes are')} not kept in the study, name their folder with --shapes: {named}."]


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"
