"""Decoders written in C run in processes of their own: what they may do wrong ends there, and the study goes on.

A process starts when it is first needed, serves some files one after another and waits for the next when it has
answered; as many as there are processors may be at work. It is given a limit of memory and of processor time for each
file, by the file's size: one that dies, hangs or asks for more becomes an exception that says so, and is replaced by a
new one. Where the system cannot limit processor time (Windows), the clock does.

Nothing but ``python -m`` and two pipes is asked of the operating system. The pipes cost about 1 ms a megapixel, a
small part of what the decoders behind them take.
"""

import atexit
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, BinaryIO, Final, cast

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError, UnsuitableFileError

GAVE_UP: Final = "decoder-failed"
"""Code of a file whose decoder died or was ended: the file may have done that, or the machine."""
_PROGRAM: Final = "fullwell.raw.decoder_process"
_BASE_S: Final = 5.0
_S_PER_MB: Final = 0.25
_PATIENCE: Final = 8.0 if hasattr(signal, "SIGXCPU") else 1.0
"""Seconds by the clock for each second of processor time that a decoder may take: others may use the machine too."""
_MOST_FILES: Final = 64
"""Files after which a process is replaced: decoders leak memory where files are damaged."""
_BASE_BYTES: Final = 320_000_000
_MEMORY_PER_BYTE: Final = 24
"""Memory a decoder may take for each byte of a file: lossless coding packs 16-bit codes of flat frames 8 to 16 fold."""
_OUT_OF_TIME: Final = -getattr(signal, "SIGXCPU", 0) or None
_LONGEST_REPLY: Final = 4_000_000
_AT_WORK: Final = threading.BoundedSemaphore(max(2, os.cpu_count() or 1))
_ERRORS: Final = {"unreadable": UnreadableFileError, "unsuitable": UnsuitableFileError}

_idle: list["_Process"] = []
_lock: Final = threading.Lock()


def ask(
    task: str, data: bytes | bytearray | memoryview, *, out: NDArray[np.uint16] | None = None, **options: object
) -> Mapping[str, Any]:
    """Have a file's bytes looked at by a decoder in a process of its own.

    Parameters
    ----------
    task
        A name of `fullwell.raw.decoder_process.TASKS`.
    data
        What to decode.
    out
        Where the pixels go, C-contiguous; None where the task has none.
    options
        Numbers, text and lists of these, for the task.

    Returns
    -------
    Mapping
        What the task found, as JSON has it.

    Raises
    ------
    RawFileError
        What the task raises; ``decoder-failed`` where its process dies, takes too long or too much memory.

    """
    with _AT_WORK:
        process = _taken()
        try:
            reply = process.ask(task, memoryview(data).cast("B"), out, options)
        except BaseException:
            process.kill()
            raise
        if process.files < _MOST_FILES:
            with _lock:
                _idle.append(process)
        else:
            process.close()
    if "error" in reply:
        raise _error(reply)
    return reply


def time_limit_s(size: int) -> float:
    """Return how much processor time a decoder may take for a file of ``size`` bytes [s]."""
    return _BASE_S + _S_PER_MB * size / 1e6


class _Process:
    """One process that decodes, and the pipes to it."""

    def __init__(self) -> None:
        paths = os.pathsep.join(path for path in sys.path if path)
        self._process = subprocess.Popen(  # noqa: S603 - this interpreter, a module of ours
            [sys.executable, "-m", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"PYTHONPATH": paths, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            process_group=0,  # an interruption from the terminal would pass for a crash
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self._input = cast("BinaryIO", self._process.stdin)
        self._output = cast("BinaryIO", self._process.stdout)
        self.files = 0

    def ask(
        self, task: str, data: memoryview, out: NDArray[np.uint16] | None, options: Mapping[str, object]
    ) -> dict[str, Any]:
        """Return the reply to one question; whatever goes wrong with the process is an `UnreadableFileError`."""
        self.files += 1
        limit_s = time_limit_s(len(data))
        late = threading.Event()
        watch = threading.Timer(_PATIENCE * limit_s, self._stop, args=[late])
        watch.daemon = True
        watch.start()
        try:
            memory = _BASE_BYTES + _MEMORY_PER_BYTE * len(data)
            question = {"task": task, "size": len(data), "memory": memory, "seconds": limit_s, "options": options}
            self._input.write(json.dumps(question).encode() + b"\n")
            self._input.write(data)
            self._input.flush()
            return self._reply(out)
        except (OSError, EOFError, ValueError) as error:
            too_long = late.is_set() or self._process.wait() == _OUT_OF_TIME
            raise _failed(f"it took more than {limit_s:.0f} s" if too_long else "it crashed") from error
        finally:
            watch.cancel()

    def _reply(self, out: NDArray[np.uint16] | None) -> dict[str, Any]:
        reply: dict[str, Any] = json.loads(self._output.readline(_LONGEST_REPLY) or "null") or {}
        if not reply:
            raise EOFError
        count = int(reply.get("bytes", 0))
        if count:
            if out is None or out.nbytes != count or not out.flags.c_contiguous:
                raise ValueError("the pixels do not fit")
            target = out.data.cast("B")
            at = 0
            while at < count:
                got = self._output.readinto(target[at:])  # type: ignore[attr-defined] - a pipe is a buffered reader
                if not got:
                    raise EOFError
                at += got
        return reply

    def _stop(self, late: threading.Event) -> None:
        late.set()
        self._process.kill()

    def kill(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self.close()

    def close(self) -> None:
        """End the process by leaving it nothing to wait for."""
        for pipe in (self._input, self._output):
            with suppress(OSError):
                pipe.close()
        self._process.wait()


def _taken() -> _Process:
    with _lock:
        while _idle:
            return _idle.pop()
    return _Process()


def _failed(what: str) -> UnreadableFileError:
    return UnreadableFileError(GAVE_UP, f"the decoder gave up on the file ({what}): it is damaged; copy it again")


def _error(reply: Mapping[str, Any]) -> RawFileError:
    return _ERRORS[str(reply["error"])](str(reply["code"]), str(reply["message"]))


@atexit.register
def _end() -> None:
    """Let all processes go."""
    with _lock:
        processes, _idle[:] = list(_idle), []
    for process in processes:
        process.close()


def _forget() -> None:
    """Leave the parent's processes to the parent: two masters would mix up their answers."""
    _idle.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
