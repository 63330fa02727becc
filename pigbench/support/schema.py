"""Reading dataclasses from plain values, as JSON and TOML have them, by their annotations."""

import functools
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, get_args, get_type_hints

import pydantic
from pydantic_core import ErrorDetails

from pigbench.errors import UserError

T = TypeVar("T")


def read(kind: type[T], values: Any, what: str) -> T:
    """The `kind` that `values` are: with each field known, there, of its type and in its range.

    Raises UserError, which begins with `what` and names the first wrong field, its name dotted from
    the outside in.
    """
    try:
        return _adapter(kind).validate_python(values, extra="forbid")
    except UserError as error:
        raise UserError(f"{what}: {error}") from None
    except pydantic.ValidationError as error:
        first = min(error.errors(), key=lambda one: one["type"] not in _UNKNOWN_FIELD)
        where = ".".join(map(str, _place(values, first)))
        said = _SAID.get(first["type"], _as_it_is)(first)
        raise UserError(": ".join(filter(None, [what, where, said]))) from None


def fill(template: T, values: Any, what: str) -> T:
    """The dataclass `template` with the fields that `values` have, of nested dataclasses too.

    Raises UserError as `read` does.
    """
    return read(type(template), _merged(template, values, what), what)


BY_KIND = pydantic.Field(discriminator="kind")
"""Annotates a union of dataclasses that differ in the default of their `Literal` field `kind`."""


@functools.cache
def _adapter(kind: type[T]) -> pydantic.TypeAdapter[T]:
    return pydantic.TypeAdapter(kind)


def _merged(template: Any, values: Any, what: str) -> Any:
    if not isinstance(values, Mapping):
        return values
    hints = get_type_hints(type(template))
    own = {field.name: getattr(template, field.name) for field in fields(template) if field.init}
    return own | {
        name: _nested(hints[name], own[name], value, f"{what}: {name}") if name in own else value
        for name, value in values.items()
    }


def _nested(hint: Any, like: Any, value: Any, what: str) -> Any:
    """The value of a field that is `like` this in the template."""
    if not is_dataclass(like) or not isinstance(value, Mapping):
        return value
    if value.get("kind", kind := getattr(like, "kind", None)) != kind:
        return value
    if type(like) in (hint, *get_args(hint)):
        return _merged(like, value, what)
    return fill(like, value, what)  # a subclass of what the annotation says


def _place(values: Any, error: ErrorDetails) -> list[str | int]:
    """Where in `values` the error is: pydantic's place without the names of a union's parts."""
    *outer, last = error["loc"] or [""]
    place = []
    for step in outer:
        if _has(values, step):
            place.append(step)
            values = values[step]
    named = last if _has(values, last) or error["type"] == "missing" else ""
    return [step for step in (*place, named) if step != ""]


def _has(values: Any, step: str | int) -> bool:
    if isinstance(values, Mapping):
        return step in values
    return isinstance(values, list | tuple) and isinstance(step, int) and step < len(values)


def _as_it_is(error: ErrorDetails) -> str:
    return f"{error['msg']}, not {reprlib.repr(error['input'])}"


_UNKNOWN_FIELD = ("unexpected_keyword_argument", "extra_forbidden")  # of dataclasses, of models
_NO_FIELDS = ("dataclass_type", "model_type")

_SAID: Mapping[str, Callable[[ErrorDetails], str]] = {
    **dict.fromkeys(_UNKNOWN_FIELD, lambda error: "there is no such field"),
    "missing": lambda error: "this field is missing",
    **dict.fromkeys(
        _NO_FIELDS, lambda error: f"{reprlib.repr(error['input'])} is no set of fields"
    ),
    "union_tag_not_found": lambda error: "its field kind is missing",
    "union_tag_invalid": lambda error: (
        f"kind is {error['ctx']['tag']!r}: known are {error['ctx']['expected_tags']}"  # pyright: ignore[reportTypedDictNotRequiredAccess]
    ),
}
"""What is said of an error, by its type in pydantic, where pydantic's own words are not clearer."""
