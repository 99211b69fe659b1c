"""A file at a URL is read as one on a disk is."""

import http.server
import pickle
import threading
from collections.abc import Generator
from functools import partial
from pathlib import Path
from typing import Any

import fsspec
import numpy as np
import pytest

from fullwell.errors import UsageError
from fullwell.raw import remote
from fullwell.raw.open import read_raw
from fullwell.raw.remote import RemotePath, located
from fullwell.raw.write import write_dng

LEVELS: Any = {"black_level": (64,) * 4, "white_level": 1023, "iso": 100, "exposure_s": 0.01}
CODES = np.random.default_rng(0).integers(0, 1023, (600, 800), np.uint16)


class _Server(http.server.SimpleHTTPRequestHandler):
    """Serves whole files, and parts of them where ``parts``; counts the bytes that were sent."""

    parts = False
    sent = 0

    def do_GET(self) -> None:
        path = Path(self.translate_path(self.path))
        if not self.parts or not path.is_file():
            super().do_GET()
            return
        content = path.read_bytes()
        first, last = 0, len(content) - 1
        if asked := self.headers.get("Range"):
            first, last = (int(text or len(content) - 1) for text in asked.removeprefix("bytes=").split("-"))
        piece = content[first : last + 1]
        self.send_response(206 if asked else 200)
        self.send_header("Content-Length", str(len(piece)))
        self.send_header("Content-Range", f"bytes {first}-{last}/{len(content)}")
        self.end_headers()
        self.wfile.write(piece)
        type(self).sent += len(piece)

    def log_message(self, *_: object) -> None:
        """Be quiet."""


@pytest.fixture(params=[False, True], ids=["whole files", "parts of files"])
def server(request: pytest.FixtureRequest, tmp_path: Path) -> Generator[tuple[str, Path, Any]]:
    handler = type("Handler", (_Server,), {"parts": request.param, "sent": 0})
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(handler, directory=str(tmp_path))) as running:
        threading.Thread(target=running.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{running.server_port}", tmp_path, handler
        running.shutdown()


@pytest.mark.parametrize("compression", ["none", "lossless-jpeg"])
def test_a_frame_is_the_same_from_a_web_server(server: tuple[str, Path, Any], compression: Any) -> None:
    url, folder, _ = server
    write_dng(folder / "a.dng", CODES, cfa="RGGB", **LEVELS, compression=compression)
    there, here = read_raw(located(f"{url}/a.dng")), read_raw(folder / "a.dng")
    np.testing.assert_array_equal(there.mosaic, here.mosaic)
    assert (there.header.iso, there.header.exposure_s) == (100, 0.01)
    assert str(there.header.path) == f"{url}/a.dng"


def test_only_what_is_asked_for_travels(server: tuple[str, Path, Any]) -> None:
    url, folder, handler = server
    (folder / "a.bin").write_bytes(bytes(range(256)) * 20_000)
    with located(f"{url}/a.bin").open("rb") as file:
        file.seek(4_000_000)
        assert file.read(4) == bytes(range(4))
        file.seek(-2, 2)
        assert file.read() == b"\xfe\xff"
    if handler.parts:
        assert handler.sent < 600_000


def test_a_folder_lists_what_is_in_it(server: tuple[str, Path, Any]) -> None:
    url, folder, _ = server
    (folder / "study" / "flat").mkdir(parents=True)
    (folder / "study" / "flat" / "a.dng").write_bytes(b"a")
    (folder / "study" / "study.toml").write_text("x = 1\n")
    study = located(f"{url}/study")
    assert study.is_dir()
    assert {entry.name: entry.is_dir() for entry in study.entries()} == {"flat": True, "study.toml": False}
    assert [path.name for path in study.glob("*/*.dng")] == ["a.dng"]
    assert (study / "study.toml").read_text(encoding="utf-8") == "x = 1\n"
    assert not (study / "other").exists()
    assert not (study / "other.toml").is_file()
    with pytest.raises(FileNotFoundError):
        (study / "other.toml").read_text(encoding="utf-8")


def test_a_server_that_fails_is_a_file_that_cannot_be_read() -> None:
    with pytest.raises(OSError, match="127"):
        located("http://127.0.0.1:9/a.dng").read_bytes()


def test_paths_travel_and_stay_urls() -> None:
    path = located("memory://bucket/study/flat") / "a.dng"
    assert str(pickle.loads(pickle.dumps(path))) == "memory://bucket/study/flat/a.dng"  # noqa: S301 - our own
    assert str(path.parent.with_name("b").resolve()) == "memory://bucket/study/b"
    assert isinstance(path.parent, RemotePath)
    assert str(path.relative_to(path.parent.parent)) == "flat/a.dng"
    with pytest.raises(OSError, match="cannot be written"):
        path.write_text("x", encoding="utf-8")


def test_a_file_that_shrinks_is_an_error() -> None:
    files = fsspec.filesystem("memory")
    files.pipe("/shrinks/a.bin", b"x" * 1000)
    with located("memory://shrinks/a.bin").open("rb", buffering=0) as file:
        files.pipe("/shrinks/a.bin", b"")
        with pytest.raises(OSError, match="changed its size"):
            file.read()


@pytest.mark.parametrize(("scheme", "extra"), [("s3", "s3"), ("gs", "gcs"), ("https", "http")])
def test_what_is_not_installed_is_named(scheme: str, extra: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(_: str) -> None:
        raise ImportError("no such library")

    remote.filesystem_of.cache_clear()
    monkeypatch.setattr(fsspec, "filesystem", missing)
    with pytest.raises(UsageError, match=rf"pip install 'fullwell\[{extra}\]'"):
        located(f"{scheme}://bucket/study")
    remote.filesystem_of.cache_clear()


def test_other_urls_are_refused() -> None:
    with pytest.raises(UsageError, match="no kind of URL"):
        located("gopher://bucket/study")
