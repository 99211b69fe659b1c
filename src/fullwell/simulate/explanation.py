"""What is wrong with a config, as a sentence that names the key, its value and what is allowed."""

import difflib
import json
from collections.abc import Sequence
from typing import Final, cast, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from fullwell.simulate.tables import ConfigTable

_UNKNOWN: Final = "extra_forbidden"


def explained(error: ValidationError, *, name: str) -> str:
    """Return what is wrong with a config: unknown keys first, since they often are why another key is missing.

    Parameters
    ----------
    error
        What pydantic found.
    name
        What to call the config.

    """
    faults = error.errors()
    first = next((fault for fault in faults if fault["type"] == _UNKNOWN), faults[0])
    return _sentence(name, first["loc"], first["type"], first["input"])


def _sentence(name: str, place: Sequence[int | str], kind: str, value: object) -> str:
    known = _known_keys()
    named = [part for part in place[:-1] if isinstance(part, int) or part in known]
    if isinstance(place[-1], int) or place[-1] in known or kind == _UNKNOWN:
        named.append(place[-1])
    key = ".".join(str(part) for part in named)
    shown = json.dumps(value, default=str)
    parent = _model_at(place[:-1])
    if kind == _UNKNOWN and parent is not None:
        names = list(parent.model_fields)
        close = difflib.get_close_matches(str(place[-1]), names, n=1)
        meant = f" Did you mean {close[0]}?" if close else ""
        return f"{name}: {key} = {shown} is not a key that is known.{meant} Allowed here: {', '.join(names)}."
    if kind == "missing":
        return f"{name}: {key} is missing; allowed: {_allowed(place)}."
    return f"{name}: {key} = {shown} cannot be used; allowed: {_allowed(place)}."


def _known_keys() -> set[str]:
    """Return every key a config may have; pydantic puts the names of alternatives between them."""
    pending: list[type[BaseModel]] = [ConfigTable]
    keys: set[str] = set()
    while pending:
        for key, field in pending.pop().model_fields.items():
            keys.add(key)
            pending += _tables_in(field.annotation)
    return keys


def _tables_in(annotation: object) -> list[type[BaseModel]]:
    if isinstance(annotation, type):
        return [annotation] if issubclass(annotation, BaseModel) else []
    parts = cast("tuple[object, ...]", getattr(annotation, "__args__", ()))
    return [table for part in parts for table in _tables_in(part)]


def _model_at(place: Sequence[int | str]) -> type[BaseModel] | None:
    model: type[BaseModel] = ConfigTable
    for part in place:
        field = model.model_fields.get(str(part))
        if field is None:
            continue
        tables = _tables_in(field.annotation)
        if not tables:
            return None
        model = tables[0]
    return model


def _allowed(place: Sequence[int | str]) -> str:
    """Return the words of the innermost field that has some; of an item of a list those of the item, if it has some."""
    for length in range(len(place), 0, -1):
        model = _model_at(place[: length - 1])
        field = None if model is None else model.model_fields.get(str(place[length - 1]))
        if field is not None:
            tables = _tables_in(field.annotation)
            parts = _parts_in_words(field.annotation)
            own = parts[:1] if place[length:] else []
            told = [*own, *filter(None, [field.description]), *parts]
            return (
                told[0] if told else ("a table of " + ", ".join(tables[0].model_fields) if tables else "true or false")
            )
    return "a table"


def _parts_in_words(annotation: object) -> list[str]:
    """Return what is said of the alternatives, or of the items, of an annotation."""
    said = (one for part in get_args(annotation) for one in getattr(part, "__metadata__", ()))
    return [one.description for one in said if isinstance(one, FieldInfo) and one.description]
