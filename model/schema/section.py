"""The common part of all tables of a robot file: types of values, validation, one-sentence errors."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar, get_args

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    Tag,
    ValidationError,
    model_validator,
)
from pydantic_core import CoreSchema, ErrorDetails, PydanticCustomError
from pydantic_core.core_schema import (
    no_info_after_validator_function,
    no_info_before_validator_function,
)

UNKNOWN = "unknown_field"  # type of error that names a field which a table does not have


class RobotFileError(ValueError):
    """A robot file that cannot be used; the text names file, field, what was found and allowed."""


def _with_strict_numbers(schema: Any) -> Any:
    """A pydantic schema in which numbers and booleans are of their own types, with all that it contains.

    A whole number may be written as a float, as JSON Schema has it, or be one of numpy.
    """
    if isinstance(schema, dict):
        if schema.get("function") == {"type": "no-info", "function": _number}:
            return schema
        if isinstance(schema.get("choices"), list):
            schema = schema | {"choices": [_labelled(item) for item in schema["choices"]]}
        found = {
            key: value if key == "default" else _with_strict_numbers(value)
            for key, value in schema.items()
        }
        if found.get("type") == "int":
            return no_info_before_validator_function(_number, found)
        return found | {"strict": True} if found.get("type") in ("float", "bool") else found
    if isinstance(schema, list):
        return [_with_strict_numbers(item) for item in schema]
    if isinstance(schema, tuple):  # a choice of a union with its label
        return tuple(_with_strict_numbers(item) for item in schema)
    return schema


def _labelled(choice: Any) -> Any:
    """A choice of a union; a number or a list with a label that errors leave out, see `validated`."""
    kind = choice.get("type") if isinstance(choice, dict) else None
    return (choice, f"<{kind}>") if kind in ("int", "float", "list", "tuple") else choice


def _number(value: object) -> object:
    """The value; raise a PydanticCustomError for a boolean or a text, which pydantic takes for integers."""
    if isinstance(value, bool | np.bool_ | str | bytes):
        raise PydanticCustomError("int_type", "Input should be a valid integer")
    return value


class Section(BaseModel):
    """A table of a robot file: unknown keys and non-finite numbers are errors, so is `true` for a number."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)
    # fields of the table in the file that others read
    read_elsewhere: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        handled = handler(source)
        if cls.__pydantic_complete__:  # the schema of a table that has been made, for one around it
            return handled
        made: CoreSchema = _with_strict_numbers(handled)
        return made

    @model_validator(mode="before")
    @classmethod
    def _known_fields(cls, raw: Any) -> Any:
        if isinstance(raw, dict) and cls.model_config.get("extra") == "forbid":
            strange = sorted(str(key) for key in raw if key not in cls.model_fields)
            if strange:
                allowed = ", ".join(dict.fromkeys((*cls.model_fields, *cls.read_elsewhere)))
                raise PydanticCustomError(
                    UNKNOWN,
                    "unknown field, allowed are {allowed}",
                    {"field": encodable(strange[0]), "allowed": allowed},
                )
        return raw


