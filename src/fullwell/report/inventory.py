"""What was read, as the report shows it: the title, a few facts, files, exclusions, settings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import PurePath
from typing import Final, cast

from fullwell.figures.results import Results
from fullwell.report.document import Plain, plain
from fullwell.report.numbers import MISSING, show_plain

MOST_LINES: Final = 2000
_HASH: Final = "xxh3_128"
_HASH_DIGITS: Final = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """A list of like things as a table."""

    name: str
    head: tuple[str, ...]
    lines: tuple[tuple[str, ...], ...]
    omitted: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Inventory:
    """What was read and how.

    Parameters
    ----------
    camera, study
        The camera's name and that of the folder that was read, for the title; empty where unknown.
    facts
        Label and text.
    listings
        Files, exclusions and other lists.

    """

    camera: str
    study: str
    facts: tuple[tuple[str, str], ...]
    listings: tuple[Listing, ...]


def take_inventory(results: Results) -> Inventory:
    """Return what ``results.study`` holds, whatever its keys, in a form to print."""
    study = cast("dict[str, Plain]", plain(results.study))
    facts: list[tuple[str, str]] = []
    listings: list[Listing] = []
    for name, value in study.items():
        if _is_listing(value):
            listings.append(_listing(name, cast("list[dict[str, Plain]]", value)))
        else:
            facts += _facts(_words(name), value)
    return Inventory(
        camera=_text_at(study.get("camera"), "name"),
        study=PurePath(_text_at(results.run, "study")).name,
        facts=tuple(facts),
        listings=tuple(listings),
    )


def run_facts(results: Results) -> tuple[tuple[str, str], ...]:
    """Return what may differ between two runs: version, time, host, duration ..."""
    return tuple(fact for name, value in results.run.items() for fact in _facts(_words(name), plain(value)))


def run_date(results: Results) -> str:
    """Return when the run was, as it says itself; empty where it does not."""
    text = _text_at(results.run, "time")
    try:
        return f"{datetime.fromisoformat(text):%Y-%m-%d %H:%M %Z}".strip()
    except ValueError:
        return text


def _text_at(mapping: object, key: str) -> str:
    value = cast("Mapping[str, object]", mapping).get(key) if isinstance(mapping, Mapping) else None
    return value if isinstance(value, str) else ""


def _is_listing(value: Plain) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _listing(name: str, items: Sequence[dict[str, Plain]]) -> Listing:
    keys = tuple(dict.fromkeys(key for item in items for key in item))
    filled = tuple(key for key in keys if any(item.get(key) not in (None, "", []) for item in items))
    lines = tuple(tuple(_text(item.get(key), key) for key in filled) for item in items[:MOST_LINES])
    return Listing(
        name=_words(name),
        head=tuple(_words(key) for key in filled),
        lines=lines,
        omitted=max(len(items) - MOST_LINES, 0),
    )


def _facts(name: str, value: Plain) -> list[tuple[str, str]]:
    """Return a value as facts; a mapping gives one fact per entry."""
    if isinstance(value, dict) and not _is_level(value):
        return [fact for key, item in value.items() for fact in _facts(f"{name}: {_words(key)}", item)]
    return [] if value in (None, "", []) else [(name, _text(value, name))]


def _text(value: Plain, name: str) -> str:
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return str(value) if isinstance(value, int) else show_plain(value)
    if isinstance(value, list):
        return (" " if name == "Command" else ", ").join(_text(item, name) for item in value)
    if isinstance(value, dict):
        return (
            _level(value)
            if _is_level(value)
            else "; ".join(f"{_words(key)} {_text(item, key)}" for key, item in value.items())
        )
    return f"{value[:_HASH_DIGITS]}…" if name == _HASH else value


def _is_level(value: Mapping[str, Plain]) -> bool:
    return {"values", "source"} <= value.keys()


def _level(level: Mapping[str, Plain]) -> str:
    """Return a level with where it came from: ``64, 64, 64, 64 (metadata, BlackLevel)``."""
    origin = ", ".join(text for key in ("source", "tag") if (text := _text(level.get(key), key)) not in ("", MISSING))
    return f"{_text(level['values'], 'values')} ({origin})"


def _words(key: str) -> str:
    """Return a key as words: ``exposure_s`` becomes ``Exposure [s]``."""
    stem, _, unit = key.rpartition("_")
    units = {"s": "s", "c": "°C", "um": "µm", "mm": "mm", "v": "V", "dn": "DN"}
    text = f"{stem} [{units[unit]}]" if stem and unit in units else key
    text = text.replace("_", " ")
    text = text[:1].upper() + text[1:]
    return {"Iso": "ISO", "Cfa": "CFA", "Xxh3 128": "XXH3-128"}.get(text, text)
