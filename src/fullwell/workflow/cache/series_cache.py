"""Finished series on disk: found again by the content of their files and all else that makes their numbers.

For each series there are two files, named by a hash of what went in: ``HASH.series`` holds what its frames came to,
with a checksum; ``HASH.json`` tells what was read and how the file system knew it. Both are written under another name
and renamed, so that a run that is killed leaves whole files or none, and runs side by side do each other no harm: they
write the same under the same name.
"""

import json
import os
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from threading import Lock
from typing import BinaryIO, Final, cast

from xxhash import xxh3_128

from fullwell.errors import UsageError
from fullwell.frames.series import Frame, Series, SeriesKey
from fullwell.raw.isolation import GAVE_UP
from fullwell.workflow.cache.fingerprint import fingerprint
from fullwell.workflow.cache.packing import DamagedError, read_packed, write_packed
from fullwell.workflow.executor import in_threads
from fullwell.workflow.outcome import SeriesOutcome
from fullwell.workflow.slots import hash_of

MAPPED_BYTES: Final = 1 << 20
"""Arrays from this size on stay in their file."""
TAG: Final = "CACHEDIR.TAG"
"""By this name backups know what they need not keep (bford.info/cachedir)."""
_TAGGED: Final = (
    "Signature: 8a477f597d28d172789f06886806bc55\n"
    "# Finished series of a study, written by fullwell; may be deleted at any time.\n"
)
_PART: Final = ".part"
_STALE_S: Final = 3600.0
"""An unfinished file that is older was left behind by a run that was killed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Entry:
    """What ``HASH.json`` says: the recipe, and of every file its hash and its fingerprint, by frame name."""

    key: str
    recipe: str
    hashes: Mapping[str, str]
    prints: Mapping[str, str | None]


class SeriesCache:
    """Finished series of a study, kept in a folder.

    Its methods may be called from several threads at once.

    Parameters
    ----------
    folder
        Where; made if need be.
    recheck
        Whether files are always read and hashed, whatever the file system says of them.
    most_bytes
        What may stay in the folder besides what this run uses; the least recently used goes first [byte].

    Raises
    ------
    UsageError
        The folder holds something else.

    """

    def __init__(self, folder: Path, *, recheck: bool = False, most_bytes: int = 0) -> None:
        _claim(folder)
        self._folder = folder
        self._recheck = recheck
        self._most_bytes = most_bytes
        self._lock = Lock()
        self._used: set[str] = set()
        self._seen: dict[str, str | None] = {}
        self._known = self._entries()
        self.found = 0
        self.damaged = 0
        self.bytes = 0

    def find(
        self, series: Sequence[Series], recipes: Sequence[str], *, workers: int
    ) -> Mapping[SeriesKey, SeriesOutcome]:
        """Return what is known of some series; files that the file system may have seen change are read and hashed.

        Parameters
        ----------
        series
            What is asked for.
        recipes
            Of each, `recipe.recipe`.
        workers
            Threads.

        """
        known = in_threads(self._find, zip(series, recipes, strict=True), workers=workers)
        return {one.key: outcome for one, outcome in zip(series, known, strict=True) if outcome is not None}

    def keep(self, series: Series, own: str, outcome: SeriesOutcome) -> SeriesOutcome | None:
        """Write what a series of the recipe ``own`` came to, and return it with sums that lie in the file.

        Returns
        -------
        SeriesOutcome or None
            None where it is not kept: a file could not be read at all, its decoder gave up, which the next one may not
            do, or the folder cannot be written to.

        """
        names = sorted(frame.name for frame in series.frames)
        if any(name not in outcome.hashes for name in names) or any(one.code == GAVE_UP for one in outcome.excluded):
            return None
        hashes = {name: outcome.hashes[name] for name in names}
        entry = _Entry(
            key=_key(own, hashes), recipe=own, hashes=hashes, prints={name: self._seen.get(name) for name in names}
        )
        path = self._folder / f"{entry.key}.series"
        try:
            with self._written(path.name) as file:
                write_packed(file, outcome)
            self._note(entry)
            return read_packed(path, SeriesOutcome, mapped=MAPPED_BYTES)
        except (OSError, DamagedError):
            return None

    def sweep(self) -> None:
        """Remove what is no longer wanted."""
        for part in self._folder.glob(f"*{_PART}"):
            if _age_s(part) > _STALE_S:
                _remove(part)
        kept = other = 0
        for entry in sorted(self._folder.glob("*.series"), key=_age_s):
            size, used = _size(entry), entry.stem in self._used
            if used or other + size <= self._most_bytes:
                kept, other = kept + size, other + (0 if used else size)
            else:
                _remove(entry)
                _remove(entry.with_suffix(".json"))
        self.bytes = kept

    def _find(self, asked: tuple[Series, str]) -> SeriesOutcome | None:
        series, own = asked
        prints = {frame.name: fingerprint(frame.header.path) for frame in series.frames}
        with self._lock:
            self._seen |= prints
        for entry in self._known.get(own, ()):
            same = not self._recheck and all(
                one is not None and one == entry.prints.get(name) for name, one in prints.items()
            )
            if not (same or _hashes(series.frames) == entry.hashes):
                continue
            outcome = self._read(entry)
            if outcome is not None:
                with suppress(OSError):
                    os.utime(self._folder / f"{entry.key}.series")
                    if not same:
                        self._note(replace(entry, prints=prints))
                with self._lock:
                    self.found += 1
                    self._used.add(entry.key)
                return outcome
        return None

    def _read(self, entry: _Entry) -> SeriesOutcome | None:
        try:
            outcome = read_packed(self._folder / f"{entry.key}.series", SeriesOutcome, mapped=MAPPED_BYTES)
        except (OSError, DamagedError):
            with self._lock:
                self.damaged += 1
            return None
        return outcome if _key(entry.recipe, outcome.hashes) == entry.key else None

    def _note(self, entry: _Entry) -> None:
        with self._written(f"{entry.key}.json") as file:
            file.write(json.dumps(asdict(entry)).encode())
        with self._lock:
            self._used.add(entry.key)

    def _entries(self) -> Mapping[str, list[_Entry]]:
        """Return what lies in the folder, by recipe; what cannot be understood counts as not there."""
        known: dict[str, list[_Entry]] = {}
        for path in sorted(self._folder.glob("*.json")):
            with suppress(OSError, ValueError, TypeError, AttributeError):
                entry = _Entry(**json.loads(path.read_bytes()))
                whole = isinstance(entry.hashes, dict) and isinstance(entry.prints, dict)
                if whole and entry.key == path.stem == _key(entry.recipe, entry.hashes):
                    known.setdefault(entry.recipe, []).append(entry)
        return known

    @property
    def told(self) -> Mapping[str, object]:
        """Return what a run says of its cache: folder, series found in it, damaged ones, and its size."""
        return {
            "folder": str(self._folder),
            "series_found": self.found,
            "series_damaged": self.damaged,
            "bytes": self.bytes,
        }

    @contextmanager
    def _written(self, name: str) -> Generator[BinaryIO]:
        """Provide a file that gets its name when it is whole."""
        with tempfile.NamedTemporaryFile(dir=self._folder, suffix=_PART, delete=False) as file:
            try:
                yield cast("BinaryIO", file)
                file.close()
                Path(file.name).replace(self._folder / name)
            except BaseException:
                Path(file.name).unlink(missing_ok=True)
                raise


def _claim(folder: Path) -> None:
    """Make a folder for a cache, or see that it is one.

    The tag is the first that a run writes into a folder. So it is looked for after all else: what another run wrote
    meanwhile has its tag by then.
    """
    tag = folder / TAG
    try:
        folder.mkdir(parents=True, exist_ok=True)
        filled = any(folder.iterdir())
        if not tag.exists():
            if filled:
                raise UsageError(
                    f"{folder} holds something else than finished series; name another folder with --cache, or use "
                    "--no-cache"
                )
            tag.write_text(_TAGGED, encoding="utf-8", newline="\n")
    except OSError as error:
        raise UsageError(
            f"{folder} cannot hold finished series ({error.strerror}); name another folder with --cache, or use "
            "--no-cache"
        ) from error


def _key(recipe: str, hashes: Mapping[str, str]) -> str:
    digest = xxh3_128(recipe.encode())
    for name in sorted(hashes):
        digest.update(f"\0{name}\0{hashes[name]}".encode())
    return digest.hexdigest()


def _hashes(frames: Sequence[Frame]) -> Mapping[str, str] | None:
    """Return the hash of every file, None where one cannot be read."""
    found: dict[str, str] = {}
    for frame in frames:
        try:
            found[frame.name] = hash_of(frame.header)
        except OSError:
            return None
    return found


def _age_s(path: Path) -> float:
    """Return how long ago a file was used, 0 where it is gone [s]."""
    try:
        return time.time() - path.stat().st_mtime
    except OSError:
        return 0.0


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _remove(path: Path) -> None:
    with suppress(OSError):
        path.unlink(missing_ok=True)
