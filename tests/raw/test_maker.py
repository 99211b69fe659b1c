"""Raw files in their makers' own formats, read through LibRaw."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from fullwell.errors import RawFileError, UnsuitableFileError
from fullwell.raw.libraw import read_with_libraw
from fullwell.raw.open import read_header, read_raw, require_measurable


@pytest.mark.parametrize("name", ["CRW_0101.CRW", "CRW_0119.CRW"])
def test_a_powershot_is_what_its_readme_says(name: str, shared_data: Callable[[str], Path]) -> None:
    path = shared_data("makers") / name
    image = read_raw(path)
    header = image.header
    assert (header.width, header.height, header.cfa, header.bit_depth) == (2312, 1720, "RGGB", 10)
    assert header.black_level is not None
    assert header.white_level is not None
    assert (set(header.black_level.values), set(header.white_level.values)) == ({32.0}, {1023.0})
    assert header.iso == 50.0
    np.testing.assert_array_equal(image.mosaic, read_with_libraw(path).mosaic)
    assert not image.mosaic.flags.writeable
    assert all(0 <= area.top < area.bottom <= header.raw_height for area in header.masked_areas)
    assert header.masked_areas


def test_companded_codes_are_refused(shared_data: Callable[[str], Path]) -> None:
    header = read_header(shared_data("makers") / "P003908.KDC")
    assert (header.make, header.cfa, header.iso) == ("Eastman Kodak Company", "GRBG", 160.0)
    with pytest.raises(UnsuitableFileError) as caught:
        require_measurable(header)
    assert caught.value.code == "companded"


def test_damaged_files_have_a_name_and_a_reason(shared_data: Callable[[str], Path], tmp_path: Path) -> None:
    whole = (shared_data("makers") / "CRW_0101.CRW").read_bytes()
    rng = np.random.default_rng(7)
    for number in range(12):
        data = bytearray(whole[: int(rng.integers(40, len(whole)))] if number % 2 else whole)
        for at in rng.integers(0, min(len(data), 4000), 20):
            data[at] = int(rng.integers(0, 256))
        path = tmp_path / f"{number}.crw"
        path.write_bytes(data)
        with suppress(RawFileError):
            assert read_raw(path).mosaic.ndim == 2


def test_text_by_the_name_of_a_raw_file_is_named_damaged(tmp_path: Path) -> None:
    (tmp_path / "a.nef").write_text("not a photograph\n" * 100)
    with pytest.raises(RawFileError):
        read_header(tmp_path / "a.nef")
