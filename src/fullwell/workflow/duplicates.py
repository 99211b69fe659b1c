"""A frame that a study holds twice counts once: its copy would make the temporal noise too small, down to none.

Whether two files are the same is known only when both have been read. So a study is reduced as it is; the series that
turn out to hold copies, which are rare, are reduced once more without them.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final, TypeVar

from fullwell.errors import RawFileError
from fullwell.findings import Finding, Severity, listed
from fullwell.frames.series import Exclusion, Frame, Kind, Series, SeriesKey, Study
from fullwell.raw.open import decode, read_bytes
from fullwell.workflow.executor import Progress
from fullwell.workflow.reduce import Reduction, reduce_study

CODE: Final = "duplicate-frame"
_Reduce = Callable[[Study], Reduction]
_Found = TypeVar("_Found")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Copy:
    """A frame whose content is that of another, which comes before it by name."""

    name: str
    original: Frame


def reduce_without_copies(
    study: Study,
    *,
    workers: int,
    tile: int,
    progress: Progress | None = None,
    keep: Collection[Kind] = (),
    scratch: Path | None = None,
) -> Reduction:
    """Return the statistics of a study's series, every file's content counted once.

    Of files with the same content, the first by name counts. Frames of a single code are no proof of a copy, since a
    camera that clips them may well write the same file twice: they count, and a finding names them.

    Parameters
    ----------
    study, workers, tile, progress, keep, scratch
        As `reduce_study`; ``progress`` starts again where frames are read a second time.

    Returns
    -------
    Reduction
        Its hashes are of all files, copies included.

    """
    reduce = partial(reduce_study, workers=workers, tile=tile, progress=progress, keep=keep, scratch=scratch)
    reduction = reduce(study)
    copies = find_copies(study, reduction)
    if copies.there:
        reduction = _corrected(study, reduction, copies, reduce)
    return copies.named(reduction)


@dataclass(frozen=True, slots=True, kw_only=True)
class Copies:
    """The copies of a study, and frames that hold one code only and may be none."""

    found: tuple[_Copy, ...]
    flat: tuple[_Copy, ...]

    @property
    def there(self) -> bool:
        """Whether any frame must be left out."""
        return bool(self.found)

    def left_out(self, series: Iterable[Series]) -> tuple[Series, ...]:
        """Return series without their copies."""
        names = {one.name for one in self.found}
        return tuple(
            replace(one, frames=tuple(frame for frame in one.frames if frame.name not in names)) for one in series
        )

    def named(self, reduction: Reduction) -> Reduction:
        """Return a reduction that says what was left out, and what was not though it looks like a copy."""
        excluded = tuple(
            Exclusion(name=one.name, code=CODE, reason=f"its content is that of {one.original.name}")
            for one in self.found
        )
        told = (_copies_finding, self.found), (_flat_finding, self.flat)
        return replace(
            reduction,
            excluded=tuple(sorted((*reduction.excluded, *excluded), key=lambda one: one.name)),
            findings=(*reduction.findings, *(finding(copies) for finding, copies in told if copies)),
        )


def find_copies(study: Study, reduction: Reduction) -> Copies:
    """Return which frames of a study are copies, by what all its files hold."""
    flat, copies = _told_apart(_copies(study, reduction))
    return Copies(found=copies, flat=flat)


def _copies(study: Study, reduction: Reduction) -> tuple[_Copy, ...]:
    """Return every usable frame whose content a frame before it by name has, by name."""
    damaged = {one.name for one in reduction.excluded}
    frames = sorted((frame for series in study.series for frame in series.frames), key=lambda frame: frame.name)
    originals: dict[str, Frame] = {}
    copies: list[_Copy] = []
    for frame in frames:
        if frame.name in damaged:
            continue
        original = originals.setdefault(reduction.hashes[frame.name], frame)
        if original is not frame:
            copies.append(_Copy(name=frame.name, original=original))
    return tuple(copies)


def _told_apart(found: Sequence[_Copy]) -> tuple[tuple[_Copy, ...], tuple[_Copy, ...]]:
    """Part the copies of frames that hold one code only from all others."""
    originals = {one.original.name: one.original for one in found}
    single = {name for name, frame in originals.items() if _has_one_code(frame)}
    flat = tuple(one for one in found if one.original.name in single)
    return flat, tuple(one for one in found if one.original.name not in single)


def _has_one_code(frame: Frame) -> bool:
    """Tell whether a frame is known to hold a single code; one that cannot be read any more is not."""
    try:
        mosaic = decode(frame.header, read_bytes(frame.header))
    except (RawFileError, OSError):
        return False
    return bool(mosaic.min() == mosaic.max())


def _corrected(study: Study, whole: Reduction, copies: Copies, reduce: _Reduce) -> Reduction:
    """Reduce the series that hold copies again without these, and put what comes out in their place."""
    cleaned = copies.left_out(study.series)
    affected = [one for one, clean in zip(study.series, cleaned, strict=True) if one.frames != clean.frames]
    keys = {one.key for one in affected}
    again = reduce(replace(study, series=tuple(one for one in cleaned if one.key in keys)))
    return replace(
        whole,
        statistics=_replaced(study, affected, whole.statistics, again.statistics),
        sums=_replaced(study, affected, whole.sums, again.sums),
        first=_replaced(study, affected, whole.first, again.first),
    )


def _replaced(
    study: Study,
    affected: Sequence[Series],
    whole: Mapping[SeriesKey, _Found],
    again: Mapping[SeriesKey, _Found],
) -> Mapping[SeriesKey, _Found]:
    """Return what was found of each series in the study's order, the second finding for those that are affected."""
    gone = {series.key for series in affected}
    found = {key: one for key, one in whole.items() if key not in gone} | dict(again)
    return {series.key: found[series.key] for series in study.series if series.key in found}


def _copies_finding(copies: Sequence[_Copy]) -> Finding:
    return Finding(
        code=CODE,
        severity=Severity.ERROR,
        message=(
            f"Left out {_spelled(copies)}: a frame that is there twice would make the temporal noise too small. Delete "
            "the copies, or put the frames there that were meant."
        ),
        files=tuple(one.name for one in copies),
    )


def _flat_finding(flat: Sequence[_Copy]) -> Finding:
    return Finding(
        code="identical-frames",
        severity=Severity.WARNING,
        message=(
            f"Some frames are the same file and hold a single code, as where all is clipped: {_spelled(flat)}. They "
            "count as frames of their own; if they are copies, delete them."
        ),
        files=tuple(sorted({name for one in flat for name in (one.name, one.original.name)})),
    )


def _spelled(copies: Sequence[_Copy]) -> str:
    return listed([f"{one.name} (the same as {one.original.name})" for one in copies])
