"""Matches in the format of `matches.json` (schema concord.matches/1) as a run of a study."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.errors import BadInput

from ..records import Proposal, Run
from ..storage.handle import StudyHandle
from .proposals import add_run, distinct, shape_item

if TYPE_CHECKING:
    from engine.shapes.result import MatchResult

Label = Annotated[int, Field(strict=True)] | Annotated[str, Field(strict=True)]
Count = Annotated[int, Field(ge=0)]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


class _Shape(_Model):
    file: str
    sha256: Annotated[str, Field(min_length=1)]
    segments: Count
    faces: Count
    segmentation: str = ""  # hash of the labels where it is given: one mesh may come with several segmentations


class _Match(_Model):
    id: Annotated[str, Field(min_length=1)]
    source: Annotated[tuple[Label, ...], Field(min_length=1)]
    target: Annotated[tuple[Label, ...], Field(min_length=1)]
    score: float
    votes: Count
    source_layer: Count
    target_layer: Count


class _MatchesFile(_Model):
    schema_: Annotated[Literal["concord.matches/1"], Field(alias="schema")]
    source: _Shape
    target: _Shape
    method: str
    preset: str = ""
    parameters: dict[str, Any]
    matches: tuple[_Match, ...]
    seconds: dict[str, float] = {}
    wishes: dict[str, Any] | None = None  # what people had pinned or forbidden


def read_matches(path: Path | str, set_name: str = "") -> Run:
    """The run that a file of matches holds; raises `BadInput` in one sentence for anything else."""
    try:
        return _run(_MatchesFile.model_validate_json(Path(path).read_bytes()), set_name)
    except OSError as error:
        raise BadInput(f"{path} cannot be read ({error.strerror}); give a matches.json file.") from None
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise BadInput(f"{path} is no file of matches ({where}: {first['msg']}); write it anew.") from None


def add_result(handle: StudyHandle, result: "MatchResult", *, set_name: str = "") -> str:
    """Register a result of shape matching (see `add_run`); `set_name` names its row group in the precision table."""
    from engine.matchfile import result_to_json

    return add_run(handle, run_of_json(result_to_json(result), set_name))


def run_of_json(content: Mapping[str, Any], set_name: str = "") -> Run:
    """The run that the content of such a file, just made, stands for."""
    return _run(_MatchesFile.model_validate(content), set_name)


def _run(read: _MatchesFile, set_name: str) -> Run:
    """The run; where wishes were honoured it is counted apart from what the method finds alone."""
    proposals = (
        Proposal(
            shape_item(match.id, _side(read.source, match.source), _side(read.target, match.target)),
            match.score, match.votes, match.source_layer, match.target_layer,
        )
        for match in read.matches
    )  # fmt: skip
    return Run(
        "shape", read.method + (" (guided)" if read.wishes else ""), read.preset, read.parameters, set_name, read.source.model_dump(),
        read.target.model_dump(), read.seconds, distinct(proposals),
    )  # fmt: skip


def _side(shape: _Shape, segments: tuple[int | str, ...]) -> dict[str, Any]:
    side: dict[str, Any] = {"file": shape.file, "sha256": shape.sha256, "segments": list(segments)}
    return side | {"segmentation": shape.segmentation} if shape.segmentation else side
