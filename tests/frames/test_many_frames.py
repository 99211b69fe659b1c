"""Files of many frames, and frames of a camera whose settings changed, in a study."""

from pathlib import Path

import numpy as np
from astropy.io import fits

from fullwell.frames.selection import Selection
from fullwell.frames.study import load_study
from fullwell.workflow.duplicates import reduce_without_copies

CHOICE = Selection(cfa="mono")


def test_planes_of_one_file_are_frames_with_names_and_hashes_of_their_own(tmp_path: Path) -> None:
    frames = np.random.default_rng(4).integers(90, 110, (11, 64, 64), dtype=np.uint16)
    frames[10] = frames[3]
    (tmp_path / "bias").mkdir()
    np.save(tmp_path / "bias" / "burst.npy", frames)
    study = load_study(tmp_path, CHOICE)
    (series,) = study.series
    assert [frame.name for frame in series.frames] == [f"bias/burst.npy#{page:02d}" for page in range(1, 12)]
    assert {frame.size for frame in series.frames} == {64 * 64 * 2}
    reduction = reduce_without_copies(study, workers=2, tile=8)
    assert [one.name for one in reduction.excluded] == ["bias/burst.npy#11"]
    assert len(set(reduction.hashes.values())) == 10
    (statistics,) = reduction.statistics.values()
    assert len(statistics.frames) == 10


def test_frames_of_another_amplification_are_not_merged(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    (tmp_path / "bias").mkdir()
    for number, readout in enumerate(("Low", "Low", "Low", "High")):
        card = fits.PrimaryHDU(rng.integers(90, 110, (64, 64), dtype=np.uint16))
        card.header.update({"EXPTIME": 0.001, "EGAIN": 10.8 if readout == "Low" else 2.4, "READOUTM": readout})
        card.writeto(tmp_path / "bias" / f"{number}.fits")
    study = load_study(tmp_path, CHOICE)
    assert [frame.name for series in study.series for frame in series.frames] == [f"bias/{n}.fits" for n in range(3)]
    assert [(one.name, one.code) for one in study.excluded] == [("bias/3.fits", "settings-differ")]
    (tmp_path / "study.toml").write_text(
        '[[series]]\nkind = "bias"\nfiles = ["bias/[012].fits"]\niso = 100\n'
        '[[series]]\nkind = "bias"\nfiles = ["bias/3.fits"]\niso = 400\n'
    )
    apart = load_study(tmp_path / "study.toml", CHOICE)
    assert [(series.iso, len(series.frames)) for series in apart.series] == [(100.0, 3), (400.0, 1)]
    assert not apart.excluded
