"""Work that another Python does meanwhile."""

import math

import pytest

from fullwell.report.beside import beside


def test_what_another_process_finds_comes_back() -> None:
    with beside(math.fsum, [0.1] * 10) as there:
        assert there() == 1.0


def test_a_process_that_fails_says_why() -> None:
    with beside(math.sqrt, -1.0) as there, pytest.raises(RuntimeError, match="that draws beside this one failed"):
        there()


def test_an_error_here_ends_the_work_there() -> None:
    with pytest.raises(KeyError), beside(math.factorial, 10**7):
        raise KeyError
