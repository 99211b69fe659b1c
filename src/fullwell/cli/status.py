"""Exit statuses, and how an exception becomes one: a sentence on stderr, no traceback without ``--verbose``."""

import math
import os
import platform
import shlex
import signal
import sys
import threading
import time
import traceback
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from types import FrameType
from typing import Final

import typer

from fullwell import __version__
from fullwell.cli.overview import INTERRUPTED
from fullwell.errors import FullwellError, system_refusal
from fullwell.findings import Finding, Severity

DONE: Final = 0
DONE_WITH_ERRORS: Final = 1
BAD_USE: Final = 2
BUG: Final = 70
_PATIENCE_S: Final = 10.0
"""How long what is half done may take to be removed before another interruption is heard [s]."""


def status_of(findings: Iterable[Finding]) -> int:
    """Return the exit status of a run that came to its end."""
    return DONE_WITH_ERRORS if any(one.severity is Severity.ERROR for one in findings) else DONE


@contextmanager
def guarded(*, verbose: bool) -> Generator[None, None, None]:
    """Turn what goes wrong inside a command into a sentence and an exit status.

    Raises
    ------
    typer.Exit
        With the exit status.

    """
    try:
        with _interrupted_once():
            yield
        sys.stdout.flush()
    except FullwellError as error:
        _say(str(error), verbose=verbose)
        raise typer.Exit(BAD_USE) from error
    except KeyboardInterrupt as error:
        _say(str(error) or "Interrupted; nothing was left half-written.", verbose=False)
        raise typer.Exit(INTERRUPTED) from error
    except BrokenPipeError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno() if sys.__stdout__ else 1)
        raise typer.Exit(DONE) from error
    except OSError as error:
        refusal = system_refusal(error)
        if refusal is None:
            _report_bug(error, verbose=verbose)
            raise typer.Exit(BUG) from error
        _say(refusal, verbose=verbose)
        raise typer.Exit(BAD_USE) from error
    except typer.Exit:
        raise
    except Exception as error:
        _report_bug(error, verbose=verbose)
        raise typer.Exit(BUG) from error


@contextmanager
def _interrupted_once() -> Generator[None, None, None]:
    """Let Ctrl-C, and a request to end as schedulers and containers send it, be one interruption.

    Upon it what is half done is removed. Another one would stop that: those that come within `_PATIENCE_S` are passed
    over.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    last_s = -math.inf

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        nonlocal last_s
        now_s = time.monotonic()
        if now_s - last_s >= _PATIENCE_S:
            last_s = now_s
            raise KeyboardInterrupt

    meant = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    former = {number: usual for number, usual in meant.items() if signal.getsignal(number) is usual}
    for number in former:
        signal.signal(number, interrupt)
    try:
        yield
    finally:
        for number, usual in former.items():
            signal.signal(number, usual)


def _say(sentence: str, *, verbose: bool) -> None:
    if verbose:
        traceback.print_exc(file=sys.stderr)
    sys.stderr.write(f"fullwell: {sentence}\n")


def _report_bug(error: BaseException, *, verbose: bool) -> None:
    last = traceback.extract_tb(error.__traceback__)[-1:]
    where = f" ({os.path.basename(last[0].filename)}:{last[0].lineno})" if last else ""  # noqa: PTH119 - a text, no path
    hint = "" if verbose else "\n  Run it again with --verbose and add the traceback."
    _say(
        f"this is a bug of ours: {type(error).__name__}: {error}{where}. Please report it with these lines:\n"
        f"  fullwell {__version__}, Python {platform.python_version()}, {platform.platform()}\n"
        f"  {shlex.join(sys.argv)}{hint}",
        verbose=verbose,
    )
