"""The other side of `fullwell.raw.isolation`: a process that decodes what it is given, one file after another.

It speaks on its standard pipes: a line of JSON and the file's bytes come in, a line of JSON and the pixels go out.
"""

import json
import math
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError, UnsuitableFileError
from fullwell.raw.libraw import describe, unpack
from fullwell.raw.pictures import decode_jpeg_xl, decode_png_pixels

Answer = tuple[Mapping[str, Any], NDArray[np.uint16] | None]
_COMPLAINTS: Final = (
    (b"unexpected end of file", UnreadableFileError("file-truncated", "it ends before its pixels do; copy it again")),
    (b"data corrupted", UnreadableFileError("file-damaged", "its coded pixels are damaged; copy the file again")),
)
"""What LibRaw prints where it goes on with what it has."""
TASKS: Final[Mapping[str, Callable[..., Answer]]] = {
    "describe": describe,
    "unpack": unpack,
    "png": decode_png_pixels,
    "jpeg-xl": decode_jpeg_xl,
}


def main() -> None:
    """Answer questions until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    source, target = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # decoders that print must not speak into the pipe
    with tempfile.TemporaryFile() as printed:
        os.dup2(printed.fileno(), 2)
        while line := source.readline():
            printed.truncate(0)
            _answer(json.loads(line), source, target, printed)
            target.flush()


def _answer(question: Mapping[str, Any], source: BinaryIO, target: BinaryIO, printed: BinaryIO) -> None:
    data = source.read(question["size"])
    pixels = None
    try:
        _set_limits(memory=question["memory"], seconds=question["seconds"])
        found, pixels = TASKS[question["task"]](data, **question["options"])
        _require_no_complaint(printed)
        reply = dict(found)
    except Exception as error:  # noqa: BLE001 - a decoder's own exceptions, whatever their class
        reply, pixels = _told(error), None
    reply["bytes"] = 0 if pixels is None else pixels.nbytes
    target.write(json.dumps(reply, default=float).encode() + b"\n")
    if pixels is not None:
        target.write(np.ascontiguousarray(pixels).data)


def _told(error: Exception) -> dict[str, Any]:
    """Return an exception as the other side reads it."""
    if isinstance(error, MemoryError):
        error = UnreadableFileError("file-damaged", "it claims more pixels than it can hold; copy the file again")
    if not isinstance(error, RawFileError):
        said = f"it cannot be decoded ({type(error).__name__}: {error}); copy the file again"
        error = UnreadableFileError("file-damaged", said)
    kind = "unsuitable" if isinstance(error, UnsuitableFileError) else "unreadable"
    return {"error": kind, "code": error.code, "message": error.message}


def _require_no_complaint(printed: BinaryIO) -> None:
    """Refuse a file of whose damage a decoder only speaks, on its standard error."""
    printed.seek(0)
    said = printed.read()
    for words, error in _COMPLAINTS:
        if words in said:
            raise error


def _set_limits(*, memory: int, seconds: float) -> None:
    """Have the system refuse memory, and processor time from now on, beyond limits, where it can [byte, s]."""
    try:
        import resource  # noqa: PLC0415 - not on every system
    except ImportError:
        return
    limits = ((resource.RLIMIT_DATA, memory), (resource.RLIMIT_CPU, math.ceil(time.process_time() + seconds)))
    for kind, limit in limits:
        _soft, hard = resource.getrlimit(kind)
        resource.setrlimit(kind, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))


if __name__ == "__main__":
    main()
