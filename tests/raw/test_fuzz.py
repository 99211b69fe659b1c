"""Hostile files of every format: each is read or refused by name, soon, and without much memory."""

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import imagecodecs
import maker_builder
import numpy as np
import pytest
import tifffile
from astropy.io import fits
from mutations import mutant
from test_open import BASES

from fullwell.errors import RawFileError
from fullwell.raw.open import decode, read_bytes, read_headers

MUTANTS = 60
LONGEST_S = 10.0
MOST_BYTES = 500_000_000


def arrays(folder: Path, mosaic: np.ndarray) -> Iterator[Path]:
    """Write files of all formats that are not in BASES."""
    stack = np.stack([mosaic] * 3)
    np.save(folder / "frame.npy", mosaic)
    np.save(folder / "stack.npy", np.stack([mosaic] * 5))
    card = fits.PrimaryHDU(mosaic)
    card.header.update({"EXPTIME": 2.5, "EGAIN": 0.8, "BAYERPAT": "RGGB", "READOUTM": "High"})
    card.writeto(folder / "frame.fits")
    fits.HDUList([fits.PrimaryHDU(), fits.ImageHDU(mosaic.astype(np.int32))]).writeto(folder / "extension.fits")
    fits.PrimaryHDU(np.stack([mosaic] * 5)).writeto(folder / "cube.fits")
    (folder / "frame.pgm").write_bytes(b"P5\n# made by a test\n32 24\n4095\n" + mosaic.astype(">u2").tobytes())
    tifffile.imwrite(folder / "pages.tif", stack, photometric="minisblack")
    tifffile.imwrite(folder / "deflated.tif", stack, photometric="minisblack", compression="zlib")
    tifffile.imwrite(folder / "big.tif", stack, photometric="minisblack", bigtiff=True)
    (folder / "frame.nef").write_bytes(maker_builder.nef(mosaic))
    (folder / "frame.raf").write_bytes(maker_builder.raf(mosaic))
    (folder / "frame.jxl").write_bytes(imagecodecs.jpegxl_encode(mosaic, lossless=True))
    yield from sorted(folder.iterdir())


def resident_bytes() -> int:
    """Return the memory of this process and of the decoders it started [byte]; 0 where the system does not tell."""
    tasks = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children")
    if not tasks.exists():
        return 0
    total = 0
    for process in [str(os.getpid()), *tasks.read_text().split()]:
        try:
            pages = Path(f"/proc/{process}/statm").read_text().split()[1]
        except OSError:
            continue
        total += int(pages) * os.sysconf("SC_PAGE_SIZE")
    return total


def judge(path: Path) -> str:
    """Read a file as a study does; return what came of it."""
    begun = time.monotonic()
    try:
        headers = read_headers(path)[:4]
        mosaics = [decode(header, read_bytes(header)) for header in headers]
    except RawFileError as error:
        outcome = f"{error.code}: {error.message}"
    else:
        outcome = "read"
        assert [mosaic.shape for mosaic in mosaics] == [(header.height, header.width) for header in headers]
    assert time.monotonic() - begun < LONGEST_S
    assert not outcome.endswith(": ")
    return outcome.partition(":")[0]


def outcomes(whole: bytes, path: Path, *, seed: int, count: int) -> set[str]:
    rng = np.random.default_rng(seed)
    found: set[str] = set()
    before = resident_bytes()
    for _ in range(count):
        path.write_bytes(mutant(whole, rng))
        found.add(judge(path))
        assert resident_bytes() - before < MOST_BYTES
    return found


def test_damaged_files_of_every_format_are_read_or_refused(tmp_path: Path) -> None:
    mosaic = np.random.default_rng(5).normal(600, 80, (24, 32)).round().astype(np.uint16)
    sources = tmp_path / "sources"
    sources.mkdir()
    bases = {f"{name}.dng": bytes(write(mosaic)) for name, write in BASES.items()}
    bases |= {path.name: path.read_bytes() for path in arrays(sources, mosaic)}
    for seed, (name, whole) in enumerate(bases.items()):
        found = outcomes(whole, tmp_path / name, seed=seed, count=MUTANTS)
        assert len(found) > 1 or name == "frame.jxl", name  # some mutants are read, others refused: both were tried


@pytest.mark.parametrize("name", ["CRW_0101.CRW", "P003908.KDC"])
def test_damaged_files_of_cameras_are_read_or_refused(
    name: str, tmp_path: Path, shared_data: Callable[[str], Path]
) -> None:
    whole = (shared_data("makers") / name).read_bytes()
    found = outcomes(whole, tmp_path / name, seed=len(name), count=6)
    assert found <= {"read", "companded", "file-damaged", "file-truncated", "not-a-raw-file", "decoder-failed"} | {
        "unsupported-cfa",
        "processed-rgb",
        "unsupported-camera",
    }
