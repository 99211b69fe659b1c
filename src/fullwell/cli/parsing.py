"""Texts of the command line become values; what is not allowed is said in a sentence."""

import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.frames.cameras import camera_named
from fullwell.frames.crop import SMALLEST_CROP
from fullwell.frames.naming import PER_SECOND
from fullwell.frames.selection import Selection
from fullwell.frames.series import HIGHEST_CODE, Kind
from fullwell.raw.cfa import BAYER, MONO
from fullwell.raw.headerless_format import parse_format
from fullwell.workflow.cache.opening import cache_beside
from fullwell.workflow.options import CacheChoice

SMALLEST_TILE: Final = 4
LARGEST_TILE: Final = 256
_TIME: Final = re.compile(r"(?P<number>[^a-zµ]*(?:e[+-]?\d+)?)(?P<unit>us|µs|ms|s)?", re.IGNORECASE)


def selection_from(
    *,
    isos: Sequence[str] | None = None,
    exposures: Sequence[str] | None = None,
    only: Sequence[str] | None = None,
    cfa: str | None = None,
    black: str | None = None,
    white: float | None = None,
    camera: str | None = None,
    crop: str | None = None,
    headerless: str | None = None,
) -> Selection:
    """Return what the user asked for.

    Raises
    ------
    UsageError
        Where an option's text is not allowed; the sentence names the option, the text and what is allowed.

    """
    return Selection(
        isos=tuple(_positive(text, option="--iso") for text in _items(isos)),
        exposures_s=tuple(_seconds(text) for text in _items(exposures)),
        kinds=tuple(_kind(text) for text in _items(only)),
        cfa=None if cfa is None else cfa_from(cfa),
        black_level=None if black is None else _black(black),
        white_level=None if white is None else _level(white, option="--white", least=1),
        camera=None if camera is None else camera_named(camera),
        crop=None if crop is None else _crop(crop),
        headerless=None if headerless is None else parse_format(headerless),
    )


def cfa_from(text: str) -> str:
    """Return a CFA's name from a text in any case."""
    known = {name.casefold(): name for name in (*BAYER, MONO)}
    if text.casefold() not in known:
        raise UsageError(f"--cfa {text}: give one of {', '.join(known.values())}.")
    return known[text.casefold()]


def legacy_black_from(text: str) -> bool:
    """Return whether the published study's tables have the black level subtracted."""
    known = {"kept": False, "subtracted": True}
    if text.casefold() not in known:
        raise UsageError(f"--legacy-black {text}: give kept (as published) or subtracted.")
    return known[text.casefold()]


def tile_from(value: int | None) -> int | None:
    """Return the edge of a tile as it was given [pixel of a plane]; None leaves it to the study."""
    if value is not None and not SMALLEST_TILE <= value <= LARGEST_TILE:
        raise UsageError(f"--tile {value}: give {SMALLEST_TILE} to {LARGEST_TILE} pixels of a CFA plane.")
    return value


def cache_from(folder: Path | None, *, no_cache: bool, out: Path | None, recheck: bool = False) -> CacheChoice | None:
    """Return where finished series are kept: beside the results unless told otherwise."""
    if folder is not None and no_cache:
        raise UsageError("--cache and --no-cache contradict each other: give one of them.")
    if folder is not None:
        return CacheChoice(folder=folder, shared=True, recheck=recheck)
    return None if no_cache or out is None else CacheChoice(folder=cache_beside(out), recheck=recheck)


def _crop(text: str) -> tuple[int, int, int, int]:
    """Return x, y, width and height of a region [pixel]."""
    wish = (
        f"--crop {text}: give x,y,width,height in pixels of the visible mosaic, for example 100,100,800,600; "
        f"width and height are at least {SMALLEST_CROP}, and {2 * SMALLEST_CROP} with a Bayer pattern."
    )
    try:
        x, y, width, height = (int(part) for part in text.split(","))
    except ValueError as error:
        raise UsageError(wish) from error
    if min(x, y) < 0 or min(width, height) < SMALLEST_CROP:
        raise UsageError(wish)
    return x, y, width, height


def _items(texts: Sequence[str] | None) -> Iterable[str]:
    return [item.strip() for text in texts or () for item in text.split(",") if item.strip()]


def _number(text: str, *, option: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"{option} {text}: give a number.")
    return value


def _level(value: float, *, option: str, least: int) -> float:
    if not least <= value <= HIGHEST_CODE:
        raise UsageError(f"{option} {value:g}: give a level from {least} to {HIGHEST_CODE} DN.")
    return value


def _positive(text: str, *, option: str) -> float:
    value = _number(text, option=option)
    if value <= 0.0:
        raise UsageError(f"{option} {text}: give a number above 0.")
    return value


def _seconds(text: str) -> float:
    match = _TIME.fullmatch(text)
    if match is None:
        raise UsageError(f"--exposure {text}: give seconds, or a number with a unit such as 10ms or 500us.")
    return _positive(match["number"].strip(), option="--exposure") / PER_SECOND[(match["unit"] or "s").lower()]


def _kind(text: str) -> Kind:
    try:
        return Kind(text.lower())
    except ValueError as error:
        raise UsageError(f"--only {text}: give one of {', '.join(kind.value for kind in Kind)}.") from error


def _black(text: str) -> tuple[float, ...]:
    values = tuple(_level(_number(item, option="--black"), option="--black", least=0) for item in _items([text]))
    if len(values) not in {1, 4}:
        raise UsageError(f"--black {text}: give one level, or four (one per CFA site, row by row).")
    return values
