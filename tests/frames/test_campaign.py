"""The [emva] table of study.toml: what a datasheet says beyond what frames tell."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import pytest

from fullwell.errors import UsageError
from fullwell.frames.campaign import Campaign
from fullwell.frames.manifest import read_manifest, write_manifest
from fullwell.frames.manifest_tables import EmvaTable
from fullwell.frames.selection import Selection
from fullwell.frames.study import load_study
from fullwell.workflow.description import describe

MakeFrame = Callable[..., Path]
_SERIES = '[[series]]\nkind = "flat"\nfiles = ["a.dng"]\nexposure_s = 1\niso = 100\n'


def written(folder: Path, text: str) -> Path:
    path = folder / "study.toml"
    path.write_text(text + _SERIES, encoding="utf-8")
    return path


def test_statements_reach_the_results_and_a_manifest_written_again(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "a.dng")
    text = '[emva]\nvendor = "V \\"1\\""\ndate = 2026-05-04\nsensor_type = "CMOS"\nframe_rate_hz = 30\n'
    study = load_study(written(tmp_path, text), Selection())
    assert study.campaign == Campaign(vendor='V "1"', date="2026-05-04", sensor_type="CMOS", frame_rate_hz=30.0)
    described = describe(study, settings={}, hashes={}, excluded=[])
    assert described["emva"] == {
        "vendor": 'V "1"',
        "date": "2026-05-04",
        "sensor_type": "CMOS",
        "frame_rate_hz": 30.0,
    }
    again = tmp_path / "again.toml"
    again.write_text(write_manifest(study), encoding="utf-8")
    assert read_manifest(again).campaign == study.campaign


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('sensor_type = "film"', "emva.sensor_type"),
        ("f_number = 0", "emva.f_number"),
        ('vendr = "X"', r"\[emva\] knows vendor"),
    ],
)
def test_what_is_not_allowed_is_refused_by_name(tmp_path: Path, line: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        read_manifest(written(tmp_path, f"[emva]\n{line}\n"))


def test_the_table_knows_every_statement() -> None:
    assert list(EmvaTable.model_fields) == list(asdict(Campaign()))
