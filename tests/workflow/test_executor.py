"""Settings of the interpreter last as long as the work that asks for them."""

import sys

from fullwell.workflow.executor import short_turns


def test_turns_are_short_only_meanwhile() -> None:
    before = sys.getswitchinterval()
    with short_turns():
        assert sys.getswitchinterval() < before
    assert sys.getswitchinterval() == before
