"""fsspec's only door: a file or a folder at a URL, read as if it lay on a disk.

`located` makes a path of what a user typed. A `RemotePath` is read piece by piece, only what is asked for where the
server allows that, and goes to other processes as a name: each reads for itself.
"""

import errno
import io
import os
import re
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, Self, TypeVar

from fullwell.errors import UsageError

_URL: Final = re.compile(r"([a-z][a-z0-9+.-]+)://.")
_EXTRAS: Final = {"s3": "s3", "s3a": "s3", "gs": "gcs", "gcs": "gcs", "http": "http", "https": "http"}
_FIRST_BYTES: Final = 1 << 18
"""Read at first, which holds most headers; each read that goes on from there takes twice as much."""
_MOST_BYTES: Final = 1 << 24

_Found = TypeVar("_Found")


def is_url(text: str) -> bool:
    """Tell whether a text is a URL rather than a path.

    Examples
    --------
    >>> is_url("s3://bucket/study"), is_url("studies/s3"), is_url("C:/studies")
    (True, False, False)

    """
    return _URL.match(text) is not None


def located(text: str) -> Path:
    """Return the path that a text stands for, on a disk or at a URL.

    Raises
    ------
    UsageError
        Nothing that is installed reads URLs of that kind.

    """
    if not is_url(text):
        return Path(text)
    path = RemotePath(text)
    path.filesystem()
    return path


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """What a remote folder holds, as `os.scandir` would tell it."""

    name: str
    folder: bool

    def is_dir(self) -> bool:
        """Tell whether it is a folder."""
        return self.folder

    def is_symlink(self) -> bool:
        """Tell that it is no link."""
        return False


@cache
def filesystem_of(scheme: str) -> Any:  # noqa: ANN401 - fsspec has no types
    """Return what reads URLs of a kind.

    Raises
    ------
    UsageError
        It is not installed, or there is no such kind.

    """
    extra = _EXTRAS.get(scheme)
    try:
        import fsspec  # noqa: PLC0415 - loads when used

        return fsspec.filesystem(scheme)
    except ImportError as error:
        how = f"pip install 'fullwell[{extra or 'http'}]'"
        what = f"{scheme}:// needs a library that is not installed: {how}"
        raise UsageError(what if extra else f"{what}, and the library that fsspec asks for ({error})") from error
    except ValueError as error:
        known = ", ".join(f"{name}://" for name in ("s3", "gs", "http", "https"))
        raise UsageError(f"{scheme}:// is no kind of URL that is read; use a folder, or {known}.") from error


@contextmanager
def _as_oserror(url: str) -> Generator[None]:
    """Let whatever a protocol raises count as a file that cannot be read."""
    try:
        yield
    except (OSError, UsageError):
        raise
    except Exception as error:  # each protocol fails in its own way, and all mean the same
        raise OSError(errno.EIO, f"{type(error).__name__}: {error}", url) from error


