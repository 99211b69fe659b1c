"""Memory as the system likes it."""

import pytest

from fullwell.workflow.memory import in_large_pages


@pytest.mark.parametrize("size", [1, 4_128_768, 1 << 22])
def test_memory_begins_where_a_large_page_does(size: int) -> None:
    memory = in_large_pages(size)
    assert memory.nbytes == size
    assert memory.__array_interface__["data"][0] % (1 << 21) == 0