def encodable(text: str) -> str:
    """The text with the halves of surrogate pairs, which JSON may hold and UTF-8 may not, as escapes."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


S = TypeVar("S", bound=Section)


@dataclass(frozen=True, slots=True)
class in_range:
    """A check that a number lies in a range, whose error states the whole range.

    Attributes:
        low: smallest value allowed; where it is zero, zero itself is not.
        high: largest value allowed.
        unit: of both, for the error.
    """

    low: float
    high: float
    unit: str

    def check(self, value: float) -> float:
        """The value, if it lies in the range.

        Raises:
            ValueError: it does not.
        """
        if not self.low <= value <= self.high or (self.low == 0.0 and value == 0.0):
            least = "more than 0" if self.low == 0.0 else f"at least {self.low:g}"
            raise ValueError(f"allowed is {least} and at most {self.high:g} {self.unit}".rstrip())
        return value

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return no_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        least = "exclusiveMinimum" if self.low == 0.0 else "minimum"
        return handler(schema) | {least: self.low, "maximum": self.high}


def kind_of_parameter(value: object) -> str:
    """Which of the choices of a parameter a value is checked against, as a tag that errors leave out."""
    if isinstance(value, str):
        return "<text>"
    if not isinstance(value, list | tuple):
        return "<number>"
    return "<rows>" if any(isinstance(item, list | tuple) for item in value) else "<numbers>"


def not_zero(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    """Raise a ValueError for a direction too short to be normalised."""
    if max(abs(value) for value in direction) < SHORTEST_DIRECTION:
        raise ValueError(f"a direction needs a component of at least {SHORTEST_DIRECTION:g}")
    return direction


SHORTEST_DIRECTION = 1e-6
LARGEST_COORDINATE = 1e3  # m; beyond it the rounding of positions is not small against gaps

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
NAME = r"^[A-Za-z][A-Za-z0-9_]*$"
Name = Annotated[str, Field(pattern=NAME)]
Coordinate = Annotated[float, in_range(-LARGEST_COORDINATE, LARGEST_COORDINATE, "m")]
Point = tuple[Coordinate, Coordinate, Coordinate]
Direction = Annotated[tuple[Coordinate, Coordinate, Coordinate], AfterValidator(not_zero)]
Thickness = Annotated[float, in_range(1e-6, 10.0, "m")]  # of solid parts
Distance = Annotated[float, in_range(1e-9, 1.0, "m")]  # alarm distance and tolerance of contact
Rate = Annotated[float, Field(gt=0.0, le=10_000.0), in_range(1e-2, 1e4, "Hz")]

# What a function of another package is made with: numbers, lists of such, or texts such as names of files.
Parameter = Annotated[
    Annotated[float, Tag("<number>")]
    | Annotated[str, Tag("<text>")]
    | Annotated[list[float], Tag("<numbers>")]
    | Annotated[list[list[float]], Tag("<rows>")],
    Discriminator(kind_of_parameter),
]
Parameters = dict[Name, Parameter]

MaxOutside = Annotated[
    NonNegative,
    Field(
        le=10.0,
        description="How far outside the body its points may lie [m], by default 0; they then move with "
        "the nearest element.",
    ),
]


def cause(error: Exception) -> str:
    """Why a file cannot be read, without its path and the number of the error, for a text that names it."""
    return str(getattr(error, "strerror", None) or error)


def read_text(path: Path, parse: Callable[[str], Any], kind: str) -> Any:
    """The contents of a file that holds TOML or JSON, not validated.

    Raises:
        RobotFileError: missing, or not of this format.
    """
    try:
        text = path.read_text(
            encoding="utf-8-sig"
        )  # editors on Windows begin with a byte order mark
    except UnicodeDecodeError as error:
        raise RobotFileError(f"{path}: cannot be read ({error}); save it as UTF-8") from error
    except (OSError, ValueError) as error:  # a zero byte in the path too
        raise RobotFileError(f"{path}: cannot be read ({cause(error)})") from error
    try:
        return parse(text)
    except (ValueError, RecursionError) as error:
        raise RobotFileError(f"{path}: not {kind}: {' '.join(str(error).split())}") from error


def read_toml(path: Path) -> dict[str, Any]:
    """The contents of a TOML file, not validated.

    Raises:
        RobotFileError: missing, or not TOML.
    """
    contents: dict[str, Any] = read_text(path, tomllib.loads, "TOML")
    return contents


def validated(kind: type[S], raw: object, source: str | Path, prefix: str = "") -> S:
    """The contents of a file, or of a table of one, as a section of some kind.

    Args:
        kind: the section.
        raw: its keys and values.
        source: the file, for errors.
        prefix: name of the table within the file, for errors; "" for the whole file.

    Raises:
        RobotFileError: a field that is not allowed; the text names it, what was found and what is allowed.
    """
    try:
        return kind.model_validate(raw)
    except ValidationError as error:
        errors = error.errors()
        places = [_place(one) for one in errors]
        # of the choices of a union the first one whose error is in an item of the value
        within = [i for i, place in enumerate(places) if place[: len(places[0])] == places[0]]
        chosen = max(within, key=lambda i: len(places[i]))
        place, value = places[chosen], errors[chosen]["input"]
        field = ".".join([prefix] * bool(prefix) + place)
        message = _reason(kind, place, errors[chosen])
        found = "" if isinstance(value, dict) else f", found {shown(value)}"
        others = len({tuple(one) for i, one in enumerate(places) if i not in within})
        more = f" (and {others} more)" if others else ""
        colon = ": " if field else ""
        text = f"{source}: {field}{colon}{message}{found}{more}"
        raise RobotFileError(" ".join(text.split())) from error


def _place(error: ErrorDetails) -> list[str]:
    """The field of an error and the tables around it, from the outermost in."""
    # a part in angle brackets names the kind of a table or value, see `tauten.model.schema.region`
    place = [str(part) for part in error["loc"] if not str(part).startswith("<")]
    return [*place, error["ctx"]["field"]] if error["type"] == UNKNOWN else place


def _reason(kind: type[Section], place: list[str], error: ErrorDetails) -> str:
    """What is wrong with a field, in words of a robot file where pydantic's are those of Python."""
    sort, outermost = error["type"], kind.model_fields.get(place[0]) if len(place) == 1 else None
    if sort in ("model_type", "model_attributes_type", "dict_type"):
        return (
            f"needs to be a table, [{place[0]}] with single brackets"
            if outermost
            else "needs to be a table"
        )
    if sort in ("list_type", "tuple_type"):
        if isinstance(error["input"], dict) and outermost and _has_tables(outermost.annotation):
            return f"needs to be a list of tables, [[{place[0]}]] with double brackets"
        return "needs to be a list"
    if sort == "string_pattern_mismatch" and error["ctx"]["pattern"] == NAME:
        return "allowed are a letter, then letters, digits and _"
    message = error["msg"].removeprefix("Value error, ").replace(" after validation", "")
    return message.replace("Tuple should", "List should")


def _has_tables(annotation: Any) -> bool:
    """Whether a type is that of a table, or of something that contains one."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return True
    return any(_has_tables(one) for one in get_args(annotation))


def shown(value: object) -> str:
    """A value as an error shows it, cut where it is long."""
    try:
        text = repr(value)
    except ValueError:  # an integer with more digits than Python prints
        text = f"a value of type {type(value).__name__}"
    return text if len(text) <= 100 else f"{text[:97]}..."


def check_unique(what: str, names: list[str]) -> None:
    """Raise a ValueError when a name is used twice."""
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"{what}: name {twice[0]!r} is used twice")