class RemotePath(type(Path())):
    """A file or a folder at a URL; it can be read, not written."""

    __slots__ = ()

    def __str__(self) -> str:
        """Return the URL; of a path that is relative to one, only the names."""
        scheme, *rest = self.parts or (".",)
        return f"{scheme}//{'/'.join(rest)}" if scheme.endswith(":") else "/".join((scheme, *rest))

    def __fspath__(self) -> str:
        """Return the URL."""
        return str(self)

    def filesystem(self) -> Any:  # noqa: ANN401 - fsspec has no types
        """Return what reads URLs of this kind.

        Raises
        ------
        UsageError
            It is not installed.

        """
        return filesystem_of(self.parts[0].removesuffix(":"))

    def _ask(self, question: Callable[[Any, str], _Found]) -> _Found:
        with _as_oserror(str(self)):
            return question(self.filesystem(), str(self))

    def is_absolute(self) -> bool:
        """Tell that a URL needs no folder to start from."""
        return True

    def absolute(self) -> Self:
        """Return the path itself."""
        return self

    def resolve(self, strict: bool = False) -> Self:  # noqa: ARG002, FBT001, FBT002 - as the base class has it
        """Return the path itself: there are no links."""
        return self

    def stat(self, *, follow_symlinks: bool = True) -> os.stat_result:  # noqa: ARG002 - as the base class has it
        """Return the size; nothing tells when the content last changed."""
        size = self._ask(lambda files, url: files.info(url)).get("size")
        if size is None:
            size = len(self._ask(lambda files, url: files.cat_file(url)))
        return os.stat_result((0o100444, 0, 0, 1, 0, 0, int(size), 0, 0, 0))

    def exists(self, *, follow_symlinks: bool = True) -> bool:  # noqa: ARG002 - as newer base classes have it
        """Tell whether there is something."""
        return bool(self._ask(lambda files, url: files.exists(url)))

    def is_file(self, *, follow_symlinks: bool = True) -> bool:  # noqa: ARG002 - as newer base classes have it
        """Tell whether it is a file."""
        try:
            return self._ask(lambda files, url: files.info(url))["type"] == "file"
        except FileNotFoundError:
            return False

    def is_dir(self, *, follow_symlinks: bool = True) -> bool:  # noqa: ARG002 - as newer base classes have it
        """Tell whether it is a folder, which on a web server is a page that links to what lies below it."""
        return bool(self._ask(lambda files, url: files.isdir(_folder(url))))

    def entries(self) -> list[Entry]:
        """Return what a folder holds."""
        found: dict[str, bool] = {}
        base = _folder(str(self))
        for one in self._ask(lambda files, url: files.ls(_folder(url), detail=True)):
            name = str(one["name"]).rstrip("/").rsplit("/", 1)[-1]
            if name and not {"?", "#"} & set(name) and str(one["name"]).rstrip("/") not in base:
                found[name] = one["type"] == "directory" or str(one["name"]).endswith("/")
        return [Entry(name=name, folder=folder) for name, folder in found.items()]

    def iterdir(self) -> Generator[Self]:
        """Yield what a folder holds."""
        for entry in self.entries():
            yield self / entry.name

    def glob(self, pattern: str, **_options: object) -> Generator[Self]:
        """Yield the files below this folder whose relative path matches a pattern."""
        scheme = self.parts[0]
        for found in self._ask(lambda files, url: files.glob(f"{_folder(url)}{pattern}")):
            yield type(self)(found if is_url(found) else f"{scheme}//{found.lstrip('/')}")

    def open(
        self,
        mode: str = "r",
        buffering: int = -1,
        encoding: str | None = None,
        errors: str | None = None,
        newline: str | None = None,
    ) -> Any:  # noqa: ANN401 - what the base class returns depends on the mode
        """Open the file for reading."""
        if set(mode) - set("rbt"):
            raise OSError(errno.EROFS, "a file at a URL cannot be written", str(self))
        raw = _RemoteFile(self)
        if "b" not in mode:
            return io.TextIOWrapper(io.BufferedReader(raw), encoding=encoding, errors=errors, newline=newline)
        return raw if buffering == 0 else io.BufferedReader(raw, _FIRST_BYTES)

    def read_range(self, start: int, stop: int | None) -> bytes:
        """Return some bytes of the file, from its beginning where the server does not serve less."""
        return self._ask(lambda files, url: files.cat_file(url, start=start, end=stop))


class _RemoteFile(io.RawIOBase):
    """A file that is read ahead; the further it is read in one go, the more at once."""

    def __init__(self, path: RemotePath) -> None:
        super().__init__()
        self._path = path
        self._size = path.stat().st_size
        self._at = 0
        self._first = 0
        self._held = b""
        self._ahead = _FIRST_BYTES
        self.name = path.name

    def readable(self) -> bool:
        """Tell that it can be read."""
        return True

    def seekable(self) -> bool:
        """Tell that any part can be asked for."""
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Go to a place."""
        self._at = max(0, offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._size}[whence])
        return self._at

    def tell(self) -> int:
        """Return the place."""
        return self._at

    def readinto(self, buffer: Any) -> int:  # noqa: ANN401 - any writable buffer, as the base class has it
        """Read some bytes."""
        view = memoryview(buffer).cast("B")
        if self._at >= self._size or not len(view):
            return 0
        if not self._first <= self._at < self._first + len(self._held):
            self._fetch(len(view))
        start = self._at - self._first
        piece = self._held[start : start + len(view)]
        view[: len(piece)] = piece
        self._at += len(piece)
        return len(piece)

    def _fetch(self, wanted: int) -> None:
        goes_on = bool(self._held) and self._at == self._first + len(self._held)
        self._ahead = min(2 * self._ahead, _MOST_BYTES) if goes_on else _FIRST_BYTES
        stop = min(self._size, self._at + max(wanted, self._ahead))
        held = self._path.read_range(self._at, stop)
        # A server that serves no parts sends the whole file instead.
        whole = len(held) == self._size and stop - self._at < self._size
        self._first, self._held = (0 if whole else self._at), held
        if not self._first <= self._at < self._first + len(held):
            raise OSError(errno.EIO, "the file changed its size while it was read", str(self._path))


def _folder(url: str) -> str:
    return url.rstrip("/") + "/"
