"""Files that are read once, piece by piece: their hash is that of all bytes, and advice is given where it helps."""

import os
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from xxhash import xxh3_128

from fullwell.raw.open import read_header
from fullwell.raw.write import write_dng
from fullwell.workflow.stream import HashedFile

MEGABYTE = 1 << 20

pytestmark = pytest.mark.skipif(not hasattr(os, "posix_fadvise"), reason="this system takes no advice")


def asked_while_reading(path: Path, monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """Read a file in pieces, see that its hash is right, and return what the system was asked to read ahead."""
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(os, "posix_fadvise", lambda _file, at, size, _advice: asked.append((at, size)))
    file, size = HashedFile(read_header(path)), path.stat().st_size
    piece = memoryview(bytearray(MEGABYTE))
    for at in range(0, size, MEGABYTE):
        file.read(piece[: size - at])
    file.close()
    assert file.hash == xxh3_128(path.read_bytes()).hexdigest()
    return asked


@pytest.fixture
def dng(tmp_path: Path) -> Path:
    """Return a file of twelve megabytes, just written and therefore in the system's memory."""
    mosaic = np.random.default_rng(5).integers(0, 4096, (2000, 3000), dtype=np.uint16)
    write_dng(tmp_path / "a.dng", mosaic, cfa="RGGB", white_level=4095, bit_depth=12, black_level=None)
    return tmp_path / "a.dng"


@pytest.mark.parametrize("refusal", [BlockingIOError, OSError], ids=["not at hand", "not told"])
def test_what_is_not_at_hand_is_asked_for_without_a_gap(
    refusal: type[OSError], dng: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_arguments: object) -> int:
        raise refusal

    monkeypatch.setattr(os, "preadv", refuse, raising=False)
    asked = asked_while_reading(dng, monkeypatch)
    assert asked[0][0] == 0
    assert all(at + size == following for (at, size), (following, _) in pairwise(asked))
    assert sum(asked[-1]) >= dng.stat().st_size


@pytest.mark.skipif(not hasattr(os, "RWF_NOWAIT"), reason="this system does not tell what it holds")
def test_what_is_at_hand_is_not_asked_for(dng: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dng.read_bytes()
    try:
        with dng.open("rb") as file:
            os.preadv(file.fileno(), [bytearray(1)], 0, os.RWF_NOWAIT)
    except OSError as error:
        pytest.skip(f"this file system does not tell what it holds: {error}")
    assert asked_while_reading(dng, monkeypatch) == []
