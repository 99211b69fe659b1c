"""Settings of the interpreter last as long as the work that asks for them."""

import os
import signal
import subprocess
import sys

import pytest

from fullwell.workflow.executor import interruptions_later, short_turns


def test_turns_are_short_only_meanwhile() -> None:
    before = sys.getswitchinterval()
    with short_turns():
        assert sys.getswitchinterval() < before
    assert sys.getswitchinterval() == before


@pytest.mark.skipif(os.name == "nt", reason="signals can be held back on POSIX only")
@pytest.mark.usefixtures("interruptible")
def test_an_interruption_waits_and_processes_that_begin_meanwhile_never_hear_of_it() -> None:
    program = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"
    reached: list[int] = []

    def interrupted() -> None:
        with interruptions_later():
            signal.raise_signal(signal.SIGINT)
            reached.append(subprocess.run([sys.executable, "-c", program], check=False).returncode)

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert reached == [0]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, set())
