"""A study at a URL comes to what the same study on a disk comes to, also where other processes read it."""

import functools
import http.server
import json
import subprocess
import sys
import threading
from collections.abc import Generator
from pathlib import Path

import fsspec
import numpy as np
import pytest

from fullwell.errors import UsageError
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.frames.study import load_study
from fullwell.raw.remote import located
from fullwell.raw.write import write_dng
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.cluster import connected
from fullwell.workflow.reduce import Reduction, reduce_study

PLAN = ((Kind.FLAT, 0.01), (Kind.FLAT, 0.02), (Kind.DARK, 0.01))


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root, rng = tmp_path_factory.mktemp("remote"), np.random.default_rng(3)
    for kind, exposure_s in PLAN:
        (root / "study" / kind).mkdir(parents=True, exist_ok=True)
        for number in range(3):
            level = 64 + (20_000 * exposure_s if kind is Kind.FLAT else 0)
            codes = rng.normal(level, 2 + level**0.5 / 8, (64, 96)).round().clip(0, 1023).astype(np.uint16)
            write_dng(
                root / "study" / kind / f"{exposure_s:g}s-{number}.dng",
                codes,
                cfa="RGGB",
                black_level=(64,) * 4,
                white_level=1023,
                iso=100,
                exposure_s=exposure_s,
                compression="lossless-jpeg" if number else "none",
            )
    return root


@pytest.fixture(scope="module")
def url(folder: Path) -> Generator[str]:
    handler = functools.partial(_Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/study"
        server.shutdown()


@pytest.fixture(scope="module")
def expected(folder: Path) -> Reduction:
    return reduce_study(load_study(folder / "study", Selection()), workers=2)


def same(found: Reduction, expected: Reduction) -> bool:
    return repr(found.statistics) == repr(expected.statistics) and found.hashes == expected.hashes


def test_the_command_measures_a_study_on_a_web_server(url: str, folder: Path, tmp_path: Path) -> None:
    documents: list[dict[str, object]] = []
    for number, place in enumerate((url, str(folder / "study"))):
        out = tmp_path / str(number)
        command = ["characterize", place, "-o", str(out), "--quiet", "--no-cache"]
        subprocess.run([sys.executable, "-m", "fullwell", *command], check=True)
        documents.append(json.loads((out / "results.json").read_text(encoding="utf-8")))
    assert [document.pop("run")["study"] for document in documents] == [url, str(folder / "study")]
    assert documents[0] == documents[1]


def test_processes_of_a_cluster_read_from_the_server(url: str, expected: Reduction) -> None:
    study = load_study(located(url), Selection())
    with connected("local", workers=2) as cluster:
        assert same(reduce_study(study, workers=2, cluster=cluster), expected)


def test_a_study_in_an_object_store_with_a_manifest(folder: Path, expected: Reduction) -> None:
    store = fsspec.filesystem("memory")
    store.put(str(folder / "study"), "/bucket/study", recursive=True)
    manifest = '[[series]]\nkind = "dark"\nfiles = ["dark/*.dng"]\n[[series]]\nkind = "flat"\nfiles = ["flat/*.dng"]\n'
    for _ in range(2):
        study = load_study(located("memory://bucket/study"), Selection())
        assert same(reduce_study(study, workers=2), expected)
        store.pipe("/bucket/study/study.toml", manifest.encode())
    store.rm("/bucket/study", recursive=True)


def test_a_finished_series_is_used_again_once_its_files_are_hashed(
    url: str, expected: Reduction, tmp_path: Path
) -> None:
    study = load_study(located(url), Selection())
    for found in (0, len(PLAN)):
        cache = SeriesCache(tmp_path / "cache")
        assert same(reduce_study(study, workers=2, cache=cache), expected)
        assert cache.found == found


def test_a_study_that_is_not_there(url: str) -> None:
    with pytest.raises(UsageError, match="does not exist"):
        load_study(located(f"{url}-of-others"), Selection())


def test_results_are_not_written_to_a_url(url: str) -> None:
    command = [sys.executable, "-m", "fullwell", "characterize", url, "-o", "s3://bucket/out"]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert "only studies and raw files are read from there" in " ".join(done.stderr.replace("│", " ").split())
