"""A function of ours that another Python works on meanwhile: drawing keeps one core busy, and there mostly are more."""

import pickle
import subprocess
import sys
from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Final, TypeVar, cast

_Found = TypeVar("_Found")

_CHILD: Final = """
import pickle, sys
sys.path[:] = pickle.load(sys.stdin.buffer)
work, arguments = pickle.load(sys.stdin.buffer)
pickle.dump(work(*arguments), sys.stdout.buffer)
"""


@contextmanager
def beside(work: Callable[..., _Found], *arguments: object) -> Generator[Callable[[], _Found]]:
    """Provide what waits for ``work(*arguments)``, which another process computes inside this.

    Parameters
    ----------
    work
        A function of a module.
    arguments
        What can be pickled.

    Raises
    ------
    RuntimeError
        When it is waited for: the other process failed.

    """
    task = pickle.dumps(sys.path) + pickle.dumps((work, arguments))
    child = subprocess.Popen(  # noqa: S603 - this interpreter, functions of ours
        [sys.executable, "-c", _CHILD],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )
    with child, ThreadPoolExecutor(1) as pool:
        talk = pool.submit(child.communicate, task)

        def found() -> _Found:
            answer, said = talk.result()
            if child.returncode:
                raise RuntimeError(f"the process that draws beside this one failed: {said.decode(errors='replace')}")
            return cast("_Found", pickle.loads(answer))  # noqa: S301 - from a process of ours

        try:
            yield found
        except BaseException:
            child.kill()
            raise
