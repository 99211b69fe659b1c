"""The datasheet is made while the page is drawn: here as far as it can be, or whole by a process of its own.

``python -m fullwell.report.datasheet.making`` loads what it needs, then waits for results; they, the datasheet and its
pdf go through its pipes. Whatever goes wrong with the process, the datasheet is made here instead.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Generator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import BinaryIO, Final, Protocol, cast

from fullwell.figures.results import Results
from fullwell.report.datasheet.contents import Datasheet

_PROGRAM: Final = "fullwell.report.datasheet.making"
_GONE: Final = (OSError, EOFError, pickle.UnpicklingError, ValueError)


class DatasheetMaker(Protocol):
    """Who makes a datasheet: to be told to begin once, then asked for both."""

    def begin(self, results: Results) -> None:
        """Begin with the datasheet of results."""
        ...

    def datasheet(self) -> Datasheet | None:
        """Return the datasheet, None where the results follow no profile of EMVA 1288."""
        ...

    def pdf(self) -> bytes:
        """Return report.pdf; there must be a datasheet."""
        ...


class _Here:
    """Draws at once, since pictures are drawn one after the other in a process; Typst prints beside Python."""

    def __init__(self, thread: ThreadPoolExecutor) -> None:
        self._thread = thread
        self._datasheet: Datasheet | None = None
        self._pdf: Future[bytes] = Future()

    def begin(self, results: Results) -> None:
        from fullwell.report.datasheet.build import build_datasheet  # noqa: PLC0415 - loads when used

        self._datasheet = build_datasheet(results)
        if self._datasheet is not None:
            self._pdf = self._thread.submit(_printed, self._datasheet)

    def datasheet(self) -> Datasheet | None:
        return self._datasheet

    def pdf(self) -> bytes:
        return self._pdf.result()


class _Process:
    """Another process, which loads its libraries from now on."""

    def __init__(self, thread: ThreadPoolExecutor) -> None:
        paths = os.pathsep.join(path for path in sys.path if path)
        self._process = subprocess.Popen(  # noqa: S603 - this interpreter, a module of ours
            [sys.executable, "-m", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"PYTHONPATH": paths},
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self._input = cast("BinaryIO", self._process.stdin)
        self._output = cast("BinaryIO", self._process.stdout)
        self._thread = thread
        self._here = _Here(thread)
        self._asked: Future[Datasheet | None] = Future()
        self._results: Results | None = None

    def begin(self, results: Results) -> None:
        self._results = results
        self._asked = self._thread.submit(self._ask, results)

    def _ask(self, results: Results) -> Datasheet | None:
        pickle.dump(results, self._input, pickle.HIGHEST_PROTOCOL)
        self._input.flush()
        return cast("Datasheet | None", pickle.load(self._output))  # noqa: S301 - from a process of ours

    def datasheet(self) -> Datasheet | None:
        try:
            return self._asked.result()
        except _GONE:
            self._here.begin(cast("Results", self._results))
            return self._here.datasheet()

    def pdf(self) -> bytes:
        if self._asked.exception() is not None:
            return self._here.pdf()
        try:
            return cast("bytes", pickle.load(self._output))  # noqa: S301 - from a process of ours
        except _GONE:
            return _printed(cast("Datasheet", self._asked.result()))

    def close(self) -> None:
        self._process.kill()
        for pipe in (self._input, self._output):
            with suppress(OSError):
                pipe.close()
        self._process.wait()


@contextmanager
def datasheet_maker(*, apart: bool = False) -> Generator[DatasheetMaker]:
    """Let a datasheet be made by a process of its own, if it is to be ``apart`` and there is a processor for it."""
    with ThreadPoolExecutor(1) as thread:
        if not apart or (os.cpu_count() or 1) < 2:
            yield _Here(thread)
            return
        process = _Process(thread)
        try:
            yield process
        finally:
            process.close()


def _printed(datasheet: Datasheet) -> bytes:
    """Return report.pdf: Typst works beside Python."""
    from fullwell.report.datasheet.pdf import datasheet_pdf  # noqa: PLC0415 - Typst loads for a datasheet alone

    return datasheet_pdf(datasheet)


def main() -> None:
    """Make the datasheet of the results that come in."""
    from fullwell.report.datasheet.build import build_datasheet  # noqa: PLC0415 - the other side may not need it
    from fullwell.report.datasheet.pdf import datasheet_pdf  # noqa: PLC0415 - as above

    target = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what prints must not speak into the pipe
    datasheet = build_datasheet(pickle.load(sys.stdin.buffer))  # noqa: S301 - from the process that started this one
    pickle.dump(datasheet, target, pickle.HIGHEST_PROTOCOL)
    target.flush()
    if datasheet is not None:
        pickle.dump(datasheet_pdf(datasheet), target, pickle.HIGHEST_PROTOCOL)
        target.flush()


if __name__ == "__main__":
    main()
