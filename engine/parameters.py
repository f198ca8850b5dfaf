"""The one way a parameter is declared: name, range, default, unit, doc, symbol and equation.

The command-line option, the slider, the saved file and the report are all derived from the fields of a
`Parameters` model, so a range is never written twice.
"""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from .errors import BadInput, BadParameter

P = TypeVar("P", bound="Parameters")


def parameter(
    default: Any,
    doc: str,
    *,
    low: float | None = None,
    high: float | None = None,
    step: float | None = None,
    multiple: int | None = None,
    symbol: str = "",
    unit: str = "",
    equation: str = "",
    group: str = "",
    live: bool = False,
    methods: tuple[str, ...] = (),
) -> Any:
    """Declare one parameter as a field of a `Parameters` model.

    `group` is the step that it belongs to (the heading above its slider), `live` says that a change costs
    milliseconds and may be followed while a slider moves, `methods` restricts it to some methods (all if empty).
    `step` is how far a slider moves at a time, `multiple` demands multiples of a number.
    """
    extra: dict[str, Any] = {
        "symbol": symbol, "unit": unit, "equation": equation, "group": group,
        "live": live, "methods": list(methods), "step": multiple or step, "multiple": multiple,
    }  # fmt: skip
    return Field(default=default, ge=low, le=high, multiple_of=multiple, description=doc, json_schema_extra=extra)


class ParameterInfo(NamedTuple):
    """Everything that is declared of one parameter, for forms, help and reports."""

    name: str
    kind: Literal["real", "integer", "switch", "choice", "text"]
    default: Any
    low: float | None
    high: float | None
    step: float | None
    multiple: int | None
    choices: tuple[str, ...]
    doc: str
    symbol: str
    unit: str
    equation: str
    group: str
    live: bool
    methods: tuple[str, ...]

    @property
    def source(self) -> str:
        """Where it comes from, in words: 'Equation 3.3' or 'Algorithm 1'; empty where nothing is cited."""
        return f"Equation {self.equation}" if self.equation[:1].isdigit() else self.equation


class Parameters(BaseModel):
    """A frozen group of declared parameters."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True)

    def changed(self, /, **values: Any) -> Self:
        """A checked copy with some values replaced; raises `BadParameter` with one clear sentence."""
        return checked(type(self), {**self.model_dump(), **values})

    def differences(self, other: "Parameters") -> dict[str, Any]:
        """The values of `self` that differ from `other`, by name."""
        theirs = other.model_dump()
        return {name: value for name, value in self.model_dump().items() if theirs.get(name) != value}


def declared(model: type[Parameters]) -> tuple[ParameterInfo, ...]:
    """All parameters of a model in the order of their declaration."""
    return tuple(_info(model, name) for name in model.model_fields)


def _info(model: type[Parameters], name: str) -> ParameterInfo:
    field = model.model_fields[name]
    extra: Mapping[str, Any] = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    limits: dict[str, float] = {}
    for mark in field.metadata:
        for side in ("ge", "le"):
            if getattr(mark, side, None) is not None:
                limits[side] = getattr(mark, side)
    choices = get_args(field.annotation) if get_origin(field.annotation) is Literal else ()
    kinds: dict[Any, Literal["switch", "integer", "text"]] = {bool: "switch", int: "integer", str: "text"}
    kind: Literal["real", "integer", "switch", "choice", "text"]
    kind = "choice" if choices else kinds.get(field.annotation, "real")
    return ParameterInfo(
        name=name, kind=kind, default=field.default, low=limits.get("ge"), high=limits.get("le"),
        step=extra.get("step"), multiple=extra.get("multiple"), choices=choices,
        doc=field.description or "", symbol=extra.get("symbol", ""),
        unit=extra.get("unit", ""), equation=extra.get("equation", ""), group=extra.get("group", ""),
        live=extra.get("live", False), methods=tuple(extra.get("methods", ())),
    )  # fmt: skip


def checked(model: type[P], values: Mapping[str, Any]) -> P:
    """Build a model from values (texts are converted), or raise `BadParameter` in one sentence."""
    try:
        return model.model_validate(dict(values))
    except ValidationError as error:
        raise BadParameter(sentence(model, error)) from None


def sentence(model: type[Parameters], error: ValidationError) -> str:
    """What is wrong with the first value that a model refuses, and what it takes."""
    first = error.errors()[0]
    name = str(first["loc"][0]) if first["loc"] else "?"
    if name not in model.model_fields:
        return f"There is no parameter named '{name}'; the parameters are: {', '.join(model.model_fields)}."
    info = _info(model, name)
    if info.kind == "choice":
        wanted = "one of " + ", ".join(map(str, info.choices))
    elif info.kind == "switch":
        wanted = "true or false"
    elif info.kind == "text":
        wanted = "a text"
    else:
        noun = "a whole number" if info.kind == "integer" else "a number"
        wanted = noun + (f" from {info.low:.12g} to {info.high:.12g}" if info.low is not None and info.high is not None else "")
        wanted += f", a multiple of {info.multiple}" if info.multiple else ""
    return f"The parameter '{name}' cannot be {first['input']!r}: it takes {wanted}."


def assignments(texts: Iterable[str]) -> dict[str, str]:
    """Read NAME=VALUE texts as the command line gives them."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise BadParameter(f"'{text}' is not of the form NAME=VALUE, for example delta_1=0.3.")
        values[name.strip()] = value.strip()
    return values


def read_values(path: Path) -> dict[str, Any]:
    """Read a parameters file (JSON object of names and values, as every run writes one)."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"The parameters file {path} cannot be read: {error.strerror}.") from None
    except (ValueError, RecursionError):
        raise BadInput(f"The parameters file {path} is not JSON; give a parameters.json that a run has written.") from None
    if not isinstance(content, dict):
        raise BadInput(f"The parameters file {path} must hold one JSON object of names and values.")
    return content
